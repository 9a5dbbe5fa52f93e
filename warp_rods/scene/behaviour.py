"""Behaviours of swimmers: the table of them, and the table ``behaviour`` of a scene.

To add one: a function, a number and a branch in ``kernels/free/behaviour.py``, and a row of ``BEHAVIOURS`` here with
the name of that number and its parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ConfigDict

from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import OR_EACH
from warp_rods.values import LARGEST, SMALLEST, nearest, shown

__all__ = ["BEHAVIOURS", "MOST_EVENTS", "Behaviour", "BehaviourTable"]

MOST_EVENTS = 1e4
"""The largest rate, and the inverse of the shortest duration: events that are denser are not resolved."""


ALLOWED: dict[str, tuple[str, Callable[[float], bool]]] = {
    "rate": (f"a positive number, at most {MOST_EVENTS:g}", lambda value: SMALLEST <= value <= MOST_EVENTS),
    "duration": (f"a number, at least {1 / MOST_EVENTS:g}", lambda value: 1 / MOST_EVENTS <= value <= LARGEST),
    "angle": ("a number from 0 to pi: radians", lambda value: 0 <= value <= math.pi),
}
"""Kinds of parameters: what is allowed, in words, and whether a value is."""


@dataclass(frozen=True)
class Behaviour:
    """What it does, the name of its number in ``kernels/free/behaviour.py``, and at most four parameters.

    Those are name → key of ``ALLOWED``, each one number for all rods, or one for each. The kernel gets them in this
    order. turns: whether it turns rods.
    """

    meaning: str
    kernel: str
    parameters: Mapping[str, str]
    turns: bool = False

    def words(self, name: str) -> str:
        """What is allowed for a parameter."""
        return ALLOWED[self.parameters[name]][0]

    def allows(self, name: str, value: float) -> bool:
        """Whether a parameter may have this value."""
        return ALLOWED[self.parameters[name]][1](value)


BEHAVIOURS: dict[str, Behaviour] = {
    "reversal": Behaviour("at random times the target of the flagella changes its sign", "REVERSAL", {"rate": "rate"}),
    "tumble": Behaviour(
        "at random times each half has a random target for a while, and the rod turns",
        "TUMBLE",
        {"rate": "rate", "duration": "duration", "turn": "angle"},
        turns=True,
    ),
}
"""Behaviours by name."""


class BehaviourTable(Table):
    """What swimmers do at random times; each of its keys is a table of the parameters of a behaviour."""

    model_config = ConfigDict(extra="allow")

    @property
    def behaviours(self) -> dict[str, dict[str, Any]]:
        """Parameters by name, by name of the behaviour."""
        return dict(self.model_extra or {})

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        """Unknown behaviours, and missing, unknown or wrong parameters."""
        faults = []
        for name, given in raw.items():
            if name not in BEHAVIOURS:
                text = f": unknown behaviour{nearest(name, BEHAVIOURS)}; known: {', '.join(BEHAVIOURS)}"
                faults.append(fault((name,), given, text))
            elif not isinstance(given, dict):
                keys = ", ".join(BEHAVIOURS[name].parameters)
                faults.append(fault((name,), given, f" = {shown(given)}: must be a table {{ {keys} }}"))
            else:
                faults += _faults_of(name, BEHAVIOURS[name], given)
        return faults


def _faults_of(name: str, row: Behaviour, given: Mapping[str, Any]) -> Faults:
    faults = []
    for key in dict.fromkeys((*row.parameters, *given)):
        if key not in row.parameters:
            text = f": unknown key{nearest(key, row.parameters)}; known here: {', '.join(row.parameters)}"
            faults.append(fault((name, key), given[key], text))
        elif key not in given:
            faults.append(fault((name, key), None, f": missing; must be {row.words(key)}{OR_EACH}"))
        else:
            values = given[key] if isinstance(given[key], tuple) else (given[key],)
            if not values or not all(_is_number(value) and row.allows(key, value) for value in values):
                text = f" = {shown(given[key])}: must be {row.words(key)}{OR_EACH}"
                faults.append(fault((name, key), given[key], text))
    return faults


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
