"""Framed curves in closed form, for tests of path-ordered products and of frames of curves."""

import numpy as np
from scipy.spatial.transform import Rotation


def curve(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation ``R(x) = exp(e2 a) exp(e0 b) exp(e1 c)`` and its exact body rate; the rotations do not commute."""
    a, b, c = np.sin(3 * x), 2 * x**2, np.cos(2 * x)
    rates = np.stack([3 * np.cos(3 * x), 4 * x, -2 * np.sin(2 * x)], axis=-1)
    R = Rotation.from_euler("ZXY", np.stack([a, b, c], axis=-1)).as_matrix()
    last = Rotation.from_euler("Y", c[..., None]).as_matrix()
    axes = np.stack([R[..., 2, :], last[..., 0, :], np.broadcast_to([0.0, 1.0, 0.0], R.shape[:-1])], axis=-2)
    return R, np.einsum("...k,...ki->...i", rates, axes)


def spiral(t: np.ndarray) -> list[np.ndarray]:
    """An open curve (cos t, sin t, t³/6), and its first three derivatives by t."""
    c, s, one = np.cos(t), np.sin(t), np.ones_like(t)
    rows = [(c, s, t**3 / 6), (-s, c, t**2 / 2), (-c, -s, t), (s, -c, one)]
    return [np.stack(row, axis=-1) for row in rows]


def knot(nodes: int, p: int = 2, q: int = 3) -> list[np.ndarray]:
    """A torus knot (p, q), closed, and its first three derivatives by its parameter 0 ≤ t < 2π, by Fourier series."""
    t = 2 * np.pi * np.arange(nodes) / nodes
    rho = 2 + 0.7 * np.cos(q * t)
    position = np.stack([rho * np.cos(p * t), rho * np.sin(p * t), 0.7 * np.sin(q * t)], axis=-1)
    waves = 1j * np.fft.fftfreq(nodes, 1 / nodes)[:, None]
    spectrum = np.fft.fft(position, axis=0)
    return [position, *(np.fft.ifft(waves**k * spectrum, axis=0).real for k in (1, 2, 3))]


def exact_frenet(derivatives: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Frenet frame [node, 3, 3], κ, τ and |r′| [node] of a curve from its derivatives by any parameter."""
    _, first, second, third = derivatives
    binormal = np.cross(first, second)
    speed, across = np.linalg.norm(first, axis=-1), np.linalg.norm(binormal, axis=-1)
    T, B = first / speed[:, None], binormal / across[:, None]
    torsion = np.sum(binormal * third, axis=-1) / across**2
    return np.stack([T, np.cross(B, T), B], axis=-1), across / speed**3, torsion, speed
