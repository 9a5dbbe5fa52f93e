"""One surface-bound filament in NumPy, written directly from the equations (docs/model.md §3; 5.24–5.42, D.2–D.4).

One rod at a time, arrays [node] or [node, 3]; u1 in ``along`` is at half nodes. Frame (q, n×q, n).
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import bmat, csr_array, diags_array, eye_array
from scipy.sparse.linalg import spsolve

from reference.symbolic_surface import SymbolicSurface


@dataclass
class Rod:
    """Parameters: surface, Δs; B, σ, ζ [3] or [node, 3]."""

    surface: SymbolicSurface
    spacing: float
    stiffness: np.ndarray
    intrinsic: np.ndarray
    drag: np.ndarray


@dataclass
class State:
    """Ω [node], frames [node, 3, 3] and positions [node, 3]."""

    geodesic: np.ndarray
    rotation: np.ndarray
    position: np.ndarray


@dataclass
class Motion:
    """The result of the force balance for one state; see ``evaluate``."""

    curvature: np.ndarray
    moment: np.ndarray
    transverse_force: np.ndarray
    tension: np.ndarray
    along: np.ndarray  # u1, half nodes
    velocity: np.ndarray  # u at nodes, frame
    spin: np.ndarray  # ω at nodes, frame
    rate: np.ndarray


# --- formulas at one point of a filament, discrete or continuous ------------------------------


def strain(K, geodesic):
    """(K12, −K11, Ω) (D.14), (D.15)."""
    return np.stack([K[..., 1], -K[..., 0], geodesic], -1)


def shear(K, m):
    """K11 m1 + K12 m2, whose slope enters (5.42)."""
    return K[..., 0] * m[..., 0] + K[..., 1] * m[..., 1]


def gaussian(K):
    """𝒦 = det K (D.18)."""
    return K[..., 0] * K[..., 2] - K[..., 1] ** 2


def tangential_force(turns, dm, f1):
    """Y1 = F1 − λ' of (5.41)."""
    return np.sum(turns * dm, -1) + f1


def transverse_force(K, geodesic, m, dm, ddm3, dshear, f2):
    """Y2 = F2 − Ωλ of (5.42); dm, ddm3, dshear: derivatives along s."""
    K12, K22 = K[..., 1], K[..., 2]
    bending = -ddm3 - (K12 * m[..., 0] + K22 * m[..., 1]) * geodesic - gaussian(K) * m[..., 2]
    return bending - dshear - K12 * dm[..., 1] + K22 * dm[..., 0] + f2


def end_slope(K, m):
    """m3' at a free end (D.60)."""
    return -2 * K[..., 1] * m[..., 1] - (K[..., 0] - K[..., 2]) * m[..., 0]


def end_tension(K, m):
    """λ at a free end (D.61)."""
    return K[..., 0] * m[..., 1] - K[..., 1] * m[..., 0]


def internal_force(turns, m, dm, tension):
    """λ e0 + e0×(m' + Ω×m) (D.28)."""
    e0 = np.array([1.0, 0.0, 0.0])
    return tension[..., None] * e0 + np.cross(e0, dm + np.cross(turns, m))


# --- the semi-discrete filament ----------------------------------------------------------------------------------


def slope(f, h):
    """f' at nodes: central differences, three points at the ends."""
    return np.gradient(f, h, axis=0, edge_order=2)


def with_end_slopes(f, first, last, h):
    """f'' at nodes, with ghost nodes such that f' has its known values at the ends."""
    padded = np.concatenate([[f[1] - 2 * h * first], f, [f[-2] + 2 * h * last]])
    return np.diff(padded, 2) / h**2


def middle(f):
    """Values at half nodes."""
    return (f[1:] + f[:-1]) / 2


def body(state, vectors):
    """Components of vectors [node, 3] in the frame."""
    return np.einsum("nij,ni->nj", state.rotation, vectors)


def resistance(K, drag):
    """Z11, Z12, Z22."""
    along, across, turn = np.moveaxis(drag, -1, 0)
    return along + turn * K[:, 1] ** 2, turn * K[:, 1] * K[:, 2], across + turn * K[:, 2] ** 2


def at_half_nodes(values):
    """Values [half node, 3] of a parameter [node, 3]; one that is uniform as it is."""
    return middle(values) if np.ndim(values) == 2 else values


def at_nodes(geodesic, h):
    """Matrices from u1 at half nodes and u2 at nodes to u1 at nodes; u1' = Ω u2 over half a spacing at an end."""
    nodes = len(geodesic)
    average = diags_array([0.5, 0.5], offsets=[-1, 0], shape=(nodes, nodes - 1)).tolil()
    average[0, 0] = average[-1, -1] = 1.0
    turn = np.zeros(nodes)
    turn[0], turn[-1] = -h / 2 * geodesic[0], h / 2 * geodesic[-1]
    return csr_array(average), diags_array(turn)


def balance(rod, K, geodesic, Y1, Y2, end_tensions):
    """λ, u1 and u2 from the two balances and u1' = Ω u2 as one sparse system.

    Unknowns: λ at nodes, u1 at half nodes, u2 at half nodes (for the first balance), u2 at nodes.
    """
    nodes, h = len(geodesic), rod.spacing
    turn = diags_array(geodesic)
    mean = diags_array([0.5, 0.5], offsets=[0, 1], shape=(nodes - 1, nodes))
    change = diags_array([-1 / h, 1 / h], offsets=[0, 1], shape=(nodes - 1, nodes))
    inner = eye_array(nodes).tocsr()[1:-1]
    ends = eye_array(nodes).tocsr()[[0, -1]]
    X11, X12, X22 = (diags_array(z) for z in resistance(middle(K), at_half_nodes(rod.drag)))
    _, Z12, Z22 = (diags_array(z) for z in resistance(K, rod.drag))
    from_half, from_node = at_nodes(geodesic, h)
    stretch = diags_array([-1 / h, 1 / h], offsets=[0, 1], shape=(nodes - 2, nodes - 1))
    matrix = bmat(
        [
            [-change, X11, X12, None],
            [-mean @ turn, X12, X22, None],
            [-turn, Z12 @ from_half, None, Z22 + Z12 @ from_node],
            [None, stretch, None, -inner @ turn],
            [ends, None, None, None],
        ]
    )
    right = np.concatenate([Y1, middle(Y2), Y2, np.zeros(nodes - 2), end_tensions])
    tension, along, _, across = np.split(spsolve(matrix.tocsc(), right), np.cumsum([nodes, nodes - 1, nodes - 1]))
    return tension, along, across, from_half @ along + from_node @ across


def moments(rod, K, geodesic):
    """m = B(Ω − σ)."""
    return rod.stiffness * (strain(K, geodesic) - rod.intrinsic)


def evaluate(rod, state, force):
    """Velocities and ∂Ω/∂t of a state under a force per length in space [node, 3]; both ends free."""
    h, geodesic = rod.spacing, state.geodesic
    K = rod.surface.curvature(state.position, state.rotation[:, :, 0])
    m, f = moments(rod, K, geodesic), body(state, force)
    dm = slope(m, h)
    ddm3 = with_end_slopes(m[:, 2], end_slope(K[0], m[0]), end_slope(K[-1], m[-1]), h)
    Y1 = tangential_force(middle(strain(K, geodesic)), np.diff(m, axis=0) / h, middle(f[:, 0]))
    Y2 = transverse_force(K, geodesic, m, dm, ddm3, slope(shear(K, m), h), f[:, 1])
    tension, along, u2, u1 = balance(rod, K, geodesic, Y1, Y2, end_tension(K[[0, -1]], m[[0, -1]]))
    spin = np.stack([K[:, 1] * u1 + K[:, 2] * u2, -K[:, 0] * u1 - K[:, 1] * u2, slope(u2, h) + geodesic * u1], -1)
    rate = np.zeros_like(geodesic)
    inner = slice(1, -1)
    swing = (geodesic**2 + gaussian(K)) * u2 + slope(geodesic, h) * u1
    rate[inner] = np.diff(u2, 2) / h**2 + swing[inner]
    return Motion(K, m, Y2, tension, along, np.stack([u1, u2, np.zeros_like(u1)], -1), spin, rate)


def total(density, h):
    """Integral along the rod; trapezoid rule."""
    return np.trapezoid(density, dx=h, axis=0)


def energy_density(rod, state, motion):
    """½ Σ B (Ω − σ)² (5.29)."""
    return np.sum(rod.stiffness * (strain(motion.curvature, state.geodesic) - rod.intrinsic) ** 2, -1) / 2


def dissipation(rod, motion):
    """∫ ζ∥ u1² + ζ⊥ u2² + ζr ω0² ds."""
    u = np.stack([motion.velocity[:, 0], motion.velocity[:, 1], motion.spin[:, 0]], -1)
    return total(np.sum(u**2 * rod.drag, -1), rod.spacing)


def membrane_load(rod, state, motion, force):
    """ν e3 + χ Rᵀ∇nR e2 of (5.31), (5.32), in space [node, 3]: the load of the filament on the membrane."""
    h, K, m = rod.spacing, motion.curvature, motion.moment
    turns, dm = strain(K, state.geodesic), slope(m, h)
    chi = (dm + np.cross(turns, m))[:, 0] - rod.drag[..., 2] * motion.spin[:, 0]
    inner = internal_force(turns, m, dm, motion.tension)
    nu = (slope(inner, h) + np.cross(turns, inner) + body(state, force))[:, 2]
    return np.einsum("nij,nj->ni", state.rotation, np.stack([-chi * K[:, 1], -chi * K[:, 2], nu], -1))
