"""A run while it runs, on a terminal: progress, energies as curves, statuses, a projection of the last frame."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from warp_rods.draw import characters
from warp_rods.errors import RunFolderError
from warp_rods.progress import LINE_EVERY, in_words
from warp_rods.simulation.files import STUDY, beside, no_run
from warp_rods.simulation.leftovers import is_being_made
from warp_rods.simulation.status import RunStatus, State, status_of
from warp_rods.simulation.store import STORE
from warp_rods.simulation.under_way import is_under_way

__all__ = ["line", "watch"]

LOOK_EVERY = 1.0
"""Seconds between two looks at a folder."""
PATIENCE = 120.0
"""Seconds for which a run may be waited for: it makes its folder when its kernels are compiled."""
MOST_FRAMES, MOST_RODS = 48, 2000
"""Frames of a curve of energy, and rods in the picture, at most."""
LINES = (6, 20)
"""Lines of the picture: at least, and at most."""
BAR = 24
"""Characters of the bar."""
SAID = 3
"""Last warnings of the run that are shown."""
STYLES = {
    State.FINISHED: "green",
    State.RUNNING: "cyan",
    State.STOPPED: "yellow",
    State.DAMAGED: "red",
    State.NONE: "red",
}


def line(status: RunStatus, widths: list[int] | None = None) -> Text:
    """A status in one line; ``widths`` of its cells, where it is one of several."""
    cells = status.cells()
    padded = [cell.ljust(width) for cell, width in zip(cells, [*(widths or []), *[0] * len(cells)], strict=False)]
    text = Text("  ").join(Text(cell, STYLES[status.state] if i == 1 else "") for i, cell in enumerate(padded))
    text.rstrip()
    return text


def watch(folder: Path, console: Console) -> RunStatus:
    """Show the run in a folder until it ends; returns its last status. Without a terminal a line every half a minute.

    Raises RunFolderError where there is no run, and none begins within two minutes.
    """
    _wait_for_the_run(folder, console)
    return (_drawn if console.is_terminal else _told)(folder, console)


def _wait_for_the_run(folder: Path, console: Console) -> None:
    for look in range(int(PATIENCE / LOOK_EVERY)):
        if (folder / STUDY).exists():
            raise RunFolderError(no_run(folder))
        if (folder / STORE).exists() or is_being_made(folder) or is_under_way(folder):
            return
        if look == 0:
            if hint := beside(folder, STORE):
                raise RunFolderError(f"There is no run in {folder}{hint}")
            text = f"no run in {folder} yet: waiting for {in_words(PATIENCE)}, as kernels may be compiled first"
            console.print(text, soft_wrap=True)
        time.sleep(LOOK_EVERY)
    raise RunFolderError(no_run(folder))


def _told(folder: Path, console: Console) -> RunStatus:
    """Without a terminal."""
    told = float("-inf")
    while True:
        running = is_under_way(folder)
        if not running or time.monotonic() - told >= LINE_EVERY:
            told, status = time.monotonic(), status_of(folder)
            console.print(line(status), soft_wrap=True)
            if status.state is not State.RUNNING:
                return status
        time.sleep(LOOK_EVERY)


def _drawn(folder: Path, console: Console) -> RunStatus:
    with Live(console=console, auto_refresh=False) as live:
        while True:
            status = status_of(folder)
            live.update(_view(status, console), refresh=True)
            if status.state is not State.RUNNING:
                return status
            time.sleep(LOOK_EVERY)


def _view(status: RunStatus, console: Console) -> RenderableType:
    """All that is shown of a run."""
    plain = not console.encoding.startswith("utf")
    parts: list[RenderableType] = [_head(status), _bar(status)]
    warnings = [Text(text, style="yellow", no_wrap=True, overflow="ellipsis") for text in _last_warnings(status)]
    if status.frames:
        try:
            parts += _of_the_frames(status, console, plain, len(warnings))
        except RunFolderError as fault:  # replaced by another run at this moment, or damaged
            parts.append(Text(str(fault).split("\n")[0], style="red"))
    return Group(*parts, *warnings)


def _head(status: RunStatus) -> Text:
    title = f": {status.title}" if status.title else ""
    return Text.assemble((f"{status.folder}{title}  "), (status.state, STYLES[status.state]))


def _bar(status: RunStatus) -> RenderableType:
    """The part that is done, and its numbers in words."""
    numbers = Text(", ".join(cell.strip() for cell in status.cells()[2:]))
    row = Table.grid(padding=(0, 2))
    row.add_row(ProgressBar(total=1.0, completed=status.fraction, width=BAR), numbers)
    return row


def _last_warnings(status: RunStatus) -> list[str]:
    return [text for text in status.messages if text.startswith("warning: ")][-SAID:]


def _of_the_frames(status: RunStatus, console: Console, plain: bool, warnings: int) -> list[RenderableType]:
    """A row for each ensemble, and the last frame."""
    from warp_rods.simulation.reading import open_run

    groups = {name: group.to_dataset() for name, group in open_run(status.folder).children.items()}
    table = Table(box=None, pad_edge=False)
    for heading in ("ensemble", "rods", "lost", "mean energy", ""):
        table.add_column(heading, no_wrap=True)
    for name, data in groups.items():
        curve, words = _energy(data, plain)
        lost = status.lost.get(name, 0)
        table.add_row(name, str(data.sizes["rod"]), Text(str(lost), "red" if lost else ""), words, curve)
    taken = 3 + 2 + len(groups) + 2 + warnings
    rows = int(np.clip(console.height - taken - 1, *LINES))
    return [table, _picture(groups, console.width - 4, rows, plain)]


def _energy(data: Any, plain: bool) -> tuple[str, str]:
    """The mean elastic energy of the rods over the frames as a curve, and its first and last value."""
    if "energy" not in data:
        return "", "not saved"
    frames = np.unique(np.linspace(0, data.sizes["frame"] - 1, MOST_FRAMES).astype(int))
    values = data["energy"].isel(frame=frames).mean("rod").to_numpy()
    arrow = "->" if plain else "→"
    return characters.sparkline(values, MOST_FRAMES, plain), f"{values[0]:.4g} {arrow} {values[-1]:.4g}"


def _picture(groups: dict[str, Any], columns: int, rows: int, plain: bool) -> Panel:
    """The rods of the last frame, seen along the axis in which they extend least."""
    shares = {name: data["position"].isel(frame=-1) for name, data in groups.items()}
    every = max(1, -(-sum(one.sizes["rod"] for one in shares.values()) // MOST_RODS))
    nodes = min(one.sizes["node"] for one in shares.values())
    chosen = [one.isel(rod=slice(None, None, every)).to_numpy() for one in shares.values()]
    resampled = [one[:, np.linspace(0, one.shape[1] - 1, nodes).round().astype(int)] for one in chosen]
    first = next(iter(groups.values()))
    period = first["period"].to_numpy() if "period" in first and first["period"].dims == ("axis",) else None
    rods, axes = characters.projected(np.concatenate(resampled), period)
    lines = characters.canvas(characters.dots_along(rods, columns, rows), columns, rows, plain)
    time_of = float(first["time"][-1])
    title = f"t = {time_of:.4g}, along {axes[0]} and {axes[1]}" + (f", one rod of {every}" if every > 1 else "")
    return Panel(Text("\n".join(lines)), title=title, padding=(0, 1))
