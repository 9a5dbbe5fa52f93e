"""What a surface that a user gave is like: whether it is there, encloses something, and is smooth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warp_rods.membranes.surfaces import Surface

SAMPLES = 49
"""Points along each edge of the box at which φ is looked at."""
MOST_POINTS = 2000
"""Points of the surface at which its gradient is looked at."""
SUSPECTS = 50
"""Of those, where the gradient is least for its rate of change, so many are followed to where it vanishes."""
FLAT = 1e-7
"""A gradient vanishes when over the whole box it would make less than this share of φ's range."""


def is_closed(surface: Surface) -> bool:
    """Whether φ > 0 all over the faces of the box, as far as samples tell; touching one is allowed."""
    phi = _samples(surface)[1]
    return bool((_faces(phi) > -1e-9 * np.abs(phi[np.isfinite(phi)]).max()).all())


def faults(surface: Surface) -> list[str]:
    """What forbids rods on this surface, each a line that follows a key path; none where all is well."""
    x, phi = _samples(surface)
    if np.isnan(phi).any():
        return [f": φ is not a number at {_shown(x[np.isnan(phi)][0])}, in its box"]
    side = "positive" if (phi > 0).all() else "never positive"
    if (phi > 0).all() or (phi <= 0).all():
        return [
            f": φ is {side} at the {SAMPLES}³ points looked at in its box, so that no surface φ = 0 is found; "
            f"put the box closely round it, and see that φ changes sign"
        ]
    if (_faces(phi) <= 0).all():
        return [": φ is negative all over the faces of its box: outward is where φ > 0, so write −φ, or widen the box"]
    return _roughness(surface, _crossings(surface, x, phi), float(np.abs(phi[np.isfinite(phi)]).max()))


def _samples(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Points [n, n, n, 3] of the box, its faces included, and φ there."""
    low, high = surface.box
    axes = [np.linspace(a, b, SAMPLES) for a, b in zip(low, high, strict=True)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return x, surface.phi(x)


def _faces(phi: np.ndarray) -> np.ndarray:
    return np.concatenate([np.take(phi, (0, -1), axis=axis).ravel() for axis in range(3)])


def _crossings(surface: Surface, x: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Where φ changes sign along edges between samples [n, 3], by bisection."""
    ends = []
    for axis in range(3):
        a, b = (np.delete(np.moveaxis(x, axis, 0), end, axis=0) for end in (-1, 0))
        a_out, b_out = (np.delete(np.moveaxis(phi, axis, 0), end, axis=0) > 0 for end in (-1, 0))
        ends += [(a[b_out & ~a_out], b[b_out & ~a_out]), (b[a_out & ~b_out], a[a_out & ~b_out])]
    inside, outside = (np.concatenate(points) for points in zip(*ends, strict=True))
    stride = -(-len(inside) // MOST_POINTS)
    inside, outside = inside[::stride], outside[::stride]
    for _ in range(52):
        middle = (inside + outside) / 2
        positive = (surface.phi(middle) > 0)[:, None]
        inside, outside = np.where(positive, inside, middle), np.where(positive, middle, outside)
    return inside


def _roughness(surface: Surface, x: np.ndarray, scale: float) -> list[str]:
    """A jump of φ, or a place on the surface where ∇φ vanishes; ``scale``: the largest |φ| in the box."""
    phi, g, H = surface.phi(x), surface.gradient(x), surface.hessian(x)
    jump = ~(np.abs(phi) < 1e-6 * scale) | ~np.isfinite(g).all(axis=-1) | ~np.isfinite(H).all(axis=(-1, -2))
    if jump.any():
        return [f": φ is not smooth where it changes sign at {_shown(x[jump][0])}"]
    size = np.linalg.norm(g, axis=-1)
    extent = float(np.linalg.norm(np.subtract(*surface.box)))
    if (flat := size * extent < FLAT * scale).any():
        return [_no_gradient(x[flat][0])]
    suspects = np.argsort(size / (np.linalg.norm(H, axis=(-1, -2)) + size / extent))[:SUSPECTS]
    found = _critical_points(surface, x[suspects])
    size = np.linalg.norm(surface.gradient(found), axis=-1)
    on_surface = (np.abs(surface.phi(found)) < 1e-10 * scale) & (size * extent < FLAT * scale)
    return [_no_gradient(found[on_surface][0])] if on_surface.any() else []


def _critical_points(surface: Surface, x: np.ndarray) -> np.ndarray:
    """Where Newton steps on ∇φ = 0 from points [n, 3] come to rest inside the box."""
    low, high = surface.box
    step = np.full_like(x, np.inf)
    for _ in range(60):
        g, H = surface.gradient(x), surface.hessian(x)
        kept = np.isfinite(g).all(axis=-1) & np.isfinite(H).all(axis=(-1, -2))
        kept &= (x >= low).all(axis=-1) & (x <= high).all(axis=-1)
        step = np.einsum("nij,nj->ni", np.linalg.pinv(H[kept], rcond=1e-9), g[kept])
        x = x[kept] - step
    return x[np.linalg.norm(step, axis=-1) < 1e-9 * np.linalg.norm(high - low)]


def _no_gradient(x: np.ndarray) -> str:
    return (
        f": ∇φ vanishes on the surface at {_shown(x)}, so that it has no normal there: it crosses itself, ends in a "
        f"tip, or φ only touches zero"
    )


def _shown(x: np.ndarray) -> str:
    return "(" + ", ".join(f"{value + 0.0:.4g}" for value in x) + ")"
