"""What rods of an ensemble do at random times: their events, and the targets of their flagella meanwhile."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import warp as wp

from warp_rods import arguments
from warp_rods.device import exclusive
from warp_rods.errors import SceneError
from warp_rods.kernels.free import behaviour as kernels
from warp_rods.kernels.layout import to_host
from warp_rods.rods.free.arrays import Arrays, allocate_couple_across
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.per_rod import each_rod, parameter
from warp_rods.rods.status import Status
from warp_rods.scene.behaviour import BEHAVIOURS, BehaviourTable
from warp_rods.scene.checks import read_table
from warp_rods.scene.flagella import needs_target

__all__ = ["EVENTS", "Behaviours", "behaviours_of", "drag_of_turning", "seed_and_streams", "turning"]

EVENTS = {"event_time": "time", "event_count": "count"}
"""Name in a state → array of events."""
NEAR = 2e-14
"""A time is that of an event if it is nearer than this, relative."""
WORDS = 2**64
"""Seeds and streams are below this."""


def behaviours_of(given: Any, count: int, flagella: Flagella) -> dict[str, dict[str, Any]]:
    """Behaviours by name, each with its parameters by name, as plain values; raises SceneError for impossible ones."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise arguments.wrong("behaviour", given, "a mapping of behaviours to mappings of their parameters")
    found = read_table(BehaviourTable, given, "behaviour").behaviours
    for name, values in found.items():
        for key, value in values.items():
            parameter(f"behaviour.{name}.{key}", value, count, arguments.ANY)
    if found and (text := needs_target(flagella.law)):
        raise SceneError(f"behaviour{text}")
    return found


def seed_and_streams(seed: Any, streams: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The seed and the number of the stream of each rod, [rod] each; raises SceneError for impossible ones."""
    if not np.ndim(seed):
        if arguments.whole("seed", seed, 0) >= WORDS:
            raise arguments.wrong("seed", seed, "below 2^64")
        seed = [seed] * count
    return _whole("seed", seed, count), _whole("streams", np.arange(count) if streams is None else streams, count)


def _whole(name: str, values: Any, count: int) -> np.ndarray:
    """Whole numbers [rod] of 64 bits."""
    given = np.asarray(values)
    if given.shape == (count,) and given.dtype.kind in "iuO":
        whole = [arguments.whole(name, value, 0) for value in given.tolist()]
        if max(whole, default=0) < WORDS:
            return np.array(whole, dtype=np.uint64)
    raise arguments.wrong(name, values, f"whole numbers from 0 to 2^64 − 1, one for each of {count} rods")


def turning(behaviours: Iterable[str]) -> bool:
    """Whether behaviours of these names turn rods."""
    return any(BEHAVIOURS[name].turns for name in behaviours)


def drag_of_turning(drag: np.ndarray, nodes: int) -> np.ndarray:
    """∫ ζ⊥ s² ds about the centre of drag [rod], of a straight rod of length 1; drag: ζ⊥ [rod] or [rod, node]."""
    s, weights = np.linspace(-0.5, 0.5, nodes), np.full(nodes, 1 / (nodes - 1))
    weights[[0, -1]] /= 2
    weights = weights * (drag[:, None] if drag.ndim == 1 else drag)
    arm = s - (weights @ s / weights.sum(axis=1))[:, None]
    return np.asarray((weights * arm**2).sum(axis=1))


class Behaviours:
    """The events of the rods of ``arrays`` under ``behaviours``, with random numbers by seed and stream of each.

    law: the parameters of the law of the flagella [rod, 4]. drag: ``drag_of_turning``.
    """

    def __init__(
        self,
        behaviours: Mapping[str, Mapping[str, Any]],
        arrays: Arrays,
        law: np.ndarray,
        drag: np.ndarray,
        seeds: np.ndarray,
        streams: np.ndarray,
    ):
        self._names, self._arrays = list(behaviours), arrays
        rods, device = len(law), arrays.position.device
        self._device = device
        values = np.zeros((rods, len(behaviours), 4))
        for column, (name, given) in enumerate(behaviours.items()):
            for k, key in enumerate(BEHAVIOURS[name].parameters):
                values[:, column, k] = each_rod(given[key], rods)
        b = self._struct = kernels.Behaviours()
        kinds = [int(getattr(kernels, BEHAVIOURS[name].kernel)) for name in behaviours]
        b.kind = wp.array(kinds, dtype=wp.int32, device=device)
        b.parameters = wp.array(values, dtype=kernels.Numbers, device=device)
        b.time = wp.zeros(values.shape[:2], dtype=wp.float64, device=device)
        b.count = wp.zeros(values.shape[:2], dtype=wp.int32, device=device)
        b.target = wp.array(law[:, None], dtype=kernels.Numbers, device=device)
        b.drag = wp.array(drag, dtype=wp.float64, device=device)
        if turning(behaviours):
            b.couple = allocate_couple_across(arrays)
        b.stream = wp.array(streams, dtype=wp.uint64, device=device)
        b.seed = wp.array(seeds, dtype=wp.uint64, device=device)
        self._launch(kernels.start, values.shape[:2], b)
        self.set_targets()

    def _launch(self, kernel: Any, dim: Any, *inputs: Any) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self._device)

    @property
    def count_array(self) -> wp.array:
        """The number of events so far on the device [rod, behaviour]."""
        return self._struct.count

    @property
    def counts(self) -> dict[str, np.ndarray]:
        """The number of events of each behaviour so far [rod]."""
        with exclusive:
            counts = to_host(self.count_array)
        return {name: counts[:, column] for column, name in enumerate(self._names)}

    def arrays_of_state(self) -> dict[str, wp.array]:
        """What the next events depend on."""
        return {name: getattr(self._struct, array) for name, array in EVENTS.items()}

    def set_targets(self) -> None:
        """Make targets and limits of steps those that follow from the events so far."""
        a = self._arrays
        self._launch(kernels.set_targets, a.now.twist.shape[0], a.rods, a.trial, self._struct)

    def next_event(self, reached: float) -> float:
        """The time of the next event of a rod that is not frozen, after those at the time reached have happened."""
        if self.find_next() <= reached * (1 + NEAR):
            self.meet(np.inf)
        return self.find_next()

    def meet(self, before: float) -> None:
        """Let events of rods that have come to one happen, if it is before a time."""
        a = self._arrays
        with exclusive:
            state = (a.rods, a.pace, a.contact, a.trial)
            self._launch(kernels.meet_events, a.now.twist.shape[0], *state, before, self._struct)

    def find_next(self) -> float:
        """The time of the next event of a rod that is not frozen: never kept, as a rod may freeze in any step."""
        with exclusive:
            limit, status = to_host(self._arrays.trial.limit), to_host(self._arrays.rods.status)
        return float(np.min(limit, where=status == Status.OK, initial=np.inf))
