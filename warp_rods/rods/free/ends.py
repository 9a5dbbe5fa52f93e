"""What holds and loads the ends of free rods (docs/model.md §2.11)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import named as check_named
from warp_rods.errors import refuse_unknown
from warp_rods.kernels.free import state
from warp_rods.rods.free.motion import Motion
from warp_rods.rods.per_rod import parameter
from warp_rods.scene.ends import OF_KIND

KINDS = {"free": int(state.FREE), "hinged": int(state.HINGED), "clamped": int(state.CLAMPED)}
"""Name of a kind of end → its number in the kernels."""
NUMBERS = ("thrust", "torque", "turning")
VECTORS = ("force", "couple")
MOTIONS = ("motion", "rotation")


@dataclass(frozen=True)
class End:
    """One end of rods: its ``kind``, and what holds, moves or loads it.

    Loads that follow the rod [rod]: ``thrust`` along the tangent and ``torque`` about it, both positive along the
    direction of s. Loads in space [rod, 3]: ``force`` and ``couple``. A clamped end is turned about its tangent at the
    rate ``turning`` [rod]. ``motion`` and ``rotation`` are functions of time, or None: the displacement of a held end,
    and the rotation vector of a clamped one, in space.
    """

    kind: str
    thrust: np.ndarray
    torque: np.ndarray
    turning: np.ndarray
    force: np.ndarray
    couple: np.ndarray
    motion: Motion | None
    rotation: Motion | None

    @classmethod
    def read(cls, name: str, given: Any, count: int, named: Mapping[str, np.ndarray] | None = None) -> End:
        """From the name of a kind, or a table {kind, …} with what that kind may have; raises SceneError.

        named: parameters of formulas [rod].
        """
        table = {"kind": given} if isinstance(given, str) else given
        if not isinstance(table, Mapping):
            raise arguments.wrong(name, given, f"one of {', '.join(KINDS)}, or a table {{kind, …}}")
        kind = str(table.get("kind", "free"))
        check_named(KINDS, f"{name}.kind", kind)
        refuse_unknown(table, ["kind", *OF_KIND[kind]], f"a {kind} end")
        values: dict[str, Any] = {
            load: parameter(f"{name}.{load}", table.get(load, 0.0), count, arguments.ANY) for load in NUMBERS
        }
        values |= {
            load: parameter(f"{name}.{load}", table.get(load, (0.0,) * 3), count, (arguments.ANY,) * 3)
            for load in VECTORS
        }
        values |= {
            key: None if table.get(key) is None else Motion(f"{name}.{key}", table[key], named or {}, key == "motion")
            for key in MOTIONS
        }
        return cls(kind, **values)

    @property
    def held(self) -> bool:
        """Whether something holds the end."""
        return self.kind != "free"

    @property
    def in_space(self) -> bool:
        """Whether it moves, or has loads with a direction in space."""
        return bool(self.motion or self.rotation or self.force.any() or self.couple.any())

    @property
    def plain(self) -> bool:
        """Whether nothing holds or loads it."""
        return not (self.held or self.in_space or self.thrust.any() or self.torque.any())


def ends_of(given: Any, count: int, named: Mapping[str, np.ndarray] | None = None) -> tuple[End, End]:
    """The first and the last end from two of what ``End.read`` takes, or None for free ends; raises SceneError."""
    if given is None:
        given = ("free", "free")
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
        raise arguments.wrong("ends", given, "two ends, the first and the last, each a kind or a table {kind, …}")
    return End.read("ends[0]", given[0], count, named), End.read("ends[1]", given[1], count, named)


def tracked_node(first: End, last: End, nodes: int) -> int:
    """The node whose frame is integrated in time: a held end, a clamped one first, otherwise the middle node."""
    if first.kind == "clamped" or (first.held and last.kind != "clamped"):
        return 0
    return nodes - 1 if last.held else nodes // 2


def needs_places(first: End, last: End) -> bool:
    """Whether conditions at the ends depend on where the rod is: both are held, or one is moved or loaded in space."""
    return (first.held and last.held) or first.in_space or last.in_space
