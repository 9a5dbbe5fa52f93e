"""From values of a quantity to colours: the range of the values, and the scale between both ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_rods.draw.colours import Colour, colour_map

__all__ = ["LACKING", "Scale", "linear", "scale_of"]

LACKING = (0.55, 0.55, 0.55)
"""sRGB of rods without a value: they were lost, or their kind has no such quantity."""
_QUANTILES = (0.02, 0.98)
"""Quantiles of an amount at both ends of its scale; that of a signed one is symmetric, at the second of |values|."""


@dataclass(frozen=True)
class Scale:
    """Colours of one quantity between ``low`` and ``high``: evenly, or as the root of a quadratic quantity."""

    colour: Colour
    low: float
    high: float

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


def scale_of(colour: Colour, values: np.ndarray) -> Scale:
    """The scale that suits all these values [...]; those that are not finite do not count."""
    if colour.kind == "angle":
        return Scale(colour, -np.pi, np.pi)
    values = values[np.isfinite(values)]
    if colour.kind == "signed":
        largest = float(np.quantile(np.abs(values), _QUANTILES[1])) if values.size else 0.0
        return Scale(colour, -largest or -1.0, largest or 1.0)
    low, high = map(float, np.quantile(values, _QUANTILES)) if values.size else (0.0, 1.0)
    low = 0.0 if colour.quadratic else low
    return Scale(colour, low, high if high > low else low + 1.0)


def linear(screen: np.ndarray) -> np.ndarray:
    """Linear RGB of sRGB [...], both from 0 to 1: colours of USD are linear, colour maps are tabulated in sRGB."""
    return np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)
