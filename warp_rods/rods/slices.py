"""Slices of the rods or points that threads share: which slices there are, and their arrays as views."""

from __future__ import annotations

import itertools
from typing import Any

import warp as wp

from warp_rods.device import cores

NODES_PER_THREAD = 10_000
"""A thread steps this many nodes in about a millisecond. With fewer nodes the cost of starting it is noticeable."""


def thread_slices(count: int, nodes: int, device: Any) -> list[slice]:
    """Slices of ``count`` rods of ``nodes`` nodes, one for each thread that has enough to do; a single one on CUDA."""
    threads = 1 if wp.get_device(device).is_cuda else min(cores(), count * nodes // NODES_PER_THREAD, count)
    edges = [count * i // max(threads, 1) for i in range(max(threads, 1) + 1)]
    return [slice(a, b) for a, b in itertools.pairwise(edges)]


def slice_array(array: wp.array | None, rods: slice) -> wp.array | None:
    """These rods of an array [rod, …]; None for None."""
    return None if array is None else array[rods]


def slice_struct(kind: Any, value: Any, rods: slice) -> Any:
    """A struct of this ``kind`` (a ``wp.struct``) with these rods of its arrays [rod, …] and the same scalars."""
    view = kind()
    for name in kind.vars:
        part = getattr(value, name)
        if isinstance(part, wp.array):
            part = part[rods]
        elif hasattr(kind.vars[name].type, "vars"):
            part = slice_struct(kind.vars[name].type, part, rods)
        setattr(view, name, part)
    return view
