"""Functions with κ = κ' = 0 at both ends: C¹ piecewise polynomials of high degree on [−1/2, 1/2].

Hermite cubics represent values and slopes at the ends of the intervals; twice-integrated Legendre polynomials (bubbles)
complete the basis inside each. Second derivatives are then nearly orthonormal, so that a fourth-order operator is well
conditioned at any degree. A kink at the end of an interval costs no accuracy.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

DEGREE = 18


@dataclass(frozen=True)
class ClampedElements:
    """The basis tabulated at the Gauss points of ``intervals`` equal intervals.

    ``s``, ``weights`` [point]. ``value``, ``slope``, ``second`` [point, function]: basis functions, their first and
    second derivatives.
    """

    intervals: int
    s: np.ndarray
    weights: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    second: np.ndarray

    def evaluate(self, amplitudes: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Functions with these ``amplitudes`` [..., function], evaluated at ``s`` [node]: [..., node]."""
        return amplitudes @ _table(s, self.intervals, 0).T

    def antiderivative(self, samples: np.ndarray) -> np.ndarray:
        """∫ from −1/2 to each Gauss point; ``samples`` [point] are given there and may jump between intervals."""
        points = len(self.s) // self.intervals
        nodes, weights = legendre.leggauss(points)
        primitives = [legendre.legval(nodes, legendre.legint(row, lbnd=-1)) for row in np.eye(points)]
        partial = np.array(primitives).T @ np.linalg.inv(legendre.legvander(nodes, points - 1))
        pieces = samples.reshape(self.intervals, points) / (2 * self.intervals)
        before = np.append(0.0, np.cumsum(pieces @ weights)[:-1])
        return (before[:, None] + pieces @ partial.T).ravel()


@lru_cache(maxsize=8)
def clamped_elements(intervals: int) -> ClampedElements:
    """The basis of degree ``DEGREE`` on ``intervals`` equal intervals."""
    nodes, weights = legendre.leggauss(DEGREE + 4)
    lefts = np.arange(intervals)[:, None]
    s = ((lefts + 0.5 * (1.0 + nodes)) / intervals - 0.5).ravel()
    value, slope, second = (_table(s, intervals, order) for order in range(3))
    return ClampedElements(intervals, s, np.tile(weights, intervals) / (2 * intervals), value, slope, second)


def _shapes() -> np.ndarray:
    """Legendre coefficients [shape, degree] on [−1, 1]: value and slope at −1, value and slope at +1, bubbles."""
    shapes = np.zeros((DEGREE + 1, DEGREE + 1))
    cubics = np.array([[2, -3, 0, 1], [1, -1, -1, 1], [2, 3, 0, -1], [-1, -1, 1, 1]]) / 4
    for row, cubic in enumerate(cubics):
        shapes[row, :4] = legendre.poly2leg(cubic)
    for k in range(2, DEGREE - 1):
        curve = np.sqrt(k + 0.5) * np.eye(k + 1)[k]
        bubble = legendre.legint(legendre.legint(curve, lbnd=-1), lbnd=-1)
        shapes[k + 2, : len(bubble)] = bubble
    return shapes


def _table(s: np.ndarray, intervals: int, order: int) -> np.ndarray:
    """The derivative of this order of every basis function at ``s``: [point, function]."""
    position = (s + 0.5) * intervals
    interval = np.clip(position.astype(int), 0, intervals - 1)
    shapes = legendre.legval(2 * (position - interval) - 1, legendre.legder(_shapes(), order, axis=1).T).T
    shapes *= (2.0 * intervals) ** order
    joints, bubbles = 2 * (intervals + 1), DEGREE - 3
    columns = np.zeros((len(s), joints + intervals * bubbles))
    rows = np.arange(len(s))[:, None]
    columns[rows, 2 * interval[:, None] + np.arange(4)] = shapes[:, :4]
    columns[rows, joints + bubbles * interval[:, None] + np.arange(bubbles)] = shapes[:, 4:]
    return np.delete(columns, [0, 1, joints - 2, joints - 1], axis=1)
