"""GSD, the format of HOOMD-blue, which OVITO, MDAnalysis and freud read: nodes as beads, bonds along each rod.

Beads are in the periodic box, with the number of the box that each is in (``image``), so that paths can be made whole.
Where space is open the box is around all that happens. Lost rods stay where they were frozen, and have no value (NaN).
Single precision.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.draw.files.optional import needed
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content

__all__ = ["size", "write"]


def write(content: Content, path: Path) -> None:
    """Write the rods to ``path``: positions, images, diameters, bonds, the time, and the colour as ``log`` of beads."""
    hoomd = needed("gsd.hoomd", "--gsd")
    edges = _box(content)
    still = _still(content)
    with hoomd.open(str(path), "w") as file:
        for frame in with_progress(range(content.frames), "GSD"):
            beads = np.concatenate([rods.variable("position", frame).reshape(-1, 3) for rods in content.rods])
            now = hoomd.Frame()
            now.configuration.step = content.numbers[frame]
            now.configuration.box = [*edges, 0.0, 0.0, 0.0]
            _fill(now, still)
            image = np.rint(beads / edges) * (content.period > 0)
            now.particles.position = (beads - image * edges).astype(np.float32)
            now.particles.image = image.astype(np.int32)
            now.log["time"] = np.array([content.times[frame]])
            if frame == 0:  # it counts for all frames
                now.log["particles/rod"] = still["rod"]
            values = np.concatenate([rods.values(frame).ravel() for rods in content.rods])
            now.log[f"particles/{content.selection.colour}"] = values.astype(np.float32)
            file.append(now)


def size(content: Content) -> float:
    """About how many bytes the file has."""
    beads = sum(rods.count * rods.nodes for rods in content.rods)
    of_a_frame = beads * (12 + 4 + (12 if content.period.any() else 0)) + 600
    return content.frames * of_a_frame + beads * 28


def _fill(frame: Any, still: dict[str, Any]) -> None:
    """What is the same in all frames; the library stores it once."""
    particles, bonds = frame.particles, frame.bonds
    particles.N, particles.types = len(still["kind"]), still["kinds"]
    particles.typeid, particles.diameter = still["kind"], still["diameter"]
    bonds.N, bonds.types = len(still["bonds"]), still["kinds"]
    bonds.group, bonds.typeid = still["bonds"], still["kind"][still["bonds"][:, 0]]


def _still(content: Content) -> dict[str, Any]:
    """Kind, diameter and rod of each bead, and the bonds [bond, 2]; rods are numbered through all ensembles."""
    kind, diameter, rod, bonds, beads, before = [], [], [], [], 0, 0
    for index, rods in enumerate(content.rods):
        own = rods.count * rods.nodes
        numbers = beads + np.arange(own).reshape(rods.count, rods.nodes)
        bonds.append(np.stack([numbers[:, :-1].ravel(), numbers[:, 1:].ravel()], axis=1))
        kind.append(np.full(own, index, np.uint32))
        diameter.append(np.full(own, 2 * rods.radius, np.float32))
        rod.append(np.repeat(np.arange(before, before + rods.count, dtype=np.int32), rods.nodes))
        beads, before = beads + own, before + rods.count
    return {
        "kinds": [rods.name for rods in content.rods],
        "kind": np.concatenate(kind),
        "diameter": np.concatenate(diameter),
        "rod": np.concatenate(rod),
        "bonds": np.concatenate(bonds).astype(np.uint32),
    }


def _box(content: Content) -> np.ndarray:
    """The edges [3] of a box around the origin: the periods, and where space is open room for all rods."""
    reach = np.zeros(3)
    if not content.period.all():
        for rods in content.rods:
            for frame in range(content.frames):
                positions = rods.variable("position", frame)
                reach = np.maximum(reach, np.abs(positions).max(axis=(0, 1)) + rods.radius)
    return np.where(content.period > 0, content.period, 2 * np.maximum(reach, 1e-6) * (1 + 1e-5))
