"""Strains that a free rod may start from, material frame, index 0 twist."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods.rods.free.flagella import named
from warp_rods.rods.modes import beam_mode


def mode(s, amplitude, parameters, *, mode: int = 0):
    """Planar: κ = amplitude φ_mode."""
    return _strain(0.0, 0.0, amplitude * beam_mode(mode, s))


def writhe(s, amplitude, parameters, *, balanced: bool = True):
    """C.63–C.65, a coiled rod; its twist is the one that balances the active torque, or ten times it as printed."""
    ratio = parameters["moment"] / parameters["twist"]
    # log cosh without overflow
    twist = np.logaddexp(10 * s, -10 * s) - np.logaddexp(5.0, -5.0)
    bending = amplitude * beam_mode(0, s)
    turn = 2 * np.pi * s
    return _strain(ratio * twist / (10 if balanced else 1), -bending * np.sin(turn), bending * np.cos(turn))


def straight(s, amplitude, parameters):
    """No strain at all."""
    return _strain(0.0, 0.0, 0.0 * amplitude * s)


SHAPES = {"mode": mode, "writhe": writhe, "straight": straight}
"""By ``kind``: functions of s [node], amplitude [rod, 1], parameters {name: [rod, 1]} and what the kind needs."""


def initial_strain(shape: Any, nodes: int, parameters: dict[str, np.ndarray]) -> np.ndarray:
    """Strain [rod, node, 3] from a table as in a scene, or from values that broadcast to that shape.

    parameters: {name: [rod]}; None stands for beam mode 0 of amplitude 1. Raises ValueError for an unknown kind.
    """
    rods = len(parameters["bend"])
    if shape is None:
        shape = {"kind": "mode"}
    if isinstance(shape, Mapping):
        rest = dict(shape)
        make = named(SHAPES, "shape", rest.pop("kind"))
        columns = {name: value[:, None] for name, value in parameters.items()}
        amplitude = np.broadcast_to(np.asarray(rest.pop("amplitude", 1.0), dtype=float), (rods,))[:, None]
        shape = make(np.linspace(-0.5, 0.5, nodes), amplitude, columns, **rest)
    strain = np.array(np.broadcast_to(np.asarray(shape, dtype=float), (rods, nodes, 3)))
    strain[:, [0, -1]] = 0.0
    return strain


def from_midpoint(density: np.ndarray) -> np.ndarray:
    """Integral of node values [rod, node] over s in [−1/2, 1/2] from the middle node, trapezoid rule."""
    nodes = density.shape[1]
    cells = (density[:, 1:] + density[:, :-1]) / (2 * (nodes - 1))
    total = np.pad(np.cumsum(cells, axis=1), ((0, 0), (1, 0)))
    return total - total[:, [nodes // 2]]


def _strain(twist, first, second) -> np.ndarray:
    return np.stack(np.broadcast_arrays(twist, first, second), axis=-1)
