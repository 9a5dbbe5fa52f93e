"""What throws doubt on the answers of a run while it goes on: each is said once."""

from __future__ import annotations

import numpy as np

RISE = 1e-3
"""Relative rise of the energy of passive filaments from frame to frame that is worth a warning; round-off is far
below."""


class EnergyWatch:
    """Passive filaments only lose energy, their steric energy included; where rods do not interact, each of them does.

    interacting: whether rods feel each other. Filaments on a moving membrane need not lose energy: do not ask then.
    """

    def __init__(self, interacting: bool):
        self._interacting = interacting
        self._before: dict[str, np.ndarray] = {}
        self._said: set[str] = set()

    def look(self, time: float, found: dict[str, dict[str, np.ndarray]]) -> list[str]:
        """Lines on the ensembles whose energy rose since the last look, from a frame {ensemble: variables}."""
        passive = {name: v for name, v in found.items() if "growth_power" in v and not v["growth_power"].any()}
        if self._interacting and len(passive) < len(found):
            return []
        energies = {name: v["energy"] + v["steric_energy"] for name, v in passive.items()}
        if self._interacting:
            energies = {"all filaments": np.array([sum(e.sum() for e in energies.values())])}
        lines = [line for name, energy in energies.items() if (line := self._rise(name, energy, time))]
        self._before = energies
        return lines

    def _rise(self, name: str, energy: np.ndarray, time: float) -> str:
        before = self._before.get(name, energy)
        rose = np.flatnonzero(energy > before * (1 + RISE) + RISE * np.abs(before).mean())
        if not len(rose) or name in self._said:
            return ""
        self._said.add(name)
        which = name if self._interacting else f"rod {rose[0]} of {name}"
        return (
            f"by t = {time:g} the energy of {which} rose from {before[rose[0]]:.4g} to {energy[rose[0]]:.4g}, but "
            f"passive filaments only lose energy: the step is too large, or there are too few nodes"
        )
