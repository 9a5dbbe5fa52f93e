"""Force and torque of filaments on their membrane, the sections at their ends included (docs/model.md §3.7)."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.spatial.transform import Rotation

from warp_rods.analysis.described import described, need, positions

_VECTORS = ("frame", "rod", "axis")


def force_on_membrane(dataset: xr.Dataset) -> xr.DataArray:
    """Total force of a filament on its membrane (frame, rod, axis).

    ∫ load ds by the trapezoid rule, and the forces of both end sections. It equals the external force on the filament
    less its drag, to second order in the node spacing: zero for a filament at rest without external forces.
    """
    need(dataset, "load", "end_load", "length")
    values = _integral(dataset, _nodes(dataset, "load")) + _ends(dataset, "end_load").sum(axis=2)
    found = described(dataset, _VECTORS, values, "force", "force on the membrane", "∫ load ds + Σ end_load")
    return found.assign_coords(axis=["x", "y", "z"])


def torque_on_membrane(dataset: xr.Dataset) -> xr.DataArray:
    """Total torque of a filament on its membrane (frame, rod, axis).

    About the origin: ∫ (r × load + load_moment q) ds by the trapezoid rule, and r × end_load + end_moment of both ends.
    Second order in the node spacing; zero for a filament at rest without external forces.
    """
    need(dataset, "load", "load_moment", "end_load", "end_moment", "length", "position", "orientation")
    r = positions(dataset)
    couple = dataset["load_moment"].transpose("frame", "rod", "node").to_numpy()[..., None] * _tangents(dataset)
    along = _integral(dataset, np.cross(r, _nodes(dataset, "load")) + couple)
    at_ends = np.cross(r[:, :, [0, -1]], _ends(dataset, "end_load")) + _ends(dataset, "end_moment")
    source = "∫ (r × load + load_moment q) ds + Σ (r × end_load + end_moment)"
    found = described(
        dataset,
        _VECTORS,
        along + at_ends.sum(axis=2),
        "force*length",
        "torque on the membrane about the origin",
        source,
    )
    return found.assign_coords(axis=["x", "y", "z"])


def _nodes(dataset: xr.Dataset, name: str) -> np.ndarray:
    return dataset[name].transpose("frame", "rod", "node", "axis").to_numpy().astype(np.float64)


def _ends(dataset: xr.Dataset, name: str) -> np.ndarray:
    return dataset[name].transpose("frame", "rod", "end", "axis").to_numpy()


def _tangents(dataset: xr.Dataset) -> np.ndarray:
    """The first director [frame, rod, node, 3], from the quaternions x, y, z, w."""
    q = dataset["orientation"].transpose("frame", "rod", "node", "quaternion").to_numpy().astype(np.float64)
    return Rotation.from_quat(q.reshape(-1, 4)).as_matrix()[:, :, 0].reshape(*q.shape[:3], 3)


def _integral(dataset: xr.Dataset, density: np.ndarray) -> np.ndarray:
    """∫ ds [frame, rod, 3] of values at nodes [frame, rod, node, 3]."""
    length = dataset["length"].transpose("frame", "rod").to_numpy()
    return np.trapezoid(density, axis=2) * (length / (density.shape[2] - 1))[..., None]
