"""Commands that look at runs and scenes: ``plot``, ``watch``, ``status``, ``scenes``, ``schema``."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from warp_rods import completion
from warp_rods.errors import RunFolderError
from warp_rods.simulation.files import RUNS, STUDY, TRAJECTORY

__all__ = ["RunDir", "add_to", "out_option"]

RunDir = Annotated[
    Path, typer.Argument(metavar="DIR", help="The folder of a run", autocompletion=completion.run_folders)
]
PlottedDir = Annotated[
    Path,
    typer.Argument(metavar="DIR", help="The folder of a run, or a study", autocompletion=completion.plotted_folders),
]
PLOTTED = {TRAJECTORY: "warp_rods.draw.of_run", STUDY: "warp_rods.studies.plot"}
"""What marks a folder that can be plotted, and the module with ``plotted(folder, names, ensembles, out, rod)``: it
draws and yields lines to print; without names it may list what there is."""


def out_option(what: str) -> Any:
    """The option --out, which may not be empty, as a variable of a shell that is not set would be."""

    def folder(text: str) -> Path:
        if not text:
            raise typer.BadParameter('"": must be the path of a folder')
        return Path(text)

    return typer.Option(parser=folder, metavar="<path>", help=what)


scenes_app = typer.Typer(help="The scenes that come with the program.")


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    for command in (plot, watch, status, schema):
        app.command()(command)
    app.add_typer(scenes_app, name="scenes")


def plot(
    run_dir: PlottedDir,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="WHAT",
            help="Names of plots, or all; without one they are listed",
            autocompletion=completion.plots,
        ),
    ] = None,
    ensembles: Annotated[str, typer.Option(metavar="A,B", help="Of these ensembles only")] = "",
    rod: Annotated[int | None, typer.Option(min=0, help="Which rod, where a plot shows one; the first is 0")] = None,
    out: Annotated[Path | None, out_option("Folder for the files; default DIR/plots")] = None,
) -> None:
    """Draw plots of a run, or diagrams of a study, as PNG and SVG; without names, list what can be drawn of a run.

    They are written to DIR/plots. Of a study all measures are drawn, or those named.
    """
    from warp_rods.simulation.files import beside, check_writable

    _start_warp()
    module = next((module for mark, module in PLOTTED.items() if (run_dir / mark).exists()), None)
    if module is None:
        raise RunFolderError(
            f"There is no run or study in {run_dir}{beside(run_dir, *PLOTTED)}: "
            "give the folder that `warp-rods run SCENE --out DIR` wrote"
        )
    if out is not None:
        check_writable(out, "out")
    chosen = [name for name in ensembles.split(",") if name]
    for said in import_module(module).plotted(run_dir, names or [], chosen, out, rod):
        print(said)


def _start_warp() -> None:
    from warp_rods.device import start

    start()


def watch(run_dir: RunDir) -> None:
    """Watch a run while it runs: progress, energies, the last frame. It only reads. Exit codes as those of status."""
    from warp_rods.draw.watch import watch
    from warp_rods.simulation.interruption import Interrupted
    from warp_rods.simulation.status import exit_code

    try:
        last = watch(run_dir, Console(markup=False, highlight=False))
    except Interrupted as signal:
        signal.told = True  # the run is not stopped
        raise
    raise typer.Exit(exit_code([last]))


def status(
    run_dirs: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="DIR",
            help="Folders of runs and studies; without one those in runs/",
            autocompletion=completion.plotted_folders,
        ),
    ] = None,
) -> None:
    """How far runs and studies are, a line each.

    Exit code 0: all are finished; 1: one stopped before its end; 2: one is damaged, or no run; 3: rods were lost; 4:
    one is running.
    """
    from warp_rods.draw.watch import line
    from warp_rods.simulation.status import RunStatus, State, exit_code, status_of

    folders = run_dirs or sorted(path.parent for store in PLOTTED for path in RUNS.glob(f"*/{store}"))
    if not folders:
        raise RunFolderError("there are no runs in runs/: give the folders of runs")
    found: list[RunStatus] = []
    for folder in folders:
        try:
            found.append(_of_study(folder) if (folder / STUDY).exists() else status_of(folder))
        except RunFolderError as fault:
            found.append(RunStatus(folder, State.NONE, why=str(fault)))
    console = Console(markup=False, highlight=False)
    rows = [one.cells() for one in found]
    widths = [max(len(row[i]) for row in rows if len(row) > i + 1) for i in range(max(map(len, rows)) - 1)]
    for one in found:
        console.print(line(one, widths), soft_wrap=True)
    raise typer.Exit(exit_code(found))


def _of_study(folder: Path) -> Any:
    """The status of a study; what it imports takes a while, and is needed for studies alone."""
    from warp_rods.studies.status import in_a_line

    return in_a_line(folder)


@scenes_app.callback(invoke_without_command=True)
def list_scenes(context: typer.Context) -> None:
    """List the scenes that come with the program, with about how long they take; `copy NAME` gives one to edit."""
    if context.invoked_subcommand is not None:
        return
    from warp_rods.scene.shipped import shipped

    rows = [(name, scene.time, scene.title) for name, scene in shipped().items()]
    names, times = (max(len(row[i]) for row in rows) for i in (0, 1))
    for name, time, title in rows:
        print(f"{name:{names}}  {time:>{times}}  {title}")
    print("Times on one core. To run one: warp-rods run NAME; to get one to edit: warp-rods scenes copy NAME")


@scenes_app.command("copy")
def copy(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A scene", autocompletion=completion.scene_names)],
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Where to", show_default="here")] = Path(),
) -> None:
    """Copy a scene, the files that it reads, and the schema by which editors complete and check it."""
    from warp_rods.scene.shipped import copy_scene

    for path in copy_scene(name, folder):
        print(path)


def schema() -> None:
    """Print the JSON Schema of scenes, by which editors complete and check them."""
    from warp_rods.scene.schema import schema_text

    print(schema_text(), end="")
