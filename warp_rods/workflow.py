"""Simulate a scene, then make its animation, its poster and its film."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warp_rods.draw.exporters import need_ffmpeg
from warp_rods.scene.scene import Scene
from warp_rods.scene.tables import Output
from warp_rods.simulation.estimates import WHOLE_ANIMATION, shown_bytes
from warp_rods.simulation.files import default_folder
from warp_rods.simulation.interruption import Interrupted
from warp_rods.simulation.report import Report
from warp_rods.simulation.runner import Hooks, Run, simulate
from warp_rods.simulation.under_way import telling_what_is_made

if TYPE_CHECKING:
    from rich.console import Console

_MADE = (("usd", "animation", "usd"), ("poster", "poster", "poster"), ("film", "film", "mp4"))
"""What is made of a run: its key in [output], its name, and its row of ``EXPORTERS``."""


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
    """Simulate a scene into the folder ``out`` (default ``runs/<scene name>``): trajectory, checkpoint, pictures.

    Pictures are the animation (unless ``output.usd = false``; in parts where it is large), the poster (unless
    ``output.poster = false``) and a film (with ``output.film = true``); one that cannot be made is a warning, as the
    run is complete.

    device: "cpu", "cuda:0", … (default: CUDA where there is one). hooks: pairs of a cadence, ``every(steps=…)`` or
    ``every(time=…)``, and a function of the ``Simulation`` that is called then. console: where progress is shown
    (default: standard error). resume: continue from the last checkpoint in the folder; where there is no run yet, start
    anew. The first SIGINT, SIGTERM or SIGHUP lets the run finish its step and save its state, then raises
    KeyboardInterrupt or SystemExit. Raises SceneError before anything is written, RunFolderError for a folder that
    holds a run (or, with ``resume``, another one), StorageError where the folder can no longer be written, RodFailure
    once no rod is left.
    """
    out = default_folder(scene) if out is None else out
    scene = scene if isinstance(scene, Scene) else Scene.load(scene)
    if scene.output is not None and scene.output.film:
        need_ffmpeg()
    return simulate(
        scene, out, device=device, overwrite=overwrite, resume=resume, hooks=hooks, console=console, then=_animate
    )


def _animate(folder: Path, scene: Scene, report: Report) -> None:
    """Make the pictures of a finished run. The run is complete whatever happens, so a failure is a warning."""
    output = scene.output or Output()
    for key, what, option in _MADE:
        if getattr(output, key):
            _make(folder, what, option, report)


def _make(folder: Path, what: str, option: str, report: Report) -> None:
    """Make one picture, and tell where it is."""
    command = f"warp-rods export {folder} --{option}"
    try:
        with telling_what_is_made(folder, what):
            path = export_usd(folder) if option == "usd" else export(folder, option)
    except (KeyboardInterrupt, Interrupted):
        report.note(f"the run in {folder} is complete; to make its {what}: {command}")
        raise
    except Exception as error:
        text = f"the run is complete, but its {what} could not be made: {type(error).__name__}: {error}"
        report.warn(f"{text}; to try again: {command}")
        return
    if path.is_dir():
        size = sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
        whole = shown_bytes(WHOLE_ANIMATION)
        report.note(f"{what}: {path / 'animation.usdc'} ({size / 1e6:.1f} MB), in parts, as it is above {whole}")
    else:
        report.note(f"{what}: {path} ({path.stat().st_size / 1e6:.1f} MB)")


def export_usd(folder: Path) -> Path:
    """Write the animation of a run; what makes it is imported at the end of the run.

    USD holds a file in memory until it is whole: a large one is made in parts, which replace that of a shorter run.
    """
    from warp_rods.draw.content import content
    from warp_rods.draw.exporters import EXPORTERS

    shown, whole = content(folder), folder / EXPORTERS["usd"].file_name
    if EXPORTERS["usd"].estimate(shown) <= WHOLE_ANIMATION:
        return EXPORTERS["usd"].write(shown, whole)
    parts = EXPORTERS["clips"].write(shown, folder / EXPORTERS["clips"].file_name)
    whole.unlink(missing_ok=True)
    return parts


def export(folder: Path, name: str) -> Path:
    """Write a picture of a run by a row of ``EXPORTERS``."""
    from warp_rods.draw.exporters import EXPORTERS

    return EXPORTERS[name].export(folder)
