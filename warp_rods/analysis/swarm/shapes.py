"""Which shapes the rods of a swarm have, frame by frame; ``motion_class`` is about their motion instead.

The shape follows from the twist-free bending k = Ω1 + iΩ2 in units of 1/L, in any gauge: the phase of k depends on the
directors. Rods that failed are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from warp_rods.analysis.described import FRAMES, described, lengths, need
from warp_rods.analysis.shape import bending
from warp_rods.analysis.swarm.data import blocks, surviving
from warp_rods.analysis.writhe import writhe
from warp_rods.rods import modes

MODES = 6
"""Number of beam modes that describe a shape."""
STRAIGHT = 0.5
"""Bending, root mean square along a rod times its length, below which it counts as straight: a U of it turns by 24°."""
WRITHED = 0.5
"""Writhe, of either hand, above which a rod is coiled; it is taken of rods with ∫ |k| ds > 2π only."""


class Snapshot(NamedTuple):
    """What the classes are made of, each [frame, rod]."""

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
"""What each class means; the first that holds gives the name. ``leading`` is the largest beam mode, ``turns`` are those
of the tangent from end to end, |∫ k ds|/2π."""


def shape_shares(dataset: xr.Dataset) -> xr.DataArray:
    """Shares of straight, coiled, U-, S-, W-shaped rods (frame, shape).

    With those of higher modes they add up to one. A rod is straight while its bending, root mean square along it times
    its length, is below 0.5 (a U then turns by 24°), and coiled if it turns by more than a whole turn or writhes. Any
    other is named by its largest beam mode: U, S, W for the first three, higher for the rest. Energies tell how
    strongly it is bent. Raises ValueError where there are no strains, or the rods are not swimmers.
    """
    shapes = shape_of(dataset)
    counts = np.stack([(shapes == name).mean("rod").to_numpy() for name in SHAPES], axis=1)
    found = described(dataset, ("frame", "shape"), counts, "1", "share of the rods", "k on the beam modes, (4.35)")
    return found.assign_coords(shape=list(SHAPES))


def shape_of(dataset: xr.Dataset) -> xr.DataArray:
    """Shape of each rod by name (frame, rod), from the table ``SHAPES``; raises ValueError as ``shape_shares``."""
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
    k = bending(frames, twist_free=True) * lengths(frames)[:, None]
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
