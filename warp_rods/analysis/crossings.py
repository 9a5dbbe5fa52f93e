"""The number of times that rods pass through each other or through themselves.

A rod is a chain of straight segments whose nodes move along straight lines at constant velocity from one frame to the
next. For this motion the count is exact. Where rods move by more than their distance between two frames, the straight
paths may cross more or less often than the rods did.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from warp_rods.analysis.described import described
from warp_rods.analysis.segment_sweeps import meet_in_plane, passes, stay_in_a_plane
from warp_rods.analysis.swarm.data import nodes_by_block, pairs_within, period_of, surviving

GENERAL = 1e-8
"""Displacement of each node, in lengths of a segment, equal at all times. It puts the rods in general position: those
that would meet exactly at a node, or exactly at a frame, meet on one side of it."""


def crossings(dataset: xr.Dataset) -> xr.Dataset:
    """Every event in which a rod passes through another rod or through itself.

    ``crossings(frame)`` is their number since the previous frame, 0 in the first. For each event:
    ``event_time(event)``; ``first_rod(event)`` and ``second_rod(event)``, equal for a rod through itself; and
    ``event_sign(event)``, +1 or −1, the jump of the Gauss linking integral of the two rods (for a rod through itself,
    half the jump of its writhe).

    Segments that stay in one plane between two frames, such as those of a planar swarm and parallel ones, do not pass
    through each other at a single time. In this case one crossing of sign 0 is counted when two rods that did not
    overlap in the earlier frame begin to overlap, up to the later frame. Rods that continue to overlap count again only
    after they have separated. Distances are those of nearest images in periodic boxes. Failed rods are left out. Raises
    ValueError where segments, or their paths between frames, are longer than half a period.
    """
    dataset = surviving(dataset)
    period, found = period_of(dataset), [np.zeros((4, 0))]
    before, offset = None, np.zeros(())
    for now in _frames(dataset):
        if before is None:
            offset = _small_offset(now)
        else:
            found.append(_between(np.stack([before, now]), offset, period))
        before = now
    return _described(dataset, found)


def crossings_per_frame(dataset: xr.Dataset) -> xr.DataArray:
    """Crossings of rods since the previous frame (frame).

    The number of times that rods passed through each other or through themselves; zero where steric repulsion is strong
    enough. Exact for nodes that move along straight lines between frames; ``analysis.crossings`` also gives the time
    and the rods of each event. Failed rods are left out.
    """
    return crossings(dataset)["crossings"]


def _frames(dataset: xr.Dataset) -> Iterator[np.ndarray]:
    for block in nodes_by_block(dataset, "crossings"):
        yield from block


def _described(dataset: xr.Dataset, found: list[np.ndarray]) -> xr.Dataset:
    """The dataset of ``crossings`` from the results of ``_between`` for each frame (none for the first)."""
    time, numbers = dataset["time"].to_numpy(), dataset["rod"].to_numpy()
    count = [part.shape[1] for part in found]
    first, second, when, sign = np.concatenate(found, axis=1)
    frame = np.repeat(np.arange(len(found)), count)
    at = time[frame - 1] + when * (time[frame] - time[frame - 1])
    columns = {
        "event_time": (at, "time", "time of the crossing"),
        "first_rod": (numbers[first.astype(int)], "1", "number of a rod"),
        "second_rod": (numbers[second.astype(int)], "1", "number of the rod that it crosses"),
        "event_sign": (sign.astype(int), "1", "jump of the Gauss integral, 0 in a plane"),
    }
    source = "(a × b)·w = 0"
    events = {name: described(dataset, ("event",), *values, source) for name, values in columns.items()}
    per_frame = described(dataset, ("frame",), count, "1", "crossings since the previous frame", source)
    return xr.Dataset({"crossings": per_frame, **events})


def _between(nodes: np.ndarray, offset: np.ndarray, period: np.ndarray) -> np.ndarray:
    """The crossings of nodes [time, rod, node, 3] between two times, in temporal order.

    First rod, second rod, time in (0, 1] and sign of each [4, crossing].
    """
    first, second, shift = _near(nodes, period)
    rods = np.stack([first, second]) // (nodes.shape[2] - 1)

    def pair(ends: np.ndarray, which: np.ndarray | slice) -> tuple[np.ndarray, np.ndarray]:
        return ends[:, first[which]], ends[:, second[which]] + shift[which][:, None]

    segments = _segments(nodes)
    flat = stay_in_a_plane(*pair(segments, slice(None)))
    solid, planar = np.flatnonzero(~flat), np.flatnonzero(flat)
    through = passes(*pair(_segments(nodes + offset), solid))
    swept, at = _rods_that_meet(rods[:, planar], shift[planar], *meet_in_plane(*pair(segments, planar)))
    found = np.concatenate(
        [[*rods[:, solid[through.pair]], through.time, through.sign], [*swept, at, np.zeros(len(at))]], axis=1
    )
    return found[:, np.lexsort((found[1], found[0], found[2]))]


def _near(nodes: np.ndarray, period: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of segments with paths near each other, neighbours excepted; and the shift to the image of the second."""
    ends = _segments(nodes)
    middle = ends.mean(axis=2)
    size = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=-1).max(axis=0)
    reach = (size + np.linalg.norm(middle[1] - middle[0], axis=-1)) / 2
    at = middle.mean(axis=0)
    if 4 * reach.max() > period.min():
        raise ValueError(
            f"crossings: a segment and its path between two frames extend over {2 * reach.max():.3g}, more than half "
            f"the period {period.min():.3g} of the box, so that it is not known which image it passed: save frames "
            f"more often (time.save_every), or measure frames between which rods move less, data.isel(frame=…)"
        )
    pairs, nearest = pairs_within(at, period, 2 * reach.max())
    first, second = pairs.T
    shift = nearest - (at[second] - at[first])
    shift = np.where(np.isfinite(period), period, 0.0) * np.round(shift / period) + 0.0  # no −0 beside 0
    low, high = ends.min(axis=(0, 2)), ends.max(axis=(0, 2))
    slack = 10 * GENERAL * size.max()
    boxes_meet = np.all(
        (low[first] <= high[second] + shift + slack) & (low[second] + shift <= high[first] + slack), axis=1
    )
    parts = nodes.shape[2] - 1
    same = (first // parts == second // parts) & np.all(shift == 0, axis=1)
    kept = boxes_meet & ~(same & (np.abs(first - second) <= 1))
    return first[kept], second[kept], shift[kept]


def _segments(nodes: np.ndarray) -> np.ndarray:
    """The ends of all segments [time, segment, end, 3] of nodes [time, rod, node, 3]."""
    return np.stack([nodes[:, :, :-1], nodes[:, :, 1:]], axis=3).reshape(2, -1, 2, 3)


def _small_offset(nodes: np.ndarray) -> np.ndarray:
    """A small displacement of each node [rod, node, 3], equal at all times."""
    size = np.linalg.norm(np.diff(nodes, axis=1), axis=-1).mean()
    return GENERAL * size * np.random.default_rng(0).standard_normal(nodes.shape)


def _rods_that_meet(
    rods: np.ndarray, shift: np.ndarray, overlapped: np.ndarray, when: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of rods [2, event] that begin to overlap, and the times [event] at which they do, from their segments."""
    if not len(when):
        return np.zeros((2, 0), int), np.zeros(0)
    keys, which = np.unique(np.column_stack([rods.T, shift]), axis=0, return_inverse=True)
    already, earliest = np.zeros(len(keys), bool), np.full(len(keys), np.inf)
    np.logical_or.at(already, which.ravel(), overlapped)
    np.minimum.at(earliest, which.ravel(), when)
    new = ~already & np.isfinite(earliest)
    return keys[new, :2].astype(int).T, earliest[new]
