"""Rods whose steps are timed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.membranes import sampling, surfaces
from warp_rods.membranes.surface import Surface
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.free.rods import FreeRods

FREE_NODES, BOUND_NODES = 65, 33
WAYS = ("own", "together")
NODE_STEPS = 200_000
"""Nodes times equal steps of a measurement, about."""
MOST_STEPS = 200
"""At most so many of them."""
STEP = {"FreeRods": 1e-3, "BoundRods": 1e-4}
"""Equal steps."""


class Stepped:
    """Rods that go through the same steps at each ``run``, after ``restore``; ``node_steps``: nodes times steps."""

    def __init__(self, rods: Ensemble, how: str):
        self.rods, self._own = rods, how == "own"
        self._step = STEP[type(rods).__name__]
        if not self._own:
            rods.step(self._step, 40)  # the first steps are divided
        self._steps = min(MOST_STEPS, max(1, NODE_STEPS // (rods.count * rods.nodes)))
        self._start, self._time = rods.state(), rods.time
        before = self._taken()
        self.run()
        self.node_steps = (self._taken() - before) * rods.nodes
        if (rods.status != 0).any():
            raise ArithmeticError(f"{rods!r}: rods that are timed were frozen")

    def _taken(self) -> int:
        return int((self.rods.steps_taken + self.rods.steps_rejected).sum())

    def restore(self) -> None:
        """Return to the start."""
        self.rods.restore(self._start)

    def run(self) -> None:
        """Take the steps."""
        if self._own:
            self.rods.advance_to(self._time + self._duration)
        else:
            self.rods.step(self._step, self._steps)

    @property
    def _duration(self) -> float:
        """A time in which a rod takes some tens of steps of its own."""
        return 0.2 if isinstance(self.rods, FreeRods) else 0.02


def swimmers(count: int, spatial: bool, nodes: int = FREE_NODES) -> FreeRods:
    """Swimmers with a range of stiffnesses, and in space of active moments."""
    share = np.linspace(0.0, 1.0, count)
    shape = {"kind": "writhe" if spatial else "mode", "amplitude": 2.0}
    moment = 5e-3 * (1.0 + share) if spatial else 0.0
    return FreeRods(count, nodes, bend=1e-3 * (1.0 + share), twist=1e-3, moment=moment, shape=shape)


FREE: dict[str, Callable[[int], Ensemble]] = {
    "in a plane": partial(swimmers, spatial=False),
    "in space": partial(swimmers, spatial=True),
}


def sensors(count: int, surface: Callable[[], Surface], nodes: int = BOUND_NODES) -> BoundRods:
    """Curvature sensors at random on a membrane."""
    rng, membrane = np.random.default_rng(1), surface()
    position = sampling.uniform_points(membrane, count, rng)
    direction = sampling.isotropic_directions(membrane, position, rng)
    given: dict[str, Any] = {"length": 0.5, "intrinsic": (0.0, 1.5, 0.0), "drag": (1.0, 2.0, 0.1)}
    return BoundRods(membrane, position, direction, nodes=nodes, **given)


@cache
def dumbbell() -> Surface:
    return surfaces.make("cassini", {"a": 1.0, "b": 1.1})


@cache
def formula() -> Surface:
    box = [[-2.0, 2.0]] * 3
    return surfaces.make("expression", {"phi": "x**2 + y**2 + z**2 - R**2", "box": box, "parameters": {"R": 1.0}})


@cache
def bumpy_sphere() -> Surface:
    return surfaces.make("undulated", {"radius": 1.0, "amplitude": 0.16, "wavenumber": 5.0})


@cache
def mesh() -> Surface:
    """A sphere as triangles."""
    import trimesh

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sphere.ply"
        trimesh.creation.icosphere(subdivisions=4).export(path)
        return surfaces.make("grid", {"file": str(path), "spacing": 0.1})


MEMBRANES: dict[str, Callable[[], Surface]] = {
    "dumbbell": dumbbell,
    "formula": formula,
    "bumpy sphere": bumpy_sphere,
    "mesh": mesh,
}
BOUND: dict[str, Callable[[int], Ensemble]] = {
    name: partial(sensors, surface=surface) for name, surface in MEMBRANES.items()
}
