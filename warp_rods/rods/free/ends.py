"""What holds and loads the ends of free rods (docs/model.md §2.7)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError, named, refuse_unknown
from warp_rods.kernels.free import state
from warp_rods.rods.per_rod import parameter

KINDS = {"free": int(state.FREE), "hinged": int(state.HINGED), "clamped": int(state.CLAMPED)}
"""Name of a kind of end → its number in the kernels."""
LOADS = {"free": ("thrust", "torque"), "hinged": ("torque",), "clamped": ("turning",)}
"""What an end of each kind may have: a force along the tangent and a couple about it, which follow the rod; the rate at
which a clamped end is turned about its tangent."""


@dataclass(frozen=True)
class End:
    """One end of rods: ``kind``, and what it has of ``LOADS`` [rod]."""

    kind: str
    thrust: np.ndarray
    torque: np.ndarray
    turning: np.ndarray

    @classmethod
    def read(cls, name: str, given: Any, count: int) -> End:
        """From the name of a kind, or a table {kind, …} with what that kind may have; raises SceneError."""
        table = {"kind": given} if isinstance(given, str) else given
        if not isinstance(table, Mapping):
            raise arguments.wrong(name, given, f"one of {', '.join(KINDS)}, or a table {{kind, …}}")
        kind = str(table.get("kind", "free"))
        named(KINDS, f"{name}.kind", kind)
        refuse_unknown(table, ["kind", *LOADS[kind]], f"a {kind} end")
        values = {
            load: parameter(f"{name}.{load}", table.get(load, 0.0), count, arguments.ANY)
            for load in ("thrust", "torque", "turning")
        }
        return cls(kind, **values)

    @property
    def held(self) -> bool:
        """Whether something holds the end."""
        return self.kind != "free"


def ends_of(given: Any, count: int) -> tuple[End, End]:
    """The first and the last end from two of what ``End.read`` takes, or None for free ends; raises SceneError."""
    if given is None:
        given = ("free", "free")
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
        raise arguments.wrong("ends", given, "two ends, the first and the last, each a kind or a table {kind, …}")
    first, last = End.read("ends[0]", given[0], count), End.read("ends[1]", given[1], count)
    return first, last


def tracked_node(first: End, last: End, nodes: int) -> int:
    """The node whose frame is integrated in time: a held end, a clamped one first, otherwise the middle node."""
    if first.kind == "clamped" or (first.held and last.kind != "clamped"):
        return 0
    return nodes - 1 if last.held else nodes // 2


def check_ends(first: End, last: End, symmetric: bool) -> None:
    """Raises SceneError for ends that contradict each other or ``symmetric``."""
    plain = first.kind == last.kind == "free" and not any(e.thrust.any() or e.torque.any() for e in (first, last))
    if symmetric and not plain:
        raise SceneError("symmetric = true: the ends must be free and without loads")
