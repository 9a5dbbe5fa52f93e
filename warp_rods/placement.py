"""Where filaments start: uniform in area and isotropic in angle, without overlap."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from warp_rods.errors import SceneError
from warp_rods.surfaces import Surface

LINES = 500
SAMPLES = 256
"""Points on each line at which the sign of φ is looked at."""
ROUNDS = 200
"""Times that filaments in the way of others are drawn again before giving up."""


def uniform_points(surface: Surface, count: int, rng: np.random.Generator) -> np.ndarray:
    """Points [count, 3] on the surface (of an open one: on the patch in its box), uniform in area.

    Crofton: straight lines, isotropic and uniform in offset, meet every piece of surface in proportion to its
    area. Raises SceneError where lines through the box find no surface.
    """
    found: list[np.ndarray] = []
    wanted = 4 * count  # drawn from more, so that points of one line seldom meet again
    while sum(map(len, found)) < wanted:
        points = _crossings(surface, LINES, rng)
        found.append(points)
        if len(found) == 10 and not sum(map(len, found)):
            low, high = surface.box
            raise SceneError(f"surface: no point of φ = 0 was found in its box {low.tolist()} to {high.tolist()}")
    return rng.choice(np.concatenate(found), size=count, replace=False)


def _crossings(surface: Surface, lines: int, rng: np.random.Generator) -> np.ndarray:
    """Where random lines cross φ = 0 inside the box [n, 3]."""
    low, high = surface.box
    centre, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    d = _unit(rng.normal(size=(lines, 3)))
    e1, e2 = _normals(d)
    rho, angle = radius * np.sqrt(rng.uniform(size=lines)), rng.uniform(0, 2 * np.pi, size=lines)
    foot = centre + rho[:, None] * (np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2)
    t = np.linspace(-radius, radius, SAMPLES)
    positive = surface.phi(foot[:, None] + t[:, None] * d[:, None]) > 0
    line, cell = np.nonzero(positive[:, 1:] != positive[:, :-1])
    a, b, outside = t[cell], t[cell + 1], positive[line, cell + 1]
    for _ in range(50):
        middle = (a + b) / 2
        beyond = (surface.phi(foot[line] + middle[:, None] * d[line]) > 0) == outside
        a, b = np.where(beyond, a, middle), np.where(beyond, middle, b)
    points = foot[line] + a[:, None] * d[line]
    return points[((points >= low) & (points <= high)).all(axis=1)]


def isotropic_directions(surface: Surface, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Unit tangents [count, 3] at points on the surface, isotropic in the tangent plane."""
    e1, e2 = _normals(surface.normal(points))
    angle = rng.uniform(0, 2 * np.pi, size=(len(points), 1))
    return np.cos(angle) * e1 + np.sin(angle) * e2


def without_overlap(
    surface: Surface,
    count: int,
    clearance: float,
    others: np.ndarray,
    centre_lines: Callable[[np.ndarray, np.ndarray], np.ndarray],
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray, int]:
    """Midpoints and tangents [count, 3] of filaments that keep ``clearance`` from each other and from ``others``.

    ``centre_lines(position, direction)`` [rod, node, 3] lays filaments out; those in the way are drawn again.
    Returns with them how often that happened. Raises SceneError where they do not fit.
    """
    taken = others.reshape(-1, 3)
    kept_r, kept_q = np.empty((0, 3)), np.empty((0, 3))
    redrawn = 0
    for _ in range(ROUNDS):
        r = uniform_points(surface, count - len(kept_r), rng)
        q = isotropic_directions(surface, r, rng)
        lines = centre_lines(r, q)
        good = _apart(lines, taken, clearance)
        taken = np.concatenate([taken, lines[good].reshape(-1, 3)])
        redrawn += len(r) - len(good)
        kept_r, kept_q = np.concatenate([kept_r, r[good]]), np.concatenate([kept_q, q[good]])
        if len(kept_r) == count:
            return kept_r, kept_q, redrawn
    raise SceneError(f"count = {count}: after {redrawn} draws only {len(kept_r)} fit {clearance:g} apart; place fewer")


def _apart(lines: np.ndarray, taken: np.ndarray, clearance: float) -> list[int]:
    """Which of the centre lines [rod, node, 3], taken in turn, keep the clearance from ``taken`` and those before."""
    nodes = lines.shape[1]
    tree = cKDTree(lines.reshape(-1, 3))
    free = np.ones(len(lines), dtype=bool)
    if len(taken):
        near = cKDTree(taken).query(tree.data, distance_upper_bound=clearance)[0] < clearance
        free = ~near.reshape(len(lines), nodes).any(axis=1)
    pairs = np.unique(np.sort(tree.query_pairs(clearance, output_type="ndarray") // nodes, axis=1), axis=0)
    rivals: dict[int, list[int]] = {}
    for first, second in pairs[pairs[:, 0] != pairs[:, 1]]:
        rivals.setdefault(int(second), []).append(int(first))
    for rod in range(len(lines)):
        free[rod] &= not any(free[other] for other in rivals.get(rod, ()))
    return np.flatnonzero(free).tolist()


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _normals(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors [n, 3] across each unit vector d [n, 3]."""
    e1 = _unit(np.cross(d, np.eye(3)[np.argmin(np.abs(d), axis=-1)]))
    return e1, np.cross(d, e1)
