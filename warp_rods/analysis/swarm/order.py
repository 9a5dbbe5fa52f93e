"""Order of a swarm: whether rods point, lie or move the same way, globally or locally.

The direction p of a rod is the unit vector from its first node to its last; a rod whose ends meet has none and is left
out. Rods with symmetric flagella have no head, so that the sign of p is arbitrary and polar order means nothing for
them; nematic order and the order of their motion do. In a plane p is the direction of the projection. Rods that failed
are left out.
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
    """Polar order: 1 where all rods point the same way (frame).

    |⟨p⟩|, whose root mean square is 1/√N for N rods of random direction.
    """
    dataset = surviving(dataset)
    values = _polar(*_directions(dataset, space(dataset, dimensions)))
    return over_frames(dataset, values, "polar order", "|⟨p⟩|").assign_attrs(_isotropic(dataset))


def nematic_order(dataset: xr.Dataset, dimensions: int | None = None) -> xr.DataArray:
    """Nematic order: 1 where all lie along one line (frame).

    The largest eigenvalue of Q = (d⟨pp⟩ − 1)/(d − 1) in d dimensions. Its root mean square for N rods of random
    direction is 1/√N in a plane and 0.86/√N in space.
    """
    dataset = surviving(dataset)
    values = _nematic(*_directions(dataset, space(dataset, dimensions)))
    return over_frames(dataset, values, "nematic order", "max eig (d⟨pp⟩ − 1)/(d − 1)").assign_attrs(
        _isotropic(dataset)
    )


def motion_order(dataset: xr.Dataset, dimensions: int | None = None) -> xr.DataArray:
    """Polar order of the velocities (frame).

    |⟨v/|v|⟩| of the centres: 1 where all rods move the same way, about 1/√N for N rods that move in random directions.
    Raises ValueError where there are fewer than two frames.
    """
    dataset = surviving(dataset)
    axes = space(dataset, dimensions).axes
    values = _polar(*_unit(velocities(dataset)[..., axes]))
    return over_frames(dataset, values, "polar order of the motion", "|⟨v/|v|⟩|").assign_attrs(_isotropic(dataset))


def local_polar_order(dataset: xr.Dataset, radius: float | None = None, dimensions: int | None = None) -> xr.DataArray:
    """Polar order of the rods about each rod (frame, rod).

    |⟨p⟩| of the rods whose middle nodes are within ``radius`` of its own, by default one rod length, itself included:
    about 1/√n among n rods of random direction, and 1 where it is alone. Raises ValueError where ``radius`` exceeds
    half the period of the box.
    """
    return _local(dataset, radius, dimensions, _polar, "local polar order", "|⟨p⟩|")


def local_nematic_order(
    dataset: xr.Dataset, radius: float | None = None, dimensions: int | None = None
) -> xr.DataArray:
    """Nematic order of the rods about each rod (frame, rod).

    The largest eigenvalue of Q of the rods that ``local_polar_order`` takes.
    """
    return _local(dataset, radius, dimensions, _nematic, "local nematic order", "max eig (d⟨pp⟩ − 1)/(d − 1)")


def _directions(dataset: xr.Dataset, where: Space) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the rods [frame, rod, axis]; and 1 for rods that have one, 0 for others [frame, rod]."""
    ends = dataset["position"].isel(node=[0, -1], axis=where.axes).transpose("frame", "rod", "node", "axis").to_numpy()
    return _unit(ends[:, :, 1] - ends[:, :, 0])


def _unit(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    size = np.linalg.norm(vectors, axis=-1)
    return vectors / np.where(size > 0, size, 1.0)[..., None], (size > 0).astype(float)


def _polar(p: np.ndarray, counted: np.ndarray, about: csr_array | None = None) -> np.ndarray:
    """|⟨p⟩| of p [..., rod, axis] over all rods [...], or over those about each rod."""
    number = np.maximum(_sum(counted[..., None], about)[..., 0], 1)
    return np.linalg.norm(_sum(p, about), axis=-1) / number


def _nematic(p: np.ndarray, counted: np.ndarray, about: csr_array | None = None) -> np.ndarray:
    """The largest eigenvalue of Q, over all rods or over those about each rod."""
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
    """1 where two rods are within the radius of each other, or are the same [rod, rod]."""
    (first, second), itself = pairs_within(points, period, radius)[0].T, np.arange(len(points))
    row, column = np.concatenate([first, second, itself]), np.concatenate([second, first, itself])
    return csr_array((np.ones(len(row)), (row, column)), shape=(len(points), len(points)))


def _isotropic(dataset: xr.Dataset) -> dict[str, float]:
    """The order of N rods of random direction: 1/√N."""
    return {"isotropic": 1 / np.sqrt(dataset.sizes["rod"])}
