"""A swimmer in space as a user of SciPy would write it: NumPy, a dense Jacobian by differences (docs/model.md §2.3)."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import solve_banded

from warp_rods.bench.peers.planar import Swimmer

TWIST, ROLL = 1e-3, 3e-3
"""Twist stiffness β∥ and rotational drag ηr."""


def split(y: np.ndarray, nodes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """k (complex), τ and f at the nodes; k and τ are 0 at the ends."""
    inner = nodes - 2
    parts = np.pad(y[: 3 * inner].reshape(3, inner), ((0, 0), (1, 1)))
    return parts[0] + 1j * parts[1], parts[2], y[3 * inner :]


def joined(k: np.ndarray, twist: np.ndarray, activity: np.ndarray) -> np.ndarray:
    """Unknowns of k, τ, f."""
    return np.concatenate([k.real[1:-1], k.imag[1:-1], twist[1:-1], activity])


def middle(x: np.ndarray) -> np.ndarray:
    return (x[1:] + x[:-1]) / 2


def to_nodes(x: np.ndarray, sign: int) -> np.ndarray:
    """Values at half nodes, continued beyond the ends with this parity."""
    return np.concatenate([[sign * x[0]], x, [sign * x[-1]]])


def rates(y: np.ndarray, swimmer: Swimmer, nodes: int) -> np.ndarray:
    """dy/dt of the unknowns of one rod without active moment."""
    bend, eta, relaxation, diffusion = swimmer
    h = 1 / (nodes - 1)
    k, twist, f = split(y, nodes)
    shear = 1j * bend * np.diff(k) / h + TWIST * middle(twist) * middle(k)
    loose = np.diff(to_nodes(shear, -1)) / h / eta
    push = bend / 2 * np.diff(np.abs(k) ** 2) / h + middle(f)
    bands = np.full((3, nodes - 2), -1 / h**2)
    bands[1] = 2 / h**2 + np.abs(k[1:-1]) ** 2 / eta
    right = np.diff(push) / h + (k.conj() * loose).imag[1:-1]
    tension = np.pad(solve_banded((1, 1), bands, right), 1)
    along = np.diff(tension) / h + push
    across = loose - 1j * tension * k / eta
    spin = 1j * np.diff(across) / h + along * middle(k)
    turned = (middle(k).conj() * spin).imag
    frame = -h * np.concatenate([[0.0], np.cumsum(turned)])
    frame -= frame[nodes // 2]
    roll = TWIST * np.diff(twist) / h / ROLL
    k_rate = np.pad(np.diff(spin) / h, 1) - 1j * frame * k
    twist_rate = np.pad(np.diff(roll) / h + middle(turned), 1)
    spread = diffusion * np.diff(to_nodes(np.diff(f) / h, -1)) / h
    f_rate = ((1 - f**2) * middle(to_nodes(along, 1)) + spread) / relaxation
    return joined(k_rate, twist_rate, f_rate)


def solve(
    swimmer: Swimmer, curvature: np.ndarray, activity: np.ndarray, times: np.ndarray, method: str, tolerance: float
) -> np.ndarray:
    """κ [time, node] of a rod that starts in a plane, by a method of ``solve_ivp``."""
    nodes = len(curvature)
    start = joined(1j * curvature, np.zeros(nodes), activity)
    found = solve_ivp(
        lambda _t, y: rates(y, swimmer, nodes), (0.0, times[-1]), start, method, t_eval=times, rtol=tolerance,
        atol=0.1 * tolerance,
    )  # fmt: skip
    if not found.success:
        raise ArithmeticError(found.message)
    return np.array([split(y, nodes)[0].imag for y in found.y.T])
