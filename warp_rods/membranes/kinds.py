"""The kinds of membrane that numbers describe: parameters, boxes, and what is impossible about them.

To add one: a Warp function ``field(x, p) -> (φ, ∇φ, ∇∇φ)`` as in ``kernels/surface/fields.py``, and a row of
``SURFACES`` with its parameters and its box. Lengths are in the scene's unit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods.kernels.surface import fields

Box = tuple[np.ndarray, np.ndarray]
Values = Mapping[str, Any]


SPARE = 1.02
"""Boxes are larger than the surfaces in them by this factor."""


@dataclass(frozen=True)
class Shape:
    """A surface with its numbers filled in: field, numbers in the order of its p, box [3], [3]."""

    field: Any
    numbers: np.ndarray
    box: Box
    closed: bool | None
    """Whether the surface is bounded; None where it takes a look at φ on the box to know."""
    grid: np.ndarray | None = None
    """Coefficients [x, y, z] of a surface given on a grid."""


@dataclass(frozen=True)
class Parameter:
    """One number (size 1) or three (size 3), all positive unless ``allowed`` is "any number"."""

    size: int = 1
    default: float | None = None
    allowed: str = "positive"


@dataclass(frozen=True)
class SurfaceKind:
    """A row of the table: parameters in the order of the field's vector p, bounding box, and impossible values."""

    field: Callable[..., Any]
    parameters: dict[str, Parameter]
    box: Callable[[Values], tuple[float, float, float]]
    """Half extents of a box round the origin that holds the surface (of an open one: the patch that is used)."""
    closed: bool = True
    check: Callable[[Values], str | None] = lambda values: None
    """What is impossible about these values, each already of the right type and sign."""

    def shape(self, values: Values) -> Shape:
        """The surface with these values."""
        numbers = np.concatenate([np.atleast_1d(values[name]) for name in self.parameters])
        half = (SPARE if self.closed else 1.0) * np.array(self.box(values))
        return Shape(self.field, numbers, (-half, half), self.closed)


def _torus_fault(v: Values) -> str | None:
    if v["minor"] < v["major"]:
        return None
    return f"minor = {v['minor']} must be smaller than major = {v['major']}"


def _cassini_fault(v: Values) -> str | None:
    if v["b"] > v["a"]:
        return None
    return f"b = {v['b']} must be larger than a = {v['a']}: at b = a the neck closes, below it falls into two"


def _undulated_fault(v: Values) -> str | None:
    R, bumps, k = v["radius"], v["amplitude"], v["wavenumber"]
    lowest = np.sqrt(max(R**2 - 3 * bumps, 0.0))  # x·∇φ ≥ r (2r − √3 ε k) is positive from this radius on
    if 2 * lowest > np.sqrt(3) * bumps * k:
        return None
    return f"amplitude = {bumps} and wavenumber = {k}: the bumps may overhang or break up; use less of either"


def _revolved(radius: float, half_length: float) -> tuple[float, float, float]:
    return radius, radius, half_length


def _tube(radius: float, length: float) -> tuple[float, float, float]:
    """An open tube along z: to spare across, cut where the scene says along z."""
    return SPARE * radius, SPARE * radius, length / 2


def _cassini_radius(a: float, b: float) -> float:
    """Widest ρ: at z² = a² − b⁴/4a² while that is positive, else at z = 0."""
    return b * b / (2 * a) if b * b < 2 * a * a else float(np.sqrt(b * b - a * a))


def _undulated_radius(v: Values) -> float:
    return float(np.sqrt(v["radius"] ** 2 + 3 * v["amplitude"]))


SURFACES: dict[str, SurfaceKind] = {
    "plane": SurfaceKind(
        fields.plane,
        {"size": Parameter(default=10.0)},
        lambda v: (v["size"] / 2, v["size"] / 2, 0.1 * v["size"]),
        closed=False,
    ),
    "sphere": SurfaceKind(fields.sphere, {"radius": Parameter()}, lambda v: (v["radius"],) * 3),
    "ellipsoid": SurfaceKind(fields.ellipsoid, {"radii": Parameter(size=3)}, lambda v: tuple(v["radii"])),
    "cylinder": SurfaceKind(
        fields.cylinder,
        {"radius": Parameter(), "length": Parameter(default=10.0)},
        lambda v: _tube(v["radius"], v["length"]),
        closed=False,
    ),
    "torus": SurfaceKind(
        fields.torus,
        {"major": Parameter(), "minor": Parameter()},
        lambda v: _revolved(v["major"] + v["minor"], v["minor"]),
        check=_torus_fault,
    ),
    "cassini": SurfaceKind(
        fields.cassini,
        {"a": Parameter(), "b": Parameter()},
        lambda v: _revolved(_cassini_radius(v["a"], v["b"]), float(np.hypot(v["a"], v["b"]))),
        check=_cassini_fault,
    ),
    "bridge": SurfaceKind(
        fields.bridge,
        {"neck": Parameter(), "body": Parameter(), "width": Parameter(), "length": Parameter(default=6.0)},
        lambda v: _tube(max(v["neck"], v["body"]), v["length"]),
        closed=False,
    ),
    "undulated": SurfaceKind(
        fields.undulated,
        {
            "radius": Parameter(default=1.0),
            "amplitude": Parameter(default=0.16),
            "wavenumber": Parameter(default=5.0),
        },
        lambda v: (_undulated_radius(v),) * 3,
        check=_undulated_fault,
    ),
}
"""Kinds of membrane by their names in a scene; ``surfaces.GIVEN`` has those of a text or a file."""
