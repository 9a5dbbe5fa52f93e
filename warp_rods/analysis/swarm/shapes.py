"""Shapes of the rods of a swarm in each frame; ``motion_class`` classifies their motion instead.

The shape follows from the twist-free bending k = Ω1 + iΩ2 in units of 1/L. It does not depend on the gauge, which
changes the phase of k. Failed rods are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from warp_rods.analysis.described import FRAMES, described, lengths, need
from warp_rods.analysis.shape import bending
from warp_rods.analysis.swarm.data import blocks, surviving
from warp_rods.frames import writhe
from warp_rods.rods import modes

MODES = 6
"""Number of beam modes that describe a shape."""
STRAIGHT = 0.5
"""Root-mean-square bending times length below which a rod is straight; the tangent of such a U turns by 24°."""
WRITHED = 0.5
"""Magnitude of the writhe above which a rod is coiled; computed only for rods with ∫ |k| ds > 2π."""


class Snapshot(NamedTuple):
    """Properties that define the shape classes, each [frame, rod]."""

    size: np.ndarray
    leading: np.ndarray
    turns: np.ndarray
    writhe: np.ndarray


SHAPES: dict[str, Callable[[Snapshot], np.ndarray]] = {
    "straight": lambda now: now.size < STRAIGHT,
    "coiled": lambda now: (now.turns > 1) | (np.abs(now.writhe) > WRITHED),
    "U": lambda now: now.leading == 0,
    "S": lambda now: now.leading == 1,
    "W": lambda now: now.leading == 2,
    "higher": lambda now: now.leading > 2,
}
"""Definition of each class; the first that applies gives the name. ``leading`` is the largest beam mode, ``turns`` are
turns of the tangent from end to end, |∫ k ds|/2π."""


def shape_shares(dataset: xr.Dataset) -> xr.DataArray:
    """Fractions of straight, coiled, U-, S-, W-shaped rods (frame, shape).

    With the fraction of higher modes they sum to one. A rod is straight where its root-mean-square bending times its
    length is below 0.5 (the tangent of such a U turns by 24°), and coiled where its tangent turns by more than a whole
    turn or its writhe exceeds 0.5. Any other rod is named by its largest beam mode: U, S, W for the first three, higher
    for the rest. Raises ValueError where there are no strains, or the rods are not swimmers.
    """
    shapes = shape_of(dataset)
    counts = np.stack([(shapes == name).mean("rod").to_numpy() for name in SHAPES], axis=1)
    found = described(dataset, ("frame", "shape"), counts, "1", "fraction of the rods", "k on the beam modes, (4.35)")
    return found.assign_coords(shape=list(SHAPES))


def shape_of(dataset: xr.Dataset) -> xr.DataArray:
    """Shape of each rod by name (frame, rod), from the table ``SHAPES``; raises ValueError as ``shape_shares`` does."""
    need(dataset, "strain", "activity", "position")
    dataset = surviving(dataset)
    names, first = [], 0
    for strain in blocks(dataset["strain"].transpose("frame", "rod", "node", "strain_component"), "shapes"):
        frames = dataset.isel(frame=slice(first, first + len(strain)))
        now = _snapshot(frames.assign(strain=(("frame", "rod", "node", "strain_component"), strain)))
        names.append(np.select([holds(now) for holds in SHAPES.values()], list(SHAPES), ""))
        first += len(strain)
    found = described(dataset, FRAMES, np.concatenate(names), "1", "shape", "k on the beam modes, (4.35)")
    return found.assign_coords(rod=dataset["rod"])


def _snapshot(frames: xr.Dataset) -> Snapshot:
    s = frames["s"].to_numpy()
    k = bending(frames, twist_free=True) * lengths(frames)[..., None]
    square = sum(modes.coefficients(part, s, MODES) ** 2 for part in (k.real, k.imag))
    folded = np.trapezoid(np.abs(k), s, axis=-1) > 2 * np.pi
    found = np.zeros(folded.shape)
    if folded.any():
        position = frames["position"].transpose("frame", "rod", "node", "axis").to_numpy()
        found[folded] = writhe(position[folded])
    return Snapshot(
        size=np.sqrt(np.trapezoid(np.abs(k) ** 2, s, axis=-1)),
        leading=np.argmax(square, axis=-1),
        turns=np.abs(np.trapezoid(k, s, axis=-1)) / (2 * np.pi),
        writhe=found,
    )
