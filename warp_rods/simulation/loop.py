"""The loop: pair forces, step, save, checkpoint, progress. It knows no physics and writes only the run folder."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_rods.contact.steps import LARGEST_MOVE, Contact
from warp_rods.contact.surroundings import Surroundings
from warp_rods.errors import RodFailure, RunFolderError, SceneError
from warp_rods.rods.step_limits import SAFETY, StepLimit
from warp_rods.rods.variables import Variable
from warp_rods.scene.scene import Scene
from warp_rods.simulation import layout as ensembles

RISE = 1e-3
"""Relative rise of the energy of passive filaments from frame to frame that is told; round-off is far below."""
MOST_STEPS, MOST_FRAMES = 1e10, 1e6
FEWEST_STEPS = 1000
"""Steps that a run takes at least when the scene names none: bounds are of stability, this is for accuracy."""


class Ensemble(Protocol):
    """What every ensemble of rods offers to the loop."""

    count: int
    nodes: int
    time: float
    saved: dict[str, Variable]

    def static(self) -> dict[str, np.ndarray]: ...
    def step(self, dt: float, steps: int = 1) -> None: ...
    def variables(self) -> dict[str, np.ndarray]: ...
    def state(self) -> dict[str, np.ndarray]: ...
    def restore(self, state: dict[str, np.ndarray]) -> None: ...
    def failures(self) -> list[tuple[int, float, str]]: ...
    def parameters(self, rod: int) -> dict[str, Any]: ...


@dataclass(frozen=True)
class Frames:
    """When frames are saved, and the steps between them."""

    times: np.ndarray
    """[frame], the first 0."""
    steps: np.ndarray
    """[frame]: steps that lead to each, the first 0."""

    @property
    def longest_step(self) -> float:
        """The longest Δt between any two frames."""
        return float((np.diff(self.times) / self.steps[1:]).max())

    @classmethod
    def plan(cls, end: float, every: float, step: float) -> Frames:
        """Frames each ``every`` and at ``end``, with equal steps of at most ``step`` from one to the next."""
        if not end / every < MOST_FRAMES:
            raise SceneError(f"time.save_every = {every:g}: {end / every:.3g} frames are too many; save less often")
        count = math.floor(end / every + 1e-9)
        times = every * np.arange(count + 1)  # the last too where it is the end: a longer run has the same
        if times[-1] < end * (1 - 1e-9):
            times = np.append(times, end)
        spans = np.diff(times, prepend=0.0)
        steps = np.ceil(spans / step * (1 - 1e-9))
        if not steps.sum() < MOST_STEPS:
            raise SceneError(f"time.end = {end:g}: {steps.sum():.3g} steps of {step:.3g} are out of reach")
        return cls(times, steps.astype(int))


class Simulation:
    """A scene set up on a device: ensembles placed, forces and step chosen.

    Raises SceneError for what only shows when a scene is laid out: a filament too long for its surface, a
    surface without points, rods that do not fit. ``notes`` and ``warnings`` are lines for the user.
    """

    def __init__(self, scene: Scene, device: str | None = None):
        self.scene, self.device = scene, wp.get_device(device)
        self._known_failures: set[tuple[str, int]] = set()
        layout = ensembles.lay_out(scene, self.device)
        self.ensembles: dict[str, Ensemble] = layout.ensembles
        self.notes = layout.notes
        self._membrane_works = layout.surface is not None and layout.surface.moving
        self._surroundings = Surroundings(scene, self.ensembles, self.device, layout.container)
        self._surroundings.refresh()
        self.contact = Contact(self.ensembles, self._surroundings, self.device)
        self.step_size, self.warnings = self._choose_step(layout.limits)
        self.warnings += layout.warnings
        self.frames = Frames.plan(scene.time.end, scene.time.save_every, self.step_size)
        if scene.time.step is None or not np.isclose(self.frames.longest_step, scene.time.step, rtol=1e-9):
            self.step_size = self.frames.longest_step
            self.scene = scene.model_copy(update={"time": scene.time.model_copy(update={"step": self.step_size})})
        self.frame = 0
        self._energies: dict[str, np.ndarray] = {}
        self._doubted: set[str] = set()
        self._doubts: list[str] = []

    def _choose_step(self, limits: dict[str, StepLimit]) -> tuple[float, list[str]]:
        """The scene's step, or a safe share of the smallest bound; a line for each bound that it breaks."""
        wanted = self.scene.time.step
        if wanted is None:
            smallest = min(limit.step for limit in limits.values())
            return min(SAFETY * smallest, self.scene.time.save_every, self.scene.time.end / FEWEST_STEPS), []
        broken = [(name, limit) for name, limit in limits.items() if wanted > limit.step]
        return wanted, [
            f"time.step = {wanted:g} is above {limit.step:.3g}, the bound for {name}: {limit.reason}. Beyond it the "
            f"answer can be wrong without blowing up: use a smaller step, or leave it out to have it chosen."
            for name, limit in broken
        ]

    @property
    def time(self) -> float:
        """Time of the last frame reached."""
        return float(self.frames.times[self.frame])

    @property
    def rods(self) -> int:
        """Rods of all ensembles."""
        return sum(e.count for e in self.ensembles.values())

    def warm_up(self) -> None:
        """Compile and load every kernel of a step and a frame; the state stays as it is."""
        before = self.state()
        self._surroundings.exert()
        for ensemble in self.ensembles.values():
            ensemble.step(self.step_size)
        self.variables()
        self.restore(before)
        self._energies, self._doubts, self._doubted = {}, [], set()

    def to_next_frame(self) -> Iterator[int]:
        """Step to the next frame; yields now and then how many steps of it are done."""
        target = self.frame + 1
        steps = int(self.frames.steps[target])
        dt = float(self.frames.times[target] - self.frames.times[self.frame]) / steps
        yield from self.contact.advance(dt, steps)
        self.frame = target

    def variables(self) -> dict[str, dict[str, np.ndarray]]:
        """The present frame as the trajectory keeps it: ensemble → variable → values."""
        self._surroundings.exert()
        energies = self._surroundings.energies()
        found = {name: ensemble.variables() | energies[name] for name, ensemble in self.ensembles.items()}
        self._watch_energy(found)
        return found

    def _watch_energy(self, found: dict[str, dict[str, np.ndarray]]) -> None:
        """Passive filaments only lose energy, their sterics' included; where there are none, each of them does.

        On a moving membrane they need not.
        """
        if self._membrane_works:
            return
        passive = {name: v for name, v in found.items() if "power" not in v and not v["growth_power"].any()}
        if self._surroundings.neighbours and len(passive) < len(found):
            return
        energies = {name: v["energy"] + v["steric_energy"] for name, v in passive.items()}
        if self._surroundings.neighbours:
            energies = {"all filaments": np.array([sum(e.sum() for e in energies.values())])}
        for name, energy in energies.items():
            before = self._energies.get(name, energy)
            rose = np.flatnonzero(energy > before * (1 + RISE) + RISE * np.abs(before).mean())
            if len(rose) and name not in self._doubted:
                self._doubted.add(name)
                which = name if self._surroundings.neighbours else f"rod {rose[0]} of {name}"
                self._doubts.append(
                    f"by t = {self.time:g} the energy of {which} rose from {before[rose[0]]:.4g} to "
                    f"{energy[rose[0]]:.4g}, and passive filaments only lose energy: the step is too large, or the "
                    f"nodes are too few"
                )
        self._energies = energies

    def new_doubts(self) -> list[str]:
        """A line for each thing seen since this was last asked that throws doubt on the answers."""
        if self.contact.unresolved and "contact" not in self._doubted:
            self._doubted.add("contact")
            self._doubts.append(
                f"by t = {self.time:g} nodes moved by more than {LARGEST_MOVE:g} of the steric core in a step, however "
                f"short: rods may have passed through each other; place them farther apart, or weaken what drives them"
            )
        found, self._doubts = self._doubts, []
        return found

    def new_failures(self) -> list[str]:
        """A line for each rod that was lost since this was last asked; RodFailure once all rods are lost."""
        lines, lost = [], 0
        for name, ensemble in self.ensembles.items():
            for rod, when, what in ensemble.failures():
                lost += 1
                if (name, rod) not in self._known_failures:
                    self._known_failures.add((name, rod))
                    lines.append(f"{name}: rod {rod} {what} at t = {when:.6g}; parameters {ensemble.parameters(rod)}")
        if lost == self.rods:
            raise RodFailure("\n".join([*lines, f"No rod is left: try time.step below {self.step_size:g}."]))
        return lines

    def state(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, for a checkpoint."""
        arrays = {f"{name}/{key}": a for name, e in self.ensembles.items() for key, a in e.state().items()}
        return {**arrays, "frame": np.array(self.frame), "parts": np.array(self.contact.parts)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go back to a ``state`` of the same scene; the next steps have the same bits."""
        for name, ensemble in self.ensembles.items():
            prefix = f"{name}/"
            ensemble.restore({k.removeprefix(prefix): a for k, a in state.items() if k.startswith(prefix)})
        self._surroundings.refresh()
        self.contact.parts = int(state.get("parts", 1))  # of a run from before steps were cut there is none
        self.frame = int(state["frame"])
        if self.frame >= len(self.frames.times):
            raise RunFolderError(f"the run is beyond time.end = {self.scene.time.end:g} already")
        if any(not np.isclose(e.time, self.time) for e in self.ensembles.values()):
            raise RunFolderError("the run stopped at a time that is no frame of this scene: run it anew")
