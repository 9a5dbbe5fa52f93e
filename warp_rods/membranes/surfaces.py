"""The membranes: surfaces φ(x) = 0 with outward where φ > 0, of a kind with numbers, of a text or of a file."""

from __future__ import annotations

import copy
from collections import ChainMap
from collections.abc import MutableMapping
from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_rods.errors import SceneError
from warp_rods.kernels.surface.geometry import Numbers, Parameters, sampler
from warp_rods.membranes import in_time
from warp_rods.membranes import inspection as enclosure
from warp_rods.membranes.expression import Expression
from warp_rods.membranes.grid import LevelSet
from warp_rods.membranes.kinds import SURFACES, Parameter, Shape, SurfaceKind, Values

__all__ = ["GIVEN", "KINDS", "SURFACES", "Fault", "Parameter", "Surface", "SurfaceKind", "make", "read"]

INSTANT = 1e-5
"""Half the span of time over which a moving surface's velocity is measured; its motion has no faster features."""
INSTANTS = 50
"""Times of a run at which a moving surface is looked at before it starts."""

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
    """A membrane: its field with numbers filled in. NumPy in, NumPy out; made by ``make``.

    One whose values hold texts in t moves; all that is asked of it is as at t = 0: see ``at`` for other times.
    """

    def __init__(self, kind: str, values: Values):
        self.kind, self.values = kind, dict(values)
        self.moving = in_time.moving(values)
        shape = KINDS[kind].shape(in_time.at(values, 0.0))
        self.field = shape.field
        """The Warp function x, p -> φ, ∇φ, ∇∇φ."""
        self.parameters = _numbers(shape)
        self._grid, self._grids = shape.grid, dict[str, wp.array]()
        self.box = shape.box
        """Lower and upper corner [3] of a box that holds the surface, a little to spare."""
        self.closed = enclosure.is_closed(self) if shape.closed is None else shape.closed
        """Whether the surface is bounded; of an open one the patch inside ``box`` is used."""

    def parameters_at(self, time: float) -> np.ndarray:
        """The field's numbers [8] at a time; raises SceneError where a text has no value then."""
        return _numbers(KINDS[self.kind].shape(in_time.at(self.values, time))) if self.moving else self.parameters

    def at(self, time: float) -> Surface:
        """The surface as it is at a time, at rest; raises SceneError where a text has no value then."""
        if not self.moving:
            return self
        frozen = copy.copy(self)
        frozen.values, frozen.moving = in_time.at(self.values, time), False
        shape = KINDS[self.kind].shape(frozen.values)
        frozen.parameters, frozen.box = _numbers(shape), shape.box
        return frozen

    def _evaluate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x = np.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        arrays = [wp.zeros(len(x), dtype=t, device="cpu") for t in (wp.float64, wp.vec3d, wp.mat33d)]
        inputs = [wp.array(x, dtype=wp.vec3d, device="cpu"), self.device_parameters("cpu"), *arrays]
        wp.launch(sampler(self.field).evaluate, dim=len(x), inputs=inputs, device="cpu")
        shape = np.shape(points)[:-1]
        phi, gradient, hessian = (a.numpy() for a in arrays)
        return phi.reshape(shape), gradient.reshape(*shape, 3), hessian.reshape(*shape, 3, 3)

    def device_parameters(self, device, time: float = 0.0) -> wp.array:
        """The parameters as a one-element array, so that a recorded step can see them change.

        Of a moving surface three elements: at a time, and ``INSTANT`` before and after it.
        """
        times = (time, time - INSTANT, time + INSTANT) if self.moving else (time,)
        return wp.array([self._on(device, self.parameters_at(t)) for t in times], dtype=Parameters, device=device)

    def _on(self, device, numbers: np.ndarray) -> Any:
        p = Parameters()
        p.v = Numbers(*numbers)
        if self._grid is not None:
            name = str(wp.get_device(device))
            if name not in self._grids:
                self._grids[name] = wp.array(self._grid, dtype=wp.float64, device=device)
            p.grid = self._grids[name]
        return p

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


def _numbers(shape: Shape) -> np.ndarray:
    return np.concatenate([shape.numbers, np.zeros(8 - shape.numbers.size)])


def faults_in_time(kind: str, values: Values, end: float) -> list[str]:
    """What first becomes impossible of a moving surface until ``end``, each a line that follows "surface".

    Numbers are looked at ``INSTANTS`` times; a surface that a user gives, half way and at the end.
    """
    if not in_time.moving(values):
        return []
    if kind in GIVEN:
        values = GIVEN[kind].read(values)[0]
    else:
        values = {name: values.get(name, parameter.default) for name, parameter in SURFACES[kind].parameters.items()}
    for time in np.linspace(0.0, end, INSTANTS):
        try:
            now = in_time.at(values, time)
        except SceneError as error:
            return [str(error).removeprefix("surface")]
        if found := [] if kind in GIVEN else _value_faults(kind, now):
            return [f" at t = {time:.4g}: {fault.removeprefix('surface').removeprefix('.')}" for fault in found]
    for time in (end / 2, end) if kind in GIVEN else ():
        then = Surface(kind, in_time.at(values, time))
        if found := enclosure.faults(then):
            return [f" at t = {time:.4g}: {fault.removeprefix(': ')}" for fault in found]
        if Surface(kind, values).closed and not then.closed:
            return [f" at t = {time:.4g}: has come out of its box, so that it is closed no more: widen the box"]
    return []


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
        texts = [part for part in np.ravel(np.array(value, dtype=object)) if isinstance(part, str)]
        wrong = [f"surface.{name} = {text!r}: {said}" for text in texts if (said := in_time.fault(text))]
        faults += wrong or _misfit(name, in_time.at({name: value}, 0.0)[name], parameter)
    if not faults and (impossible := row.check(in_time.at(filled, 0.0))):
        faults.append(f"surface: {impossible}")
    if faults:
        raise SceneError("\n".join(faults))
    return Surface(kind, filled)


def _misfit(name: str, value: Any, parameter: Parameter) -> list[str]:
    if _fits(value, parameter):
        return []
    return [f"surface.{name} = {value!r}: must be {parameter.size} number(s), {parameter.allowed}"]


def _value_faults(kind: str, values: Values) -> list[str]:
    """What is impossible about these numbers, each a line."""
    row = SURFACES[kind]
    faults = [line for name, p in row.parameters.items() for line in _misfit(name, values[name], p)]
    if not faults and (impossible := row.check(values)):
        faults.append(f"surface: {impossible}")
    return faults
