"""The command line, ``warp-rods run SCENE`` and others. Mistakes of the user are shown without a traceback.

Each command imports what it needs when it is called: ``--help`` and a mistake in a scene need no second.
"""

from __future__ import annotations

import gc
import logging
import multiprocessing
import sys
from functools import wraps
from importlib.metadata import version
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from warp_rods import cli_look, completion
from warp_rods.draw.exporters import EXPORTERS, OPTIONS
from warp_rods.errors import RodFailure, SceneError, WarpRodsError
from warp_rods.simulation.interruption import Interrupted, signals_end_the_process
from warp_rods.terminal import open_streams, show_error

app = typer.Typer(
    pretty_exceptions_enable=False,
    help="Rods at low Reynolds number: proteins on membranes, swimming cells. Start with: warp-rods",
)

SceneFile = Annotated[
    Path,
    typer.Argument(
        metavar="SCENE",
        help="A scene in TOML, or the name of one of those that warp-rods scenes lists",
        autocompletion=completion.scenes,
    ),
]
RunDir, _out = cli_look.RunDir, cli_look.out_option


def _version(wanted: bool) -> None:
    if wanted:
        print(version("warp-rods"))
        raise typer.Exit


def _start_warp() -> None:
    """Start Warp, whose import takes most of a second, before a command uses it."""
    from warp_rods.device import start

    start()


@app.callback(invoke_without_command=True)
def options(
    context: typer.Context,
    _version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version")
    ] = False,
) -> None:
    if context.invoked_subcommand is None:
        from warp_rods.front_page import front_page

        print("warp-rods simulates thin elastic rods at low Reynolds number: proteins on membranes, swimming cells.\n")
        rows = front_page(Path())
        for command, what in rows:
            print(f"  {command:{max(len(command) for command, _ in rows)}}  {what}")


@app.command()
def run(
    scene: SceneFile,
    out: Annotated[Path | None, _out("Folder for the results; default runs/<scene name>")] = None,
    device: Annotated[str, typer.Option(help="auto, cpu or cuda:N")] = "auto",
    resume: Annotated[
        bool,
        typer.Option(
            "--resume", help="Continue from the last checkpoint in the folder; start anew where there is none"
        ),
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run in the folder")] = False,
) -> None:
    """Simulate a scene: trajectory, checkpoint, animation.usdc, poster.png in a folder. Exit code 3: rods were lost."""
    from warp_rods.scene.scene import Scene
    from warp_rods.scene.shipped import find_scene
    from warp_rods.simulation.estimates import check_memory
    from warp_rods.simulation.files import default_folder

    scene = find_scene(scene)
    loaded = Scene.load(scene)
    check_memory(loaded)  # before the slow imports
    _start_warp()
    from warp_rods.workflow import run as run_scene

    console = Console(markup=False, highlight=False)
    if resume and overwrite:
        raise SceneError("--resume and --overwrite: one continues a run, the other replaces it; give one of them")
    _log_to(console)
    done = run_scene(
        loaded,
        default_folder(scene) if out is None else out,
        device=device,
        overwrite=overwrite,
        resume=resume,
        console=console,
    )
    if done.rod_steps:
        from warp_rods.analysis.summary import summary

        console.print(summary(done.data, done.order))
        speed = done.rod_steps / done.seconds if done.seconds else 0.0
        console.print(f"{done.seconds:.1f} s, {speed:,.0f} rod-steps/s; results in {done.folder}")
    console.print(f"to see them: warp-rods plot {done.folder}; for other programs: warp-rods export {done.folder}")
    if done.lost:
        raise typer.Exit(RodFailure.exit_code)


def _log_to(console: Console) -> None:
    """Show the messages of a run on this console, above its progress bar."""

    class ToConsole(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            if record.levelno >= logging.WARNING:
                console.print(f"warning: {record.getMessage()}", style="yellow", soft_wrap=True)
            else:
                console.print(record.getMessage(), soft_wrap=True)  # commands can be copied

    log = logging.getLogger("warp_rods")
    log.setLevel(logging.INFO)
    log.handlers = [ToConsole()]
    log.propagate = False


@app.command()
def sweep(
    scene: SceneFile,
    out: Annotated[Path | None, _out("Folder for the results; default runs/<scene name>")] = None,
    device: Annotated[str, typer.Option(help="auto, cpu or cuda:N")] = "auto",
    workers: Annotated[int | None, typer.Option(help="Processes on this machine; default one for each core")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="The scheduler of another cluster of Dask (docs/cluster.md)")
    ] = None,
    part: Annotated[
        str | None, typer.Option(metavar="I/N", help="Do the I-th of N parts here, without Dask: for array jobs")
    ] = None,
    status: Annotated[bool, typer.Option("--status", help="Show how far the study is, and do nothing")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the study in the folder")] = False,
) -> None:
    r"""Simulate a scene at every point of its \[sweep]; one that was stopped goes on. Exit code 3: points failed."""
    from warp_rods.scene.shipped import find_scene
    from warp_rods.simulation.files import default_folder

    folder = default_folder(scene) if out is None else out
    if status:
        from warp_rods.studies.status import status as status_of

        print(status_of(folder))
        return
    _start_warp()
    from warp_rods.studies.sweep import sweep as sweep_scene

    console = Console(markup=False, highlight=False)
    done = sweep_scene(
        find_scene(scene), folder, device=device, scheduler=scheduler, workers=workers, part=part,
        overwrite=overwrite, console=console,
    )  # fmt: skip
    console.print(done.summary, soft_wrap=True)
    if done.points.get("failed"):
        raise typer.Exit(RodFailure.exit_code)


@app.command()
def check(
    scene: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE|DIR",
            help="A scene in TOML, the name of a shipped one, or the folder of a run",
            autocompletion=completion.scenes,
        ),
    ],
) -> None:
    """Check a scene: place its rods; report size, time, frames and warnings. Of a run: read all of it, find damage."""
    _start_warp()
    if scene.is_dir():
        from warp_rods.simulation.check import check_run

        print(check_run(scene))
        return
    from warp_rods.scene.scene import Scene
    from warp_rods.scene.shipped import find_scene
    from warp_rods.simulation.check_scene import check_scene

    found = find_scene(scene)
    if Scene.load(found).sweep is None:
        print(check_scene(found))
        return
    from warp_rods.studies.check import check_study

    about, warnings = check_study(found)  # first, as its faults are those of every point
    print(check_scene(found, [about], warnings))


def _export(run_dir: Path, out: Path | None, dry_run: bool, selection: dict[str, str], **given: Any) -> None:
    """Write files for other programs from the trajectory of a run; without a flag, say what there is."""
    from warp_rods.draw.export import export, listing, select

    wanted = [name for name in EXPORTERS if given.pop(name)]
    _start_warp()
    chosen = select(**selection)
    if not wanted or dry_run:
        print(listing(run_dir, chosen, wanted, **given))
        return
    for path in export(run_dir, wanted, chosen, out, **given):
        print(path)


SELECTION = {
    "ensembles": ("", "Names of ensembles with commas between them; default all"),
    "frames": (":", 'Frames as in Python, "0:90:5", or one, "-1"; default all'),
    "colour": ("", "What colours the rods; default the first that is listed without a flag"),
    "range": ("run", "Both ends of the colours: of the whole run, of each frame, or LOW,HIGH"),
}
"""Options of ``export`` that choose what is shown: default and help."""


def add_export(app: typer.Typer) -> None:
    """Add the command ``export``, with a flag for each row of ``EXPORTERS``; Typer reads them from a signature."""
    parameters = [Parameter("run_dir", Parameter.POSITIONAL_OR_KEYWORD, annotation=RunDir)]

    def option(name: str, kind: Any, default: Any, made: Any) -> None:
        parameters.append(Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, made]))

    for name, exporter in EXPORTERS.items():
        option(name, bool, False, typer.Option(f"--{name}", help=f"{exporter.file_name}: {exporter.what}"))
    for name, (default, text) in SELECTION.items():
        option(name, str, default, typer.Option(f"--{name}", help=text))
    for name, row in OPTIONS.items():
        option(name, row.kind, row.default, typer.Option(f"--{name.replace('_', '-')}", help=row.what))
    option("out", Path | None, None, _out("The file, or the folder of several; default the folder of the run"))
    option("dry_run", bool, False, typer.Option("--dry-run", help="Write nothing; say what would be, with sizes"))

    @wraps(_export)
    def export(run_dir: Path, **arguments: Any) -> None:
        _export(run_dir, selection={name: arguments.pop(name) for name in SELECTION}, **arguments)

    export.__signature__ = Signature(parameters)  # type: ignore[attr-defined]
    app.command("export")(export)


add_export(app)


@app.command()
def reproduce(
    name: Annotated[
        str,
        typer.Argument(
            metavar="list|NAME|all",
            help="list shows the names; all runs every one",
            autocompletion=completion.reproductions,
        ),
    ],
    quick: Annotated[
        bool, typer.Option("--quick", help="Reduced forms: coarser grids, shorter times, fewer rods")
    ] = False,
    out: Annotated[Path, _out("Folder for the results")] = Path("runs/reproduce"),
) -> None:
    """Reproduce a figure of the dissertation: figure, data, and a table of published values against ours."""
    from warp_rods.reproductions import reproduce
    from warp_rods.reproductions.catalogue import REPRODUCTIONS

    if name == "list":
        for known, row in REPRODUCTIONS.items():
            print(f"{known:12} {row.what} (about {row.minutes:g} min)")
        return
    _start_warp()
    outcomes = reproduce.run([name], quick, out, Console(markup=False, highlight=False))
    if failed := [outcome.name for outcome in outcomes if outcome.error]:
        show_error(f"failed: {', '.join(failed)}")
        raise typer.Exit(1)


@app.command()
def bench(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="list|NAME...",
            help="list shows the names; without one all are run",
            autocompletion=completion.benchmarks,
        ),
    ] = None,
    out: Annotated[Path, _out("The file of results; figures go beside it")] = Path("benchmarks/RESULTS.md"),
    against: Annotated[
        Path | None, _out("A clone of this project at another commit, with which scenes are compared")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Reduced forms, whose figures mean nothing")] = False,
) -> None:
    """Measure what a simulation costs, beside other codes in the same run; writes benchmarks/RESULTS.md."""
    from warp_rods.bench import bench
    from warp_rods.bench.catalogue import BENCHMARKS

    if names == ["list"]:
        for name, row in BENCHMARKS.items():
            print(f"{name:10} {row.what} (about {row.minutes:g} min)")
        return
    console = Console(markup=False, highlight=False)
    if failed := bench.run(names or [], out, against=against, quick=quick, console=console):
        show_error(f"failed: {', '.join(failed)}")
        raise typer.Exit(1)


@app.command()
def devices() -> None:
    """List the devices for --device."""
    from warp_rods.device import known

    for device in known():
        print(f"{device.alias}: {device.name}")


cli_look.add_to(app)


def main() -> None:
    """Entry point; exit code 2: a mistake of the user, 3: rods were lost, 128 + n: signal n, 130 for Ctrl-C."""
    open_streams()
    gc.set_threshold(100_000)  # imports make objects that stay: searching them for garbage is a fifth of the start
    try:
        with signals_end_the_process():
            app()
    except Interrupted as signal:
        if not signal.told:
            print(f"stopped by {signal.name}", file=sys.stderr)
        for process in multiprocessing.active_children():  # those that reproduce figures
            process.terminate()
        raise
    except WarpRodsError as error:
        show_error(str(error))
        sys.exit(error.exit_code)
    except OSError as error:
        from warp_rods.device import said

        show_error(said(error))
        sys.exit(2)


if __name__ == "__main__":
    main()
