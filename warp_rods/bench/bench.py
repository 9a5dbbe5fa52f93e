"""Run benchmarks one after another, each in a process of its own on one core; print and write what they find."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from rich.console import Console

from warp_rods.bench import machine, results_file
from warp_rods.bench.catalogue import BENCHMARKS
from warp_rods.bench.result import Section, Settings
from warp_rods.device import cores
from warp_rods.device import start as start_warp
from warp_rods.errors import SceneError, nearest
from warp_rods.progress import LINE_EVERY, Lines, in_words
from warp_rods.simulation.files import check_writable

RESULTS = Path("benchmarks/RESULTS.md")


def chosen(names: Sequence[str]) -> list[str]:
    """The benchmarks of these names, in the order of the table; all of them for none. Raises SceneError."""
    for name in names:
        if name not in BENCHMARKS:
            known = [*BENCHMARKS, "list"]
            raise SceneError(f"bench {name}: must be one of {', '.join(known)}{nearest(name, known)}")
    return [name for name in BENCHMARKS if not names or name in names]


def run(
    names: Sequence[str] = (),
    out: Path = RESULTS,
    *,
    against: Path | None = None,
    quick: bool = False,
    console: Console | None = None,
) -> list[str]:
    """Run benchmarks, all of them by default, and put what each finds into ``out`` and beside it when it is finished.

    Returns the names of those that failed; the others continue.

    against: the folder of another version of this package, which scenes are compared with. quick: in a form so small
    that figures mean nothing, for tests. Raises SceneError for an unknown name or a folder without a package.
    """
    console = console or Console(stderr=True, markup=False, highlight=False)
    wanted = chosen(names)
    check_writable(out.parent, "out")
    if against is not None and not (against / "warp_rods" / "__init__.py").is_file():
        raise SceneError(
            f"against = {against}: there is no warp_rods/ in it: give the folder of a clone of this project"
        )
    provenance = machine.provenance(cores()) + ("; quick form, its figures mean nothing" if quick else "")
    failed = []
    for number, name in enumerate(wanted):
        row, began = BENCHMARKS[name], time.perf_counter()
        console.print(f"{name} ({number + 1} of {len(wanted)}): {row.what}, about {row.minutes:g} min")
        try:
            section = _apart(name, quick, against, out.parent)
        except Exception:  # the others continue, whatever failed here
            console.print(f"{name}: failed\n{traceback.format_exc()}", style="red")
            failed.append(name)
            continue
        report(section, console)
        text = results_file.text_of(name, row.what, section, provenance)
        results_file.write(out, name, text, list(BENCHMARKS))
        console.print(f"{in_words(time.perf_counter() - began)}; in {out}\n")
    return failed


def _apart(name: str, quick: bool, against: Path | None, folder: Path) -> Section:
    """One benchmark in a process of its own."""
    process = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
    try:
        with _one_thread():
            return process.submit(perform, name, quick, against, folder).result()
    finally:
        process.shutdown(wait=False)  # a signal must not wait for it; the command line ends it


def _begin() -> None:
    start_warp()
    machine.use_one_core()


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """Set what a new process reads: other packages use one thread."""
    before = {name: os.environ.get(name) for name in machine.ONE_THREAD}
    os.environ.update(dict.fromkeys(machine.ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def perform(name: str, quick: bool, against: Path | None, folder: Path) -> Section:
    """Run one benchmark in this process, telling what goes on, and save its figures in ``folder``, without them."""
    from warp_rods.draw.plots import save, style

    with _telling(name) as tell, style():
        section = BENCHMARKS[name].make()(Settings(quick, against, tell))
        for stem, figure in section.figures.items():
            save(figure, folder / stem)
    return Section(section.tables, dict.fromkeys(section.figures), section.notes)


@contextlib.contextmanager
def _telling(name: str) -> Iterator[Callable[[str], None]]:
    """A function that shows a note: in a line that changes on a terminal, and every half a minute elsewhere."""
    console = Console(stderr=True, markup=False, highlight=False)
    note, began = [""], time.perf_counter()
    lines = Lines(lambda: f"{name}, {in_words(time.perf_counter() - began)}: {note[0]}", console)
    lines.start(LINE_EVERY)
    with console.status("") as status, contextlib.closing(lines):

        def tell(what: str) -> None:
            note[0] = what
            status.update(f"{name}: {what}")

        yield tell


def report(section: Section, console: Console) -> None:
    """Print tables and notes."""
    for table in section.tables:
        console.print(f"\n{results_file.plain(table)}", soft_wrap=True)
    for note in section.notes:
        console.print(f"- {note}")
