"""Warnings about the results of a run while it is in progress; each is given once."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from warp_rods.rods.ensemble import Ensemble

NEAR = 0.1
"""Users are warned of filaments closer than this to the end of their surface, in units of their length."""
RISE = 1e-3
"""Users are warned if the energy of passive filaments rises by more than this fraction between frames; round-off is
much smaller."""


class EnergyWatch:
    """Checks that passive filaments lose energy, steric energy included; without interaction, each of them must.

    interacting: whether rods interact. Not to be used with a moving membrane, which may do work on filaments.
    """

    def __init__(self, interacting: bool):
        self._interacting = interacting
        self._previous: dict[str, np.ndarray] = {}
        self._warned: set[str] = set()

    def check(self, time: float, frame: dict[str, dict[str, np.ndarray]]) -> list[str]:
        """Warnings for ensembles whose energy rose since the last frame; frame: {ensemble: variables}."""
        passive = {name: v for name, v in frame.items() if "growth_power" in v and not v["growth_power"].any()}
        if self._interacting and len(passive) < len(frame):
            return []
        energies = {name: v["energy"] + v["steric_energy"] for name, v in passive.items()}
        if self._interacting:
            energies = {"all filaments": np.array([sum(e.sum() for e in energies.values())])}
        lines = [line for name, energy in energies.items() if (line := self._warning(name, energy, time))]
        self._previous = energies
        return lines

    def _warning(self, name: str, energy: np.ndarray, time: float) -> str:
        previous = self._previous.get(name, energy)
        rose = np.flatnonzero(energy > previous * (1 + RISE) + RISE * np.abs(previous).mean())
        if not len(rose) or name in self._warned:
            return ""
        self._warned.add(name)
        which = name if self._interacting else f"rod {rose[0]} of {name}"
        return (
            f"by t = {time:g} the energy of {which} rose from {previous[rose[0]]:.4g} to {energy[rose[0]]:.4g}, but "
            f"passive filaments can only lose energy: use a smaller time step or more nodes"
        )


class EndWatch:
    """Checks that filaments stay away from the end of their surface, the box in which φ is given."""

    def __init__(self, ends: dict[str, tuple[np.ndarray, np.ndarray]]):
        """ends: lower and upper corner [3] of the box by ensemble."""
        self._ends = {name: (low, high) for name, (low, high) in ends.items() if np.isfinite([low, high]).any()}

    def check(self, time: float, frame: dict[str, dict[str, np.ndarray]]) -> list[str]:
        """Warnings for ensembles of which a filament has come near the end; frame: {ensemble: variables}."""
        lines = []
        for name, (low, high) in list(self._ends.items()):
            position, length = frame[name]["position"], frame[name]["length"]
            left = np.minimum(position - low, high - position).min(axis=(1, 2))
            left = np.where(frame[name]["status"] == 0, left, np.inf)
            if (near := left < NEAR * length).any():
                rod = int(np.argmin(left))
                del self._ends[name]
                lines.append(
                    f"at t = {time:g} {int(near.sum())} of {name} are close to the end of their surface (rod {rod} is "
                    f"{left[rod]:.3g} from the box in which φ is given); a rod that reaches it is frozen"
                )
        return lines


class StepWatch:
    """Checks the errors of steps of a given length."""

    def __init__(self) -> None:
        self._warned = set[str]()

    def check(self, ensembles: Mapping[str, Ensemble]) -> list[str]:
        """Warnings for ensembles whose steps have a large error."""
        lines = []
        for name, rods in ensembles.items():
            if name not in self._warned and (line := rods.error_report()):
                self._warned.add(name)
                lines.append(f"{name}: {line} (leave time.step out)")
        return lines
