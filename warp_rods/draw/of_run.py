"""The plots of a run folder: what can be drawn of it, and ``plots/ENSEMBLE-NAME.png`` and ``.svg`` in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from warp_rods.analysis.registry import MEASURES, measures
from warp_rods.draw import measured
from warp_rods.draw.views import options_of, views
from warp_rods.errors import RunFolderError, SceneError, nearest
from warp_rods.progress import with_progress
from warp_rods.simulation.reading import open_run

__all__ = ["ALL", "FOLDER", "Drawable", "drawables", "drawn", "listed"]

FOLDER = "plots"
OF_SWIMMERS = ("speed", "instantaneous_speed", "phase_portrait")
"""Plots that mean nothing for rods that do not swim, although they could be drawn."""
ALL = "all"
"""Stands for every plot."""


@dataclass(frozen=True)
class Drawable:
    """A plot of a run: its name, the ensemble it is of, empty where it is of all rods together, and what it shows."""

    name: str
    ensemble: str
    what: str

    @property
    def stem(self) -> str:
        """The name of its files without suffix."""
        return f"{self.ensemble}-{self.name}" if self.ensemble else self.name


def drawables(run: xr.DataTree) -> list[Drawable]:
    """What can be drawn of a run; plots of swarms where there are several rods, and all of them measured together."""
    found = []
    for ensemble, group in run.children.items():
        data = group.to_dataset()
        if not data.sizes.get("frame"):
            continue
        rows = {name: view.what for name, view in views(data).items()}
        rows |= {name: row.description for name, row in measures(data).items() if row.of != "swarm"}
        found += [Drawable(name, str(ensemble), what) for name, what in rows.items() if _has_plot(name, data)]
    if sum(group.sizes["rod"] for group in run.children.values()) > 1:
        swarm = {name: row.description for name, row in measures(run).items() if row.of == "swarm"}
        found += [Drawable(name, "", what) for name, what in swarm.items() if name in measured.PLOTS]
    return found


def _has_plot(name: str, data: xr.Dataset) -> bool:
    if name in OF_SWIMMERS and "activity" not in data:
        return False
    return name in measured.PLOTS or name in views(data)


def listed(run_dir: Path) -> Iterator[str]:
    """Lines that say what can be drawn of a run, and how; ensembles with the same plots have one list."""
    found = drawables(open_run(run_dir))
    if not found:
        raise RunFolderError(f"{run_dir} has no complete frame yet: there is nothing to draw")
    lists: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for ensemble in dict.fromkeys(one.ensemble for one in found):
        rows = tuple((one.name, one.what) for one in found if one.ensemble == ensemble)
        lists.setdefault(rows, []).append(ensemble)
    width = max(len(one.name) for one in found)
    for rows, ensembles in lists.items():
        yield ", ".join(ensembles) or "all rods together"
        yield from (f"  {name:{width}}  {what}" for name, what in rows)
    yield f"To draw some: warp-rods plot {run_dir} {found[0].name} {found[-1].name}; to draw all: {ALL}"


def plotted(
    run_dir: Path, names: Sequence[str], ensembles: Sequence[str] = (), out: Path | None = None, rod: int | None = None
) -> Iterator[Path | str]:
    """``drawn``, or ``listed`` where no plot is named."""
    return drawn(run_dir, names, ensembles, out, rod) if names else listed(run_dir)


def drawn(
    run_dir: Path, names: Sequence[str], ensembles: Sequence[str] = (), out: Path | None = None, rod: int | None = None
) -> Iterator[Path | str]:
    """Draw the plots with these names, "all" for every one; yields the path of each PNG, or why one was left out.

    Raises SceneError for an unknown name or ensemble, and RunFolderError for a named plot that cannot be drawn.
    """
    run = open_run(run_dir)
    chosen = _chosen(drawables(run), names, [str(name) for name in run.children], ensembles)
    for one in with_progress(chosen, "drawing"):
        data = run[one.ensemble].to_dataset() if one.ensemble else run
        path = (run_dir / FOLDER if out is None else out) / one.stem
        try:
            measured.plot(data, one.name, path, **_options(one, data, rod))
        except ValueError as fault:
            if ALL not in names:
                raise RunFolderError(f"{one.stem}: {fault}") from None
            yield f"left out {one.stem}: {fault}"
            continue
        yield path.with_name(path.name + ".png")


def _options(one: Drawable, data: xr.Dataset | xr.DataTree, rod: int | None) -> dict[str, int]:
    """The rod of a plot of one rod."""
    if rod is None or not isinstance(data, xr.Dataset):
        return {}
    takes = options_of(views(data)[one.name]) if one.name not in MEASURES else _plot_options(one.name)
    return {"rod": rod} if "rod" in takes else {}


def _plot_options(name: str) -> list[str]:
    import inspect

    return list(inspect.signature(measured.PLOTS[name]).parameters)[2:]


def _chosen(
    found: Sequence[Drawable], names: Sequence[str], known: Sequence[str], ensembles: Sequence[str]
) -> list[Drawable]:
    for ensemble in ensembles:
        if ensemble not in known:
            hint = nearest(ensemble, known)
            raise SceneError(f"--ensembles {ensemble}: there is no such ensemble{hint}; known: {', '.join(known)}")
    there = [one for one in found if not ensembles or not one.ensemble or one.ensemble in ensembles]
    for name in names:
        if name != ALL and name not in {one.name for one in there}:
            every = list(dict.fromkeys(one.name for one in there))
            raise SceneError(f"{name}: no plot of this run{nearest(name, every)}; there are {', '.join(every)}")
    return [one for one in there if ALL in names or one.name in names]
