"""Standard output and error of the command line: on any terminal, and when nobody reads them any more.

A character that the encoding of a terminal lacks is spelled out. Where a pipe was closed early, or the disk that a log
goes to is full, the output is lost but the command goes on: a run of hours must not end because of ``| head``.
"""

from __future__ import annotations

import codecs
import io
import os
import select
import sys
import unicodedata

__all__ = ["open_streams", "show_error"]

SPELLED = {
    "…": "...", "–": "-", "—": "-", "−": "-", "→": "->", "×": "x", "·": ".", "⟨": "<", "⟩": ">", "≤": "<=", "≥": ">=",
    "∇": "grad ", "√": "sqrt", "∞": "inf", "±": "+-", "∥": "_par", "⊥": "_perp", "𝒦": "K", "“": '"',
    "”": '"', "’": "'", "µ": "u", "μ": "u", "Δ": "d",
}  # fmt: skip
"""What stands for a character that a terminal cannot show; Greek letters get their names."""


def _spell(error: UnicodeError) -> tuple[str, int]:
    """An error handler of codecs: the characters in words, and where to go on."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_spelled, error.object[error.start : error.end])), error.end


def _spelled(character: str) -> str:
    if character in SPELLED:
        return SPELLED[character]
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    name = unicodedata.name(character, "?").split()
    return plain or (name[-1].lower() if name[0] == "GREEK" else "?")


codecs.register_error("spelled", _spell)


class _Lasting(io.FileIO):
    """A file descriptor that is written to as long as that is possible."""

    instead_of: object = None

    def write(self, data) -> int:
        try:
            while (written := super().write(data)) is None:  # a pipe that does not block is full
                select.select([], [self], [])
            return written
        except OSError:
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, self.fileno())
            os.close(null)
            return len(data)


def open_streams() -> None:
    """Let ``sys.stdout`` and ``sys.stderr`` spell out what they cannot show, and outlive their readers."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        try:
            stream.flush()
            raw = _Lasting(stream.fileno(), "w", closefd=False)
            raw.instead_of = stream  # which would close the descriptor
        except (AttributeError, OSError, ValueError):  # there is none, or it is no file
            continue
        buffer = io.BufferedWriter(raw)
        lasting = io.TextIOWrapper(buffer, stream.encoding, "spelled", line_buffering=True)
        setattr(sys, name, lasting)


def show_error(text: str) -> None:
    """Write a message to standard error; its first word is red on a terminal, unless NO_COLOR is set."""
    coloured = sys.stderr.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    print(f"\x1b[1;31merror:\x1b[0m {text}" if coloured else f"error: {text}", file=sys.stderr)
