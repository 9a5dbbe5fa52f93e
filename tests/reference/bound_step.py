"""The time step of a surface-bound filament and the reconstruction of its frames in NumPy (docs/model.md §3; D.5)."""

import numpy as np
from scipy.sparse.linalg import spsolve

from reference.bound import State, implicit_matrix, strain
from reference.lie import hat

SWEEPS = 2
"""Fixed-point sweeps of (D.81), (D.82) in each cell."""


def exp_step(R, r, theta, mu):
    """S exp(θ, μ) by (D.69)-(D.71); θ not zero."""
    angle, turn = np.linalg.norm(theta), hat(theta)
    A, B = np.sin(angle) / angle, 2 * np.sin(angle / 2) ** 2 / angle**2
    C = (1 - A) / angle**2
    V = np.eye(3) + B * turn + C * turn @ turn
    return R @ (np.eye(3) + A * turn + B * turn @ turn), r + R @ V @ mu


def next_node(rod, before, after, R, r, K, guess, ds, sweeps):
    """The neighbour at ds from the fixed point of (D.81), (D.82), projected at constant length of the chord."""
    e0, surface = np.array([1.0, 0.0, 0.0]), rod.surface
    for _ in range(sweeps):
        mean = (strain(K, before) + strain(guess, after)) / 2
        Q, x = exp_step(R, r, ds * mean, ds * e0)
        guess = surface.curvature(x, surface.frame(x, Q[:, 0])[:, 0])
    chord = surface.newton(x) - r
    position = r + chord * np.linalg.norm(x - r) / np.linalg.norm(chord)
    return surface.frame(position, Q[:, 0]), position


def rebuild(rod, geodesic, node, R, r, sweeps=SWEEPS):
    """The state with these Ω whose frame at ``node`` is (R, r)."""
    nodes = len(geodesic)
    state = State(geodesic, np.empty((nodes, 3, 3)), np.empty((nodes, 3)))
    state.rotation[node], state.position[node] = R, r
    start = rod.surface.curvature(r, R[:, 0])
    for sign, stop in ((-1, -1), (1, nodes)):
        K = guess = start
        for j in range(node + sign, stop, sign):
            i = j - sign
            Q, x = state.rotation[i], state.position[i]
            Q, x = next_node(rod, geodesic[i], geodesic[j], Q, x, K, guess, sign * rod.spacing, sweeps)
            state.rotation[j], state.position[j] = Q, x
            before, K = K, rod.surface.curvature(x, Q[:, 0])
            guess = 2 * K - before
    return state


def step(rod, state, motion, old_state, old_motion, dt, ratio):
    """One step of SBDF2 in increments and of AB2–Magnus; ratio: Δt over the previous one, 0 for Euler."""
    m = len(state.geodesic) // 2
    change = state.geodesic - old_state.geodesic
    right = dt * ((1 + ratio) * motion.rate - ratio * old_motion.rate) - ratio * change
    increment = spsolve(implicit_matrix(rod, motion.curvature, dt, ratio), right)
    omega = motion.spin[m] + ratio / 2 * (motion.spin[m] - old_motion.spin[m])
    u = motion.velocity[m] + ratio / 2 * (motion.velocity[m] - old_motion.velocity[m])
    R, r = exp_step(state.rotation[m], state.position[m], dt * omega, dt * u)
    r = rod.surface.newton(rod.surface.newton(r))
    geodesic = state.geodesic + ratio * change + increment
    return rebuild(rod, geodesic, m, rod.surface.frame(r, R[:, 0]), r)
