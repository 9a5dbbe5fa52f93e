"""The poster of a run: its first, middle and last frame side by side, with clocks, a scale bar and colour bars."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from warp_rods.draw.clock import clock_of
from warp_rods.draw.content import Content
from warp_rods.draw.lettering import Canvas, length_text, round_length
from warp_rods.draw.picture import Painter
from warp_rods.draw.scale import Scale
from warp_rods.draw.view import view_of
from warp_rods.progress import with_progress

__all__ = ["WIDTH", "draw_poster", "draw_stills", "legend", "pictures", "stills_size"]

WIDTH = 2400
"""Pixels of a poster; its height follows from what is shown."""
_MARGIN, _GAP, _TEXT = 60, 30, 34
_LOWEST, _HIGHEST = 400, 1100
"""Bounds of the height of a panel."""
_LEGEND = 4.2
"""Height of scale bar and colour bars, in letters."""
_PICTURE = (6.4, 4.8)
"""Size of a still in inches."""


def draw_poster(shown: Content, path: Path) -> None:
    """Write the poster as PNG."""
    canvas = _poster(shown)
    canvas.image.save(path, format="PNG")


def _poster(shown: Content) -> Canvas:
    frames = sorted({0, (shown.frames - 1) // 2, shown.frames - 1})
    view = view_of(shown, frames)
    width = (WIDTH - 2 * _MARGIN - 2 * _GAP) // 3
    height = int(np.clip(width * view.half[1] / view.half[0], _LOWEST, _HIGHEST))
    painter = Painter(shown, view, width, height)
    each = shown.selection.span == "frame"  # panels then have ranges, and bars, of their own
    title, below = (2 * _TEXT if shown.title else 0), round((2.2 + _LEGEND * (1 + each)) * _TEXT)
    whole = np.full((2 * _MARGIN + title + height + below, WIDTH, 3), 255, np.uint8)
    left = (WIDTH - len(frames) * (width + _GAP) + _GAP) // 2
    places = [left + number * (width + _GAP) for number in range(len(frames))]
    top = _MARGIN + title
    for x, frame in zip(places, frames, strict=True):
        whole[top : top + height, x : x + width] = painter.paint(frame)
    canvas = Canvas(whole, _TEXT)
    canvas.write(_MARGIN, _MARGIN, _shortened(canvas, shown.title, WIDTH - 2 * _MARGIN, 1.2), size=1.2)
    clock = clock_of(shown)
    for x, frame in zip(places, frames, strict=True):
        canvas.write(x + width / 2, top + height + 0.5 * _TEXT, clock.text(shown.times[frame]), "ma")
        if each:
            bar = max(0.6 * width, canvas.width_of(shown.label, 0.8))
            y = top + height + (_LEGEND + 0.3) * _TEXT
            canvas.colour_bar(x + (width + bar) / 2, y, bar, shown.scale(frame), shown.label)
    scale = None if each else shown.scale(0)
    legend(canvas, painter, shown, scale, _MARGIN, WIDTH - _MARGIN, whole.shape[0] - _MARGIN)
    return canvas


def legend(
    canvas: Canvas, painter: Painter, shown: Content, scale: Scale | None, left: float, right: float, bottom: float
) -> None:
    """Scale bar at the left, colour bars at the right, above ``bottom``; without a scale none for the rods."""
    y, width = bottom - 1.9 * canvas.text, min(0.22 * (right - left), 16 * canvas.text)
    length = round_length(0.14 * (right - left) / painter.scale * shown.metres) / shown.metres
    canvas.scale_bar(left, y + 0.3 * canvas.text, length * painter.scale, length_text(length, shown))
    if scale:
        right = canvas.colour_bar(right, y, width, scale, shown.label) - 2 * canvas.text
    if painter.curvature:
        label = shown.named("Gaussian curvature of membrane", "1/length^2")
        canvas.curvature_bar(right, y, width, painter.curvature, label)


def _shortened(canvas: Canvas, text: str, width: float, size: float) -> str:
    while canvas.width_of(text, size) > width:
        text = text[:-2].rstrip() + "…"
    return text


def draw_stills(shown: Content, path: Path, dpi: int) -> None:
    """Write a folder with a picture in PNG of each frame."""
    path.mkdir()
    size = (round(_PICTURE[0] * dpi), round(_PICTURE[1] * dpi))
    digits = len(str(shown.numbers[-1]))
    for frame, canvas in zip(shown.numbers, pictures(shown, *size), strict=True):
        canvas.image.save(path / f"frame_{frame:0{digits}d}.png", format="PNG", dpi=(dpi, dpi))


def pictures(shown: Content, width: int, height: int, what: str = "pictures") -> Iterator[Canvas]:
    """The pictures of all frames, of this size, with clock, scale bar and colour bar."""
    text = round(max(height / 36, 11))
    margin, low = text, round(_LEGEND * text)
    view, clock = view_of(shown), clock_of(shown)
    painter = Painter(shown, view, width - 2 * margin, height - 2 * margin - low)
    for frame in with_progress(range(shown.frames), what):
        whole = np.full((height, width, 3), 255, np.uint8)
        whole[margin : height - margin - low, margin : width - margin] = painter.paint(frame)
        canvas = Canvas(whole, text)
        canvas.write(margin, margin, clock.text(shown.times[frame]))
        legend(canvas, painter, shown, shown.scale(frame), margin, width - margin, height - margin / 2)
        yield canvas


def stills_size(shown: Content, dpi: int) -> float:
    """About how many bytes the pictures of all frames have."""
    return 0.12 * shown.frames * _PICTURE[0] * _PICTURE[1] * dpi**2
