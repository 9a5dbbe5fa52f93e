"""Simulations of the swimmers of Fig 4.3: batches that differ in parameters and initial shape."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from warp_rods.reproductions.integrate import integrate
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.rods.modes import beam_mode

NODES = 65
"""Δs = 1/64 (§4.2)."""
SAVE_EVERY = 0.01
"""Time between frames, a thirtieth of the shortest period found at ηr ≥ 1e-3."""
LATE = 8.0
"""Duration of the late part of a simulation in which the motion is analysed."""


def symmetric_bend(even: float, odd: float) -> np.ndarray:
    """Strains [node, 3] with Ω₂ = ``even`` φ₀ and Ω₁ = ``odd`` φ₁, which have the parities of (C.49)."""
    s = np.linspace(-0.5, 0.5, NODES)
    return np.stack([0 * s, odd * beam_mode(1, s), even * beam_mode(0, s)], axis=-1)


STARTS: dict[str, Any] = {
    "coil (C.63–65)": {"kind": "writhe", "amplitude": 6.0},
    "weak coil": {"kind": "writhe", "amplitude": 2.0},
    "bent, φ₀": {"kind": "mode", "amplitude": 3.0},
    "mostly φ₁": symmetric_bend(1.0, 4.0),
    "φ₀ and φ₁": symmetric_bend(4.0, 2.0),
    "bent, φ₂": {"kind": "mode", "mode": 2, "amplitude": 2.0},
}
"""Initial shapes by name, as ``FreeRods`` takes them: the coil (C.63)–(C.65) with balanced twist, and others."""


class Case(NamedTuple):
    """One swimmer: β⊥, β∥, M, ηr and the name of its initial shape in ``STARTS``."""

    bend: float
    twist: float
    moment: float
    rotational_drag: float
    start: str = "coil (C.63–65)"


def simulate(cases: list[Case], times: np.ndarray) -> xr.Dataset:
    """Trajectory [frame, rod] of a batch of swimmers, with the symmetry of C.4 imposed as in §4.4."""
    columns: dict[str, Any] = {
        name: np.array([getattr(case, name) for case in cases])
        for name in ("bend", "twist", "moment", "rotational_drag")
    }
    one = [{name: values[[rod]] for name, values in columns.items()} for rod in range(len(cases))]
    starts = [STARTS[case.start] for case in cases]
    shapes = [initial_strain(start, NODES, each)[0] for start, each in zip(starts, one, strict=True)]
    rods = FreeRods(len(cases), NODES, **columns, shape=shapes, symmetric=True, device="cpu")
    return integrate(rods, times)


def late_times(end: float) -> np.ndarray:
    """Times of frames ``SAVE_EVERY`` apart over the last ``LATE`` time units."""
    return np.linspace(end - LATE, end, round(LATE / SAVE_EVERY) + 1)


def late_frames(motion: xr.Dataset) -> xr.Dataset:
    """The frames of the last ``LATE`` time units."""
    return motion.isel(frame=motion["time"].to_numpy() > float(motion["time"][-1]) - LATE - SAVE_EVERY / 2)
