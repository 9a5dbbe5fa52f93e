"""The time step of a surface-bound filament and the reconstruction of its frames in NumPy (docs/model.md §3; D.5)."""

from dataclasses import dataclass

import numpy as np

from reference.bound import State, at_half_nodes, evaluate, middle, resistance, strain
from reference.free import lagrange
from reference.free_motion import screw
from reference.lie import frame_matrix, hat

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


@dataclass
class Past:
    """Levels of a filament, newest first: times, Ω [node], angle ψ and frames (R, r) of the tracked node."""

    times: list
    geodesic: list
    turn: list
    frames: list


def start(rod, state):
    """A filament that has not taken a step."""
    m = len(state.geodesic) // 2
    return Past([0.0], [state.geodesic], [0.0], [(state.rotation[m], state.position[m])])


def moved(rod, past, weights, theta, mu, turn):
    """The tracked frame at Σ w x + (θ, µ), where x are the screws from its newest frame to those of the levels.

    Its angle about n changes by ``turn``.
    """
    R, r = past.frames[0]
    for weight, frame in zip(weights[1:], past.frames[1:], strict=False):
        last_theta, last_mu = screw(np.linalg.inv(frame_matrix(R, r)) @ frame_matrix(*frame))
        theta, mu = theta + weight * last_theta, mu + weight * last_mu
    R, r = exp_step(R, r, np.array([theta[0], theta[1], turn]), mu)
    r = rod.surface.newton(rod.surface.newton(r))
    return rod.surface.frame(r, R[:, 0]), r


def angle_operators(rod, K):
    """Matrices from δα at half nodes to δΩ and to δu2 at nodes: Z22 δu2 = −(B3 δΩ)'' + (e″ δα)'; both ends free."""
    nodes, h = len(K), rod.spacing
    to_nodes = np.zeros((nodes, nodes - 1))
    to_nodes[1:-1] = np.diff(np.eye(nodes - 1), axis=0) / h
    second = np.zeros((nodes, nodes))
    second[1:-1] = np.diff(np.eye(nodes), 2, axis=0)
    second[0, 1] = second[-1, -2] = 2
    half, B = middle(K), at_half_nodes(rod.stiffness)
    stiffness = B[..., 0] * (half[:, 2] - half[:, 0]) ** 2 + 4 * B[..., 1] * half[:, 1] ** 2
    bending = np.broadcast_to(rod.stiffness, (nodes, 3))[:, 2:] * to_nodes
    torque = to_nodes.copy()
    torque[0, :2], torque[-1, -2:] = [1 / h, 1 / h], [-1 / h, -1 / h]
    velocity = -second @ bending / h**2 + torque * stiffness
    return to_nodes, velocity / resistance(K, rod.drag)[2][:, None]


def step(rod, past, t, force, order=2):
    """One step to t; as many levels as the order, or as there are."""
    m, h, levels = len(past.geodesic[0]) // 2, rod.spacing, min(order, len(past.times))
    times = past.times[:levels]
    values, _ = lagrange(times, t)
    _, slopes = lagrange([t, *times], t)
    a = slopes[0]
    # dx/dt = a (x − x*) + Σ d x, as the polynomial through x* and the levels has the slope Σ d x
    d = np.array(slopes[1:]) + a * np.array(values)
    star = np.tensordot(values, past.geodesic[:levels], 1)
    turn = np.dot(values, past.turn[:levels])
    frame = past.frames[0]
    if levels > 1:
        frame = moved(rod, past, values, np.zeros(3), np.zeros(3), turn - past.turn[0])
    motion = evaluate(rod, rebuild(rod, star, m, *frame), force)

    to_nodes, to_velocity = angle_operators(rod, motion.curvature)
    source = h * (motion.rate - np.tensordot(d, past.geodesic[:levels], 1))
    g = np.zeros(len(star) - 1)
    g[m] = motion.spin[m, 2] - np.dot(d, past.turn[:levels]) + source[m] / 2
    g[m + 1 :] = g[m] + np.cumsum(source[m + 1 : -1])
    g[:m] = g[m] - np.cumsum(source[m:0:-1])[::-1]
    implicit = a * np.eye(len(g)) - np.diff(to_velocity, axis=0) / h
    alpha = np.linalg.solve(implicit, g)

    geodesic = star + to_nodes @ alpha
    increment = (alpha[m - 1] + alpha[m]) / 2
    du2, K = to_velocity[m] @ alpha, motion.curvature[m]
    velocity = motion.velocity[m] + np.array([0, du2, 0])
    spin = motion.spin[m] + np.array([K[2] * du2, -K[1] * du2, 0])
    spin[2] = a * increment + np.dot(d, past.turn[:levels])
    turn += increment
    frame = moved(rod, past, values - d / a, spin / a, velocity / a, turn - past.turn[0])
    return Past([t, *past.times], [geodesic, *past.geodesic], [turn, *past.turn], [frame, *past.frames])


def state_of(rod, past):
    """The state of the newest level."""
    return rebuild(rod, past.geodesic[0], len(past.geodesic[0]) // 2, *past.frames[0])
