"""One run from a scene to its folder, with a progress bar: what ``warp-rods run`` and ``wr.run`` do."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import warp as wp
import xarray as xr
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from warp_rods.errors import SceneError
from warp_rods.rods.variables import STATIC
from warp_rods.scene.scene import Scene
from warp_rods.simulation import trajectory
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.run_folder import RunFolder, as_begun
from warp_rods.simulation.trajectory import GroupSpec

CHECKPOINT_EVERY = 2.0
"""Seconds between checkpoints, at most one a frame."""
REFRESH = 0.1
"""Seconds between updates of the bar."""


class Run:
    """A finished run: its ``folder``, what it reported, and its trajectory as ``data``."""

    def __init__(self, folder: Path, order: list[str], seconds: float, rod_steps: int, lost: list[str]):
        self.folder, self.order, self.seconds, self.rod_steps, self.lost = folder, order, seconds, rod_steps, lost

    @property
    def data(self) -> xr.DataTree:
        """The trajectory, read lazily."""
        return trajectory.open_run(self.folder)


def run(
    scene: Scene | str | Path,
    out: str | Path | None = None,
    *,
    device: str | None = None,
    overwrite: bool = False,
    resume: bool = False,
    console: Console | None = None,
) -> Run:
    """Simulate a scene into the folder ``out`` (default ``runs/<scene name>``): trajectory, checkpoint, animation.

    device: "cpu", "cuda:0", … (default: CUDA where there is one). Raises SceneError before anything is written,
    RunFolderError for a folder that holds a run (or, with ``resume``, none), RodFailure once no rod is left.
    """
    console = console or Console(stderr=True, markup=False, highlight=False)
    folder = Path(out) if out else Path("runs") / (Path(scene).stem if isinstance(scene, (str, Path)) else "scene")
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    device = device_name(device)
    if resume:
        scene = as_begun(folder, scene)
    else:
        RunFolder.check_free(folder, overwrite)
    simulation = _prepare(scene, device, console)
    if resume:
        kept, state = RunFolder.resume(folder, simulation.scene, _attributes(simulation))
    else:
        kept, state = RunFolder.create(folder, _groups(simulation), _attributes(simulation)), None
    with kept:
        _begin(simulation, kept, state, console)
        start = time.perf_counter()
        rod_steps, lost = _loop(simulation, kept, console)
        seconds = time.perf_counter() - start
    _animate(folder, console)
    return Run(folder, list(simulation.ensembles), seconds, rod_steps, lost)


def device_name(name: str | None) -> str:
    """Warp's name of a device; None or "auto" is CUDA where there is one. Raises SceneError for one not here."""
    known = [device.alias for device in wp.get_devices()]
    if name in (None, "auto"):
        return "cuda:0" if "cuda:0" in known else "cpu"
    if name not in known:
        raise SceneError(f"--device {name}: there is no such device here; there are {', '.join(['auto', *known])}")
    return name


def _prepare(scene: Scene, device: str | None, console: Console) -> Simulation:
    """Lay the scene out and compile its kernels, saying so: on a cold cache that takes a while."""
    start = time.perf_counter()
    with console.status("compiling kernels (once on a machine, then cached) and placing rods …"):
        simulation = Simulation(scene, device)
        simulation.warm_up()
    console.print(
        f"{simulation.rods} rods on {simulation.device}; kernels compiled or loaded and rods placed in "
        f"{time.perf_counter() - start:.1f} s"
    )
    for line in simulation.notes:
        console.print(line)
    for line in simulation.warnings:
        _warn(console, line)
    frames = simulation.frames
    console.print(
        f"Δt = {simulation.step_size:.3g}, {int(frames.steps.sum())} steps, {len(frames.times)} frames", highlight=False
    )
    return simulation


def _begin(simulation: Simulation, kept: RunFolder, state: dict[str, np.ndarray] | None, console: Console) -> None:
    """The first frame and a checkpoint of it, or the state of the checkpoint to go on from."""
    if state is not None:
        simulation.restore(state)
        over = simulation.frame == len(simulation.frames.times) - 1
        more = ": that is time.end already; make it longer to go on" if over else ""
        console.print(f"going on from t = {simulation.time:g}{more}")
    else:
        kept.writer.append(0.0, simulation.variables())
        kept.checkpoint(simulation.state())
    kept.keep(simulation.scene)


def _loop(simulation: Simulation, kept: RunFolder, console: Console) -> tuple[int, list[str]]:
    """Step, save, checkpoint until the end; returns rod-steps done and a line for each rod lost."""
    frames, lost, done_before = simulation.frames, [], 0
    planned, past = int(frames.steps.sum()), int(frames.steps[: simulation.frame + 1].sum())
    begun = shown = saved = time.perf_counter()
    with _bar(console) as bar, _stopping(simulation, kept, console):
        task = bar.add_task("running", total=planned, completed=past, speed="")
        while simulation.frame < len(frames.times) - 1:
            for done in simulation.to_next_frame():
                now = time.perf_counter()
                if now - shown > REFRESH:
                    shown = now
                    steps = done_before + done
                    speed = f"{steps * simulation.rods / (now - begun):,.0f} rod-steps/s"
                    bar.update(task, completed=past + steps, speed=speed)
            done_before += int(frames.steps[simulation.frame])
            kept.writer.append(simulation.time, simulation.variables())
            if time.perf_counter() - saved > CHECKPOINT_EVERY or simulation.frame == len(frames.times) - 1:
                saved = time.perf_counter()
                kept.checkpoint(simulation.state())
            for line in simulation.new_failures():
                lost.append(line)
                _warn(bar.console, f"lost: {line}; it stays as it was, the others go on")
            for line in simulation.new_doubts():
                _warn(bar.console, line)
        bar.update(task, completed=planned)
    if simulation.contact.finest > 1:
        console.print(f"contact: steps were cut into {simulation.contact.finest} at times")
    return done_before * simulation.rods, lost


def _warn(console: Console, line: str) -> None:
    console.print(f"warning: {line}", style="yellow")


@contextlib.contextmanager
def _stopping(simulation: Simulation, kept: RunFolder, console: Console) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        again = simulation.frames.times[max(kept.checkpointed, 0)]
        console.print(f"stopped at t = {simulation.time:g}; {kept.path} is readable, --resume goes on from {again:g}")
        raise


def _bar(console: Console) -> Progress:
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    return Progress(*columns, TextColumn("{task.fields[speed]}"), console=console)


def _groups(simulation: Simulation) -> dict[str, GroupSpec]:
    period = np.array(simulation.scene.period)
    space = {"period": np.where(period > 0, period, np.inf)}
    return {
        name: GroupSpec(e.count, e.nodes, e.saved, {k: (STATIC[k], v) for k, v in (e.static() | space).items()})
        for name, e in simulation.ensembles.items()
    }


def _attributes(simulation: Simulation) -> dict:
    scene = simulation.scene
    return {
        "title": scene.title,
        "seed": scene.seed,
        "device": str(simulation.device),
        "step": simulation.step_size,
        "units": f"length {scene.units.length}" if scene.units else "dimensionless",
        "scene": scene.to_toml(),
        "scene_hash": scene.hash(),
    }


def _animate(folder: Path, console: Console) -> None:
    from warp_rods.draw.usd.export import export_usd

    path = export_usd(folder)
    console.print(f"animation: {path} ({path.stat().st_size / 1e6:.1f} MB)")
