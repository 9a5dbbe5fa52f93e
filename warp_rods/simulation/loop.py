"""The simulation loop: steps from frame to frame under contact forces, and hooks."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.contact.surroundings import Surroundings
from warp_rods.device import device as device_of
from warp_rods.documented import Documented
from warp_rods.errors import RodFailure, RunFolderError, SceneError
from warp_rods.rods.control import TOLERANCE
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.together import LARGEST_MOVE, Together, exhaust
from warp_rods.scene.scene import Scene
from warp_rods.simulation import layout, losses
from warp_rods.simulation.frames import Frames
from warp_rods.simulation.hooks import Cadence, Hook
from warp_rods.simulation.output import check_output
from warp_rods.simulation.portions import Portions
from warp_rods.simulation.watch import EndWatch, EnergyWatch, StepWatch


class Simulation(metaclass=Documented):
    """A scene on a device: its surfaces, ensembles, contact forces and time step.

    ``notes`` and ``warnings`` are lines for the user. Raises SceneError for faults that the check of a scene does not
    find, such as a filament too long for its surface, a surface without points, or rods that do not fit.

    seeds: the rods of each ensemble are equal parts, placed and perturbed as in scenes of their own with these seeds.
    """

    _unlisted = frozenset(
        {
            "starts",
            "by_error",
            "rod_steps",
            "interacting",
            "frozen",
            "can_be_left",
            "trial",
            "new_failures",
            "new_warnings",
        }
    )

    def __init__(self, scene: Scene, device: str | None = None, *, seeds: Sequence[int] = ()):
        made = "a Scene: Scene.load(path) reads one, Scene.parse takes a mapping"
        self.scene, self.device = arguments.instance("scene", scene, Scene, made), device_of(device)
        self._losses = losses.Losses()
        laid_out = layout.lay_out(scene, self.device, seeds)
        self.scene = scene = laid_out.scene
        self.ensembles: dict[str, Ensemble] = laid_out.ensembles
        check_output(scene.output, self.ensembles)
        self.notes = laid_out.notes
        self.surfaces = {"surface": laid_out.surface, "box.surface": laid_out.container}
        """The membrane and the container of its box, None where there is none."""
        self.starts = laid_out.starts
        """Shapes of rods that are from files, by the name of the ensemble."""
        outside = scene.flow or scene.gravity or scene.forces
        membrane_moves = laid_out.surface is not None and laid_out.surface.moving
        changing = any(e.changes_in_time for e in self.ensembles.values())
        self._driven = bool(outside) or membrane_moves or changing
        self._surroundings = Surroundings(scene, self.ensembles, self.device, laid_out.container)
        self._surroundings.keep()
        self.together = Together(list(self.ensembles.values()), self._surroundings)
        if self._driven:  # what changes in time must not pass unseen
            self.together.longest = scene.time.save_every
            for ensemble in self.ensembles.values():
                ensemble.foresee(0.0, scene.time.end)
        self.warnings = laid_out.warnings
        self.step_size = scene.time.save_every if scene.time.step is None else scene.time.step
        """Δt, or the time between frames where steps are chosen by their error."""
        self.frames = Frames.of(scene.time)
        if scene.time.step is not None:
            self._keep_step()
        self.frame = 0
        self.steps_taken = 0
        """Steps since the start: planned ones, where one that contact divides counts once; or the steps by error, of
        rods in steps of their own the largest number."""
        self.stopped: str | None = None
        """The reason given by the hook that ended the run, if one did."""
        self._hooks: list[Hook] = []
        self._portions, self._within_portion = Portions(), False
        self._reset_warnings()

    def _keep_step(self) -> None:
        """Keep the step as it is taken in the scene: a whole number of steps fits between frames."""
        self.step_size = self.frames.longest_step
        scene = self.scene
        if not math.isclose(self.step_size, scene.time.step or 0.0):
            self.scene = scene.model_copy(update={"time": scene.time.model_copy(update={"step": self.step_size})})

    @property
    def by_error(self) -> bool:
        """Whether steps are chosen by their error, because the scene fixes none."""
        return self.scene.time.step is None

    @property
    def own_steps(self) -> bool:
        """Whether rods take steps of their own: chosen by error, and they do not feel each other."""
        alone = not self.interacting and not self._surroundings.has_walls
        return self.by_error and alone and all(e.has_own_steps for e in self.ensembles.values())

    @property
    def tolerance(self) -> float:
        """The error aimed at, in units of the length of a rod."""
        return TOLERANCE if self.scene.time.tolerance is None else self.scene.time.tolerance

    def __repr__(self) -> str:
        counts = [f"{name} ({e.count} rod{'s' if e.count > 1 else ''})" for name, e in self.ensembles.items()]
        return f"<Simulation of {', '.join(counts)} on {self.device}: t = {self.now:g} of {self.scene.time.end:g}>"

    def _reset_warnings(self) -> None:
        self._energy = EnergyWatch(self.interacting)
        self._end = EndWatch({name: e.ends_of_space for name, e in self.ensembles.items()})
        self._step_watch = StepWatch()
        self._contact_warned = False
        self._new_warnings: list[str] = []

    # --- advancing ---------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Time of the last frame reached."""
        return float(self.frames.times[self.frame])

    @property
    def now(self) -> float:
        """Time of the present state."""
        return next(iter(self.ensembles.values())).time

    @property
    def rods(self) -> int:
        """The number of rods of all ensembles."""
        return sum(e.count for e in self.ensembles.values())

    @property
    def frozen(self) -> int:
        """The number of rods that are frozen."""
        return losses.frozen(self.ensembles)

    @property
    def interacting(self) -> bool:
        """Whether rods feel each other."""
        return self._surroundings.neighbours is not None

    @property
    def finished(self) -> bool:
        """Whether the last frame was reached, or a hook ended the run."""
        return self.frame == self.frames.last or self.stopped is not None

    def attach(self, cadence: Cadence, function: Callable[[Simulation], Any]) -> None:
        """Call ``function(simulation)`` at a cadence: ``wr.every(steps=…)`` or ``wr.every(time=…)``.

        It is called at the start and then, with ``every(time=…)``, at its times, or after the first step of a given
        length that reaches them. With ``every(steps=…)`` it is called after steps, and where rods take steps of their
        own, at frames. The bits of the run do not change. The function may read ensembles, set ``force`` in scenes
        without contact and with ``time.step``, and call ``stop``; then it is not called again. Raises SceneError for
        anything that is not a cadence and a function.
        """
        self._hooks.append(Hook.read("attach", (cadence, function)))

    def stop(self, reason: str) -> None:
        """End the run at its next frame, which is saved, for a ``reason`` in words; the first one is kept."""
        reason = arguments.instance("reason", reason, str, "text that says why the run ends")
        if self.stopped is None:
            self.stopped = reason

    def advance(self) -> Iterator[int]:
        """Advance to the last frame, calling hooks; yields the number of planned steps since the start.

        At each yield the state is whole, and every hook that is due has been called: the run may be left there.
        """
        self._call_hooks()
        while not self.finished:
            for _ in self.to_next_frame():
                if self._between_frames:
                    self._call_hooks()
                    yield self.steps_taken
            self._call_hooks()
            yield self.steps_taken

    @property
    def _between_frames(self) -> bool:
        if self.by_error:
            return self.now < self.frames.times[self.frame + 1]
        return self.steps_taken < self.frames.steps_to(self.frame + 1)

    @property
    def rod_steps(self) -> int:
        """Steps of all rods since the start, those repeated included."""
        if self.own_steps:
            return sum(int(e.steps_taken.sum() + e.steps_rejected.sum()) for e in self.ensembles.values())
        return (self.steps_taken + self.together.control.rejected) * self.rods

    @property
    def pace(self) -> str:
        """How long steps are, for the user."""
        count = f"{len(self.frames.times)} frames"
        if not self.by_error:
            return f"Δt = {self.step_size:.3g}, {self.frames.steps_to(self.frames.last)} steps, {count}"
        which = "for each rod" if self.own_steps else "for all rods together"
        return f"steps chosen by their error {which}, tolerance {self.tolerance:g}, {count}"

    def _call_hooks(self) -> None:
        for hook in () if self._within_portion else self._hooks:
            hook.call_if_due(self)

    def to_next_frame(self) -> Iterator[int]:
        """Advance to the next frame; yields from time to time the number of steps taken towards it."""
        if self.by_error:
            yield from self._to_next_frame_by_error()
            return
        target, before = self.frame + 1, self.frames.steps_to(self.frame)
        steps = int(self.frames.steps[target])
        dt = float(self.frames.times[target] - self.frames.times[self.frame]) / steps
        taken = self.steps_taken - before  # where a run was stopped between frames
        for done in self.together.advance(dt, steps - taken):
            self.steps_taken = before + taken + done
            yield taken + done
        self.frame = target

    def _to_next_frame_by_error(self) -> Iterator[int]:
        """Advance to the next frame, with a stop at each time at which a hook is due."""
        frame = float(self.frames.times[self.frame + 1])
        while self.now < frame:
            due = min((hook.next_time(self) for hook in self._hooks), default=frame)
            for _ in self._advance_to(min(due, frame)):
                yield self.steps_taken
        self.frame += 1

    def _advance_to(self, time: float) -> Iterator[float]:
        """Advance to a time in steps chosen by error; yields the time reached from time to time."""
        if self.own_steps:
            for reached in self._portions.of(self.now, time):
                for ensemble in self.ensembles.values():
                    ensemble.advance_to(reached, self.tolerance)
                self._within_portion = reached < time
                if self._within_portion:
                    yield reached
            self.steps_taken = max(int(e.steps_taken.max()) for e in self.ensembles.values())
            yield time
        else:
            for reached in self.together.advance_to(time, self.tolerance):
                self.steps_taken = self.together.control.taken
                yield reached

    @contextlib.contextmanager
    def trial(self) -> Iterator[None]:
        """A context after which state, hooks and warnings are as before, whatever steps were taken in it."""
        before, hooks, self._hooks = self.state(), self._hooks, []
        seen = {name: ensemble.changes.seen for name, ensemble in self.ensembles.items()}
        try:
            yield
        finally:
            self.restore(before)
            for name, samples in seen.items():  # steps are bounded by what was foreseen
                self.ensembles[name].changes.seen = samples
            self._hooks, self._portions = hooks, Portions()
            self._reset_warnings()

    def warm_up(self) -> None:
        """Compile and load every kernel of a step and a frame; the state does not change."""
        with self.trial():
            self._surroundings.apply()
            if self.by_error:
                exhaust(self._advance_to(1e-12 * self.scene.time.end))
            else:
                exhaust(self.together.advance(self.step_size, 1))
            self.variables()

    # --- readings -----------------------------------------------------------------------------------------------

    def variables(self) -> dict[str, dict[str, np.ndarray]]:
        """The present frame as it is saved: ensemble → variable → values."""
        for ensemble in self.ensembles.values():
            ensemble.show()
        self._surroundings.apply()
        energies = self._surroundings.energies()
        found = {name: ensemble.variables() | energies[name] for name, ensemble in self.ensembles.items()}
        if not self._driven:
            self._new_warnings += self._energy.check(self.time, found)
        self._new_warnings += self._end.check(self.time, found)
        if not self.by_error:
            self._new_warnings += self._step_watch.check(self.ensembles)
        return found

    def new_warnings(self) -> list[str]:
        """Warnings about the results since the last call."""
        if self.together.unresolved and not self._contact_warned:
            self._contact_warned = True
            self._new_warnings.append(
                f"by t = {self.time:g} nodes moved by more than {LARGEST_MOVE:g} of the steric core even in the "
                f"shortest steps: rods may have passed through each other; place them apart or use smaller forces"
            )
        found, self._new_warnings = self._new_warnings, []
        return found

    def new_failures(self) -> list[str]:
        """Lines about rods that were frozen since the last call; raises RodFailure if all rods are frozen.

        A line for each of a few, and a summary of more than that.
        """
        lines = self._losses.check(self.ensembles)
        if self.frozen == self.rods:
            what = "more nodes or a smaller time.tolerance" if self.by_error else f"time.step below {self.step_size:g}"
            lost = losses.in_all(self.ensembles)
            raise RodFailure("\n".join([*lost, f"No rod is left: try {what}."]))
        return lines

    # --- state ------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, np.ndarray]:
        """Everything that the next step depends on, for a checkpoint."""
        arrays = {f"{name}/{key}": a for name, e in self.ensembles.items() for key, a in e.state().items()}
        done = self.steps_taken - self.frames.steps_to(self.frame)
        at = {"frame": np.array(self.frame), "steps_since_frame": np.array(0 if self.by_error else done)}
        return arrays | at | {"steps": self.together.state()} | self._surroundings.state()

    @property
    def can_be_left(self) -> bool:
        """Whether a run that is left here can be continued to any later end with the same bits.

        Not within the last time between frames if it is shorter than the others: a longer run has other steps there.
        """
        return self.by_error or self.time + self.scene.time.save_every <= self.frames.times[-1] * (1 + 1e-9)

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to a ``state`` of the same scene; the next steps have the same bits.

        Raises SceneError, and changes nothing, for a state that is not one of these ensembles.
        """
        parts = {name: _under(f"{name}/", state) for name in self.ensembles}
        for name, ensemble in self.ensembles.items():
            try:
                ensemble.check_state(parts[name])
            except SceneError as error:
                raise SceneError(f"{name}: {error}") from None
        arguments.whole("state['frame']", state.get("frame"), 0)
        done = arguments.whole("state['steps_since_frame']", state.get("steps_since_frame", 0), 0)
        for name, ensemble in self.ensembles.items():
            ensemble.restore(parts[name])
        self._surroundings.restore(state)
        self.together.restore(state["steps"])
        self.frame = int(state["frame"])
        self._check_time(done)
        self.steps_taken = self.frames.steps_to(self.frame) + done
        if self.own_steps:
            self.steps_taken = max(int(e.steps_taken.max()) for e in self.ensembles.values())
        elif self.by_error:
            self.steps_taken = self.together.control.taken
        for hook in self._hooks:
            hook.skip_past(self)

    def _check_time(self, done: int) -> None:
        """Raises RunFolderError unless the present state is at a frame or, if it was left there, between two."""
        last, end = self.frames.last, self.scene.time.end
        if self.frame > last:
            raise RunFolderError(f"the run is already beyond time.end = {end:g}")
        span = float(self.frames.times[min(self.frame + 1, last)]) - self.time
        if self.by_error:
            first, after, apart = self.time, self.time + span, 1e-9 * self.step_size
        else:
            first = after = self.time + (done * span / int(self.frames.steps[min(self.frame + 1, last)]) if done else 0)
            apart = self.step_size / 2
        now = [e.time for e in self.ensembles.values()]
        if (done and not self.can_be_left) or (self.by_error and max(now) > after + apart):
            raise RunFolderError(
                f"the run stopped at t = {self.now:g}, on its way to a frame beyond time.end = {end:g}: make it longer"
            )
        if min(now) < first - apart or max(now) > after + apart:
            raise RunFolderError("the run stopped at a time that is not a frame of this scene: run the scene again")


def _under(prefix: str, state: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays whose names begin with a prefix, without it."""
    return {name.removeprefix(prefix): array for name, array in state.items() if name.startswith(prefix)}
