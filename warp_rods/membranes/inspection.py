"""Checks that φ of a formula or a file defines a surface for rods: it exists, faces outwards, and is smooth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warp_rods.membranes.kinks import kinks
from warp_rods.membranes.surface import Surface

__all__ = ["Inspection", "inspect"]

SAMPLES = 49
"""Points along each edge of the box at which φ is sampled."""
MOST_POINTS = 2000
"""Points of the surface at which its gradient is computed."""
SUSPECTS = 50
"""Points with the smallest gradient relative to its derivative, from which zeros of the gradient are searched."""
FLAT = 1e-7
"""A gradient counts as zero where, times the size of the box, it is below this fraction of the range of φ."""


class Inspection(NamedTuple):
    """The result of the inspection of a surface."""

    closed: bool
    """Whether φ > 0 at all samples on the faces of the box; the surface may touch a face."""
    faults: list[str]
    """Why rods cannot be on the surface; each text follows a key path."""


def inspect(surface: Surface) -> Inspection:
    """Sample φ in the box of a surface, and search for zeros of its gradient on the surface."""
    x, phi = _samples(surface)
    finite = np.abs(phi[np.isfinite(phi)])
    largest = float(finite.max()) if len(finite) else 0.0
    faces = np.concatenate([np.take(phi, (0, -1), axis=axis).ravel() for axis in range(3)])
    closed = bool((faces > -1e-9 * largest).all())
    if surface.data.bodies is not None:  # of a file: its surface is known, and may be too small for the samples
        points = surface.data.bodies.triangles.points
        return Inspection(closed, _roughness(surface, surface.project(_some(points)), largest))
    if np.isnan(phi).any():
        return Inspection(closed, [f": φ is not a number at {_point(x[np.isnan(phi)][0])}, in its box"])
    if (phi > 0).all() or (phi <= 0).all():
        side = "positive" if (phi > 0).all() else "never positive"
        text = (
            f": φ is {side} at the {SAMPLES}³ points sampled in its box, so that no surface φ = 0 is found: "
            f"fit the box closely to the surface, and check that φ changes sign"
        )
        return Inspection(closed, [text])
    if (faces <= 0).all():
        text = ": φ is negative all over the faces of its box: outward is where φ > 0, so write −φ, or widen the box"
        return Inspection(closed, [text])
    points = _crossings(surface, x, phi)
    return Inspection(closed, _roughness(surface, points, largest) or _kinks(surface, points))


def _samples(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Points [n, n, n, 3] of the box, including its faces, and φ there."""
    low, high = surface.box
    axes = [np.linspace(a, b, SAMPLES) for a, b in zip(low, high, strict=True)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return x, surface.phi(x)


def _crossings(surface: Surface, x: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Points [n, 3] on the edges between samples at which φ changes sign, by bisection."""
    ends = []
    for axis in range(3):
        a, b = (np.delete(np.moveaxis(x, axis, 0), end, axis=0) for end in (-1, 0))
        a_out, b_out = (np.delete(np.moveaxis(phi, axis, 0), end, axis=0) > 0 for end in (-1, 0))
        ends += [(a[b_out & ~a_out], b[b_out & ~a_out]), (b[a_out & ~b_out], a[a_out & ~b_out])]
    inside, outside = (np.concatenate(points) for points in zip(*ends, strict=True))
    inside, outside = _some(inside), _some(outside)
    for _ in range(52):
        middle = (inside + outside) / 2
        positive = (surface.phi(middle) > 0)[:, None]
        inside, outside = np.where(positive, inside, middle), np.where(positive, middle, outside)
    return inside


def _some(points: np.ndarray) -> np.ndarray:
    """``MOST_POINTS`` of the points at most."""
    return points[:: -(-len(points) // MOST_POINTS)]


def _roughness(surface: Surface, x: np.ndarray, largest: float) -> list[str]:
    """Faults: a jump of φ, or a point on the surface where ∇φ = 0; ``largest``: the largest |φ| in the box."""
    phi, (_, g, H) = surface.phi(x), surface.derivatives(x)
    jump = ~(np.abs(phi) < 1e-6 * largest) | ~np.isfinite(g).all(axis=-1) | ~np.isfinite(H).all(axis=(-1, -2))
    if jump.any():
        return [f": φ is not smooth where it changes sign at {_point(x[jump][0])}"]
    size = np.linalg.norm(g, axis=-1)
    extent = float(np.linalg.norm(np.subtract(*surface.box)))
    if (flat := size * extent < FLAT * largest).any():
        return [_no_gradient(x[flat][0])]
    suspects = np.argsort(size / (np.linalg.norm(H, axis=(-1, -2)) + size / extent))[:SUSPECTS]
    found = _critical_points(surface, x[suspects])
    phi, g, _ = surface.derivatives(found)
    on_surface = (np.abs(phi) < 1e-10 * largest) & (np.linalg.norm(g, axis=-1) * extent < FLAT * largest)
    return [_no_gradient(found[on_surface][0])] if on_surface.any() else []


def _kinks(surface: Surface, points: np.ndarray) -> list[str]:
    """A fault where the surface of a formula has a kink; ``points`` [n, 3] on it."""
    if surface.kind != "expression" or not len(found := kinks(surface, points)):
        return []
    text = (
        f": the surface has a kink, a tip or an edge at {_point(found[0])}, where its normal jumps: an argument of "
        f"sqrt(), log(), tan(), atan2() or of a power vanishes there. Move it off the surface, or round it, such as "
        f"sqrt(u**2 + w**2) for sqrt(u**2), with w several times the spacing of the nodes"
    )
    return [text]


def _critical_points(surface: Surface, x: np.ndarray) -> np.ndarray:
    """The points inside the box to which Newton's method for ∇φ = 0 converges from points [n, 3]."""
    low, high = surface.box
    step = np.full_like(x, np.inf)
    for _ in range(60):
        _, g, H = surface.derivatives(x)
        kept = np.isfinite(g).all(axis=-1) & np.isfinite(H).all(axis=(-1, -2))
        kept &= (x >= low).all(axis=-1) & (x <= high).all(axis=-1)
        step = np.einsum("nij,nj->ni", np.linalg.pinv(H[kept], rcond=1e-9), g[kept])
        x = x[kept] - step
    return x[np.linalg.norm(step, axis=-1) < 1e-9 * np.linalg.norm(high - low)]


def _no_gradient(x: np.ndarray) -> str:
    return (
        f": ∇φ vanishes on the surface at {_point(x)}, so that the surface has no normal there: it crosses itself, "
        f"ends in a tip, or φ touches zero without changing sign"
    )


def _point(x: np.ndarray) -> str:
    return "(" + ", ".join(f"{value + 0.0:.4g}" for value in x) + ")"
