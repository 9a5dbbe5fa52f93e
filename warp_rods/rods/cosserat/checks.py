"""Checks of the parameters of Cosserat rods, and their strains at the start."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError, named, refuse_unknown
from warp_rods.rods.modes import beam_mode
from warp_rods.rods.per_rod import parameter

FEWEST_NODES = 5
ENDS = {"free": (0,) * 6, "hinged": (0, 0, 0, 1, 1, 1), "clamped": (1,) * 6}
"""Kind of end → 1 for each of (ω, u) that is held at zero."""
STRAIGHT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
SYMMETRIC = 1e-12
"""Larger relative differences of a matrix and its transpose are not regarded as round-off."""
MOST_BENT = 3.0
"""The largest angle between adjacent nodes at the start."""


def stiffness_matrices(given: Any, count: int) -> np.ndarray:
    """K [rod, 6, 6] from its diagonal [6] or [rod, 6], or from matrices [1, 6, 6], [rod, 6, 6]; raises SceneError."""
    read = arguments.reals("stiffness", given)
    if read.ndim < 3:
        return np.einsum("ri,ij->rij", parameter("stiffness", read, count, ("positive",) * 6), np.eye(6))
    allowed = f"[6], {(count, 6)} [rod, 6], [1, 6, 6] or {(count, 6, 6)} [rod, 6, 6]"
    K = arguments.fitted("stiffness", read, (count, 6, 6), allowed)
    for rod, matrix in enumerate(K):
        if abs(matrix - matrix.T).max() > SYMMETRIC * abs(matrix).max():
            raise SceneError(f"stiffness[{rod}]: must be symmetric")
        if (least := np.linalg.eigvalsh(matrix)[0]) <= 0:
            raise SceneError(f"stiffness[{rod}]: must be positive definite; its smallest eigenvalue is {least:.3g}")
    return K


def natural_strains(given: Any, count: int, nodes: int) -> np.ndarray:
    """(Ω0, U0) [rod, node, 6] from [6], [node, 6] or [rod, node, 6]; raises SceneError."""
    return strains("natural", given, count, nodes)


def strains(name: str, given: Any, count: int, nodes: int) -> np.ndarray:
    """Strains (Ω, U) [rod, node, 6] from values that broadcast to it; raises SceneError."""
    allowed = f"strains (Ω, U): 6 numbers, or numbers that broadcast to {(count, nodes, 6)} [rod, node, 6]"
    return arguments.fitted(name, given, (count, nodes, 6), allowed)


def held(ends: Any) -> np.ndarray:
    """1 for what the first and the last node may not do [end, 6]; raises SceneError."""
    pair = tuple(ends) if isinstance(ends, (tuple, list, np.ndarray)) else ()
    if len(pair) != 2:
        raise arguments.wrong("ends", ends, 'a pair such as ("free", "clamped")')
    return np.array([named(ENDS, "ends", end) for end in pair], dtype=float)


def between_nodes(values: np.ndarray) -> np.ndarray:
    """Values of segments [rod, node − 1, …], the means of those at nodes [rod, node, …]."""
    return values[:, :-1] + 0.5 * (values[:, 1:] - values[:, :-1])


# --- the start --------------------------------------------------------------------------------------------------------


def natural(s, natural, amplitude):
    """At rest."""
    return natural


def straight(s, natural, amplitude):
    """Straight, of the natural length."""
    return np.zeros_like(natural) + STRAIGHT


def mode(s, natural, amplitude, *, mode: int = 0):
    """A beam mode in a plane: Ω₂ = Ω0₂ + amplitude φ_mode."""
    bent = natural.copy()
    bent[..., 2] += amplitude * beam_mode(arguments.whole("shape.mode", mode, 0), s)
    return bent


SHAPES = {"natural": natural, "straight": straight, "mode": mode}
"""Functions of s [node], the natural strain [rod, node, 6] and amplitude [rod, 1], by ``kind``."""


def initial_strain(shape: Any, natural: np.ndarray) -> np.ndarray:
    """Strain [rod, node, 6] from a table {kind, amplitude, stretch, …}, or from values that broadcast to that shape.

    stretch: all of U times this number. Raises SceneError for an unknown kind or key, and for impossible values.
    """
    count, nodes = natural.shape[:2]
    if shape is not None and not isinstance(shape, Mapping):
        return strains("shape", shape, count, nodes)
    rest = dict(shape or {})
    kind = rest.pop("kind", "natural")
    make: Any = named(SHAPES, "shape.kind", kind)
    own = [name for name, p in inspect.signature(make).parameters.items() if p.kind is p.KEYWORD_ONLY]
    amplitude = parameter("shape.amplitude", rest.pop("amplitude", 1.0), count, arguments.ANY)
    stretch = parameter("shape.stretch", rest.pop("stretch", 1.0), count)
    refuse_unknown(rest, [*own, "kind", "amplitude", "stretch"], f"shape of kind {kind}")
    strain = np.array(make(np.linspace(-0.5, 0.5, nodes), natural, amplitude[:, None], **rest))
    strain[..., 3:] *= stretch[:, None, None]
    return strain


def check_strain(strain: np.ndarray) -> None:
    """Raises SceneError where a strain of segments [rod, node − 1, 6] bends by about half a turn in one of them."""
    angles = np.linalg.norm(strain[..., :3], axis=-1) / strain.shape[1]
    if (largest := angles.max()) > MOST_BENT:
        rod = int(angles.max(axis=1).argmax())
        raise SceneError(f"shape: rod {rod} turns by {largest:.3g} between two nodes; must be below {MOST_BENT:g}")
