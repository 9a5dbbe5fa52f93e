"""Times at which two segments pass through each other while their ends move linearly from time 0 to time 1.

Pairs of segments are arrays [time, pair, end, 3] at both times; the second segment is the image nearest to the first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

FLAT = 1e-9
"""Two segments stay in one plane where their ends leave it by less than this fraction of their lengths."""
BISECTIONS = 52


class Passes(NamedTuple):
    """Pair and time in (0, 1] of each passage [passage], and its sign: +1 where the Gauss integral increases."""

    pair: np.ndarray
    time: np.ndarray
    sign: np.ndarray


def stay_in_a_plane(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether both segments of a pair stay in one plane, so that there is no single time of passage [pair].

    The plane may be fixed or rotate, or the segments may be parallel. ``meet_in_plane`` treats these pairs.
    """
    a, b, w = first[:, :, 1] - first[:, :, 0], second[:, :, 1] - second[:, :, 0], second[:, :, 0] - first[:, :, 0]
    one, other = (np.linalg.norm(side, axis=-1).max(axis=0) for side in (a, b))
    volumes = np.abs(_bernstein(_volume(a, b, w))).max(axis=0)
    return volumes <= FLAT * one * other * (one + other)


def passes(first: np.ndarray, second: np.ndarray) -> Passes:
    """Every time at which one segment passes through the other.

    The four ends lie in one plane at the roots of the cubic (a × b)·w, where a and b are the segments as vectors and w
    joins their starts. The segments pass where the cubic changes sign and they intersect. A segment includes its start
    but not its end, and a cubic of value zero counts as positive, so that in chains of segments and of times every
    passage counts exactly once.
    """
    a, b, w = first[:, :, 1] - first[:, :, 0], second[:, :, 1] - second[:, :, 0], second[:, :, 0] - first[:, :, 0]
    volume = _volume(a, b, w)
    pair, time, sign = sign_changes(volume, *(_triple(a[i], b[i], w[i]) for i in (0, 1)))
    a, b, w = (side[0, pair] + time[:, None] * (side[1, pair] - side[0, pair]) for side in (a, b, w))
    normal = np.cross(a, b)
    size = np.maximum(np.sum(normal**2, axis=1), np.finfo(float).tiny)
    along = np.stack([np.sum(np.cross(w, side) * normal, axis=1) / size for side in (b, a)])
    meet = np.all((along >= 0) & (along < 1), axis=0)
    return Passes(pair[meet], time[meet], -sign[meet])


def sign_changes(c: np.ndarray, start: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sign changes of cubics Σ c_k t^k, c [4, cubic], in (0, 1]: number of the cubic, time, and +1 (− to +) or −1.

    ``start``, ``end``: their values at 0 and 1 without the round-off of the sum, so that the end of one interval equals
    the start of the next bit by bit.
    """
    control = _bernstein(c)
    some = np.flatnonzero(~(np.all(control > 0, axis=0) & (end >= 0) | np.all(control < 0, axis=0) & (end < 0)))
    c, start, end = c[:, some], start[some], end[some]
    turn = _turning_points(c)
    at = np.stack([np.zeros(len(some)), *turn, np.ones(len(some))])
    positive = np.stack([start, _value(c, turn[0]), _value(c, turn[1]), end]) >= 0
    piece, cubic = np.nonzero(positive[1:] != positive[:-1])
    low, high, rising = at[piece, cubic], at[piece + 1, cubic], positive[piece + 1, cubic]
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        past = (_value(c[:, cubic], middle) >= 0) == rising
        low, high = np.where(past, low, middle), np.where(past, middle, high)
    return some[cubic], high, np.where(rising, 1, -1)


def meet_in_plane(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For pairs that stay in a plane: whether they overlap at time 0, and the first time in (0, 1] of overlap, or inf.

    Overlap begins when an end of one segment reaches the other; at time 1 it is checked directly.
    """
    p, q = _in_plane(first, second)
    time = np.full(p.shape[1], np.inf)
    for one, other in ((p, q), (q, p)):
        for end in (0, 1):
            c = _orientation(other[:, :, 0], other[:, :, 1], one[:, :, end])
            pair, at, _ = sign_changes(c, *(_sides(other[i], one[i][:, [end]])[:, 0] for i in (0, 1)))
            corner, side = (points[0, pair] + at[:, None] * (points[1, pair] - points[0, pair]) for points in
                            (other[:, :, 0], other[:, :, 1] - other[:, :, 0]))  # fmt: skip
            tip = one[0, pair, end] + at[:, None] * (one[1, pair, end] - one[0, pair, end])
            along = np.sum((tip - corner) * side, axis=1) / np.maximum(np.sum(side**2, axis=1), np.finfo(float).tiny)
            on = (along >= 0) & (along <= 1)
            np.minimum.at(time, pair[on], at[on])
    ends = [_overlap(p[i], q[i]) for i in (0, 1)]
    return ends[0], np.where(ends[1], np.minimum(time, 1.0), time)


def _in_plane(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both segments in coordinates of their plane, relative to a common centre [time, pair, end, 2]."""
    at = [np.concatenate([(1 - t) * s[0] + t * s[1] for s in (first, second)], axis=1) for t in (0.0, 0.5, 1.0)]
    edges = [p[:, [1, 3, 2]] - p[:, [0, 2, 0]] for p in at]
    normals = np.concatenate([np.cross(e[:, [0, 0, 1]], e[:, [1, 2, 2]]) for e in edges], axis=1)
    pairs = np.arange(first.shape[1])
    normal = normals[pairs, np.argmax(np.sum(normals**2, axis=2), axis=1)]
    along = first[0, :, 1] - first[0, :, 0]
    # All on one line: use any plane that contains it.
    line = np.sum(normal**2, axis=1) < (FLAT * np.sum(along**2, axis=1)) ** 2
    normal[line] = np.cross(along[line], np.eye(3)[np.argmin(np.abs(along[line]), axis=1)])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), np.finfo(float).tiny)
    across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), np.finfo(float).tiny)
    basis = np.stack([across, np.cross(normal, across)], axis=2)
    centre = first[0].mean(axis=1)[:, None]
    one, other = (np.einsum("tpex,pxy->tpey", s - centre, basis) for s in (first, second))
    return one, other


def _overlap(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Whether segments [pair, end, 2] share a point [pair]."""
    apart = np.any((p.max(axis=1) < q.min(axis=1)) | (q.max(axis=1) < p.min(axis=1)), axis=1)
    both = [np.prod(_sides(one, other), axis=1) <= 0 for one, other in ((p, q), (q, p))]
    return both[0] & both[1] & ~apart


def _sides(segment: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The side of a segment [pair, end, 2] on which points [pair, point, 2] lie, as a sign [pair, point]."""
    side, to = segment[:, 1] - segment[:, 0], points - segment[:, [0]]
    return side[:, None, 0] * to[..., 1] - side[:, None, 1] * to[..., 0]


def _orientation(start: np.ndarray, end: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Coefficients [4, pair] of (end − start) × (point − start), each [time, pair, 2], the last zero."""
    (a, da), (b, db) = ((v[0], v[1] - v[0]) for v in (end - start, point - start))

    def cross(v: np.ndarray, w: np.ndarray) -> np.ndarray:
        return v[:, 0] * w[:, 1] - v[:, 1] * w[:, 0]

    square = cross(da, db)
    return np.stack([cross(a, b), cross(da, b) + cross(a, db), square, np.zeros_like(square)])


def _triple(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return np.sum(np.cross(a, b) * c, axis=-1)


def _volume(a: np.ndarray, b: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Coefficients [4, pair] of (a × b)·w for vectors [time, pair, 3] that change linearly."""
    (a0, da), (b0, db), (w0, dw) = ((v[0], v[1] - v[0]) for v in (a, b, w))
    return np.stack(
        [
            _triple(a0, b0, w0),
            _triple(da, b0, w0) + _triple(a0, db, w0) + _triple(a0, b0, dw),
            _triple(da, db, w0) + _triple(da, b0, dw) + _triple(a0, db, dw),
            _triple(da, db, dw),
        ]
    )


def _bernstein(c: np.ndarray) -> np.ndarray:
    """Bernstein coefficients of cubics on [0, 1], which bound their values."""
    return np.stack([c[0], c[0] + c[1] / 3, c[0] + (2 * c[1] + c[2]) / 3, c[0] + c[1] + c[2] + c[3]])


def _value(c: np.ndarray, t: np.ndarray) -> np.ndarray:
    return c[0] + t * (c[1] + t * (c[2] + t * c[3]))


def _turning_points(c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two extrema in [0, 1], in order, between which cubics are monotone; 0 or 1 where there are fewer."""
    # Roots of c1 + 2 c2 t + 3 c3 t² without cancellation.
    root = np.sqrt(np.maximum(c[2] ** 2 - 3 * c[3] * c[1], 0.0))
    q = -(c[2] + np.copysign(root, c[2]))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        times = np.stack([q / (3 * c[3]), c[1] / q])
    low, high = np.sort(np.clip(np.nan_to_num(times, nan=0.0), 0.0, 1.0), axis=0)
    return low, high
