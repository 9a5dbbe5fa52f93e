"""Functions for all measures of swarms: positions, periodic boxes, and pairs of near points."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from warp_rods.analysis.described import described, lengths, need, without_failed
from warp_rods.progress import with_progress

THIN = 0.5
"""A swarm is planar where its thickness is below this fraction of the length of a rod."""
_BLOCK_BYTES = 32_000_000


class Space(NamedTuple):
    """The axes along which a swarm extends, and the period of its box along each of them, inf where it is open."""

    axes: np.ndarray
    period: np.ndarray


JOINED = ("position", "strain", "activity", "energy", "status")
"""Variables that are concatenated where several ensembles are measured as one swarm."""


def together(run: xr.DataTree, *names: str) -> xr.Dataset:
    """Ensembles of a run as one swarm: all their rods, with the variables that measures of swarms need.

    ``names`` of the ensembles; by default all swimmers, or all filaments of a run without swimmers. Raises ValueError
    for an unknown name, and where rods have different numbers of nodes.
    """
    names = names or members_of(run)
    if unknown := [name for name in names if name not in run.children]:
        raise ValueError(f"no ensemble called {', '.join(unknown)}: the run has {', '.join(run.children)}")
    members = {name: run[name].to_dataset() for name in names}
    check_nodes(members)
    groups = list(members.values())
    shared = [[key for key in JOINED if all(key in group for group in groups)]] * len(groups)
    joined = xr.concat([group[keys] for group, keys in zip(groups, shared, strict=True)], "rod")
    once = {key: groups[0][key] for key in ("period",) if key in groups[0]}
    every = {"length": xr.concat([group["length"] for group in groups], "rod")} if "length" in groups[0] else {}
    return joined.assign({**once, **every})


def members_of(run: xr.DataTree) -> tuple[str, ...]:
    """The names of the ensembles that form the swarm of a run: its swimmers, or its filaments where it has none."""
    swimmers = tuple(name for name, group in run.children.items() if "activity" in group)
    return swimmers or tuple(run.children)


def check_nodes(groups: Mapping[str, xr.Dataset]) -> None:
    """Raises ValueError unless all ensembles have the same number of nodes."""
    if len({group.sizes["node"] for group in groups.values()}) > 1:
        raise ValueError(f"{', '.join(groups)} have different numbers of nodes: measure them one by one")


def surviving(dataset: xr.Dataset) -> xr.Dataset:
    """The rods that did not fail; where some failed, the coordinate ``rod`` has the numbers of the others.

    Raises ValueError where all failed, or where there is no position.
    """
    need(dataset, "position")
    return without_failed(dataset)


def space(dataset: xr.Dataset, dimensions: int | None = None) -> Space:
    """The axes along which a swarm extends: all three, or two for a planar swarm.

    ``dimensions``: 2 or 3. By default 2 for a swarm that in the first and the last frame is thinner along an axis than
    ``THIN`` rod lengths. The plane is normal to the axis along which the swarm is thinnest; in a duct to that of its
    shorter sides. In a pore, and a duct with equal sides, a swarm extends along all three by default.
    """
    if dimensions not in (None, 2, 3):
        raise ValueError(f"dimensions = {dimensions}: must be 2 or 3")
    ends = dataset["position"].isel(frame=[0, -1]).transpose(..., "axis").to_numpy()
    thickness = np.ptp(ends.reshape(-1, 3), axis=0)
    normal, round_section = _thin_axis(dataset, thickness)
    planar = thickness[normal] < THIN * rod_length(dataset) and not round_section
    planar = planar if dimensions is None else dimensions == 2
    axes = np.delete(np.arange(3), normal) if planar else np.arange(3)
    return Space(axes, period_of(dataset)[axes])


def _thin_axis(dataset: xr.Dataset, thickness: np.ndarray) -> tuple[int, bool]:
    """The number of the axis normal to a planar swarm, and whether its box has no plane: a section alike both ways.

    thickness [axis]: of the swarm; the thinnest axis counts where the box says nothing, the last one of equal ones.
    """
    box = tomllib.loads(dataset.attrs.get("scene", "")).get("box", {})
    thinnest = 2 - int(np.argmin(thickness[::-1]))
    if box.get("kind") not in ("pore", "duct"):
        return thinnest, False
    width, height = box.get("sides", (1.0, 1.0))
    if width == height:
        return thinnest, True
    along = "xyz".index(box.get("axis", "x"))
    return (along + (1 if width < height else 2)) % 3, False


def period_of(dataset: xr.Dataset) -> np.ndarray:
    """Period of the box along each axis [3], inf where it is open."""
    return dataset["period"].to_numpy() if "period" in dataset else np.full(3, np.inf)


def rod_length(dataset: xr.Dataset) -> float:
    """Mean length of the rods."""
    return float(np.mean(lengths(dataset)))


def blocks(values: xr.DataArray, what: str) -> Iterator[np.ndarray]:
    """Values [frame, ...] in blocks of successive frames, so that long runs need little memory.

    ``what``: label of the progress bar.
    """
    values = values.transpose("frame", ...)
    frames = values.sizes["frame"]
    step = max(1, int(_BLOCK_BYTES * frames / max(values.nbytes, 1)))
    for first in with_progress(range(0, frames, step), what):
        yield values.isel(frame=slice(first, first + step)).to_numpy()


def nodes_by_block(dataset: xr.Dataset, what: str) -> Iterator[np.ndarray]:
    """Positions [frame, rod, node, 3] in blocks of frames."""
    return blocks(dataset["position"].transpose("frame", "rod", "node", "axis"), what)


def middles(dataset: xr.Dataset) -> np.ndarray:
    """Position of the middle nodes [frame, rod, 3]."""
    return dataset["position"].isel(node=dataset.sizes["node"] // 2).transpose("frame", "rod", "axis").to_numpy()


def weights(nodes: int) -> np.ndarray:
    """Fraction of the length of a rod that belongs to each node [node], by the trapezoid rule."""
    share = np.full(nodes, 1 / max(nodes - 1, 1))
    share[[0, -1]] /= 2 if nodes > 1 else 1
    return share


def centres(dataset: xr.Dataset) -> np.ndarray:
    """Centre of each rod [frame, rod, 3], ∫ r ds / L, which oscillates less than the middle node."""
    share = weights(dataset.sizes["node"])
    return np.concatenate([np.einsum("frnx,n->frx", block, share) for block in nodes_by_block(dataset, "centres")])


def velocities(dataset: xr.Dataset) -> np.ndarray:
    """Velocity of the centres [frame, rod, 3] from central differences between frames, second order in their spacing.

    One-sided and first order in the first and the last frame, as a higher order would amplify noise. Raises ValueError
    where there are fewer than two frames.
    """
    time = dataset["time"].to_numpy()
    if len(time) < 2:
        raise ValueError("velocities need two frames or more")
    return np.gradient(centres(dataset), time, axis=0)


def minimum_image(separation: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Separations [..., axis] to the nearest image along periodic axes."""
    return separation - np.where(np.isfinite(period), period, 0.0) * np.round(separation / period)


def wrapped(points: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Points [..., axis] moved into the box [0, period) along periodic axes."""
    inside = points - np.where(np.isfinite(period), period, 0.0) * np.floor(points / period)
    # Just below a multiple of the period the difference rounds to the period itself.
    return np.where(np.isfinite(period) & (inside >= period), 0.0, inside)


def pairs_within(points: np.ndarray, period: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of points [point, axis] within a radius of each other: numbers [pair, 2] and separations [pair, axis].

    Each pair once, by its nearest image. Raises ValueError where the radius exceeds half the period.
    """
    if 2 * radius > period.min():
        raise ValueError(f"a distance of {radius:g} is more than half the period {period.min():g} of the box")
    # SciPy's tree takes 0 for a non-periodic axis.
    tree = cKDTree(wrapped(points, period), boxsize=np.where(np.isfinite(period), period, 0.0))
    pairs = tree.query_pairs(radius, output_type="ndarray")
    return pairs, minimum_image(points[pairs[:, 1]] - points[pairs[:, 0]], period)


def over_frames(dataset: xr.Dataset, values: np.ndarray, long_name: str, source: str, units: str = "1") -> xr.DataArray:
    """A measure with one value per frame (frame)."""
    return described(dataset, ("frame",), values, units, long_name, source)
