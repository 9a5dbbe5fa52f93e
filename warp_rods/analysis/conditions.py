"""What measures need of data besides variables: frames, growth, distances.

``measures(data)`` lists a measure where its conditions hold. They are about its default options: with others it may be
possible all the same.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from warp_rods.analysis.kymograph import ROUND_OFF
from warp_rods.analysis.motion_class import FEWEST, late_frames
from warp_rods.analysis.swarm.data import centres, middles, period_of, rod_length, space, surviving
from warp_rods.analysis.swarm.motion import evenly_spaced
from warp_rods.analysis.swarm.space import shortest_side


@dataclass(frozen=True)
class Condition:
    """A condition in ``words``, for the printed table, and the function of an ensemble that says whether it holds.

    ``of_ends``: the function needs the first and the last frame alone.
    """

    words: str
    holds: Callable[[xr.Dataset], bool]
    of_ends: bool = False


def frames(fewest: int) -> Condition:
    """At least so many frames."""
    return Condition(f"{fewest} frames", lambda dataset: dataset.sizes["frame"] >= fewest)


def even_frames(fewest: int) -> Condition:
    """At least so many frames, equally spaced in time."""
    return Condition(
        f"{fewest} frames at equal intervals",
        lambda dataset: dataset.sizes["frame"] >= fewest and evenly_spaced(dataset["time"].to_numpy()),
    )


def _has_late_frames(dataset: xr.Dataset) -> bool:
    try:
        late_frames(dataset, None)
    except ValueError:
        return False
    return True


def _grows(dataset: xr.Dataset) -> bool:
    if "frame" not in dataset["length"].dims:
        return False
    first, last = (dataset["length"].isel(frame=at).to_numpy() for at in (0, -1))
    return bool((np.abs(last - first) > ROUND_OFF * first).any())


def _apart(points: Callable[[xr.Dataset], np.ndarray], dataset: xr.Dataset) -> bool:
    dataset = surviving(dataset)
    where = space(dataset)
    return all(shortest_side(now, where.period) > 0 for now in points(dataset)[..., where.axes])


def _wide(dataset: xr.Dataset) -> bool:
    return bool(2 * rod_length(dataset) <= period_of(dataset).min())


LATE_FRAMES = Condition(f"{FEWEST} frames at equal intervals in the later half", _has_late_frames)
GROWTH = Condition("growth", _grows, of_ends=True)
MIDDLES_APART = Condition("rods at several places", partial(_apart, middles), of_ends=True)
CENTRES_APART = Condition("rods at several places", partial(_apart, centres), of_ends=True)
WIDE_BOX = Condition("a box two rods wide", _wide, of_ends=True)
