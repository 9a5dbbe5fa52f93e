"""Spatial structure of a swarm: pair correlation, velocity correlation, density.

Distances are to the nearest image along periodic axes. g(r) compares with uniformly distributed rods in a box: the
periodic box itself, and along open axes the smallest box that contains the middle nodes, corrected for the pairs that
its faces cut off. Hence g(r) = 1 for uncorrelated rods between walls, while a swarm that does not fill its box, or
whose boundary is round, has g(r) > 1 at short distances. In a plane distances, areas and densities are those of the
projection. Failed rods are left out.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import attributes, described, units_of
from warp_rods.analysis.swarm.data import (
    Space,
    centres,
    middles,
    nodes_by_block,
    pairs_within,
    rod_length,
    space,
    surviving,
    velocities,
    weights,
    wrapped,
)
from warp_rods.progress import with_progress

REACH = 3.0
"""Range of correlations in rod lengths; at most half the shortest side of the box."""
CELLS = {2: 64, 3: 24}
"""Largest number of cells along an axis of a density map, in a plane and in space."""
_ABSOLUTE = {2: (2 / np.pi, 1 / np.pi), 3: (1 / 2, 2 / (3 * np.pi), 1 / (4 * np.pi))}
"""⟨|u_1|⟩, ⟨|u_1 u_2|⟩, ⟨|u_1 u_2 u_3|⟩ of unit vectors u with random directions."""


def pair_correlation(
    dataset: xr.Dataset, reach: float | None = None, bins: int = 60, dimensions: int | None = None
) -> xr.DataArray:
    """Pair correlation g(r) of the middle nodes (frame, r).

    Number of pairs in a shell over that of uniformly distributed rods, with the exact volume of the shell. ``bins`` of
    equal width up to ``reach``, by default 3 rod lengths or half the shortest side of the box. The coordinate
    ``expected`` (frame, r) is the number of pairs of uniformly distributed rods; the standard error of g(r) for
    independent rods is one over its square root. Raises ValueError where ``reach`` exceeds half the shortest side.
    """
    dataset = surviving(dataset)
    where = space(dataset, dimensions)
    middle = middles(dataset)[..., where.axes]
    edges = _edges(dataset, middle, where, reach, bins)
    counts, expected = np.empty((2, len(middle), bins))
    for frame in with_progress(range(len(middle)), "pair correlation"):
        _, apart = pairs_within(middle[frame], where.period, edges[-1])
        counts[frame] = np.bincount(_bin_of(apart, edges), minlength=bins)
        expected[frame] = _uniform_pairs(middle[frame], where.period, edges)
    found = _of_distance(dataset, counts / expected, edges, "pair correlation", "g(r) of the middle nodes")
    return found.assign_coords(expected=(("frame", "r"), expected, {"long_name": "pairs of uniform rods"}))


def velocity_correlation(
    dataset: xr.Dataset, reach: float | None = None, bins: int = 30, dimensions: int | None = None
) -> xr.DataArray:
    """Velocity correlation at a distance r (frame, r).

    C_v(r) = ⟨v_i·v_j⟩_r / ⟨v²⟩ of the centres: 1 where rods have equal velocities, 0 where velocities are uncorrelated,
    NaN where no pair has this distance. A common drift counts as correlation. ``bins`` and ``reach`` as for
    ``pair_correlation``. Raises ValueError where ``reach`` exceeds half the shortest side, and where there are fewer
    than two frames.
    """
    dataset = surviving(dataset)
    where = space(dataset, dimensions)
    centre, velocity = centres(dataset)[..., where.axes], velocities(dataset)[..., where.axes]
    edges = _edges(dataset, centre, where, reach, bins)
    values = np.full((len(centre), bins), np.nan)
    for frame in with_progress(range(len(centre)), "velocity correlation"):
        pairs, apart = pairs_within(centre[frame], where.period, edges[-1])
        at, v = _bin_of(apart, edges), velocity[frame]
        number = np.bincount(at, minlength=bins)
        together = np.bincount(at, np.einsum("px,px->p", v[pairs[:, 0]], v[pairs[:, 1]]), bins)
        mean_square = np.sum(v**2, axis=1).mean()
        np.divide(together, number * mean_square, out=values[frame], where=(number > 0) & (mean_square > 0))
    return _of_distance(dataset, values, edges, "velocity correlation", "⟨v_i·v_j⟩_r / ⟨v²⟩")


def density_map(dataset: xr.Dataset, cell: float | None = None, dimensions: int | None = None) -> xr.DataArray:
    """Rods per area, or per volume (frame, and x, y, z or the two of the plane).

    Each node counts with its fraction of the length of the rod, so that the sum over the cells times their size is the
    number of rods. Nodes are wrapped into the periodic box, which is centred on the origin; along open axes the map
    contains all nodes of all frames. ``cell``: largest side of a cell, by default half a rod length, with at most 64
    cells along an axis in a plane and 24 in space.
    """
    dataset = surviving(dataset)
    where = space(dataset, dimensions)
    edges = _grid(dataset, where, cell)
    share = np.tile(weights(dataset.sizes["node"]), dataset.sizes["rod"])
    size = np.prod([side[1] - side[0] for side in edges])
    half = np.where(np.isfinite(where.period), where.period, 0.0) / 2
    maps = []
    for block in nodes_by_block(dataset, "density"):
        for nodes in wrapped(block[..., where.axes] + half, where.period) - half:
            maps.append(np.histogramdd(nodes.reshape(-1, len(edges)), edges, weights=share)[0] / size)
    names = ["xyz"[axis] for axis in where.axes]
    long_name = "rods per area" if len(names) == 2 else "rods per volume"
    found = described(dataset, ("frame", *names), np.array(maps), f"1/length^{len(names)}", long_name, "Σ w δ(x − r)")
    middles_of = {name: (side[1:] + side[:-1]) / 2 for name, side in zip(names, edges, strict=True)}
    return found.assign_coords(
        {name: (name, at, {"units": units_of(dataset, "length")}) for name, at in middles_of.items()}
    )


def _sides(points: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Sides [axis] of the box of points [point, axis]; N uniform points extend over (N − 1)/(N + 1) of the box."""
    number = len(points)
    return np.where(np.isfinite(period), period, np.ptp(points, axis=0) * (number + 1) / max(number - 1, 1))


def shortest_side(points: np.ndarray, period: np.ndarray) -> float:
    """The shortest side of the box of points [point, axis]."""
    return float(_sides(points, period).min())


def _edges(dataset: xr.Dataset, points: np.ndarray, where: Space, reach: float | None, bins: int) -> np.ndarray:
    """Edges of the bins of distance [bin + 1]; points [frame, rod, axis]."""
    half = min(shortest_side(now, where.period) for now in points) / 2
    if reach is not None and reach > half:
        raise ValueError(f"reach = {reach:g} is more than {half:g}, half the shortest side of the box")
    far = min(REACH * rod_length(dataset), half) if reach is None else reach
    if not far > 0:
        raise ValueError("one rod, or all at one place: correlations need two or more at a distance")
    return np.linspace(0, far, bins + 1)


def _bin_of(apart: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """The bin of each separation [pair, axis], for bins of equal width; the last one includes its upper edge."""
    distance = np.sqrt(np.einsum("px,px->p", apart, apart))
    return np.minimum((distance * ((len(edges) - 1) / edges[-1])).astype(int), len(edges) - 2)


def _uniform_pairs(points: np.ndarray, period: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Number of pairs of N uniform points whose distance is in each bin [bin].

    In a box with open sides L_i, a fraction Π(1 − r|u_i|/L_i) of the points has a partner at the separation r u inside
    the box. Averaged over the directions u this is a polynomial in r, which is integrated over the shell.
    """
    d, number, sides = points.shape[1], len(points), _sides(points, period)
    opened = 1 / sides[~np.isfinite(period)]
    share = np.zeros(d + 1)
    share[: len(opened) + 1] = np.poly(opened)  # the elementary symmetric sums of 1/L_i, with signs (−1)^k
    share[1:] *= _ABSOLUTE[d]
    power = d + np.arange(d + 1)
    shells = np.diff(edges[:, None] ** power, axis=0) / power
    whole = 2 * np.pi * (d - 1)
    return number * (number - 1) / 2 * whole * (shells @ share) / np.prod(sides)


def _of_distance(
    dataset: xr.Dataset, values: np.ndarray, edges: np.ndarray, long_name: str, source: str
) -> xr.DataArray:
    found = described(dataset, ("frame", "r"), values, "1", long_name, source)
    at = (edges[1:] + edges[:-1]) / 2
    return found.assign_coords(r=("r", at, attributes(units_of(dataset, "length"), "distance")))


def _grid(dataset: xr.Dataset, where: Space, cell: float | None) -> list[np.ndarray]:
    """Edges of the cells along each axis."""
    low, high = -where.period / 2, where.period / 2  # the box is centred on the origin, as in the scene
    opened = ~np.isfinite(where.period)
    if opened.any():
        ends = [(block.min((0, 1, 2)), block.max((0, 1, 2))) for block in nodes_by_block(dataset, "extent")]
        lowest, highest = (np.array(part)[:, where.axes] for part in zip(*ends, strict=True))
        low[opened], high[opened] = lowest.min(axis=0)[opened], highest.max(axis=0)[opened]
    side = np.where(high > low, high - low, rod_length(dataset))
    wanted = np.maximum(np.ceil(side / (cell or rod_length(dataset) / 2)), 1).astype(int)
    number = np.minimum(wanted, CELLS[len(side)]) if cell is None else wanted
    return [np.linspace(at, at + long, many + 1) for at, long, many in zip(low, side, number, strict=True)]
