"""What of a run is drawn or exported: ensembles, frames, colour, and the range of the colours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from warp_rods.arguments import wrong
from warp_rods.draw.colours import COLOURS
from warp_rods.errors import SceneError, named, nearest

__all__ = ["Selection", "Span", "parse_frames", "parse_span"]

Span = Literal["run", "frame"] | tuple[float, float]
_FRAMES = 'first:last:step as in Python, such as "0:100:5", "-1" (the last) or ":" (all)'
_SPAN = '"run", "frame" or two increasing finite numbers "LOW,HIGH"'


@dataclass(frozen=True)
class Selection:
    """A part of a run, and how its rods are coloured.

    ensembles: their names, none for all. frames: a slice of the frames of the trajectory. colour: a row of ``COLOURS``,
    or empty for the first of which the run has what it needs. span: both ends of the colours are taken from all frames
    of the run, chosen or not ("run"), anew from each ("frame"), or given. Raises SceneError for an unknown colour and a
    wrong span.
    """

    ensembles: tuple[str, ...] = ()
    frames: slice = field(default_factory=lambda: slice(None))
    colour: str = ""
    span: Span = "run"

    def __post_init__(self) -> None:
        if self.colour != "":
            named(COLOURS, "colour", self.colour)
        if self.span in ("run", "frame"):
            return
        if isinstance(self.span, str) or not _increases(self.span):
            raise wrong("range", self.span, _SPAN)

    def names(self, known: Sequence[str]) -> list[str]:
        """The chosen ones of the known ensembles, in their order; raises SceneError for an unknown one."""
        for name in self.ensembles:
            if name not in known:
                raise SceneError(f"ensembles: there is no {name!r}{nearest(name, known)}; known: {', '.join(known)}")
        return [name for name in known if not self.ensembles or name in self.ensembles]

    def numbers(self, count: int) -> range:
        """The numbers of the chosen frames of ``count``; raises SceneError where there is none."""
        try:
            chosen = range(count)[self.frames]
        except (TypeError, ValueError):
            raise wrong("frames", self.frames, _FRAMES) from None
        if not chosen:
            raise SceneError(f"frames: none is chosen; the run has {count}, counted from 0")
        return chosen


def parse_frames(text: str) -> slice:
    """The slice in a text such as "0:100:5"; one number chooses one frame. Raises SceneError."""
    try:
        parts = [int(part) if part.strip() else None for part in text.split(":")]
    except ValueError:
        raise wrong("frames", text, _FRAMES) from None
    if len(parts) > 3 or (len(parts) == 3 and parts[2] == 0) or (len(parts) == 1 and parts[0] is None):
        raise wrong("frames", text, _FRAMES)
    if len(parts) > 1:
        return slice(*parts)
    assert parts[0] is not None
    return slice(parts[0], parts[0] + 1 or None)


def parse_span(text: str) -> Span:
    """The span in a text: "run", "frame", or two numbers with a comma between them. Raises SceneError."""
    if text == "run" or text == "frame":
        return text  # type: ignore[return-value]
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        raise wrong("range", text, _SPAN) from None
    if not _increases((low, high)):
        raise wrong("range", text, _SPAN)
    return low, high


def _increases(span: Sequence[float]) -> bool:
    """Whether these are two finite numbers, the second one larger."""
    return len(span) == 2 and all(map(math.isfinite, span)) and span[0] < span[1]
