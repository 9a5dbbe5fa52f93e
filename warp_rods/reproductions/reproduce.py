"""``warp-rods reproduce``: runs each reproduction in its own process and writes its figure, data and table."""

from __future__ import annotations

__all__ = ["Outcome", "chosen", "perform", "report", "run"]

import contextlib
import csv
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
from warp_rods.documented import Documented
from warp_rods.errors import UnknownReproduction, nearest
from warp_rods.progress import LINE_EVERY, Lines
from warp_rods.reproductions.catalogue import REPRODUCTIONS, Comparison, Result
from warp_rods.simulation.files import check_writable

OUT = Path("runs/reproduce")
REFRESH = 0.5
"""Seconds between updates of the status line."""
REDUCED = "reduced form, for tests: do not quote these numbers"
COLUMNS = ("quantity", "published", "ours", "difference", "reading")


@dataclass(frozen=True)
class Outcome(metaclass=Documented):
    """The outcome of one reproduction: the rows of its table, notes, files written; ``error`` where it failed."""

    name: str
    rows: tuple[Comparison, ...] = ()
    notes: tuple[str, ...] = ()
    files: tuple[Path, ...] = ()
    seconds: float = 0.0
    error: str = ""


def chosen(name: str) -> list[str]:
    """The reproductions that ``name`` stands for: all of them for "all". Raises UnknownReproduction, with all names."""
    if name == "all":
        return list(REPRODUCTIONS)
    if name not in REPRODUCTIONS:
        known = [*REPRODUCTIONS, "all"]
        raise UnknownReproduction(f"reproduce {name}: must be one of {', '.join(known)}{nearest(name, known)}")
    return [name]


def run(
    names: Sequence[str], quick: bool = False, out: str | Path = OUT, console: Console | None = None
) -> list[Outcome]:
    """Run reproductions in parallel, as many as there are cores, and print the table of each when it is finished.

    Writes ``out``/NAME.png, .svg, .table.csv and the data, NAME.csv or NAME.zarr. One that fails has an ``error`` in
    its outcome, and the others continue. The results do not depend on how many run in parallel. Raises
    UnknownReproduction for an unknown name.
    """
    names = list(dict.fromkeys(known for name in names for known in chosen(name)))
    console = console or Console(stderr=True, markup=False, highlight=False)
    check_writable(Path(out), "out")
    Path(out).mkdir(parents=True, exist_ok=True)
    workers = min(len(names), cores())
    waiting = sorted(names, key=lambda name: -REPRODUCTIONS[name].minutes)
    running, outcomes = dict[Future[Outcome], _Process](), list[Outcome]()
    lines = Lines(lambda: _status_line(list(running.values()), len(outcomes), len(names)), console)
    lines.start(LINE_EVERY)
    with _one_thread_per_process(), console.status("") as status, contextlib.closing(lines):
        while waiting or running:
            while waiting and len(running) < workers:
                process = _Process(waiting.pop(0))
                running[process.pool.submit(perform, process.name, quick, Path(out))] = process
            status.update(_status_line(running.values(), len(outcomes), len(names)))
            for done in wait(running, timeout=REFRESH, return_when=FIRST_COMPLETED).done:
                outcomes.append(running.pop(done).end(done))
                report(outcomes[-1], console)
    return sorted(outcomes, key=lambda outcome: names.index(outcome.name))


class _Process:
    """One reproduction in its own process, so that a failure does not affect the others."""

    def __init__(self, name: str):
        self.name, self.started = name, time.perf_counter()
        self.pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), start_warp)

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.started

    def end(self, done: Future[Outcome]) -> Outcome:
        """The outcome; that of a killed process is an error."""
        self.pool.shutdown()
        killed = done.exception()
        return Outcome(self.name, seconds=self.seconds, error=repr(killed)) if killed else done.result()


def perform(name: str, quick: bool, out: Path) -> Outcome:
    """Run one reproduction in this process and write its files; any exception becomes the ``error`` of its outcome."""
    from warp_rods.draw.plots import save, style

    start = time.perf_counter()
    try:
        with style():
            result = REPRODUCTIONS[name].make(quick)
        figures = save(result.figure, out / name)
        files = (*figures, _write_data(result, out, name), _write_table(result.rows, out, name))
    except Exception:  # the others continue, whatever failed here
        return Outcome(name, seconds=time.perf_counter() - start, error=traceback.format_exc())
    notes = (REDUCED, *result.notes) if quick else tuple(result.notes)
    return Outcome(name, tuple(result.rows), notes, files, time.perf_counter() - start)


def report(outcome: Outcome, console: Console) -> None:
    """Print the table and notes of an outcome, or its error."""
    if outcome.error:
        console.print(f"{outcome.name}: failed after {outcome.seconds:.0f} s\n{outcome.error}", style="red")
        return
    table = Table(*COLUMNS, title=f"{outcome.name}: {REPRODUCTIONS[outcome.name].what}", title_justify="left")
    for row in outcome.rows:
        table.add_row(row.quantity, _formatted(row.published), _formatted(row.ours), row.difference, row.reading)
    console.print(table)
    for note in outcome.notes:
        console.print(note)
    console.print(f"{outcome.seconds:.1f} s; {', '.join(map(str, outcome.files))}\n")


def _formatted(value: float | str) -> str:
    """A number to four digits; text unchanged."""
    return value if isinstance(value, str) else f"{value:.4g}"


@contextlib.contextmanager
def _one_thread_per_process() -> Iterator[None]:
    """Set what new processes read: threads of NumPy would compete for the cores and change the order of sums."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        yield
    finally:
        os.environ.pop("OMP_NUM_THREADS") if before is None else os.environ.update(OMP_NUM_THREADS=before)


def _status_line(running: Iterable[_Process], done: int, of: int) -> str:
    names = ", ".join(f"{process.name} ({process.seconds:.0f} s)" for process in running)
    return f"{done} of {of} done; running {names}"


def _write_data(result: Result, out: Path, name: str) -> Path:
    if isinstance(result.data, xr.Dataset):
        result.data.to_zarr(out / f"{name}.zarr", mode="w", consolidated=False)
        return out / f"{name}.zarr"
    columns = {key: np.asarray(values) for key, values in result.data.items()}
    return _write_csv(out / f"{name}.csv", columns, zip(*columns.values(), strict=True))


def _write_table(rows: Sequence[Comparison], out: Path, name: str) -> Path:
    lines = [(row.quantity, row.published, row.ours, row.difference, row.reading) for row in rows]
    return _write_csv(out / f"{name}.table.csv", COLUMNS, lines)


def _write_csv(path: Path, head: Sequence[str] | dict, lines) -> Path:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(lines)
    return path
