"""A folder of images of a run: ``image.ome.tif``, ``masks.ome.tif`` and the settings, ``microscope.toml``.

Both stacks have the axes time, channel, z, y, x, one channel an ensemble. Seen on a screen x points to the right, y up
and z towards the viewer. Masks have the numbers of rods from 1, and 0 beside them. Lost rods are in neither.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.draw.files.optional import needed
from warp_rods.draw.microscope.camera import MOST, counts
from warp_rods.draw.microscope.light import Field, expected_in_plane, sources
from warp_rods.draw.microscope.masks import mask_planes
from warp_rods.draw.microscope.settings import Complete, microscope
from warp_rods.errors import SceneError
from warp_rods.progress import with_progress
from warp_rods.simulation.estimates import shown_bytes

if TYPE_CHECKING:
    from warp_rods.draw.content import Content

__all__ = ["field_of", "size", "write"]

MARGIN = 4.0
"""Widths of the point spread function around the rods."""
SAMPLED = 2.0
"""Sources in a width: their sum differs from the integral along a long rod by exp(−2π² · 4), at its ends by 0.3 %."""
LARGEST, OF_A_PIXEL = 2e9, 64.0
"""Bytes of memory of a plane, at most, and of each of its pixels; stacks are made and written plane by plane."""


def write(content: Content, path: Path, optics: str) -> None:
    """Write the folder. Raises SceneError for wrong settings, and where a plane would be too large for memory."""
    tifffile = needed("tifffile", "--microscope", "images")
    settings = microscope(content, optics)
    field = field_of(content, settings)
    _check(field, settings)
    path.mkdir()
    (path / "microscope.toml").write_text(settings.to_toml(), encoding="utf-8")
    described = _metadata(content, settings, field)
    shape = (content.frames, len(content.rods), *field.shape)
    images, labels = _images(content, settings, field), _masks(content, field)
    kind = np.uint16 if max(rods.count for rods in content.rods) < 2**16 else np.uint32
    for name, pages, dtype, packed in (("image", images, np.uint16, None), ("masks", labels, kind, "zlib")):
        big = 2 * np.prod(shape, dtype=float) > 3.9e9
        with tifffile.TiffWriter(path / f"{name}.ome.tif", ome=True, bigtiff=big) as file:
            file.write(
                pages, shape=shape, dtype=dtype, photometric="minisblack", compression=packed, metadata=described
            )


def size(content: Content, optics: str) -> float:
    """About how many bytes the files have; masks are compressed."""
    voxels = np.prod(field_of(content, microscope(content, optics)).shape, dtype=float)
    return content.frames * len(content.rods) * (2.3 * voxels + 500) + 3e3


def field_of(content: Content, settings: Complete) -> Field:
    """The pixels that hold all rods at all frames, with a margin, and the planes."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for rods in content.rods:
        for frame in range(content.frames):
            places = rods.positions(frame)[..., :2]
            low, high = np.minimum(low, places.min(axis=(0, 1))), np.maximum(high, places.max(axis=(0, 1)))
    low, high = low - MARGIN * settings.width, high + MARGIN * settings.width
    columns, rows = np.minimum(np.ceil((high - low) / settings.pixel), 1e15).astype(int)
    heights = settings.focus + settings.spacing * (np.arange(settings.planes) - (settings.planes - 1) / 2)
    return Field(float(low[0]), float(high[1]), settings.pixel, int(rows), int(columns), heights)


def _check(field: Field, settings: Complete) -> None:
    bytes_of_plane = OF_A_PIXEL * float(field.columns) * float(field.rows)
    if bytes_of_plane > LARGEST:
        raise SceneError(
            f"pixel = {settings.pixel:g}: a plane would have {field.columns} × {field.rows} pixels, which take about "
            f"{shown_bytes(bytes_of_plane)} of memory, and may take {shown_bytes(LARGEST)}: give a larger pixel in "
            "--optics"
        )


def _images(content: Content, settings: Complete, field: Field) -> Iterator[np.ndarray]:
    """Pages [row, column] of counts, in the order time, channel, z."""
    saturated = 0
    for frame in with_progress(range(content.frames), "microscope"):
        for channel, rods in enumerate(content.rods):
            places = rods.without_lost(rods.positions(frame), frame)
            lights = sources(places, settings.photons, settings.width / SAMPLED)
            for plane, height in enumerate(field.heights):
                photons = expected_in_plane(lights, field, height, settings.width, settings.depth)
                seen = counts(photons, settings, (content.numbers[frame], channel, plane))
                saturated += int((seen == MOST).sum())
                yield seen
    if saturated:
        logging.getLogger(__name__).warning(f"{saturated} voxels are saturated: lower photons or gain in --optics")


def _masks(content: Content, field: Field) -> Iterator[np.ndarray]:
    """Pages [row, column] of labels, in the same order."""
    for frame in with_progress(range(content.frames), "masks"):
        for rods in content.rods:
            yield from mask_planes(rods.without_lost(rods.positions(frame), frame), rods.radius, field)


def _metadata(content: Content, settings: Complete, field: Field) -> dict[str, Any]:
    """What OME-TIFF says of the stacks: lengths in µm and times in s where the scene has these units.

    OME has a unit for lengths without one, "reference frame", but none for times: the description then has the time.
    """
    unit = "µm" if content.scene.units else "reference frame"
    scale = content.metres * 1e6 if content.scene.units else 1.0
    steps = np.diff(content.times)
    step = float(steps.mean()) if len(steps) else None
    timed = {} if step is None or content.seconds is None else {"TimeIncrement": step * content.seconds}
    return {
        "axes": "TCZYX",
        "Name": content.title or "rods",
        "Channel": {"Name": [rods.name for rods in content.rods]},
        "PhysicalSizeX": field.pixel * scale,
        "PhysicalSizeXUnit": unit,
        "PhysicalSizeY": field.pixel * scale,
        "PhysicalSizeYUnit": unit,
        "PhysicalSizeZ": settings.spacing * scale,
        "PhysicalSizeZUnit": unit,
        **(timed and timed | {"TimeIncrementUnit": "s"}),
        "Description": f"x = {field.left:.9g} + {field.pixel:.9g} (column + 1/2), "
        f"y = {field.top:.9g} - {field.pixel:.9g} (row + 1/2), z = {field.heights[0]:.9g} + "
        f"{settings.spacing:.9g} plane" + (f", a frame every {step:.9g}" if step else "") + ", in units of the scene",
    }
