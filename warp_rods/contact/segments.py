"""Centre lines as chains of straight segments, and the distances between them, in a box that may be periodic."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from warp_rods.contact.cells import close_pairs

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


class Segments(NamedTuple):
    """Segments from ``start`` to ``end`` [n, 3], and the number of the rod to which each belongs [n]."""

    start: np.ndarray
    end: np.ndarray
    rod: np.ndarray

    @classmethod
    def of(cls, lines: Sequence[np.ndarray]) -> Segments:
        """The segments of centre lines [rod, node, 3], the rods of one array after the other.

        A line of one node is a segment of length zero. Segments that are not finite are left out.
        """
        pairs = [(part, part) if part.shape[1] == 1 else (part[:, :-1], part[:, 1:]) for part in lines]
        start, end = (np.concatenate([np.empty((0, 3)), *(p[i].reshape(-1, 3) for p in pairs)]) for i in (0, 1))
        each = np.concatenate([np.empty(0, int), *(np.full(len(p), p.shape[1]) for p, _ in pairs)])
        rod = np.repeat(np.arange(len(each)), each)
        kept = np.isfinite(start + end).all(axis=1)
        return cls(start[kept], end[kept], rod[kept])

    @property
    def middle(self) -> np.ndarray:
        """Middle points [n, 3]."""
        return (self.start + self.end) / 2

    @property
    def longest(self) -> float:
        """The largest length of a segment."""
        return float(np.linalg.norm(self.end - self.start, axis=-1).max(initial=0.0))


class Close(NamedTuple):
    """Pairs of segments that are close: their numbers [pair], the places of the two nearest points along them, in
    fractions of each [pair], and the separation of the first point from the second [pair, 3]."""

    first: np.ndarray
    second: np.ndarray
    along_first: np.ndarray
    along_second: np.ndarray
    gap: np.ndarray

    @property
    def distance(self) -> np.ndarray:
        """Distances of the two points [pair]."""
        return np.linalg.norm(self.gap, axis=-1)


Pair = tuple[np.ndarray, np.ndarray]
"""Numbers of first and of second segments [pair]."""


@dataclass(frozen=True)
class OccupiedSpace:
    """Centre lines ``others`` [rod, node, 3] of other rods, in a box of periods [3], 0 along an axis without one."""

    others: Sequence[np.ndarray]
    period: np.ndarray

    @property
    def periodic(self) -> bool:
        """Whether the box has a period along any axis."""
        return bool(np.any(self.period))

    def tree(self, points: np.ndarray) -> cKDTree:
        """The tree of points [n, 3], periodic along axes with a period."""
        from scipy.spatial import cKDTree

        divisor = np.where(self.period > 0, self.period, 1.0)
        wrapped = np.where(self.period > 0, np.mod(points, divisor), points)
        wrapped = np.where(
            (self.period > 0) & (wrapped >= divisor), 0.0, wrapped
        )  # a remainder may round to the period
        return cKDTree(wrapped, boxsize=self.period)

    def nearest_image(self, d: np.ndarray) -> np.ndarray:
        """Separations [n, 3] between nearest images."""
        divisor = np.where(self.period > 0, self.period, np.inf)
        return d - np.where(self.period > 0, self.period, 0.0) * np.rint(d / divisor)

    def close_within(self, segments: Segments, clearance: float) -> Close:
        """Pairs of segments of different rods that are closer than the clearance."""
        middle, reach = segments.middle, clearance + segments.longest

        def once(first: np.ndarray, second: np.ndarray) -> Pair:
            """Each pair of different rods once."""
            kept = (first < second) & (segments.rod[first] != segments.rod[second])
            return first[kept], second[kept]

        if self.periodic:
            found = self.tree(middle).query_pairs(reach, output_type="ndarray")
            pairs = [once(found[:, 0], found[:, 1])]
        else:
            pairs = [once(*part) for part in close_pairs(middle, middle, reach)]
        return self._closer(segments, segments, pairs, clearance)

    def close_between(self, some: Segments, others: Segments, clearance: float) -> Close:
        """Pairs of one of ``some`` segments and one of the ``others`` that are closer than the clearance."""
        reach = clearance + (some.longest + others.longest) / 2
        if self.periodic:
            trees = self.tree(some.middle), self.tree(others.middle)
            found = trees[0].sparse_distance_matrix(trees[1], reach, output_type="ndarray")
            return self._closer(some, others, [(found["i"], found["j"])], clearance)
        return self._closer(some, others, close_pairs(some.middle, others.middle, reach), clearance)

    def _closer(self, some: Segments, others: Segments, pairs: Iterable[Pair], clearance: float) -> Close:
        """Those of the pairs, which come in parts, that are closer than the clearance."""
        parts = [self._close(some, others, first, second, clearance) for first, second in pairs]
        some_pair, place = np.empty(0, int), np.empty(0)
        none = Close(some_pair, some_pair, place, place, np.empty((0, 3)))
        return Close._make(np.concatenate(part) for part in zip(none, *parts, strict=True))

    def _close(
        self, some: Segments, others: Segments, first: np.ndarray, second: np.ndarray, clearance: float
    ) -> Close:
        apart = (some.start[first] + some.end[first]) / 2 - (others.start[second] + others.end[second]) / 2
        shift = self.nearest_image(apart) - apart
        p, a = some.start[first] + shift, some.end[first] - some.start[first]
        q, b = others.start[second], others.end[second] - others.start[second]
        along_first, along_second = nearest_points(p, a, q, b)
        gap = p + along_first[:, None] * a - q - along_second[:, None] * b
        near = np.linalg.norm(gap, axis=-1) < clearance
        return Close(first[near], second[near], along_first[near], along_second[near], gap[near])


def nearest_points(p: np.ndarray, a: np.ndarray, q: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where segments p + x a and q + y b are closest: x and y in [0, 1] [n]; the vectors are [n, 3].

    Ericson, Real-Time Collision Detection (2005), §5.1.9. Parallel segments are closest at many places; one is given.
    """
    tiny = np.finfo(float).tiny

    def dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.einsum("ni,ni->n", u, v)

    w = p - q
    aa, bb, ab, aw, bw = dot(a, a), dot(b, b), dot(a, b), dot(a, w), dot(b, w)
    size = np.maximum(aa * bb - ab * ab, 0.0)
    skew = size > 1e-14 * aa * bb
    x = np.where(skew, np.clip((ab * bw - aw * bb) / np.where(skew, size, 1.0), 0.0, 1.0), 0.0)
    y = np.clip((ab * x + bw) / np.maximum(bb, tiny), 0.0, 1.0)
    return np.clip((ab * y - aw) / np.maximum(aa, tiny), 0.0, 1.0), y
