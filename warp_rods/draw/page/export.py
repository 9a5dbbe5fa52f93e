"""The page of a run: what is shown, packed into one HTML file of bounded size."""

from __future__ import annotations

import html
import json
import logging
import re
from collections.abc import Sequence
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.draw.clock import clock_of
from warp_rods.draw.colours import colour_map
from warp_rods.draw.page.encoding import (
    LEVELS,
    Packer,
    packed_points,
    packed_sheet,
    packed_triangles,
    packed_values,
    quantised,
)
from warp_rods.draw.scale import LACKING
from warp_rods.draw.sheet import curvature_colours
from warp_rods.draw.view import view_of
from warp_rods.errors import SceneError
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.sheet import Sheet

__all__ = ["size", "write"]

SCRIPTS = ("data.js", "camera.js", "shaders.js", "scene.js", "controls.js")
SAMPLED = 6
"""Frames that are packed to estimate the size."""
MEMBRANE, CONTAINER = 0.22, 0.06
"""Opacities where a surface is seen face on; that of a container is low, as the cells are inside."""
TRAILS = 20
"""Largest number of rods that leave trails."""
Arrays = dict[str, str]


def write(content: Content, path: Path, limit: float) -> None:
    """Write the page to ``path``, at most ``limit`` MB: otherwise frames are left out evenly, with a warning.

    Raises SceneError where even one frame is larger.
    """
    frames = _chosen(content, limit)
    page = _packed(content, frames)
    while len(page) > limit * 1e6:  # frames differ from those by which the size was estimated
        if len(frames) == 1:
            raise _too_large(len(page), limit)
        frames = range(0, content.frames, _longer(frames.step, len(page) / (limit * 1e6), content.frames))
        page = _packed(content, frames)
    if frames.step > 1:
        logging.getLogger(__name__).warning(
            f"the page shows one frame in {frames.step}, {len(frames)} of {content.frames}, to stay below {limit:.3g} "
            "MB; --limit sets how large it may be"
        )
    path.write_bytes(page)


def _longer(step: int, too_large: float, frames: int) -> int:
    """A step from frame to frame of a page with fewer of them, where that of this step is so many times too large."""
    count = -(-frames // step)
    return max(step + 1, -(-frames // max(1, min(count - 1, int(count / too_large)))))


def _packed(content: Content, frames: range) -> bytes:
    """The page with these frames."""
    arrays: Arrays = {}
    facts = _facts(content, frames)
    facts["rods"] = [_rods(content, index, frames, arrays, facts) for index in range(len(content.rods))]
    sheets = [(content.membrane, MEMBRANE), (content.container, CONTAINER)]
    facts["sheets"] = [
        _sheet(sheet, index, frames, arrays, sheet is content.membrane) | {"opacity": opacity}
        for index, (sheet, opacity) in enumerate((s, o) for s, o in sheets if s is not None)
    ]
    return _page(content, facts, arrays).encode()


def size(content: Content, limit: float) -> float:
    """About how many bytes the page has."""
    fixed, each = _bytes(content)
    return fixed + each * min(content.frames, max(1.0, (limit * 1e6 - fixed) / each))


def _chosen(content: Content, limit: float) -> range:
    """The frames on a page of at most about ``limit`` MB; raises SceneError where there is no room for one."""
    fixed, each = _bytes(content)
    room = limit * 1e6 - fixed
    if room < each:
        raise _too_large(fixed + each, limit)
    return range(0, content.frames, max(1, int(np.ceil(content.frames * each / room))))


def _too_large(size: float, limit: float) -> SceneError:
    """The error where not even one frame has room."""
    return SceneError(
        f"limit = {limit:g}: one frame takes {size / 1e6:.3g} MB: choose fewer ensembles, or a larger limit in MB"
    )


def _bytes(content: Content) -> tuple[float, float]:
    """Bytes that a page has anyhow, and of each frame: of a sample of frames, as packed."""
    sample = content.sample(SAMPLED)
    packer = Packer()
    for frame in sample:
        scale = content.scale(frame)
        for rods in content.rods:
            packer.add(packed_points(quantised(rods.positions(frame)).numbers))
            packer.add(packed_values(scale.fraction(rods.values(frame))))
    each = len(packer.text()) / len(sample) + 150
    fixed = 40e3
    for sheet in (content.membrane, content.container):
        if sheet is not None:
            mesh = sheet.mesh(0)
            packer = Packer()
            packer.add(packed_triangles(mesh.triangles))
            last = min(1, content.frames - 1) if sheet.moving else 0
            numbers = quantised(np.array([mesh.points, sheet.mesh(last).points])).numbers
            first, change = Packer(), Packer()
            first.add(packed_sheet(numbers[0], None))
            change.add(packed_sheet(numbers[1], numbers[0]))
            fixed += len(packer.text()) + len(first.text())
            each += len(change.text()) if sheet.moving else 0.0
            if sheet is content.membrane and sheet.curvature:
                packer = Packer()
                packer.add(_tints(sheet, 0))
                tints = len(packer.text())
                fixed, each = fixed + 6e3 + tints * (not sheet.moving), each + tints * sheet.moving
    return fixed, each


def _facts(content: Content, frames: range) -> dict[str, Any]:
    """What the page says and how it looks, without rods and membranes."""
    scales = [content.scale(frame) for frame in (frames if content.selection.span == "frame" else frames[:1])]
    colours = colour_map(content.colour.map_name)(np.linspace(0.0, 1.0, LEVELS))[:, :3]
    return {
        "metres": content.metres if content.scene.units else None,
        "clock": asdict(clock_of(content)),
        "times": [float(f"{content.times[frame]:.9g}") for frame in frames],
        "colour": {"label": content.label, "ticks": [_short(scale.ticks(3)) for scale in scales]},
        "map": np.rint(255 * colours).astype(int).tolist(),
        "lacking": LACKING,
        "curvature": _curvature(content),
        "view": _view(content, frames),
        "edges": content.edges.tolist(),
    }


def _rods(content: Content, index: int, frames: range, arrays: Arrays, facts: dict[str, Any]) -> dict[str, Any]:
    """Pack the rods of an ensemble; returns what the page must know of them."""
    rods = content.rods[index]
    points, values, boxes = Packer(), Packer(), []
    for frame in with_progress(frames, f"page: {rods.name}"):
        numbers, low, spacing = quantised(rods.positions(frame))
        points.add(packed_points(numbers))
        values.add(packed_values(content.scale(frame).fraction(rods.values(frame))))
        boxes.append([_short(low), _short(spacing)])
    arrays[f"points{index}"], arrays[f"values{index}"] = points.text(), values.text()
    return {"name": rods.name, "rods": rods.count, "nodes": rods.nodes, "radius": rods.radius, "boxes": boxes}


def _sheet(sheet: Sheet, index: int, frames: range, arrays: Arrays, coloured: bool) -> dict[str, Any]:
    """Pack a membrane or a container; returns what the page must know of it. coloured: by its Gaussian curvature."""
    moving = list(frames) if sheet.moving else [0]
    meshes = [sheet.mesh(frame).points for frame in with_progress(moving, "page: membrane")]
    numbers, low, spacing = quantised(np.array(meshes))
    packer = Packer()
    for frame, points in enumerate(numbers):
        packer.add(packed_sheet(points, numbers[frame - 1] if frame else None))
    arrays[f"sheet{index}"] = packer.text()
    triangles = sheet.mesh(0).triangles
    packer = Packer()
    packer.add(packed_triangles(triangles))
    arrays[f"triangles{index}"] = packer.text()
    coloured = coloured and sheet.curvature > 0
    if coloured:
        packer = Packer()
        for frame in moving:
            packer.add(_tints(sheet, frame))
        arrays[f"tints{index}"] = packer.text()
    return {
        "coloured": coloured,
        "points": numbers.shape[1],
        "triangles": len(triangles),
        "frames": len(moving),
        "box": [_short(low), _short(spacing)],
    }


def _tints(sheet: Sheet, frame: int) -> bytes:
    """The places of the points of a mesh on the scale of the curvature, a byte each."""
    return packed_values((sheet.ratio(frame)[None] + 1) / 2)


def _curvature(content: Content) -> dict[str, Any] | None:
    """The colours of the membrane, as on posters; None where its curvature hardly varies."""
    sheet = content.membrane
    if sheet is None or not sheet.curvature:
        return None
    return {
        "label": content.named("Gaussian curvature of membrane", "1/length^2"),
        "ticks": [_short([-sheet.curvature, 0.0, sheet.curvature])],
        "map": np.rint(255 * curvature_colours(np.linspace(-1.0, 1.0, LEVELS))).astype(int).tolist(),
    }


def _view(content: Content, frames: range) -> dict[str, Any]:
    """Direction towards the viewer, half width, height and depth of what is seen, and its centre at each frame."""
    view = view_of(content)
    low, high = content.bounds()
    depth = view.half.max() if view.follows else np.abs(view.axes[2]) @ (high - low) / 2
    centres = [view.at(content, frame).centre for frame in (frames if view.follows else frames[:1])]
    return {
        "back": _short(view.axes[2]),
        "half": _short([*view.half, depth]),
        "centres": [_short(centre) for centre in centres],
        "trails": _trails(content, frames) if view.follows else [],
    }


def _trails(content: Content, frames: range) -> list[Any]:
    """Paths of the middles of rods that travel far, [rod][frame][3]; none where they are many."""
    if sum(rods.count for rods in content.rods) > TRAILS:
        return []
    middles = [[rods.positions(frame)[:, rods.nodes // 2] for frame in frames] for rods in content.rods]
    return [[_short(place) for place in path] for part in middles for path in np.swapaxes(part, 0, 1)]


def _short(numbers: np.ndarray | Sequence[float]) -> list[float]:
    return [float(f"{number:.8g}") for number in numbers]


def _page(content: Content, facts: dict[str, Any], arrays: Arrays) -> str:
    """The page: its template, filled."""
    here = files(__package__)
    rods = ", ".join(f"{rods.name}: {rods.count} rod{'s' * (rods.count > 1)}" for rods in content.rods)
    parts = {
        "title": html.escape(content.title or "rods"),
        "about": html.escape(rods),
        "style": (here / "page.css").read_text(encoding="utf-8"),
        "script": "\n".join((here / name).read_text(encoding="utf-8") for name in SCRIPTS),
        "facts": json.dumps(facts, separators=(",", ":")).replace("<", "\\u003c"),
        "arrays": "\n".join(f'<script type="text/plain" id="{name}">{text}</script>' for name, text in arrays.items()),
    }
    template = (here / "page.html").read_text(encoding="utf-8")
    return re.sub(r"@(\w+)@", lambda found: parts[found[1]], template)
