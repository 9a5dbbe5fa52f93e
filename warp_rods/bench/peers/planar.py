"""The planar swimmer as an expert of SciPy would write it: one half of the rod, compiled right side.

The equations and stencils of docs/model.md §2.3 with k = iκ, and κ, λ, u⊥ even and f, u0 odd in s. Nodes 0 (the middle)
to n (the end); unknowns κ_0, f_1, κ_1, f_2, … κ_{n−1}, f_n, as κ_n = f_0 = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import dia_array

from warp_rods.bench.peers.optional import compiled

WIDTH = 4
"""Unknowns on each side that a rate depends on, where the tension is given."""
BUMP = 1e-7


class Swimmer(NamedTuple):
    """β⊥, η, τf, D and the number of nodes of the half rod besides the middle one."""

    bend: float
    drag_ratio: float = 2.0
    relaxation: float = 1e-2
    diffusion: float = 1e-3


@compiled
def unpack(y, curvature, activity):
    """Fill κ [n + 1] and f [n + 1] from the unknowns."""
    n = len(y) // 2
    for i in range(n):
        curvature[i] = y[2 * i]
        activity[i + 1] = y[2 * i + 1]
    curvature[n] = 0.0
    activity[0] = 0.0


@compiled
def tension_of(curvature, across, axial, drag_ratio, h, tension):
    """λ from (4.24): −λ'' + κ²λ/η = S0' − κ S⊥, by elimination from the middle outwards; λ = 0 at the end."""
    n = len(curvature) - 1
    upper = np.empty(n)
    for i in range(n):
        before = -axial[0] if i == 0 else axial[i - 1]
        right = (axial[i] - before) * h - curvature[i] * across[i] * h * h
        diagonal = 2.0 + curvature[i] ** 2 * h * h / drag_ratio
        if i == 0:
            upper[0] = 2.0 / diagonal
            tension[0] = right / diagonal
        else:
            diagonal -= upper[i - 1]
            upper[i] = 1.0 / diagonal
            tension[i] = (right + tension[i - 1]) / diagonal
    tension[n] = 0.0
    for i in range(n - 1, -1, -1):
        tension[i] += upper[i] * tension[i + 1]


@compiled
def rates(y, bend, drag_ratio, relaxation, diffusion, tension, given):
    """dy/dt; the tension [n + 1] is written, or taken as it is if it is ``given``."""
    n = len(y) // 2
    h = 0.5 / n
    curvature, activity = np.empty(n + 1), np.empty(n + 1)
    unpack(y, curvature, activity)
    across, axial, turning = np.empty(n + 1), np.empty(n), np.empty(n)
    last = 0.0
    for i in range(n):
        force = -bend * (curvature[i + 1] - curvature[i]) / h
        across[i] = (force + force if i == 0 else force - last) / (h * drag_ratio)
        axial[i] = bend * (curvature[i + 1] ** 2 - curvature[i] ** 2) / (2 * h) + (activity[i] + activity[i + 1]) / 2
        last = force
    across[n] = -2.0 * last / (h * drag_ratio)
    if not given:
        tension_of(curvature, across, axial, drag_ratio, h, tension)
    for i in range(n + 1):
        across[i] += tension[i] * curvature[i] / drag_ratio
    for i in range(n):
        axial[i] += (tension[i + 1] - tension[i]) / h
        turning[i] = (across[i + 1] - across[i]) / h + axial[i] * (curvature[i] + curvature[i + 1]) / 2
    found = np.empty(2 * n)
    for i in range(n):
        found[2 * i] = (2.0 * turning[0] if i == 0 else turning[i] - turning[i - 1]) / h
        j = i + 1
        f, inner, outer = activity[j], activity[j - 1], activity[j + 1] if j < n else activity[j - 1]
        flow = (axial[j - 1] + axial[j]) / 2 if j < n else axial[n - 1]
        found[2 * i + 1] = ((1.0 - f * f) * flow + diffusion * (outer - 2.0 * f + inner) / h**2) / relaxation
    return found


@compiled
def dense_jacobian(y, bend, drag_ratio, relaxation, diffusion):
    """∂(dy/dt)/∂y by differences, one column after the other."""
    tension = np.empty(len(y) // 2 + 1)
    start = rates(y, bend, drag_ratio, relaxation, diffusion, tension, False)
    found = np.empty((len(y), len(y)))
    near = y.copy()
    for j in range(len(y)):
        step = BUMP * max(1.0, abs(y[j]))
        near[j] = y[j] + step
        found[:, j] = (rates(near, bend, drag_ratio, relaxation, diffusion, tension, False) - start) / step
        near[j] = y[j]
    return found


@compiled
def banded_jacobian(y, bend, drag_ratio, relaxation, diffusion):
    """The same at given tension, packed as LAPACK does, [2 WIDTH + 1, unknown]; 2 WIDTH + 1 columns at a time."""
    tension = np.empty(len(y) // 2 + 1)
    start = rates(y, bend, drag_ratio, relaxation, diffusion, tension, False)
    found = np.zeros((2 * WIDTH + 1, len(y)))
    for colour in range(2 * WIDTH + 1):
        near = y.copy()
        for j in range(colour, len(y), 2 * WIDTH + 1):
            near[j] += BUMP
        change = (rates(near, bend, drag_ratio, relaxation, diffusion, tension, True) - start) / BUMP
        for j in range(colour, len(y), 2 * WIDTH + 1):
            for i in range(max(0, j - WIDTH), min(len(y), j + WIDTH + 1)):
                found[WIDTH + i - j, j] = change[i]
    return found


def right_side(swimmer: Swimmer, half: int) -> Callable[[float, np.ndarray], np.ndarray]:
    """dy/dt as SciPy calls it."""
    tension = np.empty(half + 1)
    return lambda _t, y: rates(y, *swimmer, tension, False)


def dense(swimmer: Swimmer) -> dict[str, Any]:
    """Options of ``solve_ivp`` with the whole Jacobian."""
    return {"jac": lambda _t, y: dense_jacobian(y, *swimmer)}


def sparse(swimmer: Swimmer) -> dict[str, Any]:
    """Options with the banded part as a sparse matrix."""

    def jacobian(_t: float, y: np.ndarray) -> Any:
        packed = banded_jacobian(y, *swimmer)
        return dia_array((packed, np.arange(WIDTH, -WIDTH - 1, -1)), shape=(len(y), len(y))).tocsc()

    return {"jac": jacobian}


def banded(swimmer: Swimmer) -> dict[str, Any]:
    """Options with the banded part as LSODA takes it."""
    return {"jac": lambda _t, y: banded_jacobian(y, *swimmer), "lband": WIDTH, "uband": WIDTH}


METHODS: dict[str, tuple[str, Callable[[Swimmer], dict[str, Any]]]] = {
    "BDF, dense": ("BDF", dense),
    "BDF, banded": ("BDF", sparse),
    "Radau, dense": ("Radau", dense),
    "LSODA, banded": ("LSODA", banded),
}
"""Name → method of ``solve_ivp`` and how it is given the Jacobian."""


def packed(curvature: np.ndarray, activity: np.ndarray) -> np.ndarray:
    """Unknowns from κ and f at the nodes from the middle to the end."""
    return np.stack([curvature[:-1], activity[1:]], axis=1).ravel()


def solve(
    swimmer: Swimmer, start: np.ndarray, times: np.ndarray, method: str, tolerance: float, least: float = 0.1
) -> np.ndarray:
    """κ [time, node] from the middle to the end, by one of ``METHODS``; relative and ``least`` times that absolute."""
    name, options = METHODS[method]
    found = solve_ivp(
        right_side(swimmer, len(start) // 2), (0.0, times[-1]), start, name, t_eval=times, rtol=tolerance,
        atol=least * tolerance, **options(swimmer),
    )  # fmt: skip
    if not found.success:
        raise ArithmeticError(found.message)
    return np.pad(found.y[::2].T, ((0, 0), (0, 1)))
