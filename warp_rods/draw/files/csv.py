"""CSV: a row for each node of each rod at each frame, with the quantity that the colours show.

Rods are where they were saved, not shifted into a periodic box; lost ones are empty.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warp_rods.draw.files.saved import saved_positions
from warp_rods.draw.files.text import filled
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.rods import Rods

__all__ = ["COLUMNS", "size", "write"]

COLUMNS = ("frame", "time", "ensemble", "rod", "node", "s", "x", "y", "z")
"""Followed by the colour. frame: its number in the trajectory; s: along the rod, from −1/2 to 1/2."""
DIGITS = 9


def write(content: Content, path: Path) -> None:
    """Write the table, frame by frame; numbers have nine digits."""
    paths = [saved_positions(rods) for rods in content.rods]
    rows = [_rows(rods) for rods in content.rods]
    with path.open("w", encoding="utf-8") as file:
        file.write(",".join([*COLUMNS, content.selection.colour]) + "\n")
        for frame in with_progress(range(content.frames), "CSV"):
            when = f"{content.numbers[frame]},{content.times[frame]:.{DIGITS}g},"
            for index, rods in enumerate(content.rods):
                places = next(paths[index]).reshape(-1, 3)
                values = np.column_stack([places, rods.values(frame).ravel()])
                file.write(filled(rows[index].replace("@", when), values, DIGITS))


def size(content: Content) -> float:
    """About how many bytes the file has."""
    return content.frames * sum(rods.count * rods.nodes * (20 + len(rods.name) + 6 * DIGITS) for rods in content.rods)


def _rows(rods: Rods) -> str:
    """The rows of a frame: "@" for its number and time, "%s" for each number that changes."""
    nodes = [f"{node},{s:.{DIGITS}g},%s,%s,%s,%s\n" for node, s in enumerate(rods.data["s"].values)]
    return "".join(f"@{rods.name},{rod},{node}" for rod in range(rods.count) for node in nodes)
