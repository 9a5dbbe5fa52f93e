"""CSV: a row for each node of each rod at each frame, with the quantity that the colours show.

Rods are where they were saved, not shifted into a periodic box; lost ones are empty.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from warp_rods.draw.files.saved import saved_positions
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content

__all__ = ["COLUMNS", "size", "write"]

COLUMNS = ("frame", "time", "ensemble", "rod", "node", "s", "x", "y", "z")
"""Followed by the colour. frame: its number in the trajectory; s: along the rod, from −1/2 to 1/2."""
DIGITS = 9


def write(content: Content, path: Path) -> None:
    """Write the table, frame by frame; numbers have nine digits."""
    import pandas as pd

    paths = [saved_positions(rods) for rods in content.rods]
    still = [_still(rods.name, rods.count, rods.data["s"].values) for rods in content.rods]
    with path.open("w", encoding="utf-8", newline="") as file:
        for frame in with_progress(range(content.frames), "CSV"):
            for index, rods in enumerate(content.rods):
                x, y, z = next(paths[index]).reshape(-1, 3).T
                own = {"frame": content.numbers[frame], "time": content.times[frame], **still[index]}
                own |= {"x": x, "y": y, "z": z, content.selection.colour: rods.values(frame).ravel()}
                first = frame == 0 and index == 0
                pd.DataFrame(own).to_csv(file, header=first, index=False, float_format=f"%.{DIGITS}g")


def size(content: Content) -> float:
    """About how many bytes the file has."""
    return content.frames * sum(rods.count * rods.nodes * (20 + len(rods.name) + 6 * DIGITS) for rods in content.rods)


def _still(name: str, count: int, s: np.ndarray) -> dict[str, np.ndarray | str]:
    """Columns that are the same at all frames."""
    nodes = len(s)
    return {
        "ensemble": name,
        "rod": np.repeat(np.arange(count), nodes),
        "node": np.tile(np.arange(nodes), count),
        "s": np.tile(s, count),
    }
