"""A cell that fails soon, and one that does not."""

from warp_rods.scene.scene import Scene

SOUND = {"bend": 5e-3, "moment": 0.0}
DOOMED = {"bend": 1e-6, "moment": 5.0}
"""Bends by more than half a turn between two of its 17 nodes at t = 0.03."""


def scene(*cells: dict, **tables) -> Scene:
    """Cells with these parameters, side by side, that do not feel each other."""
    parameters = {key: [cell[key] for cell in cells] for key in SOUND}
    place = {"position": [[0, 2.0 * i, 0] for i in range(len(cells))]}
    kind = {"name": "cells", "count": len(cells), "nodes": 17, "twist": 1e-3, "placement": place}
    kind["shape"] = {"kind": "mode", "mode": 0}
    return Scene(swimmers=[kind | parameters], **{"time": {"end": 0.2, "save_every": 0.05}, **tables})
