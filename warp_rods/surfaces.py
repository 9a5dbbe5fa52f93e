"""The membranes: surfaces φ(x) = 0 with outward where φ > 0, and the table that names them.

To add one: a Warp function ``field(x, p) -> (φ, ∇φ, ∇∇φ)`` as in ``kernels/fields.py``, and a row of ``SURFACES``
with its parameters and its box. Lengths are in the scene's unit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.errors import SceneError
from warp_rods.kernels import fields
from warp_rods.kernels.surface import Parameters, sampler

Box = tuple[np.ndarray, np.ndarray]
Values = Mapping[str, Any]


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
    return 1.02 * radius, 1.02 * radius, length / 2


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
"""Every kind of membrane by its name in a scene."""


class Surface:
    """A membrane: its field with numbers filled in. NumPy in, NumPy out; made by ``make``."""

    def __init__(self, kind: str, values: Values):
        self.kind, self.values = kind, dict(values)
        self._row = SURFACES[kind]
        numbers = np.concatenate([np.atleast_1d(values[name]) for name in self._row.parameters])
        self.parameters = np.zeros(8)
        self.parameters[: numbers.size] = numbers

    @property
    def field(self) -> Callable[..., Any]:
        """The Warp function x, p -> φ, ∇φ, ∇∇φ."""
        return self._row.field

    @property
    def closed(self) -> bool:
        """Whether the surface is bounded; of an open one the patch inside ``box`` is used."""
        return self._row.closed

    @property
    def box(self) -> Box:
        """Lower and upper corner [3] of a box that holds the surface, a little to spare."""
        half = (1.02 if self.closed else 1.0) * np.array(self._row.box(self.values))
        return -half, half

    def _evaluate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x = np.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        arrays = [wp.zeros(len(x), dtype=t, device="cpu") for t in (wp.float64, wp.vec3d, wp.mat33d)]
        inputs = [wp.array(x, dtype=wp.vec3d, device="cpu"), self.device_parameters("cpu"), *arrays]
        wp.launch(sampler(self.field).evaluate, dim=len(x), inputs=inputs, device="cpu")
        shape = np.shape(points)[:-1]
        phi, gradient, hessian = (a.numpy() for a in arrays)
        return phi.reshape(shape), gradient.reshape(*shape, 3), hessian.reshape(*shape, 3, 3)

    def device_parameters(self, device) -> wp.array:
        """The parameters as a one-element array, so that a recorded step can see them change."""
        return wp.array(self.parameters.reshape(1, 8), dtype=Parameters, device=device)

    def phi(self, points: np.ndarray) -> np.ndarray:
        """φ at points [..., 3]."""
        x = np.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        phi = wp.zeros(len(x), dtype=wp.float64, device="cpu")
        inputs = [wp.array(x, dtype=wp.vec3d, device="cpu"), self.device_parameters("cpu"), phi]
        wp.launch(sampler(self.field).value, dim=len(x), inputs=inputs, device="cpu")
        return phi.numpy().reshape(np.shape(points)[:-1])

    def gradient(self, points: np.ndarray) -> np.ndarray:
        """∇φ [..., 3] at points [..., 3]."""
        return self._evaluate(points)[1]

    def hessian(self, points: np.ndarray) -> np.ndarray:
        """∇∇φ [..., 3, 3] at points [..., 3]."""
        return self._evaluate(points)[2]

    def normal(self, points: np.ndarray) -> np.ndarray:
        """Outward unit normal [..., 3] at points [..., 3]."""
        g = self.gradient(points)
        return g / np.linalg.norm(g, axis=-1, keepdims=True)

    def project(self, points: np.ndarray, iterations: int = 20) -> np.ndarray:
        """Points [..., 3] moved along ∇φ to φ = 0 by Newton steps."""
        x: wp.array = wp.array(np.ascontiguousarray(points, dtype=float).reshape(-1, 3), dtype=wp.vec3d, device="cpu")
        inputs = [x, self.device_parameters("cpu"), iterations]
        wp.launch(sampler(self.field).project, dim=len(x), inputs=inputs, device="cpu")
        return x.numpy().reshape(np.shape(points))

    def second_form(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Two unit tangents t1, t2 = n×t1 [..., 3] and II = −∇n in them [..., 2, 2] (5.16) at points on the surface."""
        _, g, H = self._evaluate(points)
        size = np.linalg.norm(g, axis=-1, keepdims=True)
        n = g / size
        helper = np.eye(3)[np.argmin(np.abs(n), axis=-1)]
        t1 = np.cross(n, helper)
        t1 /= np.linalg.norm(t1, axis=-1, keepdims=True)
        t = np.stack([t1, np.cross(n, t1)], axis=-2)
        return t[..., 0, :], t[..., 1, :], -np.einsum("...ia,...ab,...jb->...ij", t, H, t) / size[..., None]

    def gaussian_curvature(self, points: np.ndarray) -> np.ndarray:
        """𝒦 [...] at points [..., 3] on the surface; 1/length²."""
        return np.linalg.det(self.second_form(points)[2])


def _fits(value: Any, parameter: Parameter) -> bool:
    """Whether a value from Python is as many finite numbers as the parameter asks for, positive where it must be."""
    try:
        number = np.asarray(value)
    except ValueError:  # rows of several lengths
        return False
    if number.shape != (() if parameter.size == 1 else (parameter.size,)) or number.dtype.kind not in "iuf":
        return False
    return bool(np.isfinite(number).all() and (parameter.allowed == "any number" or (number > 0).all()))


def make(kind: str, values: Values) -> Surface:
    """The surface of this kind with these parameters (defaults filled in).

    Raises SceneError naming every fault: an unknown kind or parameter, a missing or impossible value.
    """
    if kind not in SURFACES:
        raise SceneError(f"surface.kind: {kind!r} is not known; known are {', '.join(SURFACES)}")
    row, faults, filled = SURFACES[kind], [], {}
    for name in values.keys() - row.parameters.keys():
        faults.append(f"surface.{name}: not a parameter of {kind}; it has {', '.join(row.parameters)}")
    for name, parameter in row.parameters.items():
        filled[name] = value = values.get(name, parameter.default)
        if not _fits(value, parameter):
            faults.append(f"surface.{name} = {value!r}: must be {parameter.size} number(s), {parameter.allowed}")
    if not faults and (impossible := row.check(filled)):
        faults.append(f"surface: {impossible}")
    if faults:
        raise SceneError("\n".join(faults))
    return Surface(kind, filled)
