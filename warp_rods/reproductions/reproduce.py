"""``warp-rods reproduce``: runs reproductions in processes of their own and writes figure, data and table of each."""

from __future__ import annotations

import contextlib
import csv
import difflib
import multiprocessing
import os
import time
import traceback
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Console
from rich.table import Table

from warp_rods.device import cores
from warp_rods.device import start as start_warp
from warp_rods.errors import RunFolderError, UnknownReproduction
from warp_rods.reproductions.catalogue import REPRODUCTIONS, Result, Row

OUT = Path("runs/reproduce")
REFRESH = 0.5
"""Seconds between updates of the status line."""
REDUCED = "a reduced form, to see that it runs: its verdicts are not to be quoted"
COLUMNS = ("quantity", "published", "ours", "difference", "reading")


@dataclass(frozen=True)
class Outcome:
    """What came of one reproduction: its rows and notes, the files written, and ``error`` where it failed."""

    name: str
    rows: tuple[Row, ...] = ()
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()
    seconds: float = 0.0
    error: str = ""


def chosen(name: str) -> list[str]:
    """The names that ``name`` stands for: all of them for "all". Raises UnknownReproduction with those there are."""
    if name == "all":
        return list(REPRODUCTIONS)
    if name not in REPRODUCTIONS:
        near = difflib.get_close_matches(name, [*REPRODUCTIONS, "all"], 1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise UnknownReproduction(f"reproduce {name}: no such name{hint}; there are {', '.join(REPRODUCTIONS)}, all")
    return [name]


def run(
    names: Sequence[str], quick: bool = False, out: str | Path = OUT, console: Console | None = None
) -> list[Outcome]:
    """Run reproductions, as many at once as there are cores, and print the table of each as it is done.

    Writes ``out``/NAME.png, .svg, .table.csv and the data, NAME.csv or NAME.zarr. One that fails is told in its
    outcome's ``error``, the others go on. The numbers are those of one process, however many run at once.
    Raises UnknownReproduction for a name that is not known.
    """
    names = list(dict.fromkeys(known for name in names for known in chosen(name)))
    console = console or Console(stderr=True, markup=False, highlight=False)
    if Path(out).is_file():
        raise RunFolderError(f"{out} is a file: give another --out")
    Path(out).mkdir(parents=True, exist_ok=True)
    workers = min(len(names), cores())
    waiting = sorted(names, key=lambda name: -REPRODUCTIONS[name].minutes)
    running, outcomes = dict[Future[Outcome], _Process](), list[Outcome]()
    with _one_thread_each(), console.status("") as status:
        while waiting or running:
            while waiting and len(running) < workers:
                process = _Process(waiting.pop(0))
                running[process.pool.submit(perform, process.name, quick, Path(out))] = process
            status.update(_so_far(running.values(), len(outcomes), len(names)))
            for done in wait(running, timeout=REFRESH, return_when=FIRST_COMPLETED).done:
                outcomes.append(running.pop(done).end(done))
                report(outcomes[-1], console)
    return sorted(outcomes, key=lambda outcome: names.index(outcome.name))


class _Process:
    """One reproduction in a process of its own: whatever becomes of it, the others' go on."""

    def __init__(self, name: str):
        self.name, self.begun = name, time.perf_counter()
        self.pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), start_warp)

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.begun

    def end(self, done: Future[Outcome]) -> Outcome:
        """What came of it; a process that was killed leaves an error, too."""
        self.pool.shutdown()
        killed = done.exception()
        return Outcome(self.name, seconds=self.seconds, error=repr(killed)) if killed else done.result()


def perform(name: str, quick: bool, out: Path) -> Outcome:
    """Make one reproduction in this process and write its files; what goes wrong in it is the outcome's ``error``."""
    from warp_rods.draw.plots import save, style

    start = time.perf_counter()
    try:
        with style():
            result = REPRODUCTIONS[name].make(quick)
        figures = save(result.figure, out / name)
        files = (*figures, _write_data(result, out, name), _write_table(result.rows, out, name))
    except Exception:  # any fault of one must leave the others to go on
        return Outcome(name, seconds=time.perf_counter() - start, error=traceback.format_exc())
    notes = (REDUCED, *result.notes) if quick else tuple(result.notes)
    return Outcome(name, tuple(result.rows), notes, files, time.perf_counter() - start)


def report(outcome: Outcome, console: Console) -> None:
    """Print an outcome: its table and notes, or what went wrong."""
    if outcome.error:
        console.print(f"{outcome.name}: failed after {outcome.seconds:.0f} s\n{outcome.error}", style="red")
        return
    table = Table(*COLUMNS, title=f"{outcome.name}: {REPRODUCTIONS[outcome.name].what}", title_justify="left")
    for row in outcome.rows:
        table.add_row(row.quantity, shown(row.published), shown(row.ours), row.difference, row.reading)
    console.print(table)
    for note in outcome.notes:
        console.print(note)
    console.print(f"{outcome.seconds:.1f} s; {', '.join(map(str, outcome.files))}\n")


def shown(value: float | str) -> str:
    """A number to four digits; a text as it is."""
    return value if isinstance(value, str) else f"{value:.4g}"


@contextlib.contextmanager
def _one_thread_each() -> Iterator[None]:
    """What a process reads when it starts: NumPy's own threads would fight over the cores, and change sums."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        yield
    finally:
        os.environ.pop("OMP_NUM_THREADS") if before is None else os.environ.update(OMP_NUM_THREADS=before)


def _so_far(running: Iterable[_Process], done: int, of: int) -> str:
    names = ", ".join(f"{process.name} ({process.seconds:.0f} s)" for process in running)
    return f"{done} of {of} done; running {names}"


def _write_data(result: Result, out: Path, name: str) -> Path:
    if isinstance(result.data, xr.Dataset):
        result.data.to_zarr(out / f"{name}.zarr", mode="w", consolidated=False)
        return out / f"{name}.zarr"
    columns = {key: np.asarray(values) for key, values in result.data.items()}
    return _write_csv(out / f"{name}.csv", columns, zip(*columns.values(), strict=True))


def _write_table(rows: Sequence[Row], out: Path, name: str) -> Path:
    lines = [(row.quantity, row.published, row.ours, row.difference, row.reading) for row in rows]
    return _write_csv(out / f"{name}.table.csv", COLUMNS, lines)


def _write_csv(path: Path, head: Sequence[str] | dict, lines) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(lines)
    return path
