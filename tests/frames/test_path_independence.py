"""Frames do not depend on the path in (s, t) along which strains and velocities are integrated (5.7), (5.8), (5.11)."""

import numpy as np
from examples import bound
from examples.free import slope
from reference.bound import State, evaluate

from warp_rods import frames

START, END = 0.2, 0.3
"""Times between which frames are compared, when what is rough about the start has decayed."""


def transported(along: np.ndarray, in_time: np.ndarray, ds: float, dt: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """S(0, t₀)⁻¹ S(L, t₁) by two paths: along s at t₀, then in time at s = L; in time at s = 0, then along s at t₁.

    along: (Ω, U) [time, node, 6]; in_time: (ω, u) [time, node, 6].
    """

    def last(A, step):
        R, r = frames.path_product(A[:, :3], step, A[:, 3:])
        return R[-1], r[-1]

    first = frames.se3_compose(*last(along[0], ds), *last(in_time[:, -1], dt))
    return [first, frames.se3_compose(*last(in_time[:, 0], dt), *last(along[-1], ds))]


def moving(s: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A field of frames e^{A(s, t)} with r = (s + st, cos(s + t), s t²), [time, node, ...]."""
    t = t[:, None]
    screw = np.stack([np.sin(2 * s + t), s * t, np.cos(s - 2 * t)], axis=-1)
    return frames.rotation_exp(screw), np.stack([s + s * t, np.cos(s + t), s * t**2], axis=-1)


def gauge_potential(s: np.ndarray, t: np.ndarray, by_s: bool) -> np.ndarray:
    """S⁻¹ ∂S [time, node, 6] of these frames, by fourth-order differences in s or t."""
    R, _ = moving(s, t)
    h = 1e-3
    shifted = [moving(s + k * h, t) if by_s else moving(s, t + k * h) for k in (-2, -1, 1, 2)]
    dR, dr = ((a[0] - 8 * a[1] + 8 * a[2] - a[3]) / (12 * h) for a in zip(*shifted, strict=True))
    back = np.swapaxes(R, -1, -2)
    return np.concatenate([frames.vee(back @ dR), (back @ dr[..., None])[..., 0]], axis=-1)


def test_frames_of_a_field_do_not_depend_on_the_path_and_others_do():
    sizes, apart = [16, 32, 64], []
    for cells in sizes:
        s, t = np.linspace(0, 1, cells + 1), np.linspace(0, 0.8, cells + 1)
        A_s, A_t = gauge_potential(s, t, True), gauge_potential(s, t, False)
        R, r = moving(s, t)
        exact = frames.se3_compose(*frames.se3_inverse(R[0, 0], r[0, 0]), R[-1, -1], r[-1, -1])
        found = transported(A_s, A_t, 1 / cells, 0.8 / cells)
        apart.append([max(abs(a - b).max() for a, b in zip(U, exact, strict=True)) for U in found])
    assert all(abs(slope(sizes, column) - 2) < 0.2 for column in zip(*apart, strict=True))
    # A twist that is added to A_t alone violates (5.8).
    spoilt = A_t + 0.3 * np.eye(6)[0] * s[:, None]
    one, other = transported(A_s, spoilt, 1 / cells, 0.8 / cells)
    assert abs(one[0] - other[0]).max() > 0.05


def recorded(
    turns: list, nodes: int, steps: int, device
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """(Ω, U), (ω, u) [time, node, 6] and the frames of a filament on a torus at the times of its steps.

    Of its middle half: at the ends, velocities of a state amplify its errors by Δt²/Δs².
    """
    rods = bound.smooth_filaments("torus", nodes, device, turns)
    parameters, force = bound.twin_rod("torus", 0, nodes), rods.force[0]
    inner, dt = slice(nodes // 4, 3 * nodes // 4 + 1), (END - START) / steps
    rods.step(dt, round(START / dt))
    along, in_time, R, r = [], [], [], []
    for step in range(steps + 1):
        if step:
            rods.step(dt)
        state = State(rods.strain[0, :, 2], rods.rotation[0], rods.position[0])
        motion = evaluate(parameters, state, force)
        along.append(np.concatenate([rods.strain[0], np.tile([1.0, 0.0, 0.0], (nodes, 1))], axis=-1)[inner])
        in_time.append(np.concatenate([motion.spin, motion.velocity], axis=-1)[inner])
        R.append(state.rotation[inner])
        r.append(state.position[inner])
    return np.array(along), np.array(in_time), (np.array(R), np.array(r))


def test_frames_of_a_bound_filament_do_not_depend_on_the_path(device, verified):
    """Of a moving filament on a torus: its strains and velocities carry the frame of one place at one time to another
    place later, by both paths."""
    turns = [lambda x, sigma=sigma: sigma + np.sin(np.pi * x) ** 2 * np.cos(2 * x) for sigma in bound.INTRINSIC[:, 2]]
    sizes, errors = [16, 32, 64], []
    for cells in sizes:
        along, in_time, (R, r) = recorded(turns, cells + 1, cells // 2, device)
        ds, dt = bound.LENGTH[0] / cells, (END - START) / (cells // 2)
        actual = frames.se3_compose(*frames.se3_inverse(R[0, 0], r[0, 0]), R[-1, -1], r[-1, -1])
        found = transported(along, in_time, ds, dt)
        errors.append([max(abs(a - b).max() for a, b in zip(U, actual, strict=True)) for U in found])
    assert abs(r[-1] - r[0]).max() > 0.01
    verified.order(
        "S(s′, t′) = S(s, t) U of a bound filament (5.11), along s then t, and t then s: order in Δs, Δt",
        measured=[slope(sizes, column) for column in zip(*errors, strict=True)], reference="its frames",
    )  # fmt: skip
