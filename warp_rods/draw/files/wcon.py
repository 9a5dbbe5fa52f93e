"""WCON, the format of the Tracker Commons for midlines of worms: JSON with x, y and z of each rod at each frame.

Rods are where they were saved, not shifted into a periodic box; lost ones are null.
https://github.com/openworm/tracker-commons
"""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.draw.files.saved import saved_positions
from warp_rods.draw.files.text import filled
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.rods import Rods

__all__ = ["size", "write"]

DIGITS = 9


def write(content: Content, path: Path) -> None:
    """Write a record of each rod at each frame; its id is "ENSEMBLE NUMBER". Numbers have the units of the scene."""
    head = {"units": _units(content), "metadata": _metadata(content)}
    paths = [saved_positions(rods) for rods in content.rods]
    records = [_records(rods) for rods in content.rods]
    with path.open("w", encoding="utf-8") as file:
        file.write(json.dumps(head, ensure_ascii=False, indent=1)[:-2] + ',\n "data": [\n')
        for frame in with_progress(range(content.frames), "WCON"):
            when = f"{content.times[frame]:.9g}"
            texts = [
                filled(text.replace("@", when), np.moveaxis(next(positions), -1, 1), DIGITS, "null")
                for text, positions in zip(records, paths, strict=True)
            ]
            file.write(",\n".join(texts) + (",\n" if frame < content.frames - 1 else "\n ]\n}\n"))


def size(content: Content) -> float:
    """About how many bytes the file has."""
    return 300 + content.frames * sum(rods.count * (50 + rods.nodes * 3 * (DIGITS + 3)) for rods in content.rods)


def _records(rods: Rods) -> str:
    """The records of a frame: "@" for its time, "%s" for each number."""
    row = ", ".join(["%s"] * rods.nodes)
    axes = ", ".join(f'"{axis}": [[{row}]]' for axis in "xyz")
    return ",\n".join(f'{{"id": "{rods.name} {rod}", "t": [@], {axes}}}' for rod in range(rods.count))


def _units(content: Content) -> dict[str, str]:
    """Units of length and time as the format writes them, such as "2.5*um"; "1" where there are none."""
    length = "1"
    if content.scene.units:
        microns = f"{content.metres * 1e6:.12g}"
        length = "um" if microns == "1" else f"{microns}*um"
    time = "1" if content.seconds is None else "s" if content.seconds == 1 else f"{content.seconds:.12g}*s"
    return {"t": time, "x": length, "y": length, "z": length}


def _metadata(content: Content) -> dict[str, Any]:
    software = {"name": "warp-rods", "version": version("warp-rods")}
    return {"id": content.title, "software": {"tracker": software}}
