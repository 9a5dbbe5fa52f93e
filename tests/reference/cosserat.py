"""One extensible and shearable rod in NumPy, written from docs/model.md §10: dense matrices, series, SciPy.

A screw is (θ, μ), angular part first; so are strains (Ω, U), stresses (m, n) and velocities (ω, u), in the frame.
"""

import itertools
from dataclasses import dataclass
from math import factorial

import numpy as np
from scipy.linalg import expm, solve
from scipy.spatial.transform import Rotation
from scipy.special import bernoulli

from reference.lie import ad_matrix, frame_matrix, hat, twist_matrix

TERMS = 40
BERNOULLI = [value / factorial(k) for k, value in enumerate(bernoulli(TERMS))]


@dataclass(frozen=True)
class Rod:
    """Stiffness [6, 6], natural strain [node − 1, 6], drag [6] with zeros across the tangent for ω, ends."""

    stiffness: np.ndarray
    natural: np.ndarray
    drag: np.ndarray
    ends: tuple[str, str] = ("free", "free")

    @property
    def spacing(self) -> float:
        return 1 / len(self.natural)

    @property
    def weights(self) -> np.ndarray:
        """Of the trapezoid rule [node]."""
        w = np.full(len(self.natural) + 1, self.spacing)
        w[[0, -1]] /= 2
        return w

    @property
    def moves(self) -> np.ndarray:
        """Which components of each node may move [node, 6]."""
        free = np.ones((len(self.natural) + 1, 6), bool)
        for node, end in zip((0, -1), self.ends, strict=True):
            free[node] = {"free": [1] * 6, "hinged": [1, 1, 1, 0, 0, 0], "clamped": [0] * 6}[end]
        return free


def ad(x: np.ndarray) -> np.ndarray:
    return ad_matrix(x[:3], x[3:])


def exp(x: np.ndarray) -> np.ndarray:
    return expm(twist_matrix(x[:3], x[3:]))


def log(S: np.ndarray) -> np.ndarray:
    theta = Rotation.from_matrix(S[:3, :3]).as_rotvec()
    return np.concatenate([theta, _series(hat(theta)) @ S[:3, 3]])


def _series(x: np.ndarray) -> np.ndarray:
    """Σ B_k x^k/k!, B_1 = −1/2: x/(eˣ − 1)."""
    total, power = np.zeros_like(x), np.eye(len(x))
    for coefficient in BERNOULLI:
        total, power = total + coefficient * power, power @ x
    return total


def left(x: np.ndarray) -> np.ndarray:
    """log(exp(−δ) exp x) = x − left(x) δ."""
    return _series(ad(x))


def right(x: np.ndarray) -> np.ndarray:
    """log(exp(x) exp δ) = x + right(x) δ."""
    return left(-x)


def screws(S: np.ndarray) -> np.ndarray:
    """X [node − 1, 6] from frames [node, 4, 4]."""
    return np.array([log(np.linalg.solve(a, b)) for a, b in itertools.pairwise(S)])


def stress(rod: Rod, S: np.ndarray) -> np.ndarray:
    """(m, n) [node − 1, 6]."""
    return (screws(S) / rod.spacing - rod.natural) @ rod.stiffness


def energy(rod: Rod, S: np.ndarray) -> float:
    excess = screws(S) / rod.spacing - rod.natural
    return 0.5 * rod.spacing * float(np.einsum("ni,ij,nj->", excess, rod.stiffness, excess))


def elastic_force(rod: Rod, S: np.ndarray, P: np.ndarray | None = None) -> np.ndarray:
    """Minus the gradient of the energy [node, 6]."""
    P = stress(rod, S) if P is None else P
    found = np.zeros((len(S), 6))
    for e, x in enumerate(screws(S)):
        found[e] += left(x).T @ P[e]
        found[e + 1] -= right(x).T @ P[e]
    return found


def geometric(P: np.ndarray) -> np.ndarray:
    """The matrix of X ↦ adᵀ_X P."""
    m, n = hat(P[:3]), hat(P[3:])
    return np.block([[m, n], [n, np.zeros((3, 3))]])


def jacobian(rod: Rod, S: np.ndarray, P: np.ndarray) -> np.ndarray:
    """Minus the derivative of the elastic force [6 node, 6 node], of the geometric part the leading order in Δs."""
    size = 6 * len(S)
    found = np.zeros((size, size))
    for e, x in enumerate(screws(S)):
        first, second = slice(6 * e, 6 * e + 6), slice(6 * e + 6, 6 * e + 12)
        rows = -left(x).T @ rod.stiffness / rod.spacing, right(x).T @ rod.stiffness / rod.spacing
        for at, row in zip((first, second), rows, strict=True):
            row = row + 0.5 * geometric(P[e])
            found[at, first] -= row @ left(x)
            found[at, second] += row @ right(x)
    return found


def load_in_frame(S: np.ndarray, couple: np.ndarray, force: np.ndarray) -> np.ndarray:
    """(couple, force) per length in the frames [node, 6] of those in space [node, 3]."""
    return np.concatenate([np.einsum("nij,ni->nj", S[:, :3, :3], v) for v in (couple, force)], axis=1)


def step(rod: Rod, S, past, stresses, times, end, couple, force):
    """Frames, screws and stress after a step to ``end``.

    past: screws of the steps before, newest first; stresses: of the levels, newest first; times: of the levels.
    """
    order = min(len(times), 2)
    a = sum(1 / (end - t) for t in times[:order])
    share = (end - times[0]) / (times[0] - times[1]) if order == 2 else 0.0
    e1 = -share
    d1 = e1 * (a - 1 / (end - times[1])) if order == 2 else 0.0
    last = past[0] if past else np.zeros((len(S), 6))
    foretold = -e1 * last
    star = np.array([frame @ exp(y) for frame, y in zip(S, foretold, strict=True)])
    now, before = stresses[0], stresses[1] if order == 2 else stresses[0]
    weights = rod.weights[:, None]
    rhs = weights * (load_in_frame(star, couple, force) + d1 * rod.drag * last) + elastic_force(rod, star)
    matrix = np.diag((a * weights * rod.drag).ravel()) + jacobian(rod, star, now + share * (now - before))
    delta, moves = np.zeros(rhs.size), rod.moves.ravel()
    delta[moves] = solve(matrix[np.ix_(moves, moves)], rhs.ravel()[moves])
    delta = delta.reshape(-1, 6)
    P = stress(rod, star)
    for e, x in enumerate(screws(star)):
        P[e] += rod.stiffness @ (right(x) @ delta[e + 1] - left(x) @ delta[e]) / rod.spacing
    after = np.array([frame @ exp(d) for frame, d in zip(star, delta, strict=True)])
    moved = np.array([y + d + 0.5 * ad(y) @ d for y, d in zip(foretold, delta, strict=True)])
    return after, moved, P


def rates(rod: Rod, S: np.ndarray, couple: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Velocities [node, 6] of the rod discretised in s: those with drag from the balance, the others from its change.

    The balance of moments across the tangent, where there is no drag, must hold in S; ω there keeps it so.
    """
    weights, moves = rod.weights[:, None], rod.moves
    total = weights * load_in_frame(S, couple, force) + elastic_force(rod, S)
    v = np.divide(total, weights * rod.drag, out=np.zeros_like(total), where=(rod.drag > 0) & moves)
    slow = (np.broadcast_to(rod.drag == 0, v.shape) & moves).ravel()
    h, shape = 1e-6, v.shape

    def change(velocity):
        """d/dt of the balance, by central differences along a motion."""

        def at(t):
            moved = np.array([frame @ exp(t * u) for frame, u in zip(S, velocity.reshape(shape), strict=True)])
            return (weights * load_in_frame(moved, couple, force) + elastic_force(rod, moved)).ravel()[slow]

        return (at(h) - at(-h)) / (2 * h)

    matrix = np.array([change(column) for column in np.eye(v.size)[slow]]).T
    free = v.ravel().copy()
    free[slow] = solve(matrix, -change(v))
    return free.reshape(shape)


def balance_moments(rod: Rod, S: np.ndarray, couple: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Frames turned until moments across the tangent balance, by Newton's method."""
    for _ in range(30):
        total = rod.weights[:, None] * load_in_frame(S, couple, force) + elastic_force(rod, S)
        slow = (np.broadcast_to(rod.drag == 0, total.shape) & rod.moves).ravel()
        delta = np.zeros(total.size)
        delta[slow] = solve(jacobian(rod, S, stress(rod, S))[np.ix_(slow, slow)], total.ravel()[slow])
        S = np.array([frame @ exp(d) for frame, d in zip(S, delta.reshape(-1, 6), strict=True)])
        if abs(delta).max() < 1e-15:
            break
    return S


def lay_out(strain: np.ndarray, spacing: float, first: np.ndarray | None = None) -> np.ndarray:
    """Frames [node, 4, 4] with strains [node − 1, 6] between them."""
    S = [frame_matrix(np.eye(3), np.zeros(3)) if first is None else first]
    for x in strain:
        S.append(S[-1] @ exp(spacing * x))
    return np.array(S)
