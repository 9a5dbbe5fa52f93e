"""One run from a scene to its folder: steps, frames, checkpoints, progress."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods import arguments
from warp_rods import device as devices
from warp_rods.documented import Documented
from warp_rods.errors import SceneError
from warp_rods.notebook import html_table
from warp_rods.progress import Bar, waiting
from warp_rods.scene.scene import ENSEMBLES, Scene
from warp_rods.simulation import losses, timing
from warp_rods.simulation.checkpoint import State
from warp_rods.simulation.estimates import check_disk
from warp_rods.simulation.files import check_writable, default_folder
from warp_rods.simulation.hooks import Cadence, EveryFrame, read_hooks
from warp_rods.simulation.interruption import Interruption
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.opening import opened, where_to_begin
from warp_rods.simulation.report import Report
from warp_rods.simulation.run_folder import RunFolder
from warp_rods.simulation.saver import Saver, stop_for_failures
from warp_rods.simulation.stopping import leave, stopping
from warp_rods.simulation.under_way import Telling

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Console

PARTS = 1000
"""Parts of the progress bar."""
STEPS = ("steps_taken", "steps_rejected")

Hooks = Sequence[tuple[Cadence, Callable[[Simulation], Any]]]


class Run(metaclass=Documented):
    """A finished run.

    folder: where it is. scene: as run. order: its ensembles as in the scene. seconds it took, rod_steps done: none of a
    run that was at its end when it was continued. lost: a line for each rod that was frozen. messages: all that the run
    said, in order.
    """

    def __init__(
        self,
        folder: Path,
        scene: Scene,
        order: list[str],
        seconds: float,
        rod_steps: int,
        lost: list[str],
        messages: list[str],
    ):
        self.folder, self.scene, self.order = folder, scene, order
        self.seconds, self.rod_steps = seconds, rod_steps
        self.lost, self.messages = lost, messages

    def __repr__(self) -> str:
        lost = f", {len(self.lost)} rods lost" if self.lost else ""
        return f"<Run in {self.folder}: {', '.join(self.order)}; {self.seconds:.1f} s{lost}>"

    def _repr_html_(self) -> str:
        tables = {table.name: table for kind in ENSEMBLES for table in getattr(self.scene, kind)}
        rods = [(name, tables[name].count, tables[name].nodes) for name in self.order]
        rows = [*rods, ("lost", len(self.lost), ""), ("took", f"{self.seconds:.1f} s", "")]
        return html_table(rows, ("ensemble", "rods", "nodes"), f"Run in {self.folder}")

    @property
    def data(self) -> xr.DataTree:
        """The trajectory, read lazily."""
        from warp_rods.simulation.reading import open_run

        return open_run(self.folder)


def simulate(
    scene: Scene | str | Path,
    out: str | Path | None = None,
    *,
    device: str | None = None,
    overwrite: bool = False,
    resume: bool = False,
    hooks: Hooks = (),
    console: Console | None = None,
    then: Callable[[Path, Scene, Report], None] | None = None,
) -> Run:
    """Simulate a scene into the folder ``out`` (default ``runs/<scene name>``): trajectory and checkpoint.

    device: "cpu", "cuda:0", … (default: CUDA where there is one). hooks: pairs of a cadence and a function, as
    ``Simulation.attach`` takes them. console: where progress is shown (default: standard error). then: called at the
    end, when all frames are saved, with the folder and the messages of the run.
    resume: continue from the last checkpoint in the folder; where there is no run yet, start anew. The first SIGINT,
    SIGTERM or SIGHUP lets the run finish its step and save its state, then raises KeyboardInterrupt or SystemExit.
    Raises SceneError before anything is written, RunFolderError for a folder that holds a run (or, with ``resume``,
    another one), StorageError where the folder can no longer be written, RodFailure once no rod is left.
    """
    from rich.console import Console

    console = console or Console(stderr=True, markup=False, highlight=False)
    folder = default_folder(scene) if out is None else arguments.path("out", out)
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    if scene.sweep is not None:
        raise SceneError("sweep: this scene is a study: run it with `warp-rods sweep SCENE`, or without its [sweep]")
    device, attached = devices.choose(device), read_hooks(hooks)
    check_writable(folder, "out")
    mark, report = RunFolder.mark(folder), Report()
    scene, resume, overwrite = where_to_begin(scene, folder, resume, overwrite, report)
    there = RunFolder.size(folder) if resume or overwrite else 0.0
    check_disk(scene, folder, there)  # before anything is compiled; again when the numbers of nodes are chosen
    simulation = _prepare(scene, device, report, console)
    for line in check_disk(simulation.scene, folder, there):
        report.warn(line)
    if not resume:
        _tell_needs(simulation, report)
    for hook in attached:
        simulation.attach(hook.cadence, hook.function)
    with contextlib.ExitStack() as held:
        interruption = held.enter_context(Interruption())
        kept, state = opened(folder, simulation, resume, overwrite, mark)
        held.enter_context(kept)
        saver = Saver(kept, report)
        held.push(saver.keep_last_messages)
        simulation.attach(EveryFrame(), saver)
        at_end = state is not None and _continued(simulation, kept, state, report)
        start = time.perf_counter()
        rod_steps = 0 if at_end else _loop(simulation, kept, report, console, interruption)
        seconds = time.perf_counter() - start
        kept.finish()
        if interruption.number is not None:
            report.note(f"the run in {folder} is complete; for its animation: warp-rods export {folder} --usd")
        interruption.over()
        if then is not None:
            then(folder, simulation.scene, report)
    lost = losses.lines(simulation.ensembles)
    return Run(folder, simulation.scene, list(simulation.ensembles), seconds, rod_steps, lost, report.messages)


def _prepare(scene: Scene, device: str, report: Report, console: Console) -> Simulation:
    """Lay the scene out and compile its kernels, saying so: on a cold cache that takes a while."""
    start = time.perf_counter()
    with waiting("compiling kernels (once on a machine, then cached) and placing rods", console):
        simulation = Simulation(scene, device)
        simulation.warm_up()
    seconds = time.perf_counter() - start
    rods = f"{simulation.rods} rod{'s' if simulation.rods > 1 else ''} on {simulation.device}"
    report.note(f"{rods}; kernels compiled or loaded and rods placed in {seconds:.1f} s")
    for line in simulation.notes:
        report.note(line)
    for line in simulation.warnings:
        report.warn(line)
    return simulation


def _tell_needs(simulation: Simulation, report: Report) -> None:
    """What the rest of the run needs, and its steps."""
    for line in timing.lines(simulation):
        report.note(line)
    report.note(simulation.pace)


def _continued(simulation: Simulation, kept: RunFolder, state: State, report: Report) -> bool:
    """Put the simulation where the checkpoint has it; whether that is its end already."""
    simulation.restore(state)
    kept.continues_from = simulation.now
    simulation.new_failures()  # told before; raises where no rod is left
    if simulation.finished:
        report.note(f"already finished at t = {simulation.now:g}; give a larger time.end to go on")
        return True
    stop_for_failures(simulation)
    report.note(f"continuing from t = {simulation.now:g}")
    if not simulation.finished:
        _tell_needs(simulation, report)
    return False


def _loop(simulation: Simulation, kept: RunFolder, report: Report, console: Console, interruption: Interruption) -> int:
    """Step to the end with a progress bar; returns rod-steps done."""
    first, end, begun = simulation.rod_steps, simulation.scene.time.end, time.perf_counter()
    bar, others = Bar("running", PARTS, console, int(PARTS * simulation.now / end)), Telling(kept.path, simulation.now)
    with bar, others, stopping(simulation, kept, report):
        for _ in simulation.advance():
            others.tell(simulation.now, simulation.rod_steps - first)
            speed = (simulation.rod_steps - first) / (time.perf_counter() - begun)
            bar.update(int(PARTS * simulation.now / end), f"{speed:,.0f} rod-steps/s")
            kept.write_frames()
            if interruption.number is not None and not simulation.finished:
                leave(simulation, kept)
                interruption.end()
    _tell_losses(simulation, report)
    if simulation.together.finest > 1:
        report.note(f"contact: steps were cut into {simulation.together.finest} at times")
    if simulation.stopped is not None:
        report.note(f"stopped at t = {simulation.time:g}: {simulation.stopped}")
    if simulation.by_error:
        report.note(_steps_by_error(simulation))
    return simulation.rod_steps - first


def _tell_losses(simulation: Simulation, report: Report) -> None:
    """How many rods were lost in all, and what became of the others."""
    others = "the others go on without them" if simulation.interacting else "the others go on"
    others = "the others are not affected" if simulation.own_steps else others
    for name, ensemble in simulation.ensembles.items():
        if line := losses.summary(name, ensemble):
            report.warn(f"lost in all: {line}; they keep their last valid state, measures leave them out, {others}")


def _steps_by_error(simulation: Simulation) -> str:
    if not simulation.own_steps:
        control = simulation.together.control
        return f"{control.taken} steps; {control.rejected} more were repeated shorter"
    taken, rejected = (np.concatenate([getattr(e, name) for e in simulation.ensembles.values()]) for name in STEPS)
    each = (
        f"{taken.min()} to {taken.max()} steps a rod, {taken.sum()} in all" if len(taken) > 1 else f"{taken[0]} steps"
    )
    return f"{each}; {rejected.sum()} more were repeated shorter"
