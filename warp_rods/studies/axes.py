"""The axes of a study: the swept keys with their values at all points of the grid, and the seeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods.scene.scene import Scene
from warp_rods.values import literal

__all__ = ["SEED", "Axis", "axes_of"]

SEED = "seed"
"""The name of the last axis."""


@dataclass(frozen=True)
class Axis:
    """A swept key and its values; the first points are every ``stride``-th of them, the others are for refinement."""

    key: str
    values: tuple[Any, ...]
    scale: str = "list"
    """"linear", "log", or "list" for values that were listed, which are not refined."""
    stride: int = 1

    def __len__(self) -> int:
        return len(self.values)

    @property
    def first(self) -> int:
        """The number of values before refinement."""
        return (len(self.values) - 1) // self.stride + 1

    @property
    def numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in self.values)

    @property
    def labels(self) -> np.ndarray:
        """The values as a coordinate: numbers, or else text in TOML notation."""
        if self.key == SEED:
            return np.array(self.values, dtype=np.int64)
        if self.numeric:
            return np.array(self.values, dtype=np.float64)
        return np.array([value if isinstance(value, str) else literal(value) for value in self.values], dtype=object)


def axes_of(scene: Scene) -> tuple[Axis, ...]:
    """The axes of the sweep of a scene in its order, the seeds last."""
    sweep = scene.sweep
    assert sweep is not None
    axes = [_axis(key, given, sweep.refine) for key, given in sweep.axes.items()]
    seeds = sweep.seeds if isinstance(sweep.seeds, tuple) else tuple(scene.seed + k for k in range(sweep.seeds))
    return (*axes, Axis(SEED, seeds))


def _axis(key: str, given: Any, refine: int) -> Axis:
    if not isinstance(given, Mapping):
        return Axis(key, tuple(given))
    first, last, stride = given["from"], given["to"], 2**refine
    scale = given.get("scale", "linear")
    values: tuple[float, ...] = _range(float(first), float(last), (given["num"] - 1) * stride, scale)
    if isinstance(first, int) and isinstance(last, int) and all(value.is_integer() for value in values):
        values = tuple(map(int, values))  # a key such as the number of nodes takes whole numbers alone
    return Axis(key, values, scale, stride)


def _range(first: float, last: float, steps: int, scale: str) -> tuple[float, ...]:
    """Values from first to last. Twice as many steps give the same values, to the bit, at every second place."""
    if scale == "log":
        inner = [math.exp(value) for value in _range(math.log(first), math.log(last), steps, "linear")[1:-1]]
    else:
        step = (last - first) / steps
        inner = [first + k * step for k in range(1, steps)]
    return (first, *inner, last)
