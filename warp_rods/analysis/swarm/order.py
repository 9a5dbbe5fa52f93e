"""Order of a swarm: polar and nematic order of the rods and polar order of their motion, global or local.

The direction p of a rod is the unit vector from its first node to its last; a rod whose ends coincide is left out. Rods
with symmetric flagella have no head: the sign of p is arbitrary, and polar order has no meaning for them, unlike
nematic order and the order of the motion. In a plane p is the direction of the projection. Failed rods are left out.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr
from scipy.sparse import csr_array

from warp_rods.analysis.described import FRAMES, described
from warp_rods.analysis.swarm.data import (
    Space,
    middles,
    over_frames,
    pairs_within,
    rod_length,
    space,
    surviving,
    velocities,
)
from warp_rods.progress import with_progress


def polar_order(dataset: xr.Dataset, dimensions: int | None = None) -> xr.DataArray:
    """Polar order: 1 for rods that all point in one direction (frame).

    |⟨p⟩|, whose root mean square is 1/√N for N rods with random directions.
    """
    dataset = surviving(dataset)
    values = _polar(*_directions(dataset, space(dataset, dimensions)))
    return over_frames(dataset, values, "polar order", "|⟨p⟩|").assign_attrs(_isotropic(dataset))


def nematic_order(dataset: xr.Dataset, dimensions: int | None = None) -> xr.DataArray:
    """Nematic order: 1 for rods all along one axis (frame).

    The largest eigenvalue of Q = (d⟨pp⟩ − 1)/(d − 1) in d dimensions. Its root mean square for N rods with random
    directions is 1/√N in a plane and 0.86/√N in space.
    """
    dataset = surviving(dataset)
    values = _nematic(*_directions(dataset, space(dataset, dimensions)))
    return over_frames(dataset, values, "nematic order", "max eig (d⟨pp⟩ − 1)/(d − 1)").assign_attrs(
        _isotropic(dataset)
    )


def motion_order(dataset: xr.Dataset, dimensions: int | None = None) -> xr.DataArray:
    """Polar order of the velocities (frame).

    |⟨v/|v|⟩| of the centres: 1 where all rods move in one direction, about 1/√N for N rods with random directions.
    Raises ValueError where there are fewer than two frames.
    """
    dataset = surviving(dataset)
    axes = space(dataset, dimensions).axes
    values = _polar(*_unit(velocities(dataset)[..., axes]))
    return over_frames(dataset, values, "polar order of the motion", "|⟨v/|v|⟩|").assign_attrs(_isotropic(dataset))


def local_polar_order(dataset: xr.Dataset, radius: float | None = None, dimensions: int | None = None) -> xr.DataArray:
    """Polar order of the rods around each rod (frame, rod).

    |⟨p⟩| over the rods whose middle nodes are within ``radius`` of its own (default: one rod length), itself included:
    about 1/√n for n rods with random directions, and 1 for an isolated rod. Raises ValueError where ``radius`` exceeds
    half the period of the box.
    """
    return _local(dataset, radius, dimensions, _polar, "local polar order", "|⟨p⟩|")


def local_nematic_order(
    dataset: xr.Dataset, radius: float | None = None, dimensions: int | None = None
) -> xr.DataArray:
    """Nematic order of the rods around each rod (frame, rod).

    The largest eigenvalue of Q over the same rods as in ``local_polar_order``.
    """
    return _local(dataset, radius, dimensions, _nematic, "local nematic order", "max eig (d⟨pp⟩ − 1)/(d − 1)")


def _directions(dataset: xr.Dataset, where: Space) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the rods [frame, rod, axis]; and 1 for rods that have a direction, 0 for others [frame, rod]."""
    ends = dataset["position"].isel(node=[0, -1], axis=where.axes).transpose("frame", "rod", "node", "axis").to_numpy()
    return _unit(ends[:, :, 1] - ends[:, :, 0])


def _unit(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    size = np.linalg.norm(vectors, axis=-1)
    return vectors / np.where(size > 0, size, 1.0)[..., None], (size > 0).astype(float)


def _polar(p: np.ndarray, counted: np.ndarray, about: csr_array | None = None) -> np.ndarray:
    """|⟨p⟩| of p [..., rod, axis] over all rods, or over those around each rod."""
    number = np.maximum(_sum(counted[..., None], about)[..., 0], 1)
    return np.linalg.norm(_sum(p, about), axis=-1) / number


def _nematic(p: np.ndarray, counted: np.ndarray, about: csr_array | None = None) -> np.ndarray:
    """The largest eigenvalue of Q over all rods, or over those around each rod."""
    d = p.shape[-1]
    number = np.maximum(_sum(counted[..., None], about), 1)
    dyads = (p[..., :, None] * p[..., None, :]).reshape(*p.shape[:-1], d * d)
    mean = (_sum(dyads, about) / number).reshape(*number.shape[:-1], d, d)
    return (d * np.linalg.eigvalsh(mean)[..., -1] - 1) / (d - 1)


def _sum(values: np.ndarray, about: csr_array | None) -> np.ndarray:
    return values.sum(axis=-2) if about is None else about @ values


def _local(
    dataset: xr.Dataset,
    radius: float | None,
    dimensions: int | None,
    order: Callable[[np.ndarray, np.ndarray, csr_array], np.ndarray],
    long_name: str,
    source: str,
) -> xr.DataArray:
    dataset = surviving(dataset)
    where, reach = space(dataset, dimensions), rod_length(dataset) if radius is None else radius
    p, counted = _directions(dataset, where)
    middle = middles(dataset)[..., where.axes]
    values = np.empty(p.shape[:2])
    for frame in with_progress(range(len(p)), long_name):
        about = _about(middle[frame], where.period, reach)
        values[frame] = order(p[frame], counted[frame], about)
    found = described(dataset, FRAMES, values, "1", long_name, source)
    return found.assign_coords(rod=dataset["rod"]).assign_attrs(radius=reach)


def _about(points: np.ndarray, period: np.ndarray, radius: float) -> csr_array:
    """1 for two rods within this radius of each other, and on the diagonal [rod, rod]."""
    (first, second), itself = pairs_within(points, period, radius)[0].T, np.arange(len(points))
    row, column = np.concatenate([first, second, itself]), np.concatenate([second, first, itself])
    return csr_array((np.ones(len(row)), (row, column)), shape=(len(points), len(points)))


def _isotropic(dataset: xr.Dataset) -> dict[str, float]:
    """The order of N rods with random directions: 1/√N."""
    return {"isotropic": 1 / np.sqrt(dataset.sizes["rod"])}
