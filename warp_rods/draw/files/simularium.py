"""Simularium, for the viewer at simularium.allencell.org: rods as fibres; the binary form of the format, version 2.

Lengths are scaled so that the longest edge of the box is 100, as the viewer expects; ``spatialUnits`` says by how much.
Units without a name are those of a scene that has none. The format has no meshes of its own: membranes are left out.
https://github.com/simularium/simulariumio/blob/main/file_format.md
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from warp_rods.draw.style import OKABE_ITO
from warp_rods.errors import SceneError
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.rods import Rods

__all__ = ["size", "write"]

IDENTIFIER = b"SIMULARIUMBINARY"
HEADER = struct.Struct("<16s12I")
"""Identifier; length of the header, version, number of blocks; and of each block offset, type and length."""
FACTS, PLOTS, FRAMES = 1, 2, 3
"""Types of blocks: what the file is about, plots (none here), and frames."""
FIBRE = 1001.0
AGENT = 11
"""Numbers of an agent before its points."""
EDGE = 100.0
"""The longest edge of the box in the units of the file."""
LARGEST = 4e9
"""Bytes: offsets have 32 bits."""


def write(content: Content, path: Path) -> None:
    """Write the rods as fibres, one type an ensemble. Raises SceneError where the file would exceed 4 GB."""
    if size(content) > LARGEST:
        raise SceneError(f"frames: the file would have {size(content) / 1e9:.3g} GB, and may have 4: choose fewer")
    box = content.bounds()
    scale = EDGE / (2 * np.abs(box).max())
    facts = _padded(json.dumps(_facts(content, box, scale)).encode())
    plots = _padded(json.dumps({"version": 1, "data": []}).encode())
    numbers = [3 + sum(rods.count * (AGENT + 3 * rods.nodes) for rods in content.rods)] * content.frames
    frames = 8 + 4 * (2 + 2 * content.frames + sum(numbers))
    lengths = [8 + len(facts), frames, 8 + len(plots)]
    offsets = [HEADER.size, HEADER.size + lengths[0], HEADER.size + sum(lengths[:2])]
    table = [n for block in zip(offsets, (FACTS, FRAMES, PLOTS), lengths, strict=True) for n in block]
    with path.open("wb") as file:
        file.write(HEADER.pack(IDENTIFIER, HEADER.size, 2, 3, *table))
        file.write(struct.pack("<2I", FACTS, lengths[0]) + facts)
        file.write(struct.pack("<2I", FRAMES, lengths[1]))
        _write_frames(file, content, numbers, scale)
        file.write(struct.pack("<2I", PLOTS, lengths[2]) + plots)


def size(content: Content) -> float:
    """About how many bytes the file has."""
    return 3e3 + content.frames * (20 + 4 * sum(rods.count * (AGENT + 3 * rods.nodes) for rods in content.rods))


def _write_frames(file: BinaryIO, content: Content, numbers: list[int], scale: float) -> None:
    """Where each frame begins and its length; then of each its number, time, number of rods, and the rods."""
    begin = 8 + 4 * (2 + 2 * content.frames)
    begins = begin + 4 * np.concatenate([[0], np.cumsum(numbers[:-1])])
    table = np.stack([begins, 4 * np.array(numbers)], axis=1)
    file.write(struct.pack("<2I", 1, content.frames) + table.astype("<u4").tobytes())
    count = sum(rods.count for rods in content.rods)
    for frame in with_progress(range(content.frames), "Simularium"):
        file.write(struct.pack("<IfI", frame, content.times[frame], count))
        before = 0
        for kind, rods in enumerate(content.rods):
            file.write(_fibres(rods, frame, kind, before, scale).astype("<f4").tobytes())
            before += rods.count


def _fibres(rods: Rods, frame: int, kind: int, before: int, scale: float) -> np.ndarray:
    """Numbers [rod, 11 + 3 × node] of fibres: form, number, kind, place and turn of all (0), radius, points."""
    agents = np.zeros((rods.count, AGENT + 3 * rods.nodes))
    agents[:, 0] = FIBRE
    agents[:, 1] = before + np.arange(rods.count)
    agents[:, 2] = kind
    agents[:, 9] = rods.radius * scale
    agents[:, 10] = 3 * rods.nodes
    agents[:, AGENT:] = rods.positions(frame).reshape(rods.count, -1) * scale
    return agents


def _facts(content: Content, box: np.ndarray, scale: float) -> dict[str, Any]:
    """The block about the trajectory, version 3 of its form."""
    edges = 2 * np.abs(box).max(axis=0) * scale
    centre = box.mean(axis=0) * scale
    flat = edges[2] < 0.06 * max(edges[:2])
    eye = centre + (np.array([0, 0, 1.3]) if flat else np.array([0.5, -1.0, 0.5])) * EDGE
    steps = np.diff(content.times)
    title = {"trajectoryTitle": content.title} if content.title else {}
    return {
        "version": 3,
        **title,
        "timeUnits": {"magnitude": content.seconds or 1.0, "name": "s" if content.seconds else ""},
        "timeStepSize": float(f"{steps[0]:.4g}") if len(steps) else 0.0,
        "totalSteps": content.frames,
        "spatialUnits": {"magnitude": float(content.metres * 1e6 / scale), "name": "µm"}
        if content.scene.units
        else {"magnitude": float(1 / scale), "name": ""},
        "size": _point(edges),
        "cameraDefault": {
            "position": _point(eye),
            "lookAtPosition": _point(centre),
            "upVector": _point(np.array([0.0, 1.0, 0.0] if flat else [0.0, 0.0, 1.0])),
            "fovDegrees": 50.0,
        },
        "typeMapping": {
            str(kind): {
                "name": rods.name,
                "geometry": {"displayType": "FIBER", "url": "", "color": OKABE_ITO[kind % len(OKABE_ITO)]},
            }
            for kind, rods in enumerate(content.rods)
        },
    }


def _point(numbers: np.ndarray) -> dict[str, float]:
    return dict(zip("xyz", map(float, numbers), strict=True))


def _padded(text: bytes) -> bytes:
    """Text up to a multiple of four bytes."""
    return text + b"\0" * (-len(text) % 4)
