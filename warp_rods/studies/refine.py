"""Which points a refinement adds: those within cells whose corners differ.

A cell is between neighbours in the ranges. It is halved in every direction where a word, such as the class of the
motion, differs along one of its edges, or a number by more than ``SHARE`` of the range of all, or where one end has a
value and the other none. Numbers are means over the seeds, words the commonest. Cells stay those of a grid, so that
the store has one labelled array; the library ``adaptive`` adds scattered points, a few at a time, by numbers alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from warp_rods.analysis.averages import mean_or_commonest
from warp_rods.studies.plan import Plan
from warp_rods.studies.store import Store

__all__ = ["SHARE", "added"]

SHARE = 0.2
"""Of the range of a number: neighbours that differ by more are refined."""


def added(plan: Plan, store: Store, level: int, states: np.ndarray) -> np.ndarray:
    """The points of a level of refinement, from 1 on, as a mask of the grid, those that are computed included."""
    strides = [max(axis.stride // 2 ** (level - 1), 1) for axis in plan.axes[:-1]]
    refined = [k for k, axis in enumerate(plan.axes[:-1]) if axis.stride > 1]
    coarse = tuple(slice(None, None, step) for step in strides)
    known = np.all(states[coarse] > 0, axis=-1)
    cells = _corners(np.asarray(known), refined, np.logical_and)
    different = np.zeros_like(cells)
    for name in store.scalars:
        values = mean_or_commonest(store.whole(name)[coarse])
        for axis in refined:
            edges = _differ(values, axis)
            different |= _corners(edges, [k for k in refined if k != axis], np.logical_or)
    mask = np.zeros(plan.shape, dtype=bool)
    for cell in np.argwhere(cells & different):
        place = (
            slice(int(c) * step, int(c) * step + step + 1, step // 2) if k in refined else int(c)
            for k, (c, step) in enumerate(zip(cell, strides, strict=True))
        )
        mask[tuple(place)] = True
    return mask


def _differ(values: np.ndarray, axis: int) -> np.ndarray:
    """Whether neighbours along an axis differ; something measured differs from nothing."""
    count = values.shape[axis]
    a, b = values.take(range(count - 1), axis), values.take(range(1, count), axis)
    if values.dtype == object:
        return np.asarray(a != b)
    finite = values[np.isfinite(values)]
    reach = SHARE * float(np.ptp(finite)) if len(finite) else 0.0
    with np.errstate(invalid="ignore"):
        return (np.abs(a - b) > reach) | (np.isfinite(a) != np.isfinite(b))


def _corners(values: np.ndarray, axes: Sequence[int], joined: np.ufunc) -> np.ndarray:
    """Values of both neighbours along all these axes, joined."""
    for axis in axes:
        count = values.shape[axis]
        values = joined(values.take(range(count - 1), axis), values.take(range(1, count), axis))
    return values


def levels(plan: Plan, store: Store) -> Iterator[tuple[int, np.ndarray]]:
    """The levels whose points are known, with masks of these: as far as the points of those before are computed."""
    mask = plan.first()
    yield 0, mask
    for level in range(1, plan.levels + 1):
        states = store.states()
        if not (states[mask] > 0).all():
            return
        mask = added(plan, store, level, states)
        yield level, mask
