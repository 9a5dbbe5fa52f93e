"""Strains of free rods at the start, in the material frame, twist first."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError, named, refuse_unknown
from warp_rods.rods.modes import beam_mode
from warp_rods.rods.per_rod import parameter


def mode(s, amplitude, parameters, *, mode: int = 0):
    """A beam mode in a plane: κ = amplitude φ_mode."""
    mode, highest = arguments.whole("shape.mode", mode, 0), len(s) - 3
    if mode > highest:  # with fewer than two nodes in a wave it would look like a lower mode
        raise SceneError(f"shape.mode = {mode}: must be {highest} or less for {len(s)} nodes; use more nodes")
    return _strain(0.0, 0.0, amplitude * beam_mode(mode, s))


def writhe(s, amplitude, parameters, *, balanced: bool = True):
    """A coiled rod (C.63) to (C.65); its twist balances the active moment, or is ten times that, as printed."""
    balanced = arguments.truth("shape.balanced", balanced)
    ratio = parameters["moment"] / parameters["twist"]
    # log cosh without overflow
    twist = np.logaddexp(10 * s, -10 * s) - np.logaddexp(5.0, -5.0)
    bending = amplitude * beam_mode(0, s)
    turn = 2 * np.pi * s
    return _strain(ratio * twist / (10 if balanced else 1), -bending * np.sin(turn), bending * np.cos(turn))


def straight(s, amplitude, parameters):
    """No strain."""
    return _strain(0.0, 0.0, 0.0 * amplitude * s)


SHAPES: dict[str, Callable[..., np.ndarray]] = {"mode": mode, "writhe": writhe, "straight": straight}
"""Functions of s [node], amplitude [rod, 1], parameters {name: [rod, 1]} and the keywords of the kind, by ``kind``."""


def initial_strain(shape: Any, nodes: int, parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """Strain [rod, node, 3] from a table as in a scene, or from values that broadcast to that shape.

    parameters: {name: [rod]}. None is beam mode 0 of amplitude 1. Raises SceneError for an unknown kind or key, for
    values whose shape does not fit, and for values that are not finite.
    """
    rods = len(parameters["bend"])
    if shape is None:
        shape = {}
    values = _from_table(shape, nodes, parameters) if isinstance(shape, Mapping) else shape
    expected = f"a table such as {{'kind': 'mode'}}, or strains {(rods, nodes, 3)} [rod, node, 3]"
    if np.ndim(values) == 0:
        raise arguments.wrong("shape", shape, expected)
    strain = arguments.fitted("shape", values, (rods, nodes, 3), expected)
    strain[:, [0, -1]] = 0.0
    return strain


def _from_table(table: Mapping[str, Any], nodes: int, parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """Strains of a table {kind, amplitude, …}."""
    rest = dict(table)
    kind = rest.pop("kind", "mode")
    make = named(SHAPES, "shape.kind", kind)
    own = [name for name, p in inspect.signature(make).parameters.items() if p.kind is p.KEYWORD_ONLY]
    amplitude = parameter("shape.amplitude", rest.pop("amplitude", 1.0), len(parameters["bend"]), "any finite number")
    refuse_unknown(rest, [*own, "kind", "amplitude"], f"shape of kind {kind}")
    columns = {name: value[:, None] for name, value in parameters.items()}
    return make(np.linspace(-0.5, 0.5, nodes), amplitude[:, None], columns, **rest)


def from_midpoint(density: np.ndarray) -> np.ndarray:
    """Integral over s from the middle node of node values [rod, node], by the trapezoid rule; s from −1/2 to 1/2."""
    nodes = density.shape[1]
    cells = (density[:, 1:] + density[:, :-1]) / (2 * (nodes - 1))
    total = np.pad(np.cumsum(cells, axis=1), ((0, 0), (1, 0)))
    return total - total[:, [nodes // 2]]


def _strain(twist, first, second) -> np.ndarray:
    return np.stack(np.broadcast_arrays(twist, first, second), axis=-1)
