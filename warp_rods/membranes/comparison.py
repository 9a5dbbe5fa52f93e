"""The membrane before and after it was smoothed: told, warned of, or refused where a part is gone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive, start
from warp_rods.kernels.surface.geometry import Numbers, Parameters, sampler
from warp_rods.membranes.bodies import Bodies
from warp_rods.membranes.files import FileError, counted, shown_point
from warp_rods.membranes.fit import AGREE, Fit, Raw, Shape
from warp_rods.membranes.level_set import Data, LevelSet

__all__ = ["compared", "curvature_error"]

UNSURE = 0.1
"""Relative error of curvature from which there is a warning."""
SAMPLES = 2000
"""Points at which curvature is compared."""


def compared(raw: Raw, fit: Fit, what: str, notes: Sequence[str], remedy: str, metres: float | None = None) -> LevelSet:
    """The level set with notes and warnings; raises FileError where bodies are gone, joined or divided."""
    before, after = raw.shape, fit.shape
    owner = raw.bodies.nearest(fit.bodies.triangles.points)
    if lost := _lost(raw.bodies, fit.bodies, owner):
        raise FileError(
            f"is too coarse for its finest parts: with nodes {_shown(fit.spacing)} apart and smoothing over "
            f"{fit.width:.3g}, {lost}; use {remedy}, or leave out what is too fine"
        )
    error = curvature_error(fit)
    lines = [*notes, f"before smoothing: {_words(before)} ({what})"]
    lines.append(
        f"after smoothing: {_words(after, before)}; nodes {_shown(fit.spacing)} apart, smoothed over {fit.width:.3g}; "
        f"curvature to about {_percent(error)}"
    )
    bodies = Bodies(raw.bodies.bodies, fit.bodies.triangles, owner)  # numbered and measured as in the data
    if len(bodies) > 1:
        lines.append(f"bodies {bodies.listed()}")
    wrong = {name: change for name, change in after.changes(before).items() if abs(change) > AGREE}
    warnings = []
    if wrong:
        changed = ", ".join(f"{name} by {100 * change:+.1f} %" for name, change in wrong.items())
        warnings.append(f"smoothing changes the {changed}: use {remedy}")
    if error > UNSURE:
        warnings.append(f"curvature is only known to about {_percent(error)}: use {remedy}")
    return replace(fit.level_set, data=Data(tuple(lines), tuple(warnings), bodies, metres))


def _words(shape: Shape, before: Shape | None = None) -> str:
    changes = shape.changes(before) if before else {}

    def change(name: str) -> str:
        return f" ({100 * changes[name]:+.1f} %)" if name in changes else ""

    words = f"volume {shape.volume:.4g}{change('volume')}, area {shape.area:.4g}{change('area')}, "
    words += "1 body" if shape.bodies == 1 else f"{shape.bodies} bodies"
    if np.isfinite(shape.finest):
        words += f", half the finest part (neck) {shape.finest:.3g}{change('finest part')}"
    if np.isfinite(shape.gap):
        words += f", half the narrowest gap {shape.gap:.3g}{change('narrowest gap')}"
    return words


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.1f} %" if fraction < 0.1 else f"{100 * fraction:.0f} %"


def _shown(spacing: np.ndarray) -> str:
    return f"{spacing[0]:.3g}" if np.ptp(spacing) < 1e-9 * spacing[0] else " × ".join(f"{h:.3g}" for h in spacing)


def _lost(before: Bodies, after: Bodies, owner: np.ndarray) -> str:
    """Words on bodies that are gone, joined or divided, or none; ``owner``: the earlier body of each later point."""
    pairs = np.unique(np.stack([owner, after.of_points]), axis=1).T
    gone = [n for n in range(len(before)) if n not in pairs[:, 0]]
    if gone:
        where = shown_point(before.bodies[gone[0]].centre)
        return f"{counted(len(gone), 'part')} of {len(before)} would be gone, the first around {where}"
    for number, body in enumerate(after.bodies):
        if (joined := pairs[pairs[:, 1] == number][:, 0]).size > 1:
            return f"{joined.size} parts would be joined around {shown_point(body.centre)}"
    for number, body in enumerate(before.bodies):
        if (pieces := pairs[pairs[:, 0] == number][:, 1]).size > 1:
            return f"the part around {shown_point(body.centre)} would fall into {pieces.size} pieces"
    return ""


def curvature_error(fit: Fit) -> float:
    """The relative error of curvature, estimated as twice the difference between two widths of the smoothing.

    Wider smoothing leaves about half of what facets and voxels do to curvature, and moves thick parts little.
    """
    middles = fit.bodies.triangles.corners().mean(axis=0)
    low, high = fit.level_set.box
    middles = middles[((middles >= low) & (middles <= high)).all(axis=-1)]
    middles = middles[:: -(-len(middles) // SAMPLES)]
    narrow, wide = (_principal(level_set, middles) for level_set in (fit.level_set, fit.wider))
    flattest = 1 / fit.bodies.triangles.size  # so that a plane has a relative error, too
    rms = float(np.sqrt(np.mean(narrow**2)))
    return 2 * float(np.sqrt(np.mean((narrow - wide) ** 2))) / max(rms, flattest)


def _principal(level_set: LevelSet, points: np.ndarray) -> np.ndarray:
    """Principal curvatures [n, 2] where points [n, 3] are projected onto the surface."""
    start()
    with exclusive:
        p: Any = Parameters()
        p.v = Numbers(*level_set.numbers, *np.zeros(8 - level_set.numbers.size))
        p.grid = wp.array(level_set.grid, dtype=wp.float64, device="cpu")
        parameters: Any = wp.array([p], dtype=Parameters, device="cpu")
        x: Any = wp.array(points, dtype=wp.vec3d, device="cpu")
        phi, g, H = (wp.zeros(len(points), dtype=t, device="cpu") for t in (wp.float64, wp.vec3d, wp.mat33d))
        kernels = sampler(level_set.field)
        wp.launch(kernels.project, dim=len(points), inputs=[x, parameters, 10], device="cpu")
        wp.launch(kernels.evaluate, dim=len(points), inputs=[x, parameters, phi, g, H], device="cpu")
        gradient, hessian = g.numpy().copy(), H.numpy().copy()
    size = np.linalg.norm(gradient, axis=-1)[:, None, None]
    n = gradient[:, :, None] / size
    tangent = np.eye(3) - n * np.swapaxes(n, 1, 2)
    values = np.linalg.eigvalsh(tangent @ hessian @ tangent / size)  # one of the three is 0, along the normal
    order = np.argsort(np.abs(values), axis=-1)
    return np.sort(np.take_along_axis(values, order[:, 1:], axis=-1), axis=-1)
