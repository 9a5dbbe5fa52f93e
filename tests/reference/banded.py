"""Banded systems in NumPy and SciPy: construction, solution by LAPACK, backward error."""

import numpy as np
from scipy.linalg import solve_banded

LOWER_TO_UPPER = {3: (-1, 0, 1), 5: (-2, -1, 0, 1, 2)}


def off_the_rod(bands: int, nodes: int) -> np.ndarray:
    """Mask [band, node] of the coefficients that would multiply an unknown off the rod."""
    column = np.arange(nodes) + np.array(LOWER_TO_UPPER[bands])[:, None]
    return (column < 0) | (column >= nodes)


def multiply(coefficients: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The matrices [band, rod, node], lowest band first, times x [rod, node, ...]."""
    bands, _, nodes = coefficients.shape
    result = np.zeros_like(x)
    for offset, band in zip(LOWER_TO_UPPER[bands], coefficients, strict=True):
        rows = slice(max(0, -offset), nodes - max(0, offset))
        columns = slice(max(0, offset), nodes + min(0, offset))
        weights = band[:, rows].reshape(x[:, columns].shape[:2] + (1,) * (x.ndim - 2))
        result[:, rows] += weights * x[:, columns]
    return result


def lapack(coefficients: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Each rod's solution by ``solve_banded`` (partial pivoting); right is [rod, node, ...]."""
    bands, rods, nodes = coefficients.shape
    width = bands // 2
    inside = ~off_the_rod(bands, nodes)
    solution = np.empty_like(right)
    for rod in range(rods):
        packed = np.zeros((bands, nodes))
        for offset, band, use in zip(LOWER_TO_UPPER[bands], coefficients[:, rod], inside, strict=True):
            rows = np.flatnonzero(use)
            packed[width - offset, rows + offset] = band[rows]
        solution[rod] = solve_banded((width, width), packed, right[rod])
    return solution


def backward_error(coefficients: np.ndarray, x: np.ndarray, right: np.ndarray) -> float:
    """The largest component of |A x − r| / (|A| |x| + |r|), the componentwise relative backward error.

    Independent of the scaling of rows (Oettli and Prager).
    """
    bound = multiply(abs(coefficients), abs(x)) + abs(right)
    return float((abs(multiply(coefficients, x) - right) / bound).max())


def biharmonic(rods: int, nodes: int, strength: float) -> np.ndarray:
    """``I + strength h⁻⁴ D4`` [5, rod, node] with f = f' = 0 beyond both ends, h = 1 / (nodes − 1)."""
    c = strength * (nodes - 1) ** 4
    stencil = c * np.array([1.0, -4.0, 6.0, -4.0, 1.0]) + [0, 0, 1, 0, 0]
    return np.broadcast_to(stencil[:, None, None], (5, rods, nodes)).copy()


def dominant(rng: np.random.Generator, bands: int, rods: int, nodes: int) -> np.ndarray:
    """Random, diagonally dominant coefficients [band, rod, node]."""
    coefficients = rng.normal(size=(bands, rods, nodes))
    middle = bands // 2
    rest = abs(coefficients).sum(axis=0) - abs(coefficients[middle])
    sign = rng.choice([-1.0, 1.0], size=(rods, nodes))
    coefficients[middle] = sign * rest * rng.uniform(1.05, 2.0, size=(rods, nodes))
    return coefficients
