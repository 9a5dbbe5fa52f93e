"""Simulate a scene, then export its animation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warp_rods.scene.scene import Scene
from warp_rods.simulation.interruption import Interrupted
from warp_rods.simulation.report import Report
from warp_rods.simulation.runner import Hooks, Run, simulate

if TYPE_CHECKING:
    from rich.console import Console


def run(
    scene: Scene | str | Path,
    out: str | Path | None = None,
    *,
    device: str | None = None,
    overwrite: bool = False,
    resume: bool = False,
    hooks: Hooks = (),
    console: Console | None = None,
) -> Run:
    """Simulate a scene into the folder ``out`` (default ``runs/<scene name>``): trajectory, checkpoint, animation.

    No animation is made with ``output.usd = false``; one that cannot be made is a warning, as the run is complete.

    device: "cpu", "cuda:0", … (default: CUDA where there is one). hooks: pairs of a cadence, ``every(steps=…)`` or
    ``every(time=…)``, and a function of the ``Simulation`` that is called then. console: where progress is shown
    (default: standard error). resume: continue from the last checkpoint in the folder; where there is no run yet, start
    anew. The first SIGINT, SIGTERM or SIGHUP lets the run finish its step and save its state, then raises
    KeyboardInterrupt or SystemExit. Raises SceneError before anything is written, RunFolderError for a folder that
    holds a run (or, with ``resume``, another one), StorageError where the folder can no longer be written, RodFailure
    once no rod is left.
    """
    return simulate(
        scene, out, device=device, overwrite=overwrite, resume=resume, hooks=hooks, console=console, then=_animate
    )


def _animate(folder: Path, scene: Scene, report: Report) -> None:
    """Write the animation of a finished run. The run is complete whatever happens, so a failure is a warning."""
    if scene.output is not None and not scene.output.usd:
        return
    try:
        path = export_usd(folder)
    except (KeyboardInterrupt, Interrupted):
        report.note(f"the run in {folder} is complete; to make its animation: warp-rods export {folder} --usd")
        raise
    except Exception as error:
        text = f"the run is complete, but its animation could not be made: {type(error).__name__}: {error}"
        report.warn(f"{text}; to try again: warp-rods export {folder} --usd")
        return
    report.note(f"animation: {path} ({path.stat().st_size / 1e6:.1f} MB)")


def export_usd(folder: Path) -> Path:
    """Write the animation of a run; what makes it is imported at the end of the run."""
    from warp_rods.draw.usd.export import export_usd

    return export_usd(folder)
