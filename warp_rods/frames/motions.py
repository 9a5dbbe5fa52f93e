"""Rigid motions, SE(3): exp, log, adjoint and coadjoint actions, the metric (dissertation, §3.2 and appendix B).

A frame is a pair (R, r) of a rotation [..., 3, 3] and a place [..., 3]. An element of se(3), a screw, is a pair (θ, µ)
[..., 3], angular part first, and so is one of its dual, (moment, force). Leading axes are broadcast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from warp_rods.frames import checks
from warp_rods.frames.rotations import coefficients, inverse_coefficient, polynomial, rotation_log

Pair = tuple[np.ndarray, np.ndarray]


def se3_exp(theta: ArrayLike, mu: ArrayLike) -> Pair:
    """The frame (R, r) of a screw (B.13): R = exp θ, r = V µ."""
    theta, mu = _screw(theta, mu, "theta", "mu")
    a, b, c = coefficients(theta)
    return polynomial(theta, a, b), _polynomial_on(theta, b, c, mu)


def se3_log(R: ArrayLike, r: ArrayLike) -> Pair:
    """The screw (θ, µ) of a frame (B.17), |θ| ≤ π; raises SceneError where R is no rotation."""
    theta, r = _screw(rotation_log(R), r, "R", "r")
    return theta, _polynomial_on(theta, np.full(theta.shape[:-1], -0.5), inverse_coefficient(theta), r)


def se3_compose(R: ArrayLike, r: ArrayLike, Q: ArrayLike, q: ArrayLike) -> Pair:
    """The product (R, r)(Q, q) = (RQ, Rq + r) of §3.2."""
    R, r, Q, q = _matrices(R, "R"), checks.vectors("r", r), _matrices(Q, "Q"), checks.vectors("q", q)
    return R @ Q, _on(R, q) + r


def se3_inverse(R: ArrayLike, r: ArrayLike) -> Pair:
    """The inverse frame (Rᵀ, −Rᵀr)."""
    inverse = np.swapaxes(_matrices(R, "R"), -1, -2)
    return inverse, -_on(inverse, checks.vectors("r", r))


def Ad(R: ArrayLike, r: ArrayLike, theta: ArrayLike, mu: ArrayLike) -> Pair:
    """S (θ, µ) S⁻¹ = (Rθ, Rµ + r × Rθ): the spatial velocity of a body velocity (2.67), (3.20)."""
    R, r = _matrices(R, "R"), checks.vectors("r", r)
    rotated = _on(R, checks.vectors("theta", theta))
    return rotated, _on(R, checks.vectors("mu", mu)) + np.cross(r, rotated)


def ad(theta: ArrayLike, mu: ArrayLike, phi: ArrayLike, nu: ArrayLike) -> Pair:
    """The commutator of (θ, µ) and (φ, ν): (θ × φ, θ × ν − φ × µ) (3.36), (B.33)."""
    theta, mu = _screw(theta, mu, "theta", "mu")
    phi, nu = _screw(phi, nu, "phi", "nu")
    return np.cross(theta, phi), np.cross(theta, nu) - np.cross(phi, mu)


def Ad_star(R: ArrayLike, r: ArrayLike, moment: ArrayLike, force: ArrayLike) -> Pair:
    """The dual of Ad, ⟨Ad* p, A⟩ = ⟨p, Ad A⟩: the body momentum of a spatial momentum about the origin."""
    R, r = _matrices(R, "R"), checks.vectors("r", r)
    moment, force = _screw(moment, force, "moment", "force")
    inverse = np.swapaxes(R, -1, -2)
    return _on(inverse, moment - np.cross(r, force)), _on(inverse, force)


def ad_star(theta: ArrayLike, mu: ArrayLike, moment: ArrayLike, force: ArrayLike) -> Pair:
    """The dual of ad, ⟨ad* p, A⟩ = ⟨p, ad A⟩ (3.43), (B.34). The body momentum of a free body obeys dp/dt = ad*_A p."""
    theta, mu = _screw(theta, mu, "theta", "mu")
    moment, force = _screw(moment, force, "moment", "force")
    return -(np.cross(theta, moment) + np.cross(mu, force)), -np.cross(theta, force)


def metric(dR: ArrayLike, dr: ArrayLike, dP: ArrayLike, dp: ArrayLike) -> np.ndarray:
    """½ tr(dRᵀ dP) + dr·dp [...] of two tangent vectors (dR, dr), (dP, dp) at the same frame (3.34), (B.8).

    dR = R ω̂ and dr = R u of body velocities (ω, u), of which it is ω·ω′ + u·u′. Invariant under motions from the left,
    and from the right under rotations only.
    """
    dR, dP = checks.matrices("dR", dR), checks.matrices("dP", dP)
    along = np.sum(checks.vectors("dr", dr) * checks.vectors("dp", dp), axis=-1)
    return 0.5 * np.sum(dR * dP, axis=(-1, -2)) + along


def _matrices(R: ArrayLike, name: str) -> np.ndarray:
    return checks.rotations(name, R)


def _screw(theta: ArrayLike, mu: ArrayLike, *names: str) -> tuple[np.ndarray, np.ndarray]:
    """Both parts with the same shape."""
    parts = [checks.vectors(name, part) for name, part in zip(names, (theta, mu), strict=True)]
    try:
        first, second = np.broadcast_arrays(*parts)
    except ValueError:
        shapes = " and ".join(str(part.shape) for part in parts)
        raise checks.SceneError(f"{', '.join(names)}: must have shapes that broadcast; have {shapes}") from None
    return first, second


def _on(R: np.ndarray, v: np.ndarray) -> np.ndarray:
    """R v."""
    return (R @ v[..., None])[..., 0]


def _polynomial_on(theta: np.ndarray, first: np.ndarray, second: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(1 + first θ̂ + second θ̂²) v."""
    once = np.cross(theta, v)
    return v + first[..., None] * once + second[..., None] * np.cross(theta, once)
