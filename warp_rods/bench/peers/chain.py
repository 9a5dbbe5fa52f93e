"""A filament on a membrane as a chain of nodes with penalties, or of beads that are put back onto the membrane.

Energy: springs between nodes hold the length, a penalty of the distance holds nodes on the membrane (the chain), and
½ Σ B_j (Ω_j − σ_j)² with the strains from neighbours and the normal: Ω = (K12, −K11, geodesic curvature), docs/model.md
§3.1. Forces are exact derivatives, by complex steps of each node's energy. Drag is ζ∥ along and ζ⊥ across the tangent.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csr_array, diags_array, kron

from warp_rods.bench.peers.optional import compiled

TINY = 1e-30
"""The imaginary step: its square vanishes beside 1."""
REACH = 2
"""Nodes on each side that the force on a node depends on."""


class Chain(NamedTuple):
    """Sphere (``b`` = 0, radius ``a``) or Cassini surface; B, σ, ζ∥ and ζ⊥; spacing; stiffness of the penalties.

    stretch is a force; hold is a force per length and distance; hold = 0 for beads that are projected.
    """

    a: float
    b: float
    stiffness: tuple[float, float, float]
    intrinsic: tuple[float, float, float]
    drag: tuple[float, float]
    spacing: float
    stretch: float
    hold: float


@compiled
def dot(u, v):
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@compiled
def cross(u, v):
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


@compiled
def less(u, v):
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


@compiled
def scaled(c, u):
    return (c * u[0], c * u[1], c * u[2])


@compiled
def unit(u):
    return scaled(1.0 / np.sqrt(dot(u, u)), u)


@compiled
def level(x, a, b):
    """φ and ∇φ."""
    if b == 0.0:
        return (dot(x, x) - a * a) / (2.0 * a), scaled(1.0 / a, x)
    Q = dot(x, x) + a * a
    value = Q * Q - 4.0 * a * a * x[2] * x[2] - b**4
    return value, (4.0 * Q * x[0], 4.0 * Q * x[1], 4.0 * Q * x[2] - 8.0 * a * a * x[2])


@compiled
def bending(before, here, after, chain):
    """Energy per length of an inner node."""
    h = chain.spacing
    _, g = level(here, chain.a, chain.b)
    _, g_before = level(before, chain.a, chain.b)
    _, g_after = level(after, chain.a, chain.b)
    n = unit(g)
    t = less(after, before)
    q = unit(less(t, scaled(dot(t, n), n)))
    side = cross(n, q)
    bent = scaled(1.0 / h, less(unit(less(after, here)), unit(less(here, before))))
    tilted = scaled(0.5 / h, less(unit(g_after), unit(g_before)))
    twist, normal, geodesic = -dot(side, tilted), -dot(bent, n), dot(bent, side)
    B, s = chain.stiffness, chain.intrinsic
    return 0.5 * (B[0] * (twist - s[0]) ** 2 + B[1] * (normal - s[1]) ** 2 + B[2] * (geodesic - s[2]) ** 2)


@compiled
def forces(x, chain, force):
    """−∂E/∂x [node, 3]."""
    nodes, h = x.shape[0], chain.spacing
    force[:] = 0.0
    for i in range(1, nodes - 1):
        triple = (
            (x[i - 1, 0] + 0j, x[i - 1, 1] + 0j, x[i - 1, 2] + 0j),
            (x[i, 0] + 0j, x[i, 1] + 0j, x[i, 2] + 0j),
            (x[i + 1, 0] + 0j, x[i + 1, 1] + 0j, x[i + 1, 2] + 0j),
        )
        for axis in range(3):
            step = 1j * TINY
            e = (step if axis == 0 else 0j, step if axis == 1 else 0j, step if axis == 2 else 0j)
            minus = scaled(-1.0, e)
            force[i - 1, axis] -= h * bending(less(triple[0], minus), triple[1], triple[2], chain).imag / TINY
            force[i, axis] -= h * bending(triple[0], less(triple[1], minus), triple[2], chain).imag / TINY
            force[i + 1, axis] -= h * bending(triple[0], triple[1], less(triple[2], minus), chain).imag / TINY
    for i in range(nodes - 1):
        d = less((x[i + 1, 0], x[i + 1, 1], x[i + 1, 2]), (x[i, 0], x[i, 1], x[i, 2]))
        length = np.sqrt(dot(d, d))
        pull = chain.stretch * (length / h - 1.0) / length
        for axis in range(3):
            force[i, axis] += pull * d[axis]
            force[i + 1, axis] -= pull * d[axis]
    if chain.hold > 0.0:
        for i in range(nodes):
            value, g = level((x[i, 0], x[i, 1], x[i, 2]), chain.a, chain.b)
            push = chain.hold * h * value / dot(g, g)
            for axis in range(3):
                force[i, axis] -= push * g[axis]


@compiled
def velocities(x, chain, force, velocity):
    """dx/dt [node, 3] from the drag of each node's share of the length."""
    nodes = x.shape[0]
    for i in range(nodes):
        low, high = max(i - 1, 0), min(i + 1, nodes - 1)
        t = unit(less((x[high, 0], x[high, 1], x[high, 2]), (x[low, 0], x[low, 1], x[low, 2])))
        share = chain.spacing * (0.5 if i in (0, nodes - 1) else 1.0)
        along = force[i, 0] * t[0] + force[i, 1] * t[1] + force[i, 2] * t[2]
        for axis in range(3):
            part = along * t[axis]
            velocity[i, axis] = (part / chain.drag[0] + (force[i, axis] - part) / chain.drag[1]) / share


@compiled
def projected_steps(x, chain, dt, steps):
    """Explicit steps of beads, each put back onto the membrane along its normal."""
    force, velocity = np.empty_like(x), np.empty_like(x)
    for _ in range(steps):
        forces(x, chain, force)
        velocities(x, chain, force, velocity)
        for i in range(x.shape[0]):
            for axis in range(3):
                x[i, axis] += dt * velocity[i, axis]
            for _newton in range(2):
                value, g = level((x[i, 0], x[i, 1], x[i, 2]), chain.a, chain.b)
                share = value / dot(g, g)
                for axis in range(3):
                    x[i, axis] -= share * g[axis]


def sparsity(nodes: int) -> csr_array:
    """Which coordinates a velocity depends on."""
    near = diags_array(np.ones((2 * REACH + 1, nodes)), offsets=range(-REACH, REACH + 1), shape=(nodes, nodes))
    return csr_array(kron(near, np.ones((3, 3))))


def solve(start: np.ndarray, chain: Chain, end: float, tolerance: float) -> np.ndarray:
    """Nodes [node, 3] at the end by SciPy's BDF, with a banded Jacobian by differences."""
    shape, force, velocity = start.shape, np.empty_like(start), np.empty_like(start)

    def rate(_t: float, y: np.ndarray) -> np.ndarray:
        forces(y.reshape(shape), chain, force)
        velocities(y.reshape(shape), chain, force, velocity)
        return velocity.ravel().copy()

    options = {"rtol": tolerance, "atol": tolerance, "jac_sparsity": sparsity(len(start))}
    found = solve_ivp(rate, (0.0, end), start.ravel(), "BDF", **options)
    if not found.success:
        raise ArithmeticError(found.message)
    return found.y[:, -1].reshape(shape)
