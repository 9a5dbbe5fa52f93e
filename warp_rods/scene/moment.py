"""The active moment M of a swimmer from the shape of its flagella (dissertation, §4.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.errors import SceneError

__all__ = ["moment_from_flagella"]


def moment_from_flagella(
    pitch: ArrayLike, circumference: ArrayLike, length: ArrayLike, drag_ratio: ArrayLike = 2.0
) -> np.ndarray:
    """M = torque/(force · length) of helical flagella that turn without advancing, as ``moment`` of ``FreeRods``.

    pitch P and circumference C of the helix and length L of the cell, in one unit; drag_ratio: η > 1 of the flagellum,
    2 for a very thin one. Numbers or arrays that broadcast. By local drag on the helix

        M = (η P² + C²)/(2π (η − 1) P L),    P/πL for η = 2, C ≪ P

    Length, thickness, speed and number of the flagella cancel. Positive for left-handed flagella, whose thrust and
    torque on the cell have the same direction; take minus it for right-handed ones. The text's torque has π² for π:
    for P = 2 µm, C = 1.5 µm, L = 10 and 100 µm it gives P/π²L = 2.0e-2 and 2.0e-3 (and says 1e-2 to 1e-3), this
    function 8.2e-2 and 8.2e-3. Raises SceneError for values that are not positive, and η ≤ 1.
    """
    given = {"pitch": pitch, "circumference": circumference, "length": length, "drag_ratio": drag_ratio}
    read = {name: arguments.reals(name, value) for name, value in given.items()}
    for name, values in read.items():
        arguments.check(name, values, "positive")
    P, C, L, eta = read.values()
    if (eta <= 1).any():
        raise SceneError(f"drag_ratio = {eta[eta <= 1][0]:g}: must be greater than 1, where a flagellum has thrust")
    try:
        return (eta * P**2 + C**2) / (2 * np.pi * (eta - 1) * P * L)
    except ValueError:
        shapes = ", ".join(f"{name} {values.shape}" for name, values in read.items())
        raise SceneError(f"shapes must broadcast; given are {shapes}") from None
