"""A measured centre line as a filament on a membrane: projected, and described by its geodesic curvature."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from warp_rods.centrelines.curve import Curve, curve_through
from warp_rods.centrelines.rod import distances, means
from warp_rods.centrelines.track import TrackError
from warp_rods.documented import Documented

if TYPE_CHECKING:
    from warp_rods.membranes.surface import Surface

__all__ = ["FARTHEST", "CentrelineOnMembrane", "on_membrane"]

FARTHEST = 0.1
"""Distance from the membrane, in lengths of the line, beyond which a line is refused."""
SAMPLES, PARTS = 4, 16
"""Points that are projected for each cell of the filament, and straight parts of a cell, for distances."""


@dataclass(frozen=True)
class CentrelineOnMembrane(metaclass=Documented):
    """A filament along a measured centre line that was projected onto a membrane, in units of the membrane.

    position [3], direction [3]: of the middle node; geodesic_curvature [node] and length: as ``BoundRods`` takes them.
    line, tangent [node, 3]: of all nodes. off_rms, off_largest: distances of the points from the membrane. rms,
    largest: from the filament. smoothing: the wavelength that was halved. notes: what was done with the points.
    """

    position: np.ndarray = field(repr=False)
    direction: np.ndarray = field(repr=False)
    geodesic_curvature: np.ndarray = field(repr=False)
    line: np.ndarray = field(repr=False)
    tangent: np.ndarray = field(repr=False)
    length: float
    smoothing: float
    rms: float
    largest: float
    off_rms: float
    off_largest: float
    notes: tuple[str, ...] = ()


def on_membrane(
    curve: Curve,
    points: np.ndarray,
    surface: Surface,
    nodes: int,
    length: float | None = None,
    notes: tuple[str, ...] = (),
) -> CentrelineOnMembrane:
    """The filament along a curve; with a ``length`` the curve is first scaled to it about its middle.

    Raises TrackError where the points are farther from the membrane than ``FARTHEST`` of the length of the line.
    """
    s = np.linspace(0.0, curve.length, SAMPLES * (nodes - 1) + 1)
    middle = curve.place(np.array([curve.length / 2]))
    factor = 1.0 if length is None else length / curve.length
    points, line = (middle + factor * (x - middle) for x in (points, curve.place(s)))
    off, off_line = (np.linalg.norm(_foot(surface, x) - x, axis=1) for x in (points, line))
    farthest, allowed = float(np.max([off.max(), off_line.max()])), FARTHEST * factor * curve.length
    if not farthest <= allowed:
        raise TrackError(
            f"is up to {farthest:.3g} away from the membrane, more than {FARTHEST:g} of its length "
            f"{factor * curve.length:.4g}: move it there, or give scale, what one unit of the points is in its units"
        )
    foot = curve_through(_foot(surface, line))
    at = np.linspace(0.0, foot.length, PARTS * (nodes - 1) + 1)
    place, (tangent, bend) = foot.place(at), foot.tangent_and_bend(at)
    geodesic = means(np.sum(bend * np.cross(surface.normal(place), tangent), axis=1), PARTS)
    from_line = distances(points, place)
    place, tangent = place[::PARTS], tangent[::PARTS]
    return CentrelineOnMembrane(
        place[nodes // 2], tangent[nodes // 2], geodesic, place, tangent,
        length or foot.length, curve.wavelength, _rms(from_line), float(from_line.max()),
        _rms(off), float(off.max()), notes,
    )  # fmt: skip


def _foot(surface: Surface, x: np.ndarray) -> np.ndarray:
    """The points on the membrane near points [n, 3]; infinitely far where none was found."""
    with np.errstate(all="ignore"):
        foot = surface.project(x)
        size = float(np.linalg.norm(np.subtract(*surface.box)))
        distance = np.abs(surface.phi(foot)) / np.linalg.norm(surface.gradient(foot), axis=-1)
    return np.where((distance < 1e-9 * size)[:, None], foot, np.inf)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
