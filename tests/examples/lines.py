"""Curves in closed form, for measured centre lines: points, and distances from the curve."""

import numpy as np


def helix(u, radius=1.0, pitch=0.8, turns=1.2):
    """Points of a helix for u in [0, 1], whose curvature and torsion are constant."""
    angle = 2 * np.pi * turns * np.asarray(u)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), pitch / (2 * np.pi) * angle], axis=-1)


def helix_curvature(radius=1.0, pitch=0.8):
    return radius / (radius**2 + (pitch / (2 * np.pi)) ** 2)


def helix_length(radius=1.0, pitch=0.8, turns=1.2):
    return 2 * np.pi * turns * np.hypot(radius, pitch / (2 * np.pi))


def trefoil(u):
    """Points of a half of a trefoil knot for u in [0, 1]."""
    t = np.pi * np.asarray(u)
    return np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=-1)


def on_torus(u, major=1.0, minor=0.4):
    """Points of a curve on a torus, which winds both ways."""
    a, b = 1.5 * np.asarray(u), 2.0 * np.asarray(u)
    ring = major + minor * np.cos(b)
    return np.stack([ring * np.cos(a), ring * np.sin(a), minor * np.sin(b)], axis=-1)


def unequal(count, seed=0):
    """Increasing numbers in [0, 1], with distances that differ by about ten times."""
    steps = np.random.default_rng(seed).uniform(0.1, 1.0, count - 1)
    return np.r_[0.0, np.cumsum(steps)] / steps.sum()
