"""What the reproductions of Fig 4.3 share: its parameters, the starts, and batches of swimmers that differ."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from warp_rods.reproductions.film import film
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.rods.modes import beam_mode

NODES = 65
"""Δs = 1/64 (§4.2)."""
SAVE_EVERY = 0.01
"""Between frames that periods are told from: a thirtieth of the shortest one met at ηr ≥ 1e-3."""
LATE = 8.0
"""How long before the end a motion is looked at."""


def pair(even: float, odd: float) -> np.ndarray:
    """Strains [node, 3] with Ω₂ = even φ₀ and Ω₁ = odd φ₁, which have the parities of (C.49)."""
    s = np.linspace(-0.5, 0.5, NODES)
    return np.stack([0 * s, odd * beam_mode(1, s), even * beam_mode(0, s)], axis=-1)


STARTS: dict[str, Any] = {
    "coil (C.63–65)": {"kind": "writhe", "amplitude": 6.0},
    "weak coil": {"kind": "writhe", "amplitude": 2.0},
    "bent, φ₀": {"kind": "mode", "amplitude": 3.0},
    "mostly φ₁": pair(1.0, 4.0),
    "φ₀ and φ₁": pair(4.0, 2.0),
    "bent, φ₂": {"kind": "mode", "mode": 2, "amplitude": 2.0},
}
"""By name, as ``FreeRods`` takes a shape: the coil of (C.63)–(C.65), its twist in balance, and others."""


class Swimmer(NamedTuple):
    """β⊥, β∥, M, ηr and a name of ``STARTS``."""

    bend: float
    twist: float
    moment: float
    rotational_drag: float
    start: str = "coil (C.63–65)"


def swim(swimmers: list[Swimmer], times: np.ndarray, dt: float) -> xr.Dataset:
    """Film [frame, rod] of a batch of different swimmers, with the symmetry of C.4 kept, as §4.4 has it."""
    columns: dict[str, Any] = {
        name: np.array([getattr(swimmer, name) for swimmer in swimmers])
        for name in ("bend", "twist", "moment", "rotational_drag")
    }
    one = [{name: values[[rod]] for name, values in columns.items()} for rod in range(len(swimmers))]
    starts = [STARTS[swimmer.start] for swimmer in swimmers]
    shapes = [initial_strain(start, NODES, each)[0] for start, each in zip(starts, one, strict=True)]
    rods = FreeRods(len(swimmers), NODES, **columns, shape=shapes, symmetric=True, device="cpu")
    return film(rods, times, dt)


def late_times(end: float) -> np.ndarray:
    """Times of frames ``SAVE_EVERY`` apart over the last ``LATE``."""
    return np.linspace(end - LATE, end, round(LATE / SAVE_EVERY) + 1)


def late(motion: xr.Dataset) -> xr.Dataset:
    """The frames of the last ``LATE`` of a film."""
    return motion.isel(frame=motion["time"].to_numpy() > float(motion["time"][-1]) - LATE - SAVE_EVERY / 2)
