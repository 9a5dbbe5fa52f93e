"""The table of colours: the quantities that can colour rods, each with a map that fits it.

To add one, write a function ``(data, frames) -> values [frame, rod, node]`` of an ensemble and numbers of its frames,
and give it a row of ``COLOURS``. Maps are perceptually uniform: from dark to bright for amounts, with a dark middle for
quantities that have a sign (of a curvature from blue to red, as on the membrane), and a circle of hues of one lightness
for angles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr

__all__ = ["BLUE_RED", "COLOURS", "HUES", "Colour", "at_frames", "colour_map"]

HUES = "hues"
"""The name of the cyclic map, which is made here: ``colour_map``."""
BLUE_RED = "blue_red"
"""The name of the map of a curvature, made here: the hues of the membrane's, but dark, so that rods stand out on it."""
Kind = Literal["amount", "signed", "angle"]
MAPS: dict[str, str] = {"amount": "viridis", "signed": "managua", "angle": HUES}
"""Kind of a quantity → name of its colour map."""
Values = Callable[[xr.Dataset, range], np.ndarray]


@dataclass(frozen=True)
class Colour:
    """A quantity that colours rods.

    label, unit: for a colour bar (a product of the scene's length, force and time; "1" for a number). needs: variables
    of the trajectory. values(data, frames): of the nodes at these frames, [frame, rod, node]. kind: an amount (zero or
    more, or a number), a quantity with a sign, or an angle from −π to π. quadratic: colours follow its root, from zero:
    those of an energy then follow the strain, and rods that have nearly relaxed are not all alike. whole: the scale
    goes from the smallest value to the largest, not between quantiles. frames: how many of a run it needs. own_map: the
    name of a colour map, where that of its kind does not suit.
    """

    label: str
    unit: str
    kind: Kind
    needs: tuple[str, ...]
    values: Values
    quadratic: bool = False
    whole: bool = False
    frames: int = 1
    own_map: str = ""

    def is_in(self, data: xr.Dataset) -> bool:
        """Whether the trajectory of an ensemble has what the quantity needs."""
        return all(name in data for name in self.needs) and data.sizes["frame"] >= self.frames

    @property
    def map_name(self) -> str:
        """The name of the colour map."""
        return self.own_map or MAPS[self.kind]


def colour_map(name: str) -> Any:
    """The Matplotlib colour map of this name; ``hues`` and ``blue_red`` are made here."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    made = {HUES: _hues, BLUE_RED: _blue_red}
    return ListedColormap(made[name](256), name=name) if name in made else colormaps[name]


def _hues(count: int) -> np.ndarray:
    """sRGB [count, 3] of a circle of hues of equal lightness and chroma."""
    angle = np.linspace(0.0, 2 * np.pi, count, endpoint=False) + np.pi
    return _srgb(np.full(count, 0.66), np.full(count, 0.115), angle)


def _blue_red(count: int) -> np.ndarray:
    """sRGB [count, 3] from blue over a dark middle to red; both halves become lighter alike."""
    signed = np.linspace(-1.0, 1.0, count)
    size = np.abs(signed)
    return _srgb(0.26 + 0.3 * size, 0.2 * size, np.radians(np.where(signed < 0, 262.0, 27.0)))


def _srgb(lightness: np.ndarray, chroma: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """sRGB [..., 3] of lightness, chroma and hue in Oklab (Ottosson 2020)."""
    lab = np.stack([lightness, chroma * np.cos(angle), chroma * np.sin(angle)], axis=-1)
    to_lms = np.array(
        [[1, 0.3963377774, 0.2158037573], [1, -0.1055613458, -0.0638541728], [1, -0.0894841775, -1.2914855480]]
    )
    to_rgb = np.array(
        [
            [4.0767416621, -3.3077115913, 0.2309699292],
            [-1.2684380046, 2.6097574011, -0.3413193965],
            [-0.0041960863, -0.7034186147, 1.7076147010],
        ]
    )
    linear = np.clip((lab @ to_lms.T) ** 3 @ to_rgb.T, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def at_frames(variable: xr.DataArray, frames: range | np.ndarray) -> np.ndarray:
    """Values of a variable at frames; evenly spaced ones are read as a slice, which costs one read."""
    if not isinstance(frames, range):
        step = int(frames[1] - frames[0]) if len(frames) > 1 else 1
        even = range(int(frames[0]), int(frames[-1]) + 1, step) if step > 0 else range(0)
        frames = even if np.array_equal(frames, even) else frames
    if isinstance(frames, range) and frames.step > 0:
        return variable.isel(frame=slice(frames.start, frames.stop, frames.step)).values
    return variable.isel(frame=np.asarray(frames)).values


def _variable(name: str) -> Values:
    return lambda data, frames: at_frames(data[name], frames)


def _twist(data: xr.Dataset, frames: range) -> np.ndarray:
    return at_frames(data["strain"].isel(strain_component=0), frames)


def _speed(data: xr.Dataset, frames: range) -> np.ndarray:
    """|∂t r| from the frames before and after: second order in their distance, first order at both ends of a run."""
    last, number = data.sizes["frame"] - 1, np.asarray(frames)
    before, after = np.maximum(number - 1, 0), np.minimum(number + 1, last)
    read = np.unique(np.concatenate([before, after]))
    position, time = at_frames(data["position"], read), data["time"].values
    moved = position[np.searchsorted(read, after)] - position[np.searchsorted(read, before)]
    return np.linalg.norm(moved, axis=-1) / (time[after] - time[before])[:, None, None]


def _heading(data: xr.Dataset, frames: range) -> np.ndarray:
    """The angle of the tangent of the middle in the plane x, y; one for the whole rod."""
    middle, nodes = data.sizes["node"] // 2, data.sizes["node"]
    ends = at_frames(data["position"].isel(node=[middle - 1, middle + 1]), frames)
    tangent = ends[..., 1, :] - ends[..., 0, :]
    return np.repeat(np.arctan2(tangent[..., 1], tangent[..., 0])[..., None], nodes, axis=-1)


def _gauss(data: xr.Dataset, frames: range) -> np.ndarray:
    return np.repeat(at_frames(data["gauss"], frames)[..., None], data.sizes["node"], axis=-1)


def _rod(data: xr.Dataset, frames: range) -> np.ndarray:
    rods, nodes = data.sizes["rod"], data.sizes["node"]
    return np.broadcast_to(np.arange(rods, dtype=float)[:, None], (len(frames), rods, nodes))


COLOURS: dict[str, Colour] = {
    "energy_density": Colour(
        "elastic energy per length", "force", "amount", ("energy_density",), _variable("energy_density"), True
    ),
    "twist": Colour("twist", "1/length", "signed", ("strain",), _twist),
    "tension": Colour("tension", "force", "signed", ("tension",), _variable("tension")),
    "activity": Colour("flagellar activity", "1", "signed", ("activity",), _variable("activity")),
    "speed": Colour("speed", "length/time", "amount", ("position",), _speed, frames=2),
    "heading": Colour("heading in the plane x, y", "rad", "angle", ("position",), _heading),
    "gauss": Colour("Gaussian curvature under the rod", "1/length^2", "signed", ("gauss",), _gauss, own_map=BLUE_RED),
    "rod": Colour("number of the rod", "1", "amount", (), _rod, whole=True),
}
"""By the name of the option ``--colour``."""
