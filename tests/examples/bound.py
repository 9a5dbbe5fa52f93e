"""States of surface-bound filaments for tests: on the device, for the NumPy version, and as smooth curves."""

import numpy as np
from numpy.polynomial import Chebyshev
from reference.bound import Rod, State, end_slope, moments
from reference.lie import se3_exp
from reference.symbolic_surface import cassini, torus
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.tiles import Tiled, is_tiled

LENGTH = np.array([1.2, 0.9])
STIFFNESS = np.array([[1.0, 1.3, 0.7], [0.6, 0.9, 1.1]])
INTRINSIC = np.array([[0.4, 0.8, 0.3], [-0.5, -0.7, -0.2]])
DRAG = np.array([[1.0, 2.0, 0.3], [0.8, 1.7, 0.6]])
"""Two rods that differ in every coefficient, none of them zero."""

TWINS = {"torus": torus(1.0, 0.5), "cassini": cassini(1.0, 1.1)}
OURS = {
    "torus": ("torus", {"major": 1.0, "minor": 0.5}),
    "cassini": ("cassini", {"a": 1.0, "b": 1.1}),
}
MIDDLES = {
    "torus": np.array([[1.4, 0.3, 0.3], [-0.2, 0.6, 0.35]]),
    "cassini": np.array([[0.5, 0.1, 0.3], [-0.3, 0.5, -0.9]]),
}
DIRECTIONS = np.array([[0.3, 0.8, 0.5], [0.6, -0.2, 0.7]])
"""Approximate positions of the middle nodes, and tangents there."""


def wave(rng, scale=1.0):
    """A random smooth function on [−1, 1]."""
    amplitude, phase = scale * rng.normal(size=4), rng.uniform(0, 2 * np.pi, 4)
    return lambda x: np.cos(np.multiply.outer(x, [0.0, 1.5, 3.0, 4.5]) + phase) @ amplitude


def graded(values, x, seed):
    """Values [rod, node, 3] that are those [rod, 3] times random waves between 0.6 and 1.4."""
    rng = np.random.default_rng(seed)
    number, phase = rng.uniform(1, 4, size=(2, 1, 3)), rng.uniform(0, 2 * np.pi, size=(2, 1, 3))
    return values[:, None] * (1 + 0.4 * np.cos(number * x[:, None] + phase))


def graded_parameters(x):
    """B, σ, ζ [rod, node, 3] of the two rods at x in [−1, 1]."""
    given = {"stiffness": STIFFNESS, "intrinsic": INTRINSIC, "drag": DRAG}
    return {name: graded(values, x, seed) for seed, (name, values) in enumerate(given.items())}


def filaments(kind, nodes, device, geodesic_curvature, force=0.0, **changed):
    """The two rods on the device with these Ω [rod, node] and force per length [rod, node, 3]."""
    given = {"length": LENGTH, "stiffness": STIFFNESS, "intrinsic": INTRINSIC, "drag": DRAG}
    rods = BoundRods(
        surfaces.make(*OURS[kind]),
        MIDDLES[kind],
        DIRECTIONS,
        nodes=nodes,
        geodesic_curvature=geodesic_curvature,
        device=device,
        **(given | changed),
    )
    rods.force = force
    return rods


def random_filaments(kind, nodes, device, seed=3, along=False):
    """The two rods with random smooth Ω and force; ``along``: and with parameters that change along them."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-1, 1, nodes)
    turn = np.stack([wave(rng)(x) for _ in LENGTH])
    force = np.stack([np.stack([wave(rng)(x) for _ in range(3)], -1) for _ in LENGTH])
    return filaments(kind, nodes, device, turn, force, **(graded_parameters(x) if along else {}))


def twin_rod(kind, rod, nodes, along=False):
    """Parameters of one of the two rods for the NumPy version; ``along``: those that change along them."""
    if along:
        values = graded_parameters(np.linspace(-1, 1, nodes))
        return Rod(TWINS[kind], LENGTH[rod] / (nodes - 1), *(values[name][rod] for name in values))
    return Rod(TWINS[kind], LENGTH[rod] / (nodes - 1), STIFFNESS[rod], INTRINSIC[rod], DRAG[rod])


def read(rods, name):
    """A copy of a device array of the ensemble [rod, ...]; workspace holds a single tile."""
    array = getattr(rods._f, name)
    return Tiled(array, rods.count).numpy() if is_tiled(array) else array.numpy().copy()


def twin_state(rods, rod):
    """The present state of one rod for the NumPy version."""
    return State(read(rods, "geodesic")[rod], rods.rotation[rod], read(rods, "position")[rod])


# --- smooth curves -----------------------------------------------------------------------------------------------


def start_frame(kind, rod):
    """Middle position and tangent of one of the two rods, exactly on the surface."""
    x = MIDDLES[kind][rod]
    for _ in range(20):
        x = TWINS[kind].newton(x)
    return x, TWINS[kind].frame(x, DIRECTIONS[rod])[:, 0]


def trace(surface, turn, r, q, s):
    """Positions and tangents [..., 3] at ascending arc lengths s (0 in the middle) of the curve with these Ω(s).

    q' = Ω n×q − (q·∇n·q) n, (5.46) with the sign of docs/model.md §3.1.
    """

    def slope(at, y):
        x, q = y[:3], y[3:]
        n = surface.normal(x)
        return np.concatenate([q, turn(at) * np.cross(n, q) - (q @ surface.normal_gradient(x) @ q) * n])

    parts = []
    for sign, side in ((-1, s[s < 0][::-1]), (1, s[s >= 0])):
        path = solve_ivp(slope, (0, side[-1]), np.concatenate([r, q]), "DOP853", t_eval=side, rtol=1e-13, atol=1e-13)
        parts.append(path.y.T[::sign])
    x = np.concatenate(parts)
    return x[:, :3], x[:, 3:]


def compatible_turn(kind, rod, seed=5):
    """A smooth Ω(s) whose curve satisfies both conditions at free ends: m3 = 0 and (D.60)."""
    half = LENGTH[rod] / 2
    B3, sigma3 = STIFFNESS[rod][2], INTRINSIC[rod][2]
    inside = Chebyshev.interpolate(wave(np.random.default_rng(seed + rod), 0.5), 12)
    inside *= Chebyshev.fromroots([-1, -1, 1, 1])
    left, right = Chebyshev.fromroots([-1, 1, 1]) / 4, Chebyshev.fromroots([-1, -1, 1]) / 4
    ends = half * np.array([-1.0, 1.0])

    def with_slopes(slopes):
        return sigma3 + inside + slopes[0] * left + slopes[1] * right

    def excess(slopes):
        shape = with_slopes(slopes)
        curve = trace(TWINS[kind], lambda s: shape(s / half), *start_frame(kind, rod), ends)
        K = TWINS[kind].curvature(*curve)
        return slopes - half / B3 * end_slope(K, moments(twin_rod(kind, rod, 2), K, shape(ends / half)))

    return with_slopes(fsolve(excess, np.zeros(2)))


def smooth_filaments(kind, nodes, device, turns, seed=1):
    """The two rods with Ω from ``turns``, functions on [−1, 1], under a smooth force."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-1, 1, nodes)
    force = np.stack([np.stack([wave(rng)(x) for _ in range(3)], -1) for _ in LENGTH])
    return filaments(kind, nodes, device, np.stack([turn(x) for turn in turns]), force)


def order(cells, errors):
    """Fitted orders of convergence of errors [run, ...] with these numbers of cells."""
    return -np.polyfit(np.log(cells), np.log(errors), 1)[0]


def energy_defect(rods, dt):
    """|dE/dt + dissipation − power|/dissipation of the first rod, dE/dt from five states ``dt`` apart."""
    energy, lost = [], []
    for _ in range(5):
        energy.append(rods.energy[0])
        lost.append((rods.dissipation[0], rods.power[0]))
        rods.step(dt)
    rate = (energy[0] - 8 * energy[1] + 8 * energy[3] - energy[4]) / (12 * dt)
    dissipation, power = lost[2]
    return abs(rate + dissipation - power) / dissipation


BOUNDS = {
    "|φ|/|∇φ|": 1e-9,
    "RᵀR − 1 and det R − 1 of the directors": 1e-14,
    "third director against ∇φ/|∇φ|": 1e-14,
    "relative error of the lengths of segments": 1e-9,
}


def constraint_errors(rods: BoundRods) -> dict[str, float]:
    """Errors of the constraints of ``BOUNDS``, from directors and places.

    A segment is an arc of the screw motion with the mean strain of its ends.
    """
    R, r, surface = rods.rotation[0], rods.position[0], rods.surface.at(rods.time)
    gradient = surface.gradient(r)
    size = np.linalg.norm(gradient, axis=-1)
    gram = np.swapaxes(R, 1, 2) @ R - np.eye(3)
    cell = rods.reading("length")[0] / (rods.nodes - 1)
    mean = (rods.strain[0, 1:] + rods.strain[0, :-1]) / 2
    chord = [np.linalg.norm(se3_exp(cell * strain, np.array([cell, 0, 0]))[1]) for strain in mean]
    errors = (
        np.abs(surface.phi(r) / size).max(),
        max(np.abs(gram).max(), np.abs(np.linalg.det(R) - 1).max()),
        np.abs(R[:, :, 2] - gradient / size[:, None]).max(),
        np.abs(np.linalg.norm(np.diff(r, axis=0), axis=-1) / chord - 1).max(),
    )
    return dict(zip(BOUNDS, map(float, errors), strict=True))
