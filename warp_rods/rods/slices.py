"""Slices of the rods or points that threads share: which slices there are, and their arrays as views."""

from __future__ import annotations

import itertools
from typing import Any

import warp as wp

from warp_rods.device import cores
from warp_rods.kernels.lanes import WIDTH
from warp_rods.rods.tiles import is_tiled, tiles_of

NODES_PER_THREAD = 10_000
"""A thread steps this many nodes in about a millisecond. With fewer nodes the cost of starting it is noticeable."""
NODES_AT_OWN_PACE = 500
"""The same where rods take steps of their own: threads start once for many steps, and never wait for each other."""


def thread_slices(count: int, nodes: int, device: Any, own_pace: bool = False) -> list[slice]:
    """Slices of ``count`` rods of ``nodes`` nodes, one for each thread that has enough to do; a single one on CUDA.

    They begin where a tile begins. own_pace: rods take steps of their own.
    """
    tiles, enough = tiles_of(count), min(NODES_AT_OWN_PACE if own_pace else NODES_PER_THREAD, NODES_PER_THREAD)
    threads = 1 if wp.get_device(device).is_cuda else min(cores(), count * nodes // enough, tiles)
    edges = [min(tiles * i // max(threads, 1) * WIDTH, count) for i in range(max(threads, 1) + 1)]
    return [slice(a, b) for a, b in itertools.pairwise(edges)]


def slice_array(array: Any, rods: slice) -> Any:
    """These rods of an array [rod, …] or [tile, …]; None for None."""
    if array is None or not is_tiled(array):
        return None if array is None else array[rods]
    return array[rods.start // WIDTH : tiles_of(rods.stop)]


def slice_struct(kind: Any, value: Any, rods: slice) -> Any:
    """A struct of this ``kind`` (a ``wp.struct``) with these rods of its arrays, where it has them, and the same
    scalars."""
    view = kind()
    for name in kind.vars:
        part = getattr(value, name)
        if isinstance(part, wp.array):
            part = slice_array(part, rods)
        elif part is not None and hasattr(kind.vars[name].type, "vars"):
            part = slice_struct(kind.vars[name].type, part, rods)
        setattr(view, name, part)
    return view
