"""What is written on pictures: title, clock, scale bar and colour bars, in the font of the figures."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from warp_rods.draw.content import Content
from warp_rods.draw.scale import Scale
from warp_rods.draw.sheet import curvature_colours

__all__ = ["Canvas", "length_text", "round_length"]

_INK = (40, 42, 46)
_PREFIXES = ((1.0, "m"), (1e-2, "cm"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"))


class Canvas:
    """A picture [height, width, 3] on which one can write; sizes are in pixels, ``text`` in that of its letters."""

    def __init__(self, picture: np.ndarray, text: int) -> None:
        from PIL import Image, ImageDraw

        self.image = Image.fromarray(picture)
        self._pen = ImageDraw.Draw(self.image)
        self.text = text

    @property
    def picture(self) -> np.ndarray:
        """The picture with what was written on it."""
        return np.asarray(self.image)

    def write(self, x: float, y: float, text: str, anchor: str = "la", size: float = 1.0) -> None:
        """Write at (x, y). anchor: "l", "m", "r" for left, middle, right; then "a" for the top, "s" for the base."""
        self._pen.text((x, y), text, fill=_INK, font=_font(round(size * self.text)), anchor=anchor)

    def width_of(self, text: str, size: float = 1.0) -> float:
        """Width of a text."""
        return float(self._pen.textlength(text, font=_font(round(size * self.text))))

    def scale_bar(self, x: float, y: float, pixels: float, label: str) -> None:
        """A bar from (x, y) to the right, with its length above it."""
        thick = max(2, self.text // 6)
        self._pen.rectangle((x, y, x + pixels, y + thick), fill=_INK)
        self.write(x + pixels / 2, y - 0.25 * self.text, label, "ms", 0.9)

    def colour_bar(self, right: float, y: float, width: float, scale: Scale, label: str) -> float:
        """A bar with a label above it and three numbers below; y: of its upper edge.

        It ends at ``right`` and is at least as wide as its label; an arrow goes beyond an end beyond which there are
        values. Returns its left end.
        """
        ends = ["−π", "0", "π"] if scale.colour.kind == "angle" else [_number(value) for value in scale.ticks(3)]
        x = self._bar(right, y, width, lambda count: scale.rgb(scale.ticks(count)), label, ends)
        beyond = [(right, 1, scale.high)] if scale.above else []
        for end, towards, value in [(x, -1, scale.low), *beyond] if scale.below else beyond:
            self._arrow(end, y, towards, scale.rgb(np.array([value]))[0])
        return x

    def _arrow(self, x: float, y: float, towards: int, colour: np.ndarray) -> None:
        """A tip on an end of a bar: there are values beyond it."""
        height = round(0.7 * self.text)
        x, y = round(x), round(y)
        corners = [(x, y), (x + 0.7 * towards * height, y + height / 2), (x, y + height)]
        self._pen.polygon(corners, fill=tuple(int(level) for level in np.rint(255 * colour)))

    def curvature_bar(self, right: float, y: float, width: float, largest: float, label: str) -> float:
        """The bar of the Gaussian curvature of a membrane."""
        ends = [_number(value) for value in (-largest, 0.0, largest)]
        return self._bar(right, y, width, lambda count: curvature_colours(np.linspace(-1, 1, count)), label, ends)

    def _bar(
        self, right: float, y: float, width: float, colours: Callable[[int], np.ndarray], label: str, ends: list[str]
    ) -> float:
        from PIL import Image

        width, height = round(max(width, self.width_of(label, 0.8))), round(0.7 * self.text)
        x = round(right) - width
        strip = np.rint(255 * np.broadcast_to(colours(width), (height, width, 3))).astype(np.uint8)
        self.image.paste(Image.fromarray(strip), (x, round(y)))
        self.write(x, y - 0.35 * self.text, label, "ls", 0.8)
        for place, text, anchor in zip((x, x + width / 2, x + width), ends, ("la", "ma", "ra"), strict=True):
            self.write(place, y + height + 0.15 * self.text, text, anchor, 0.75)
        return x


@lru_cache(maxsize=32)
def _font(size: int) -> Any:
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf", max(size, 6))


def _number(value: float) -> str:
    return f"{value:.2g}".replace("-", "−")


def round_length(most: float) -> float:
    """The largest of 1, 2, 5, 10, … that is at most ``most``."""
    ten = 10.0 ** np.floor(np.log10(most))
    return float(max(step * ten for step in (1, 2, 5) if step * ten <= most * (1 + 1e-9)))


def length_text(length: float, shown: Content) -> str:
    """A length in words: in metres and their parts where the scene has units, else a number."""
    if shown.scene.units is None:
        return f"{length:g}"
    metres = length * shown.metres
    one, name = next(((one, name) for one, name in _PREFIXES if metres >= one * (1 - 1e-9)), _PREFIXES[-1])
    return f"{metres / one:.3g} {name}"
