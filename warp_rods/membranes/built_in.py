"""The built-in surfaces: their parameters, their boxes, and checks of their values.

To add one: a Warp function ``field(x, p) -> (φ, ∇φ, ∇∇φ)`` in ``kernels/surface/fields.py``, and a row of ``SURFACES``
with its name, its parameters and its box. Lengths are in the unit of the scene. This module imports no kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods import formula
from warp_rods.membranes import motion
from warp_rods.membranes.level_set import Described, Fault, LevelSet, Values
from warp_rods.values import Number, Positive, must_be, number, shown

__all__ = ["SPARE", "SURFACES", "Parameter", "SurfaceKind"]

SPARE = 1.02
"""Boxes are larger than their surfaces by this factor."""
ALLOWED = {"positive": Positive, "any number": Number}
"""Kinds of allowed values of a parameter."""


@dataclass(frozen=True)
class Parameter:
    """What it means; one number (size 1) or three (size 3), all positive unless ``allowed`` is "any number"."""

    meaning: str
    size: int = 1
    default: float | None = None
    allowed: str = "positive"

    def read(self, name: str, value: Any, faults: list[Fault]) -> Any:
        """The value as numbers and formulas in t; appends its faults to ``faults``."""
        if self.size == 1 and value is not None:
            return self._read_one((name,), value, faults)
        if not isinstance(value, tuple) or len(value) != self.size:
            faults.append(((name,), must_be(self.words, value)))
            return None
        return tuple(self._read_one((name, i), part, faults) for i, part in enumerate(value))

    @property
    def words(self) -> str:
        """What is allowed at rest."""
        noun = "number" if self.allowed == "any number" else f"{self.allowed} number"
        return f"a {noun}" if self.size == 1 else f"{self.size} {noun}s"

    @property
    def or_formula(self) -> str:
        """What is allowed besides of a surface that may move."""
        return ", or a formula in t" if self.size == 1 else ", or formulas in t"

    def _read_one(self, loc: tuple[str | int, ...], value: Any, faults: list[Fault]) -> Any:
        try:
            if not isinstance(value, str):
                return number(value, ALLOWED[self.allowed])
            at_start = formula.function_of_time(value)(0.0)
        except formula.FormulaError as error:
            faults.append((loc, f" = {shown(value)}: must be {self.words}, or a formula in t: {error}"))
        except ValueError as error:
            faults.append((loc, must_be(self.words, value, str(error))))
        else:
            if self.allowed == "positive" and at_start <= 0:
                faults.append((loc, f" = {shown(value)}: must be {self.words}, but is {at_start:g} at t = 0"))
            return value.strip()
        return None


@dataclass(frozen=True)
class SurfaceKind:
    """A row of the table: a field, its parameters in the order of its vector p, its box, and a check of values."""

    function: Any
    """The Warp function x, p -> φ, ∇φ, ∇∇φ, or the name of one in ``kernels/surface/fields.py``."""
    parameters: dict[str, Parameter]
    box: Callable[[Values], tuple[float, float, float]]
    """Half the edges of a box around the origin that contains the surface (for an open one: the part that is used)."""
    closed: bool = True
    check: Callable[[Values], str | None] = lambda values: None
    """Why these values are impossible, or None. Each value already has the right type and sign."""
    phi: str | None = None
    """φ as a formula in x, y, z and the parameters, for the time derivatives of a surface that moves.

    A parameter of three numbers is written ``radii_x``, ``radii_y``, ``radii_z``. Without a formula it cannot move.
    """

    @property
    def field(self) -> Any:
        """The Warp function."""
        if not isinstance(self.function, str):
            return self.function
        from warp_rods.kernels.surface import fields

        return getattr(fields, self.function)

    @property
    def keys(self) -> tuple[str, ...]:
        """The names of the parameters."""
        return tuple(self.parameters)

    @property
    def described(self) -> dict[str, Described]:
        """What each of them means, and what is allowed."""
        return {
            name: Described(row.meaning, row.words + (row.or_formula if self.phi else ""), row.default)
            for name, row in self.parameters.items()
        }

    def read(self, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
        """The values with defaults filled in, and their faults."""
        faults: list[Fault] = []
        values = {
            name: parameter.read(name, raw.get(name, parameter.default), faults)
            for name, parameter in self.parameters.items()
        }
        if not faults and (impossible := self.check(motion.values_at(values, 0.0))):
            faults.append(((), f": {impossible}"))
        if self.phi is None and motion.is_moving(values):
            faults.append(((), ": cannot move, because this kind has no formula phi: give numbers, not formulas in t"))
        return values, faults

    def level_set(self, values: Values) -> LevelSet:
        """The surface with these values."""
        half = (SPARE if self.closed else 1.0) * np.array(self.box(values))
        return LevelSet(self.field, self.numbers(values), (-half, half), self.closed)

    def numbers(self, values: Values) -> np.ndarray:
        """The parameters of the field, in the order of the table."""
        return np.concatenate([np.atleast_1d(values[name]) for name in self.parameters])

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parameters in ``phi``, one for each number."""
        parts = [[name] if p.size == 1 else [f"{name}_{axis}" for axis in "xyz"] for name, p in self.parameters.items()]
        return tuple(name for part in parts for name in part)

    def rate(self, values: Values) -> Any:
        """The Warp function x, p, dp/dt -> ∂tφ, ∇∂tφ."""
        from warp_rods.membranes.formula_fields import rate

        assert self.phi is not None  # refused by ``read``
        return rate(self.phi, self.names)


def _torus_fault(v: Values) -> str | None:
    if v["minor"] < v["major"]:
        return None
    return f"minor = {v['minor']} must be smaller than major = {v['major']}"


def _cassini_fault(v: Values) -> str | None:
    if v["b"] > v["a"]:
        return None
    fault = f"b = {v['b']} must be larger than a = {v['a']}"
    return f"{fault}: at b = a the neck closes, and for b < a the surface has two parts"


def _undulated_fault(v: Values) -> str | None:
    R, bumps, k = v["radius"], v["amplitude"], v["wavenumber"]
    lowest = np.sqrt(max(R * R - 3 * bumps, 0.0))  # x·∇φ ≥ r (2r − √3 ε k) is positive from this radius on
    if 2 * lowest > np.sqrt(3) * bumps * k:
        return None
    return f"amplitude = {bumps} and wavenumber = {k}: the bumps may overhang or separate; reduce either"


def _revolved(radius: float, half_length: float) -> tuple[float, float, float]:
    return radius, radius, half_length


def _tube(radius: float, length: float) -> tuple[float, float, float]:
    """Half the box of an open tube along z of this length; slightly larger than the tube across."""
    return SPARE * radius, SPARE * radius, length / 2


def _cassini_radius(a: float, b: float) -> float:
    """Widest ρ: at z² = a² − b⁴/4a² while that is positive, else at z = 0."""
    return b * b / (2 * a) if b * b < 2 * a * a else float(np.sqrt(b * b - a * a))


def _undulated_radius(v: Values) -> float:
    return float(np.sqrt(v["radius"] * v["radius"] + 3 * v["amplitude"]))


SURFACES: dict[str, SurfaceKind] = {
    "plane": SurfaceKind(
        "plane",
        {"size": Parameter("side of the square (length)", default=10.0)},
        lambda v: (v["size"] / 2, v["size"] / 2, 0.1 * v["size"]),
        closed=False,
        phi="z",
    ),
    "sphere": SurfaceKind(
        "sphere",
        {"radius": Parameter("radius of the sphere (length)")},
        lambda v: (v["radius"],) * 3,
        phi="(x**2 + y**2 + z**2 - radius**2)/(2*radius)",
    ),
    "ellipsoid": SurfaceKind(
        "ellipsoid",
        {"radii": Parameter("half axes along x, y, z (length)", size=3)},
        lambda v: tuple(v["radii"]),
        phi="(x**2/radii_x**2 + y**2/radii_y**2 + z**2/radii_z**2 - 1)/2",
    ),
    "cylinder": SurfaceKind(
        "cylinder",
        {
            "radius": Parameter("distance from the axis z (length)"),
            "length": Parameter("length along z", default=10.0),
        },
        lambda v: _tube(v["radius"], v["length"]),
        closed=False,
        phi="(x**2 + y**2 - radius**2)/(2*radius)",
    ),
    "torus": SurfaceKind(
        "torus",
        {
            "major": Parameter("radius R of the circle along which the tube runs (length)"),
            "minor": Parameter("radius r of the tube (length)"),
        },
        lambda v: _revolved(v["major"] + v["minor"], v["minor"]),
        check=_torus_fault,
        phi="((sqrt(x**2 + y**2) - major)**2 + z**2 - minor**2)/(2*minor)",
    ),
    "cassini": SurfaceKind(
        "cassini",
        {
            "a": Parameter("distance of the foci on the axis z from the middle (length)"),
            "b": Parameter("b² is the product of the distances from both foci, b > a (length)"),
        },
        lambda v: _revolved(_cassini_radius(v["a"], v["b"]), float(np.hypot(v["a"], v["b"]))),
        check=_cassini_fault,
        phi="(x**2 + y**2 + z**2 + a**2)**2 - 4*a**2*z**2 - b**4",
    ),
    "bridge": SurfaceKind(
        "bridge",
        {
            "neck": Parameter("radius of the neck (length)"),
            "body": Parameter("radius far from the neck (length)"),
            "width": Parameter("width of the neck along z (length)"),
            "length": Parameter("length along z", default=6.0),
        },
        lambda v: _tube(max(v["neck"], v["body"]), v["length"]),
        closed=False,
        phi="(x**2 + y**2 - (body - (body - neck)*exp(-z**2/width**2))**2)/2",
    ),
    "undulated": SurfaceKind(
        "undulated",
        {
            "radius": Parameter("radius R of the sphere without bumps (length)", default=1.0),
            "amplitude": Parameter("size ε of the bumps, in φ beside ∣x∣² (length²)", default=0.16),
            "wavenumber": Parameter("wavenumber k of the bumps (1/length)", default=5.0),
        },
        lambda v: (_undulated_radius(v),) * 3,
        check=_undulated_fault,
        phi="x**2 + y**2 + z**2 - radius**2 + amplitude*(cos(wavenumber*x) + cos(wavenumber*y) + cos(wavenumber*z))",
    ),
}
"""Built-in kinds of surface by their names in a scene."""
