"""A surface φ(x) = 0, outward where φ > 0, and the evaluation of φ and its derivatives."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any, cast

import numpy as np
import warp as wp

from warp_rods.device import exclusive, start
from warp_rods.documented import Documented
from warp_rods.kernels.surface.geometry import Numbers, Parameters, crossings_of, sampler
from warp_rods.membranes import motion
from warp_rods.membranes.level_set import Box, Kind, LevelSet, MovingKind, Values
from warp_rods.values import shown

__all__ = ["Surface", "ends_of"]


class Surface(metaclass=Documented):
    """A surface: its field φ and its parameters. Takes and returns NumPy arrays; made by ``surfaces.make``.

    A surface with a formula in t among its values moves. Its methods then refer to t = 0; see ``at`` for other times.
    """

    _unlisted = frozenset({"crossings", "phi_again", "sampled"})

    def __init__(self, kind: str, values: Values, row: Kind):
        """``row``: that of the kind; ``values``: as ``row.read`` returns them."""
        self.kind, self.values, self._row = kind, dict(values), row
        self.moving = motion.is_moving(values)
        """Whether it changes with time."""
        level_set = row.level_set(motion.values_at(values, 0.0))
        self.field = level_set.field
        """The Warp function x, p -> φ, ∇φ, ∇∇φ."""
        self.rate = cast(MovingKind, row).rate(values) if self.moving else None
        """The Warp function x, p, dp/dt -> ∂tφ, ∇∂tφ of a moving surface."""
        self.parameters = _numbers(level_set)
        """The parameters p.v [8] of the field."""
        self._grid, self._grids = level_set.grid, dict[str, wp.array]()
        self._sampled: wp.array | None = None
        self.grid = level_set.grid
        """The spline coefficients [x, y, z] of a surface from a file; None for the other kinds."""
        self.box = level_set.box
        """Lower and upper corner [3] of a box that contains the surface and is slightly larger."""
        self.closed = bool(level_set.closed)
        """Whether the surface is closed; of an open one the part inside ``box`` is used."""
        self.data = level_set.data
        """Notes, warnings and bodies of a surface from a file."""
        self.given = level_set.closed is None
        """Whether φ is given by the user, as a formula or a file, so that it is known in the box only."""

    def __repr__(self) -> str:
        values = ", ".join(f"{name} = {shown(value)}" for name, value in self.values.items() if name != "box")
        form = "closed" if self.closed else "open"
        box = " × ".join(f"[{low:.4g}, {high:.4g}]" for low, high in zip(*self.box, strict=True))
        return f"<Surface {self.kind} ({values}): {form}{', moving' if self.moving else ''}, in the box {box}>"

    def sampled(self, times: np.ndarray) -> Iterator[np.ndarray]:
        """Values [time] of the formulas in t of a surface that moves."""
        return motion.sampled(self.values, times)

    def parameters_at(self, time: float) -> np.ndarray:
        """The parameters of the field [8] at this time; raises SceneError where a formula has no value."""
        return _numbers(self._row.level_set(motion.values_at(self.values, time))) if self.moving else self.parameters

    def parameter_rates(self, time: float) -> np.ndarray:
        """Time derivatives of the parameters [8], exact; raises SceneError where a formula has none."""
        numbers = cast(MovingKind, self._row).numbers(motion.rates_at(self.values, time))
        return np.concatenate([numbers, np.zeros(8 - numbers.size)])

    def at(self, time: float) -> Surface:
        """The surface at this time, at rest; raises SceneError where a formula has no value."""
        if not self.moving:
            return self
        frozen = copy.copy(self)
        frozen.values, frozen.moving = motion.values_at(self.values, time), False
        level_set = self._row.level_set(frozen.values)
        frozen.parameters, frozen.box, frozen._sampled = _numbers(level_set), level_set.box, None
        return frozen

    def derivatives(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """φ [...], ∇φ [..., 3] and ∇∇φ [..., 3, 3] at points [..., 3]."""
        shape = np.shape(points)[:-1]
        phi, gradient, hessian = self._sample("evaluate", points, (wp.float64, wp.vec3d, wp.mat33d))
        return phi.reshape(shape), gradient.reshape(*shape, 3), hessian.reshape(*shape, 3, 3)

    def _sample(self, kernel: str, points: np.ndarray, results: tuple[Any, ...]) -> list[np.ndarray]:
        """Results of a kernel of ``sampler`` at points [..., 3]: one array [point, ...] per type."""
        x = np.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        start()
        with exclusive:
            arrays = [wp.empty(len(x), dtype=t, device="cpu") for t in results]
            if self._sampled is None:
                self._sampled = self.device_parameters("cpu")
            inputs = [wp.array(x, dtype=wp.vec3d, device="cpu", copy=False), self._sampled, *arrays]
            wp.launch(getattr(sampler(self.field), kernel), dim=len(x), inputs=inputs, device="cpu")
            return [a.numpy() for a in arrays]

    def crossings(
        self, foot: np.ndarray, direction: np.ndarray, place: np.ndarray, begin: np.ndarray, end: np.ndarray
    ) -> np.ndarray:
        """Where φ changes its sign along lines ``foot`` + t ``direction`` [line, 3] between places t [line, sample].

        Only places from ``begin`` to ``end`` [line] count. Integers [line, sample]: −1 where φ > 0 at the next place
        alone, 1 where it is at this place alone, otherwise 0.
        """
        start()
        with exclusive:
            if self._sampled is None:
                self._sampled = self.device_parameters("cpu")
            crossed = wp.zeros(place.shape, dtype=wp.int32, device="cpu")
            inputs: list[Any] = [wp.array(x, dtype=wp.vec3d, device="cpu") for x in (foot, direction)]
            inputs += [wp.array(np.ascontiguousarray(x), device="cpu") for x in (place, begin, end)]
            inputs += [self._sampled, crossed]
            wp.launch(crossings_of(self.field), dim=len(foot), inputs=inputs, device="cpu")
            return crossed.numpy()

    def phi_again(self, count: int) -> Callable[[np.ndarray], np.ndarray]:
        """A function that evaluates φ [count] at points [count, 3] many times; a result lasts until the next one."""
        start()
        with exclusive:
            if self._sampled is None:
                self._sampled = self.device_parameters("cpu")
            x = wp.empty(count, dtype=wp.vec3d, device="cpu")
            phi = wp.empty(count, dtype=wp.float64, device="cpu")
            inputs = [x, self._sampled, phi]
            launch = wp.launch(sampler(self.field).value, dim=count, inputs=inputs, device="cpu", record_cmd=True)
        points, found = x.numpy(), phi.numpy()

        def evaluate(at: np.ndarray) -> np.ndarray:
            points[:] = at
            with exclusive:
                launch.launch()
            return found

        return evaluate

    def device_parameters(self, device, time: float = 0.0) -> wp.array:
        """The parameters in an array of one element, whose changes a recorded step sees.

        For a moving surface two elements: the parameters at this time, and their rates.
        """
        numbers = [self.parameters_at(time), *([self.parameter_rates(time)] if self.moving else [])]
        start()
        with exclusive:
            return wp.array([self._on(device, row) for row in numbers], dtype=Parameters, device=device)

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
        (phi,) = self._sample("value", points, (wp.float64,))
        return phi.reshape(np.shape(points)[:-1])

    def gradient(self, points: np.ndarray) -> np.ndarray:
        """∇φ [..., 3] at points [..., 3]."""
        return self.derivatives(points)[1]

    def hessian(self, points: np.ndarray) -> np.ndarray:
        """∇∇φ [..., 3, 3] at points [..., 3]."""
        return self.derivatives(points)[2]

    def normal(self, points: np.ndarray) -> np.ndarray:
        """Outward unit normal [..., 3] at points [..., 3]."""
        g = self.gradient(points)
        return g / np.linalg.norm(g, axis=-1, keepdims=True)

    def project(self, points: np.ndarray, iterations: int = 20) -> np.ndarray:
        """Points [..., 3] moved along ∇φ to φ = 0 by Newton steps."""
        given = np.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        start()
        with exclusive:
            x: wp.array = wp.array(given, dtype=wp.vec3d, device="cpu")
            inputs = [x, self.device_parameters("cpu"), iterations]
            wp.launch(sampler(self.field).project, dim=len(x), inputs=inputs, device="cpu")
            return x.numpy().reshape(np.shape(points))

    def second_form(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit tangents t1, t2 = n×t1 [..., 3] and components of −∇n [..., 2, 2] (5.16) at points on the surface."""
        _, g, H = self.derivatives(points)
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


def ends_of(surface: Surface) -> Box:
    """The box [3] outside which φ is not known: that of an open surface of a formula or a file, or infinite."""
    return surface.box if surface.given and not surface.closed else (np.full(3, -np.inf), np.full(3, np.inf))


def _numbers(level_set: LevelSet) -> np.ndarray:
    return np.concatenate([level_set.numbers, np.zeros(8 - level_set.numbers.size)])
