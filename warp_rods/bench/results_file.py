"""``RESULTS.md``: one section a benchmark, replaced when that benchmark is run again; figures beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from warp_rods.bench.result import Section, Table, shown
from warp_rods.simulation.files import replace_file

HEAD = """# Results of the benchmarks

Made by `warp-rods bench`, which replaces the sections of those that it runs; not edited. Times are CPU time of one core
(the process is kept on it, other codes have one thread), medians of runs in turns with what they are compared with,
unless a table says otherwise. Each section says on which machine, when, and of which commit.
"""
MARK = "\n## "


def sections_of(text: str) -> dict[str, str]:
    """Name → text of each section of a file of results."""
    return {part.split("\n", 1)[0].strip(): part for part in text.split(MARK)[1:]}


def markdown(table: Table) -> str:
    """A table in Markdown."""
    lines = [table.columns, ["---"] + ["---:"] * (len(table.columns) - 1)]
    lines += [[shown(cell) for cell in row] for row in table.rows]
    return f"**{table.title}**\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines)


def plain(table: Table) -> str:
    """A table in columns of text."""
    lines = [[*table.columns], *([shown(cell) for cell in row] for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = [
        line[0].ljust(widths[0]) + "".join(f"  {c:>{w}}" for c, w in zip(line[1:], widths[1:], strict=True))
        for line in lines
    ]
    return "\n".join([table.title, *text])


def text_of(name: str, what: str, section: Section, provenance: str) -> str:
    """A section in Markdown."""
    parts = [name, f"{what[0].upper()}{what[1:]}. {provenance}."]
    parts += [markdown(table) for table in section.tables]
    parts += [f"![{stem}]({stem}.png)" for stem in section.figures]
    if section.notes:
        parts.append("\n".join(f"- {note}" for note in section.notes))
    return "\n\n".join(parts) + "\n"


def write(path: Path, name: str, text: str, order: Sequence[str]) -> None:
    """Put a section into the file, in the order of the table of benchmarks; others stay as they are."""
    kept = sections_of(path.read_text(encoding="utf-8")) if path.is_file() else {}
    kept[name] = text
    known = [kept[each] for each in order if each in kept]
    path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, (HEAD + "".join(MARK + each.strip() + "\n" for each in known)).encode())
