"""Late motion of swimmers: its period and its class."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from warp_rods.analysis.described import described, need
from warp_rods.analysis.shape import bending, mode_coefficients

MODES = 6
"""Number of beam modes that describe a shape."""
STRAIGHT = 0.05
"""Bending, root mean square over time and length, below which a rod counts as straight."""
STEADY = 0.02
"""Largest root-mean-square fluctuation of a steady shape, relative to its root mean square."""
FLAT = 1e-3
"""Largest fraction of the bending of a planar shape that is out of its plane."""
RECURRENCE = 0.1
"""Largest mean square difference from the shape one period earlier, relative to twice the variance."""
FEWEST = 6
"""Smallest number of frames in the late window."""
SIGN_CHANGE = 0.1
"""a₀ changes sign where its extrema have opposite signs and the smaller one exceeds this fraction of the larger."""


class Motion(NamedTuple):
    """Properties of the motion in the late window, each [rod]."""

    straight: np.ndarray
    steady: np.ndarray
    planar: np.ndarray
    even: np.ndarray
    periodic: np.ndarray
    reverses: np.ndarray


CLASSES: dict[str, Callable[[Motion], np.ndarray]] = {
    "straight": lambda m: m.straight,
    "U": lambda m: m.steady & m.planar & m.even,
    "twisted-U": lambda m: m.steady & ~m.planar & m.even,
    "S": lambda m: m.steady & ~m.even,
    "waving": lambda m: m.periodic & ~m.reverses,
    "flapping": lambda m: m.periodic & m.reverses,
}
"""Definition of each class. The first that applies gives the name; a motion to which none applies is irregular."""


def period(dataset: xr.Dataset, since: float | None = None) -> xr.DataArray:
    """Period of the shape (rod).

    The shortest time after which the beam-mode coefficients of both twist-free bendings recur, refined by a parabola.
    The window are the frames after ``since``, equally spaced in time; by default the later half of the run. The period
    is at most half the window. The mirror image of the shape (a₀ → −a₀) marks half a period. NaN where the shape
    is steady, straight or does not recur. Raises ValueError where there are fewer than ``FEWEST`` frames.
    """
    window = _late(dataset, since)
    shapes = _shapes(window)
    found = _recurrence(shapes, window["time"].to_numpy())
    found[_steady(shapes) | _straight(shapes)] = np.nan
    return described(dataset, ["rod"], found, "time", "period of the shape", "recurrence of a_k, (4.49), (4.50)")


def shape_class(dataset: xr.Dataset, since: float | None = None) -> xr.DataArray:
    """Class of the motion: U, waving, flapping, … (rod).

    straight, U, waving, flapping, twisted-U, S or irregular (§4.3, §4.4), from the twist-free bending after ``since``,
    by default in the later half of the run; ``motion_class.CLASSES`` has the definitions. The bending is even where
    more than half of its square is in even beam modes. The motion reverses where a₀, and with it the swimming
    direction, changes sign. A failed rod is irregular. Raises ValueError as ``period`` does.
    """
    need(dataset, "status")
    window = _late(dataset, since)
    motion = _motion(window)
    names = np.select([holds(motion) for holds in CLASSES.values()], list(CLASSES), "irregular")
    names = np.where(window["status"].isel(frame=-1).to_numpy() == 0, names, "irregular")
    return described(dataset, ["rod"], names, "1", "class of the shape", "§4.3, §4.4")


def _motion(window: xr.Dataset) -> Motion:
    shapes = _shapes(window)
    size = np.sum(shapes**2, axis=(0, 2, 3))
    leading = shapes[:, :, 1, 0]
    low, high = leading.min(axis=0), leading.max(axis=0)
    k = bending(window, twist_free=True)
    # In a plane the phase of k is constant up to its sign, hence |Σ k²| = Σ |k|².
    flatness = abs(np.sum(k**2, axis=(0, 2))) / np.maximum(np.sum(abs(k) ** 2, axis=(0, 2)), np.finfo(float).tiny)
    return Motion(
        straight=_straight(shapes),
        steady=_steady(shapes),
        planar=1 - flatness < FLAT,
        even=np.sum(shapes[..., ::2] ** 2, axis=(0, 2, 3)) > 0.5 * size,
        periodic=np.isfinite(_recurrence(shapes, window["time"].to_numpy())),
        reverses=np.minimum(high, -low) > SIGN_CHANGE * np.maximum(high, -low),
    )


def _late(dataset: xr.Dataset, since: float | None) -> xr.Dataset:
    """The frames after ``since``, without a last one at a shorter interval; ValueError for filaments or few frames."""
    need(dataset, "activity")
    return dataset.isel(frame=late_frames(dataset, since))


def late_frames(dataset: xr.Dataset, since: float | None) -> np.ndarray:
    """The numbers of the frames after ``since``, by default in the later half; ValueError where there are too few."""
    time = dataset["time"].to_numpy()
    start = (time[0] + time[-1]) / 2 if since is None else since
    frames = np.flatnonzero(time >= start)
    if len(frames) > 2 and time[-1] - time[-2] < (1 - 1e-6) * (time[-2] - time[-3]):
        frames = frames[:-1]
    spacing = np.diff(time[frames])
    if len(frames) < FEWEST or np.ptp(spacing) > 1e-6 * spacing[0]:
        raise ValueError(
            f"needs {FEWEST} frames or more, equally spaced in time, after {start:g}; there are {len(frames)}"
        )
    return frames


def _shapes(window: xr.Dataset) -> np.ndarray:
    """Twist-free beam-mode coefficients [frame, rod, component, mode]."""
    return mode_coefficients(window, MODES, twist_free=True).to_numpy()


def _straight(shapes: np.ndarray) -> np.ndarray:
    return np.sqrt(np.sum(shapes**2, axis=(2, 3)).mean(axis=0)) < STRAIGHT


def _steady(shapes: np.ndarray) -> np.ndarray:
    variance, size = shapes.var(axis=0).sum(axis=(1, 2)), np.sum(shapes**2, axis=(2, 3)).mean(axis=0)
    return variance <= STEADY**2 * size


def _recurrence(shapes: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Shortest time [rod] after which shapes [frame, rod, ...] at equal intervals recur; NaN where they do not."""
    frames, rods = shapes.shape[:2]
    moving = (shapes - shapes.mean(axis=0)).reshape(frames, rods, -1)
    overlap = np.fft.irfft((abs(np.fft.rfft(moving, 2 * frames, axis=0)) ** 2).sum(axis=2), axis=0)[:frames]
    summed = np.cumsum(np.sum(moving**2, axis=2), axis=0)
    # Mean square of the two shapes of all pairs of frames one lag apart.
    lag = np.arange(1, frames // 2 + 1)
    early, late = summed[frames - 1 - lag], summed[-1] - summed[lag - 1]
    distance = 1 - 2 * overlap[lag] / np.maximum(early + late, np.finfo(float).tiny)
    left, here, right = distance[:-2], distance[1:-1], distance[2:]
    # The mean of the distance over a period is 1: a minimum before it has risen is a ripple, not a recurrence.
    risen = np.maximum.accumulate(here, axis=0) > 0.5
    minima = risen & (here < RECURRENCE) & (here <= left) & (here < right)
    first = minima.argmax(axis=0)[None]
    a, b, c = (np.take_along_axis(part, first, axis=0)[0] for part in (left, here, right))
    shift = 0.5 * (a - c) / np.where(minima.any(axis=0), a - 2 * b + c, 1.0)
    found = (lag[1:-1][first[0]] + shift) * (time[-1] - time[0]) / (frames - 1)
    return np.where(minima.any(axis=0), found, np.nan)
