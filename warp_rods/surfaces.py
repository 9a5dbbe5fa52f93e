"""The membranes: surfaces φ(x) = 0 with outward where φ > 0, of a kind with numbers, of a text or of a file."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import MutableMapping
from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_rods import enclosure
from warp_rods.errors import SceneError
from warp_rods.expression import Expression
from warp_rods.kernels.surface import Numbers, Parameters, sampler
from warp_rods.level_set import LevelSet
from warp_rods.surface_kinds import SURFACES, Parameter, Shape, SurfaceKind, Values

__all__ = ["GIVEN", "KINDS", "SURFACES", "Fault", "Parameter", "Surface", "SurfaceKind", "make", "read"]

Fault = tuple[tuple[str | int, ...], str]
"""Where a value of the table is, and what to say after its key path."""


class Given(Protocol):
    """A kind of surface that the user gives as a text or a file."""

    key: str
    """The key whose value the surface is made of."""

    def read(self, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
        """The values with defaults filled in, and what is wrong with them."""

    def shape(self, values: Values) -> Shape:
        """The surface with these values."""


GIVEN: dict[str, Given] = {"expression": Expression(), "grid": LevelSet()}
"""Kinds of membrane that a user gives."""

KINDS: MutableMapping[str, SurfaceKind | Given] = ChainMap(GIVEN, SURFACES)  # type: ignore[arg-type]
"""Every kind of membrane by its name in a scene."""


class Surface:
    """A membrane: its field with numbers filled in. NumPy in, NumPy out; made by ``make``."""

    def __init__(self, kind: str, values: Values):
        self.kind, self.values = kind, dict(values)
        shape = KINDS[kind].shape(values)
        self.field = shape.field
        """The Warp function x, p -> φ, ∇φ, ∇∇φ."""
        self.parameters = np.zeros(8)
        self.parameters[: shape.numbers.size] = shape.numbers
        self._grid, self._grids = shape.grid, dict[str, wp.array]()
        self.box = shape.box
        """Lower and upper corner [3] of a box that holds the surface, a little to spare."""
        self.closed = enclosure.is_closed(self) if shape.closed is None else shape.closed
        """Whether the surface is bounded; of an open one the patch inside ``box`` is used."""

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
        p = Parameters()
        p.v = Numbers(*self.parameters)
        if self._grid is not None:
            name = str(wp.get_device(device))
            if name not in self._grids:
                self._grids[name] = wp.array(self._grid, dtype=wp.float64, device=device)
            p.grid = self._grids[name]
        return wp.array([p], dtype=Parameters, device=device)

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


def read(kind: str, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
    """The values of a surface of a given kind with defaults filled in, and all that is wrong with them and with it."""
    values, faults = GIVEN[kind].read(raw)
    if not faults:
        faults = [((GIVEN[kind].key,), text) for text in enclosure.faults(Surface(kind, values))]
    return values, faults


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
    if kind not in KINDS:
        raise SceneError(f"surface.kind: {kind!r} is not known; known are {', '.join(KINDS)}")
    if kind in GIVEN:
        filled, found = read(kind, values)
        if found:
            raise SceneError("\n".join(f"surface.{'.'.join(map(str, where))}{text}" for where, text in found))
        return Surface(kind, filled)
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
