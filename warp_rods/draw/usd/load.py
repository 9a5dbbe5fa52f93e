"""Forces in a USD stage, drawn as arrows: load on the membrane, also that of the filaments' ends, and activity.

An arrow is one linear curve, base – neck – neck – tip, whose widths form its head. Readers that draw the rods draw the
arrows too. They have the purpose "guide", as hundreds of arrows would hide the rods; usdview (Display › Display
Purposes › Guide) and Blender (import with "Guide" ticked) show them on request.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods.draw.content import Content
from warp_rods.draw.rods import Rods
from warp_rods.draw.usd.curves import linear_curves, set_points
from warp_rods.progress import with_progress

__all__ = ["ACTIVITY", "LOADS", "draw_forces"]

_SPACING = 8  # approximate number of nodes between arrows; an arrow at every node would double the size of the file
_QUANTILE, _LENGTH = 0.95, 0.08  # length of the arrow at this quantile of |force|, in sizes of what is drawn
_POINTS = np.array([0.0, 0.7, 0.7, 1.0])  # base, neck (twice) and tip along the arrow
_WIDTHS = np.array([0.05, 0.05, 0.15, 0.0])  # widths there, in lengths of the arrow at that quantile
_COLOUR = (0.80, 0.10, 0.02)  # does not occur in the colour map of the energy
LOADS = ("load", "end_load")
ACTIVITY = "activity"
_DOCUMENTATION = {
    "load": "force per length of the filaments on the membrane: −ν, −χ of (5.31), (5.32)",
    "end_load": "force of both end sections of the filaments on the membrane: ∓(λ, λ2, λ3) of (D.30), (D.32)",
    "activity": "force per length of the flagella on the rod: f along the tangent, (4.12)",
}
"""Variables that are drawn; each has a scale of its own, as their units differ."""


@dataclass(frozen=True)
class _Scale:
    """A force of size ``typical`` has an arrow of this ``length``; the scale is that of all ensembles and frames."""

    typical: float
    length: float


def draw_forces(stage: Any, shown: Content, names: tuple[str, ...], frames: range, size: float, material: Any) -> None:
    """Arrows of these variables at these frames, for each ensemble where they are not zero at some time of the run.

    An arrow at the 0.95 quantile of |force| has 0.08 times ``size``, the size of what is drawn.
    """
    for variable in names:
        found = {rods: _magnitudes(rods, variable, shown.sample()) for rods in shown.rods if variable in rods.data}
        loaded = {rods: magnitudes for rods, magnitudes in found.items() if magnitudes.any()}
        if not loaded:
            continue
        every = np.concatenate(list(loaded.values()))
        scale = _Scale(float(np.quantile(every, _QUANTILE)) or float(every.max()), _LENGTH * size)
        for rods in loaded:
            _draw(stage, rods, frames, variable, scale, material)


def _magnitudes(rods: Rods, variable: str, frames: range) -> np.ndarray:
    """All values of |force| at these frames."""
    return np.concatenate([np.linalg.norm(_forces(rods, variable, frame), axis=-1).ravel() for frame in frames])


def _forces(rods: Rods, variable: str, frame: int) -> np.ndarray:
    """The forces [rod, node or end, 3] at a frame; 0 of lost rods, on which nothing acts any more."""
    values = rods.variable(variable, frame)
    values = np.where(rods.lost(frame).reshape(-1, *[1] * (values.ndim - 1)), 0.0, values)
    if variable != ACTIVITY:
        return values
    tangent = np.gradient(rods.variable("position", frame), axis=1)
    return values[..., None] * tangent / np.linalg.norm(tangent, axis=-1, keepdims=True)


def _arrow_nodes(nodes: int) -> np.ndarray:
    """The nodes of a rod that have arrows: both ends, and evenly spaced nodes between them."""
    return np.linspace(0, nodes - 1, max(3, (nodes - 1) // _SPACING + 1)).round().astype(int)


def _draw(stage: Any, rods: Rods, frames: range, variable: str, scale: _Scale, material: Any) -> None:
    """The arrows of one ensemble at these frames."""
    from pxr import Gf, Tf, UsdGeom, Vt

    at_ends = "end" in rods.data[variable].dims
    nodes = np.array([0, rods.nodes - 1]) if at_ends else _arrow_nodes(rods.nodes)
    path = f"/World/Loads/{Tf.MakeValidIdentifier(rods.name)}_{variable}"
    arrows = linear_curves(stage, path, np.full(rods.count * len(nodes), len(_POINTS)), material)
    arrows.CreatePurposeAttr(UsdGeom.Tokens.guide)
    arrows.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([Gf.Vec3f(*_COLOUR)])
    arrows.GetPrim().SetDocumentation(_DOCUMENTATION[variable])
    arrows.GetPrim().SetCustomDataByKey("lengthPerLoad", scale.length / scale.typical)
    arrows.SetWidthsInterpolation(UsdGeom.Tokens.vertex)
    for frame in with_progress(frames, f"USD: {variable} of {rods.name}"):
        values, base = _forces(rods, variable, frame), rods.positions(frame)[:, nodes]
        load = values if at_ends else values[:, nodes]
        points = base[..., None, :] + _POINTS[:, None] * load[..., None, :] * (scale.length / scale.typical)
        set_points(arrows, frame, points.reshape(-1, 3), _WIDTHS.max() / 2 * scale.length)
        # Arrows shorter than the typical one are also thinner; otherwise they would look like discs.
        thinner = np.minimum(np.linalg.norm(load, axis=-1, keepdims=True) / scale.typical, 1.0)
        widths = (thinner * _WIDTHS * scale.length).astype(np.float32)
        arrows.CreateWidthsAttr().Set(Vt.FloatArray.FromNumpy(widths.ravel()), frame)
