"""The command ``warp-rods export``: what a run holds, what can be made of it and how large, and the making."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from warp_rods.draw.colours import COLOURS
from warp_rods.draw.content import Content, content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.selection import Selection, parse_frames, parse_span
from warp_rods.errors import SceneError
from warp_rods.simulation.estimates import shown_bytes

__all__ = ["export", "listing", "select"]


def select(ensembles: str = "", frames: str = ":", colour: str = "", range: str = "run") -> Selection:
    """The selection in texts of the command line; raises SceneError naming the option that is wrong."""
    names = tuple(name.strip() for name in ensembles.split(",") if name.strip())
    return Selection(names, parse_frames(frames), colour, parse_span(range))


def export(
    run_dir: Path, names: Sequence[str], selection: Selection, out: Path | None = None, **options: Any
) -> Iterator[Path]:
    """Make the files of these exporters; yields the path of each. ``out``: the file, or the folder of several.

    A folder that exists, and one for more than one file, keeps the usual names. Raises SceneError and RunFolderError.
    """
    shown = content(run_dir, selection)
    for name in names:
        exporter = EXPORTERS[name]
        yield exporter.write(shown, _path(exporter.file_name, run_dir, out, len(names)), **options)


def _path(file_name: str, run_dir: Path, out: Path | None, files: int) -> Path:
    if out is None:
        return run_dir / file_name
    if files > 1 and out.exists() and not out.is_dir():
        raise SceneError(f"out = {str(out)!r}: must be a folder, as {files} files are to be written")
    return out / file_name if files > 1 or out.is_dir() else out


def listing(run_dir: Path, selection: Selection, names: Sequence[str] = (), **options: Any) -> str:
    """What the run holds, and what can be made of the chosen part (default: everything), with sizes."""
    shown = content(run_dir, selection)
    lines = _what_there_is(shown)
    width = max(map(len, EXPORTERS)) + 2
    for name, exporter in EXPORTERS.items():
        if not names or name in names:
            size = shown_bytes(exporter.estimate(shown, **options))
            lines.append(f"--{name:{width - 2}} {exporter.file_name}, about {size}: {exporter.what}")
    return "\n".join(lines)


def _what_there_is(shown: Content) -> list[str]:
    times = shown.times
    title = [shown.title] if shown.title else []
    lines = [*title, f"{shown.frames} frames, t = {times[0]:g} to {times[-1]:g}"]
    for rods in shown.rods:
        saved = sorted(str(name) for name, variable in rods.data.data_vars.items() if "frame" in variable.dims)
        lines.append(f"{rods.name}: {rods.count} rods of {rods.nodes} nodes; {', '.join(saved)}")
    if shown.membrane:
        moving = ", moving" if shown.membrane.moving else ""
        lines.append(f"membrane: {shown.scene.surface.kind if shown.scene.surface else ''}{moving}")
    if shown.scene.box:
        lines.append(f"box: {shown.scene.box.kind}")
    colours = [name for name, row in COLOURS.items() if any(row.is_in(rods.data) for rods in shown.rods)]
    lines.append(f"colours: {', '.join(colours)}")
    return lines
