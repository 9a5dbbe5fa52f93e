"""From values of a quantity to colours: the range of the values, and the scale between both ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warp_rods.draw.colours import Colour, colour_map

__all__ = ["LACKING", "Scale", "linear", "scale_of"]

LACKING = (0.55, 0.55, 0.55)
"""sRGB of rods without a value: they were lost, or their kind has no such quantity."""
_QUANTILES = (0.02, 0.98)
"""Quantiles of an amount at both ends of its scale; that of a signed one is symmetric, at the second of |values|."""

_OF_A_FRAME, _ROOM = 0.9, 2.0
"""The root scale of an energy goes to this quantile of the frame in which it is largest, but to at most so many times
that of all frames: the last picture, where rods have relaxed, must not be dark. Arrows mark what is beyond."""
_BEYOND = 0.01
"""Values beyond an end of the scale by more than this part of it are marked by an arrow."""
_SAME = 1e-12
"""Values that differ by this part of their size are equal but for round-off."""


@dataclass(frozen=True)
class Scale:
    """Colours of one quantity between ``low`` and ``high``: evenly, or as the root of a quadratic quantity.

    below, above: whether there are values beyond these ends, which have the colours of the ends.
    """

    colour: Colour
    low: float
    high: float
    below: bool = False
    above: bool = False

    def marked(self, values: np.ndarray) -> Scale:
        """This scale, with whether any of these values [...] are beyond its ends."""
        slack = _BEYOND * (self.high - self.low)
        below, above = bool((values < self.low - slack).any()), bool((values > self.high + slack).any())
        return replace(self, below=below, above=above)

    def fraction(self, values: np.ndarray) -> np.ndarray:
        """Where values [...] are on the scale, from 0 to 1; NaN where there is no value."""
        even = np.clip((values - self.low) / (self.high - self.low), 0.0, 1.0)
        return np.sqrt(even) if self.colour.quadratic else even

    def rgb(self, values: np.ndarray) -> np.ndarray:
        """sRGB [..., 3] of values [...], from 0 to 1; ``LACKING`` where there is no value."""
        fraction = self.fraction(np.asarray(values, dtype=float))
        colours = colour_map(self.colour.map_name)(np.nan_to_num(fraction))[..., :3]
        return np.where(np.isfinite(fraction)[..., None], colours, LACKING)

    def ticks(self, count: int = 5) -> np.ndarray:
        """``count`` values evenly spaced on the scale, for a colour bar."""
        even = np.linspace(0.0, 1.0, count)
        return self.low + (self.high - self.low) * (even**2 if self.colour.quadratic else even)


def scale_of(colour: Colour, values: np.ndarray, round_off: float = 0.0) -> Scale:
    """The scale that suits all these values [frame, value], or [value]; those that are not finite do not count.

    Where the quantiles leave no range, as of few values beside many zeros, it goes to the extreme ones. A constant is
    in the middle of its scale. Values up to ``round_off``, and differences of 1e-12 of the largest value, are none.
    """
    if colour.kind == "angle":
        return Scale(colour, -np.pi, np.pi)
    return _between(colour, values, round_off).marked(values)


def _between(colour: Colour, values: np.ndarray, round_off: float) -> Scale:
    frames = np.atleast_2d(values)
    values = values[np.isfinite(values)]
    values = np.where(np.abs(values) > round_off, values, 0.0) if values.size else np.zeros(1)
    if colour.kind == "signed":
        size = np.abs(values)
        largest = float(np.quantile(size, _QUANTILES[1]) or size.max()) or 1.0
        return Scale(colour, -largest, largest)
    quantiles = (0.0, 1.0) if colour.whole else _QUANTILES
    for ends in (quantiles, (0.0, 1.0)):
        low, high = map(float, np.quantile(values, ends))
        if colour.quadratic:
            low, high = 0.0, max(high, min(_largest_of_a_frame(frames), _ROOM * high))
        if high - low > _SAME * max(abs(low), abs(high)):
            return Scale(colour, low, high)
    return Scale(colour, min(0.0, 2 * low), max(0.0, 2 * low)) if low else Scale(colour, 0.0, 1.0)


def _largest_of_a_frame(frames: np.ndarray) -> float:
    """The largest of the upper quantiles of single frames [frame, value]."""
    finite = [frame[np.isfinite(frame)] for frame in frames]
    return max((float(np.quantile(frame, _OF_A_FRAME)) for frame in finite if frame.size), default=0.0)


def linear(screen: np.ndarray) -> np.ndarray:
    """Linear RGB of sRGB [...], both from 0 to 1: colours of USD are linear, colour maps are tabulated in sRGB."""
    return np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)
