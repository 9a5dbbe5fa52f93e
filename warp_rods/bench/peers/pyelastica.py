"""The planar swimmer in PyElastica: a Cosserat rod with mass, stretching and shear, and forcing compiled by Numba.

A rod without mass and stretching is a limit that an explicit code cannot take: the mass per length is ``mass`` times
the drag per length, so that velocities relax in that time, and the stretching stiffness EA is ``STRETCH``, which with
forces f* L about 0.5 stretches it by about a hundredth. Its radius follows from both stiffnesses.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from warp_rods.bench.peers.optional import compiled
from warp_rods.bench.peers.planar import Swimmer

STRETCH = 50.0
"""EA in units of f* L."""
BLOWN = 0.5
"""A rod that is stretched by this much is unstable."""


@compiled
def force_nodes(tangents, velocity, activity, lengths, drag_ratio, relaxation, diffusion, dt, force):
    """Add drag and activity to the forces [3, node], and advance f [node] by (4.12); explicit."""
    last = len(activity) - 1
    flow = np.empty(last + 1)
    for i in range(last + 1):
        left, right = max(i - 1, 0), min(i, last - 1)
        tangent = tangents[:, left] + tangents[:, right]
        tangent /= np.sqrt((tangent**2).sum())
        weight = (lengths[left] if i > 0 else 0.0) / 2 + (lengths[right] if i < last else 0.0) / 2
        flow[i] = (tangent * velocity[:, i]).sum()
        for axis in range(3):
            along = flow[i] * tangent[axis]
            push = activity[i] * tangent[axis] - along - drag_ratio * (velocity[axis, i] - along)
            force[axis, i] += weight * push
    h = 1.0 / last
    before = activity.copy()
    for i in range(last + 1):
        f, left, right = before[i], before[abs(i - 1)], before[i + 1] if i < last else before[last - 1]
        change = (1.0 - f * f) * flow[i] + diffusion * (left - 2.0 * f + right) / h**2
        activity[i] += dt * change / relaxation


class Made(NamedTuple):
    """A simulator with its rods, which ``run`` steps."""

    simulator: Any
    rods: list[Any]
    stepper: Any

    @property
    def stretched(self) -> float:
        """The largest strain of an element of the first rod."""
        return float(abs(self.rods[0].dilatation - 1).max())


def _forcing(swimmer: Swimmer, activity: np.ndarray) -> type:
    """The class that PyElastica asks for."""
    from elastica import NoForces

    class Flagella(NoForces):
        def __init__(self) -> None:
            self.activity, self.now = activity.copy(), 0.0

        def apply_forces(self, system: Any, time: Any = 0.0) -> None:
            dt, self.now = float(time) - self.now, float(time)
            force_nodes(
                system.tangents, system.velocity_collection, self.activity, system.lengths, *swimmer[1:], dt,
                system.external_forces,
            )  # fmt: skip

    return Flagella


def make(swimmer: Swimmer, curvature: np.ndarray, activity: np.ndarray, mass: float, count: int = 1) -> Made:
    """``count`` equal rods with this curvature and activity at the nodes, in the plane z = 0."""
    import elastica

    class Simulator(elastica.BaseSystemCollection, elastica.Forcing):  # type: ignore[name-defined, misc]
        pass

    nodes, h = len(curvature), 1 / (len(curvature) - 1)
    angle = np.cumsum((curvature[1:] + curvature[:-1]) / 2) * h
    angle = np.concatenate([[0.0], angle])[:-1] + curvature[:-1] * h / 2
    tangent = np.stack([np.cos(angle), np.sin(angle), 0 * angle])
    position = np.concatenate([np.zeros((3, 1)), np.cumsum(tangent * h, axis=1)], axis=1)
    area = 4 * np.pi * swimmer.bend / STRETCH  # EA/EI = 4/r²
    simulator, rods = Simulator(), []
    for _ in range(count):
        rod = elastica.CosseratRod.straight_rod(
            nodes - 1, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 1.0, float(np.sqrt(area / np.pi)),
            mass / area, youngs_modulus=STRETCH / area, position=position.copy(),
        )  # fmt: skip
        simulator.append(rod)
        simulator.add_forcing_to(rod).using(_forcing(swimmer, activity))
        rods.append(rod)
    simulator.finalize()
    return Made(simulator, rods, elastica.PositionVerlet())


def run(made: Made, step: float, steps: int, shown: int) -> np.ndarray | None:
    """κ [time, inner node] of the first rod after every ``shown`` steps; None where the rod blew up."""
    time, found = np.float64(0.0), []
    rod = made.rods[0]
    for number in range(1, steps + 1):
        time = made.stepper.step(made.simulator, time, np.float64(step))
        if number % shown == 0:
            if not made.stretched < BLOWN:
                return None
            found.append(rod.kappa[0].copy())
    return np.array(found)
