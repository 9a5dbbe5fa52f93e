"""The status of a rod, in words: stored with every frame of a trajectory."""

from __future__ import annotations

from enum import IntEnum

from warp_rods.kernels import status


class Status(IntEnum):
    """Why a rod was frozen at its last sound state; the numbers are those of ``kernels/status.py``."""

    SOUND = int(status.SOUND)
    NOT_FINITE = int(status.NOT_FINITE)
    OFF_SURFACE = int(status.OFF_SURFACE)
    TOO_BENT = int(status.TOO_BENT)
    TOO_FAST = int(status.TOO_FAST)

    @property
    def words(self) -> str:
        """What happened, as the end of a sentence about the rod."""
        return WORDS[self]

    @classmethod
    def attributes(cls) -> dict[str, list[int] | str]:
        """CF's description of a variable of statuses: its values and, in the same order, their meanings."""
        return {"flag_values": [int(one) for one in cls], "flag_meanings": " ".join(one.name.lower() for one in cls)}


WORDS = {
    Status.SOUND: "is sound",
    Status.NOT_FINITE: "became non-finite",
    Status.OFF_SURFACE: "left its surface",
    Status.TOO_BENT: "bent by more than half a turn between two nodes",
    Status.TOO_FAST: "was about to move by more than its length in a step",
}
