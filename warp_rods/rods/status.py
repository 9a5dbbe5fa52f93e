"""The status of a rod, in words; it is saved with every frame of a trajectory."""

from __future__ import annotations

from enum import EnumMeta, IntEnum

from warp_rods.kernels import status


class _Documented(EnumMeta):
    """Limits ``help`` to the statuses and their words, without the members of integers."""

    def __dir__(cls) -> list[str]:
        return [*cls.__members__, "words"]


class Status(IntEnum, metaclass=_Documented):
    """OK, or why a rod was frozen at its last valid state; the numbers are those of ``kernels/status.py``."""

    OK = int(status.OK)
    NOT_FINITE = int(status.NOT_FINITE)
    OFF_SURFACE = int(status.OFF_SURFACE)
    TOO_BENT = int(status.TOO_BENT)
    TOO_FAST = int(status.TOO_FAST)
    KINK = int(status.KINK)
    LEFT_DATA = int(status.LEFT_DATA)
    UNRESOLVED = int(status.UNRESOLVED)

    @property
    def words(self) -> str:
        """What happened, in words that follow "the rod"."""
        return WORDS[self]


WORDS = {
    Status.OK: "is ok",
    Status.NOT_FINITE: "became non-finite",
    Status.OFF_SURFACE: "left its surface",
    Status.TOO_BENT: "bent by more than half a turn between two nodes",
    Status.TOO_FAST: "was about to move by more than its length in one step",
    Status.KINK: "reached a kink of its surface, or a bend that is too sharp for the spacing of its nodes",
    Status.LEFT_DATA: "reached the end of its surface, the box beyond which φ is not given",
    Status.UNRESOLVED: "changed too fast to be followed: its error was too large even in the shortest step",
}
