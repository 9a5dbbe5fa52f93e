"""Potentials of rigid bodies: values and gradients, checked, and the wrench that they give (3.41), (3.42)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from warp_rods import arguments, frames
from warp_rods.errors import SceneError
from warp_rods.frames import checks
from warp_rods.rigid_body.variational import on

Potential = Callable[[np.ndarray, np.ndarray], tuple[Any, Any, Any]]
TRIED = 1e-5
"""Change of the frame by which the gradient of a potential is checked."""


def evaluate(potential: Potential, R: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """V [...], dV/dR [..., 3, 3] and dV/dr [..., 3]; raises SceneError for other shapes and numbers not finite."""
    given = potential(R, r)
    if not isinstance(given, tuple) or len(given) != 3:
        raise arguments.wrong("potential", given, "a function that returns (V, dV/dR, dV/dr)")
    shapes = {"V": r.shape[:-1], "dV/dR": R.shape, "dV/dr": r.shape}
    V, by_R, by_r = (
        arguments.fitted(f"potential, {name}", value, shape, f"finite numbers {list(shape)}")
        for value, (name, shape) in zip(given, shapes.items(), strict=True)
    )
    return V, by_R, by_r


def wrench(potential: Potential | None, R: np.ndarray, r: np.ndarray, held: bool) -> tuple[np.ndarray, np.ndarray]:
    """Moment −Rᵀ Σ b_i × ∇_{b_i} V and force −Rᵀ ∇_r V in the body frame (3.42); no force on held bodies."""
    if potential is None:
        return np.zeros_like(r), np.zeros_like(r)
    _, by_R, by_r = evaluate(potential, R, r)
    back = np.swapaxes(R, -1, -2)
    moment = -np.cross(R, by_R, axisa=-2, axisb=-2).sum(axis=-2)
    return on(back, moment), np.zeros_like(r) if held else -on(back, by_r)


def check_gradient(potential: Potential, R: np.ndarray, r: np.ndarray, length: np.ndarray, held: bool) -> None:
    """Raises SceneError where the wrench is not the slope of V along a screw of the body; length [..., 1]: its size."""
    moment, force = wrench(potential, R, r, held)
    expected = -np.concatenate([moment, length * force], axis=-1)
    for i, step in enumerate(np.eye(6)[: 3 if held else 6] * TRIED):
        Q, q = frames.se3_exp(step[:3], length * step[3:])
        ahead, behind = (evaluate(potential, R @ P, r + on(R, p))[0] for P, p in ((Q, q), frames.se3_inverse(Q, q)))
        slope = (ahead - behind) / (2 * TRIED)
        allowed = 1e-4 * np.abs(expected).max(axis=-1) + 1e-10 * (np.abs(ahead) + np.abs(behind)) / TRIED
        wrong = np.atleast_1d(np.abs(slope - expected[..., i]) > allowed)
        if wrong.any():
            at = checks.first(wrong)
            what = f"turning about axis {i}" if i < 3 else f"moving along axis {i - 3}"
            unit = 1.0 if i < 3 else np.atleast_1d(length[..., 0])[at]
            found, given = np.atleast_1d(slope)[at] / unit, np.atleast_1d(expected[..., i])[at] / unit
            raise SceneError(
                f"potential: {what} of the body changes V at the rate {found:.6g}, its gradient gives {given:.6g}; "
                "dV/dR has the gradients by the directors as columns"
            )
