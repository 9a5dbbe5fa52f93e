"""Some of the rods of an ensemble's arrays, as views: a thread each steps its own."""

from __future__ import annotations

from typing import Any

import warp as wp


def of_array(array: wp.array | None, rods: slice) -> wp.array | None:
    """These rods of an array [rod, …]; None stays None."""
    return None if array is None else array[rods]


def of_struct(kind: Any, value: Any, rods: slice) -> Any:
    """The struct of this ``kind`` (a ``wp.struct``) with these rods of its arrays [rod, …]; its numbers stay."""
    view = kind()
    for name in kind.vars:
        part = getattr(value, name)
        setattr(view, name, part[rods] if isinstance(part, wp.array) else part)
    return view
