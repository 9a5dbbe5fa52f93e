"""Rods drawn as shaded tubes on two-dimensional axes, with a membrane if there is one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warp_rods.draw.style import COLOUR_MAP, OKABE_ITO

__all__ = ["one_scale", "scale_bar", "tubes"]

SIDES = 14
"""Sides of a tube's cross-section."""
CAP = np.deg2rad([90.0, 60.0, 30.0])
"""Angles of the rings that form a rounded end."""
LIGHT = np.array([-0.4, 0.6, 0.7])
"""Direction of the light: right, up and towards the viewer."""
MEMBRANE, MEMBRANE_OPACITY = np.array([0.66, 0.70, 0.76]), 0.35


def tubes(
    axes: Any,
    lines: Any,
    values: Any = None,
    radius: float = 0.02,
    *,
    view: tuple[float, float] = (-60.0, 25.0),
    limits: tuple[float, float] | None = None,
    colour: str = OKABE_ITO[0],
    colour_map: str = COLOUR_MAP,
    membrane: Any = None,
) -> Any:
    """Draw rods as shaded tubes in orthographic projection; returns what ``figure.colorbar`` takes.

    lines: centre lines [rod, node, 3], or a list of [node, 3]. values: one scalar per node or per rod, coloured by
    ``colour_map`` between ``limits`` (default: smallest and largest value); without values all rods have ``colour``.
    radius: of the tubes. view: azimuth and elevation of the viewer in degrees. membrane: a ``mesh.Mesh``, drawn
    translucent, with tubes in front of it and behind it.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize, to_rgb

    camera, lines = _camera(view), [np.asarray(line, dtype=float) for line in lines]
    each = [0.0] * len(lines) if values is None else values
    given = [np.broadcast_to(v, len(line)) for v, line in zip(each, lines, strict=True)]
    mapped = ScalarMappable(Normalize(*(limits or (min(map(np.min, given)), max(map(np.max, given))))), colour_map)
    shades = [mapped.to_rgba(v)[:, :3] if values is not None else np.full((len(v), 3), to_rgb(colour)) for v in given]
    faces = [_shaded(*_tube(line, radius, camera), shade) for line, shade in zip(lines, shades, strict=True)]
    faces += _sheet(membrane, camera) if membrane is not None else []
    corners, colours, depth = (np.concatenate(column) for column in zip(*faces, strict=True))
    order = np.argsort(depth, kind="stable")
    corners, colours = corners[order], colours[order]
    edges = np.where(colours[:, 3:] == 1.0, colours, 0.0)  # edges close the thin gaps between the faces of a tube
    drawn = PolyCollection(list(corners), facecolors=colours, edgecolors=edges, linewidths=0.15, rasterized=True)
    axes.add_collection(drawn)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.autoscale_view()
    return mapped


def one_scale(panels: Sequence[Any]) -> None:
    """Give panels of tubes one scale, by which the largest drawing fills its panel; each stays in the middle of its."""
    limits = [np.array([axes.get_xlim(), axes.get_ylim()]) for axes in panels]
    half = np.max([np.ptp(each, axis=1) for each in limits], axis=0) / 2
    for axes, each in zip(panels, limits, strict=True):
        (left, bottom), (right, top) = each.mean(axis=1) - half, each.mean(axis=1) + half
        axes.set(xlim=(left, right), ylim=(bottom, top))


def scale_bar(axes: Any, length: float, label: str) -> None:
    """A bar of this length below the drawing, as tubes are drawn without axes."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    at = bottom - 0.06 * (top - bottom)
    axes.plot([left, left + length], [at, at], color="black", linewidth=1.2, solid_capstyle="butt")
    axes.text(left + length / 2, at - 0.03 * (top - bottom), label, ha="center", va="top", fontsize=6.0)
    axes.set_xlim(left, max(right, left + length))
    axes.set_ylim(bottom - 0.2 * (top - bottom), top)


def _camera(view: tuple[float, float]) -> np.ndarray:
    """Rows: right, up and towards the viewer."""
    azimuth, elevation = np.deg2rad(view)
    back = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.stack([right, np.cross(back, right), back])


def _tube(line: np.ndarray, radius: float, camera: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rings [ring, side, 3] around a line [node, 3] with rounded ends, and their normals, in camera coordinates."""
    line = line @ camera.T
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    across = np.cross(tangent[0], np.eye(3)[np.argmin(np.abs(tangent[0]))])
    frames = []
    for t in tangent:  # the frame does not rotate about the line
        across = across - (across @ t) * t
        across = across / np.linalg.norm(across)
        frames.append((across, np.cross(t, across)))
    angle = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)
    outward = (
        np.cos(angle)[:, None] * np.array(frames)[:, None, 0] + np.sin(angle)[:, None] * np.array(frames)[:, None, 1]
    )
    back, across = -np.sin(CAP)[:, None, None] * tangent[0], np.cos(CAP)[:, None, None]
    front = np.sin(CAP[::-1])[:, None, None] * tangent[-1]
    normals = np.concatenate([back + across * outward[0], outward, front + across[::-1] * outward[-1]])
    centres = np.concatenate([line[:1].repeat(len(CAP), 0), line, line[-1:].repeat(len(CAP), 0)])
    return centres[:, None] + radius * normals, normals


def _shaded(rings: np.ndarray, normals: np.ndarray, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The visible faces of a tube: corners [face, 4, 2], colours [face, 4], depths [face]."""
    quads, normal = _quads(rings), _quads(normals).mean(axis=1)
    padded = np.concatenate([colours[:1].repeat(len(CAP), 0), colours, colours[-1:].repeat(len(CAP), 0)])
    colour = ((padded[1:] + padded[:-1]) / 2).repeat(SIDES, axis=0)
    shown = normal[:, 2] > -0.2
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    light = LIGHT / np.linalg.norm(LIGHT)
    half = light + np.eye(3)[2]
    half = half / np.linalg.norm(half)
    diffuse = 0.4 + 0.6 * np.clip(normal @ light, 0.0, None)
    gloss = 0.35 * np.clip(normal @ half, 0.0, None) ** 30
    rgb = np.clip(colour * diffuse[:, None] + gloss[:, None], 0.0, 1.0)
    rgba = np.concatenate([rgb, np.ones((len(rgb), 1))], axis=1)
    # A tube on a membrane is half inside it; the outer half is drawn in front of the membrane.
    thickness = np.ptp(rings[len(CAP)], axis=0).max()
    return quads[shown, :, :2], rgba[shown], quads[shown, :, 2].mean(axis=1) + thickness / 2


def _quads(rings: np.ndarray) -> np.ndarray:
    """Corners [ring − 1 × side, 4, 3] of the faces between rings [ring, side, 3]."""
    turned = np.roll(rings, -1, axis=1)
    return np.stack([rings[:-1], turned[:-1], turned[1:], rings[1:]], axis=2).reshape(-1, 4, 3)


def _sheet(mesh: Any, camera: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The triangles of a membrane, as quadrilaterals with one corner repeated."""
    corners = (mesh.points @ camera.T)[mesh.triangles]
    normal = (mesh.normals @ camera.T)[mesh.triangles].mean(axis=1)
    light = 0.6 + 0.4 * np.abs(normal @ (LIGHT / np.linalg.norm(LIGHT)))
    rgba = np.concatenate([MEMBRANE * light[:, None], np.full((len(corners), 1), MEMBRANE_OPACITY)], axis=1)
    return [(corners[:, [0, 1, 2, 2], :2], rgba, corners[..., 2].mean(axis=1))]
