"""What notebooks show: objects as small tables, and the progress of what takes long."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

__all__ = ["Shown", "html_table"]


def html_table(rows: Iterable[Sequence[object]], head: Sequence[object] = (), title: str = "") -> str:
    """A table in HTML, with the words of ``head`` above its columns and a title; all text is escaped."""

    def line(cells: Sequence[object], tag: str) -> str:
        return (
            "<tr>" + "".join(f"<{tag} style='text-align: left'>{escape(str(one))}</{tag}>" for one in cells) + "</tr>"
        )

    caption = f"<caption style='text-align: left'><b>{escape(title)}</b></caption>" if title else ""
    return f"<table>{caption}{line(head, 'th') if head else ''}{''.join(line(row, 'td') for row in rows)}</table>"


class Shown:
    """A bar with a line of text in the output of a cell, updated in place; nothing is left of it at the end."""

    def __init__(self) -> None:
        self._handle: Any = None

    def update(self, fraction: float | None, text: str) -> None:
        """Show which part is done; None where that is not known."""
        value = "" if fraction is None else f" value='{fraction:.4f}'"
        self._show(f"<progress max='1'{value} style='width: 20em'></progress> {escape(text)}")

    def close(self) -> None:
        """Remove it."""
        if self._handle is not None:
            self._show("")

    def _show(self, text: str) -> None:
        from IPython.display import HTML, display

        if self._handle is None:
            self._handle = display(HTML(text), display_id=True)
        else:
            self._handle.update(HTML(text))
