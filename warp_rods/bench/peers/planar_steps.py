"""Our step of second order (docs/model.md §2.4) for half a planar swimmer, as plain loops compiled by Numba."""

from __future__ import annotations

import numpy as np

from warp_rods.bench.peers.loops import pentadiagonal, tridiagonal
from warp_rods.bench.peers.optional import compiled
from warp_rods.bench.peers.planar import Swimmer, rates, unpack


@compiled
def fill_bending(tension, axial, bend, drag_ratio, a, h, rows):
    """Rows of a − J, J z = [(−b z'' + λ z)/η]'' + (u0 z)': z is even at the middle, and 0 at the end as z'."""
    n = len(axial)
    c = -bend / (h * h * drag_ratio)
    for i in range(n):
        # across(z) at the nodes i − 1, i, i + 1: before * z of the node before, own * its own, after * the next
        own = -2 * c + tension[i] / drag_ratio
        after = 2 * c if i == 0 else c
        own_next = -2 * c + tension[i + 1] / drag_ratio
        before_next = 2 * c if i == n - 1 else c
        push = axial[i] / (2 * h)
        if i == 0:
            rows[2, 0, 0] = a - 2 * (before_next - own) / h**2 - 2 * push
            rows[3, 0, 0] = -2 * (own_next - after) / h**2 - 2 * push
            rows[4, 0, 0] = -2 * c / h**2
            continue
        own_last = -2 * c + tension[i - 1] / drag_ratio
        after_last = 2 * c if i == 1 else c
        pull = axial[i - 1] / (2 * h)
        rows[0, 0, i] = -c / h**2
        rows[1, 0, i] = -(own_last - 2 * c) / h**2 + pull
        rows[2, 0, i] = a - (after_last - 2 * own + before_next) / h**2 - push + pull
        rows[3, 0, i] = -(own_next - 2 * after) / h**2 - push
        rows[4, 0, i] = -c / h**2


@compiled
def fill_flagella(activity, axial, relaxation, diffusion, a, h, rows):
    """Rows of τf a + f u0 − D ∂² at the nodes 1 to n; f is odd at the middle, and even beyond the end."""
    n = len(axial)
    spread = diffusion / h**2
    for j in range(n):
        flow = (axial[j] + axial[j + 1]) / 2 if j < n - 1 else axial[j]
        rows[0, 0, j] = -2 * spread if j == n - 1 else -spread
        rows[1, 0, j] = relaxation * a + activity[j + 1] * flow + 2 * spread
        rows[2, 0, j] = -spread


@compiled
def advance(y, before, dt, steps, bend, drag_ratio, relaxation, diffusion):
    """Equal steps from y, with ``before`` a step earlier; both are replaced."""
    n = len(y) // 2
    h, a = 0.5 / n, 1.5 / dt
    curvature, activity, tension, axial = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1), np.empty(n)
    rows, right, found = np.empty((5, 1, n)), np.empty((1, n)), np.empty((1, n))
    first, second = np.empty(n), np.empty(n)
    for _ in range(steps):
        star = 2 * y - before
        rate = rates(star, bend, drag_ratio, relaxation, diffusion, tension, False) - (y - before) / dt
        before[:] = y
        unpack(star, curvature, activity)
        for i in range(n):
            push = bend * (curvature[i + 1] ** 2 - curvature[i] ** 2) / (2 * h) + (activity[i] + activity[i + 1]) / 2
            axial[i] = (tension[i + 1] - tension[i]) / h + push
        fill_bending(tension, axial, bend, drag_ratio, a, h, rows)
        right[0] = rate[::2]
        pentadiagonal(rows, right, first, second, found)
        y[::2] = star[::2] + found[0]
        fill_flagella(activity, axial, relaxation, diffusion, a, h, rows)
        right[0] = relaxation * rate[1::2]
        tridiagonal(rows, right, first, second, found)
        y[1::2] = star[1::2] + found[0]


def solve(swimmer: Swimmer, start: np.ndarray, times: np.ndarray, dt: float) -> np.ndarray:
    """κ [time, node] of the half rod at ``times``, multiples of the step; the first step is many short ones."""
    parts = 64
    y, before = start.copy(), start - dt / parts * rates(start, *swimmer, np.empty(len(start) // 2 + 1), False)
    advance(y, before, dt / parts, parts, *swimmer)
    before[:] = start
    found, done = [], 1
    for number in np.round(np.asarray(times) / dt).astype(int):
        advance(y, before, dt, number - done, *swimmer)
        done = number
        found.append(np.append(y[::2], 0.0))
    return np.array(found)
