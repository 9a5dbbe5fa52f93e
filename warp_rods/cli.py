"""The command line: ``warp-rods run SCENE`` and its relatives; users' mistakes are shown without a traceback."""

from __future__ import annotations

import logging
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer
import warp as wp
from rich.console import Console

from warp_rods.device import start as start_warp
from warp_rods.errors import SceneError, WarpRodsError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Rods at low Reynolds number: proteins on membranes, swimming cells. Begin with: warp-rods run SCENE",
)

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene in TOML, such as scenes/proteins.toml")]
RunDir = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run")]


def _version(wanted: bool) -> None:
    if wanted:
        print(version("warp-rods"))
        raise typer.Exit


@app.callback()
def options(
    _version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Say which")] = False,
) -> None: ...


@app.command()
def run(
    scene: SceneFile,
    out: Annotated[Path | None, typer.Option(help="Folder to write; default runs/<scene name>")] = None,
    device: Annotated[str, typer.Option(help="auto, cpu or cuda:N")] = "auto",
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the last checkpoint in the folder")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run that the folder holds")] = False,
) -> None:
    """Simulate a scene: trajectory.zarr, checkpoint.npz and animation.usdc in a folder."""
    from warp_rods.analysis.summary import summary
    from warp_rods.workflow import run as run_scene

    console = Console(markup=False, highlight=False)
    if resume and overwrite:
        raise SceneError("--resume and --overwrite: one goes on with a run, the other replaces it; give one of them")
    _log_to(console)
    done = run_scene(scene, out, device=device, overwrite=overwrite, resume=resume, console=console)
    console.print(summary(done.data, done.order))
    speed = done.rod_steps / done.seconds if done.seconds else 0.0
    console.print(f"{done.seconds:.1f} s, {speed:,.0f} rod-steps/s; results in {done.folder}")


def _log_to(console: Console) -> None:
    """Show what a run says on this console, above its progress bar."""

    class ToConsole(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if record.levelno >= logging.WARNING:
                console.print(f"warning: {record.getMessage()}", style="yellow")
            else:
                console.print(record.getMessage())

    log = logging.getLogger("warp_rods")
    log.setLevel(logging.INFO)
    log.handlers = [ToConsole()]
    log.propagate = False


@app.command()
def check(scene: SceneFile) -> None:
    """Read a scene, lay it out and say what a run of it would do; writes nothing."""
    from warp_rods.scene.scene import Scene
    from warp_rods.simulation.loop import Simulation

    read = Scene.load(scene)
    with Console(stderr=True).status("placing rods …"):
        simulation = Simulation(read, "cpu")
    frames = simulation.frames
    for name, ensemble in simulation.ensembles.items():
        print(f"{name}: {ensemble.count} rods of {ensemble.nodes} nodes")
    for line in simulation.notes:
        print(line)
    for line in simulation.warnings:
        print(f"warning: {line}")
    verdict = "run it at your own risk" if simulation.warnings else "sound"
    print(f"Δt = {simulation.step_size:.3g}, {int(frames.steps.sum())} steps, {len(frames.times)} frames: {verdict}")


@app.command()
def export(
    run_dir: RunDir,
    usd: Annotated[bool, typer.Option("--usd", help="animation.usdc for Blender, Omniverse and the like")] = False,
) -> None:
    """Make the animation of a run again, from its trajectory."""
    if not usd:
        raise SceneError("export: say what to make: --usd")
    from warp_rods.draw.usd.export import export_usd

    print(export_usd(run_dir))


@app.command()
def reproduce(
    name: Annotated[str, typer.Argument(metavar="list|NAME|all", help="list names them; all makes every one")],
    quick: Annotated[bool, typer.Option("--quick", help="Reduced forms: coarser, shorter, fewer")] = False,
    out: Annotated[Path, typer.Option(help="Folder to write")] = Path("runs/reproduce"),
) -> None:
    """Make a figure of the dissertation again: figure, data, and a table of published against ours."""
    from warp_rods.reproductions import reproduce
    from warp_rods.reproductions.catalogue import REPRODUCTIONS

    if name == "list":
        for known, row in REPRODUCTIONS.items():
            print(f"{known:12} {row.what} (about {row.minutes:g} min)")
        return
    outcomes = reproduce.run([name], quick, out, Console(markup=False, highlight=False))
    if failed := [outcome.name for outcome in outcomes if outcome.error]:
        print(f"error: failed: {', '.join(failed)}", file=sys.stderr)
        raise typer.Exit(1)


@app.command()
def devices() -> None:
    """The devices that --device can name."""
    for device in wp.get_devices():
        print(f"{device.alias}: {device.name}")


def main() -> None:
    """Entry point; exit code 2 for a user's mistake, 1 for a run that failed, 130 for one stopped."""
    start_warp()
    try:
        app()
    except WarpRodsError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
