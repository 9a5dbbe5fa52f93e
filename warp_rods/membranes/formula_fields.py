"""Functions of formulas: of φ on the device φ, ∇φ, ∇∇φ and ∂tφ, ∇∂tφ, in NumPy where it is singular; flows, forces.

Their sources are kept on disk, so that SymPy is needed for a new formula only.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from warp_rods.kernels.outside import written_flow, written_force
from warp_rods.kernels.surface.geometry import written_field, written_rate
from warp_rods.membranes.source_cache import kept_source

__all__ = ["Singular", "field", "flow", "force", "rate", "singular"]

Singular = Callable[[np.ndarray, np.ndarray], list[tuple[np.ndarray, ...]]]
"""A function of points [n, 3] and parameters [8]: for each argument its value [n] and its derivatives along x, y, z."""

IN_NUMPY = SimpleNamespace(
    float64=np.float64, vec3d=None, pow=np.power, atan=np.arctan, atan2=np.arctan2,
    **{name: getattr(np, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")},
)  # fmt: skip
"""What the functions of Warp are called in NumPy."""


@functools.cache
def field(phi: str, names: tuple[str, ...]) -> Any:
    """The Warp function x, p -> φ, ∇φ, ∇∇φ of a formula; p are its parameters in the order of ``names``.

    Raises FormulaError for a formula that is not allowed or cannot be differentiated.
    """

    def made() -> str:
        from warp_rods.membranes.field_source import field_source
        from warp_rods.membranes.symbolic import expression

        return field_source(expression(phi, names))

    source = kept_source("field", phi, names, made)
    return written_field(f"field_{_digest(source)}", source)


@functools.cache
def rate(phi: str, names: tuple[str, ...]) -> Any:
    """The Warp function x, p, dp/dt -> ∂tφ, ∇∂tφ of a formula whose parameters p depend on time: exact derivatives."""

    def made() -> str:
        from warp_rods.membranes.field_source import rate_source
        from warp_rods.membranes.symbolic import unchecked

        return rate_source(unchecked(phi, names), len(names))

    source = kept_source("rate", phi, names, made)
    return written_rate(f"rate_{_digest(source)}", source)


@functools.cache
def singular(phi: str, names: tuple[str, ...]) -> Singular:
    """The arguments in a formula whose zeros are where φ is not smooth, and their gradients, as a function in NumPy."""

    def made() -> str:
        from warp_rods.membranes.field_source import singular_source
        from warp_rods.membranes.symbolic import unchecked

        return singular_source(unchecked(phi, names))

    names_of_source = {"wp": IN_NUMPY, "Parameters": None}
    exec(kept_source("singular", phi, names, made), names_of_source)
    function: Any = names_of_source["singular"]

    def evaluated(x: np.ndarray, parameters: np.ndarray) -> list[tuple[np.ndarray, ...]]:
        with np.errstate(all="ignore"):
            rows = function(x.T, SimpleNamespace(v=parameters))
        return [tuple(np.broadcast_to(part, len(x)) for part in row) for row in rows]

    return evaluated


@functools.cache
def flow(velocity: tuple[str, ...]) -> Any:
    """The Warp function x, t, p -> u, ½∇×u of three formulas in x, y, z and t; p is not used.

    Raises FormulaError for formulas that are not allowed or cannot be differentiated.
    """

    def made() -> str:
        from warp_rods.membranes.field_source import flow_source
        from warp_rods.membranes.symbolic import unchecked

        return flow_source([unchecked(text, ("t",)) for text in velocity])

    source = kept_source("flow", json.dumps(velocity), (), made)
    return written_flow(f"flow_{_digest(source)}", source)


@functools.cache
def force(tables: tuple[tuple[str, ...], ...]) -> Any:
    """The Warp function x, s, t -> force, couple: sums of tables of six formulas in x, y, z, s and t.

    Raises FormulaError for a formula that is not allowed.
    """

    def made() -> str:
        from warp_rods.membranes.field_source import force_source
        from warp_rods.membranes.symbolic import unchecked

        read = [[unchecked(text, ("s", "t")) for text in table] for table in tables]
        return force_source([sum(column[1:], column[0]) for column in zip(*read, strict=True)])

    source = kept_source("force", json.dumps(tables), (), made)
    return written_force(f"force_{_digest(source)}", source)


def _digest(source: str) -> str:
    return hashlib.sha256(source.encode()).hexdigest()[:16]
