"""Sequences of kernels of an ensemble of Cosserat rods, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial
from typing import Any

import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.cosserat import equal_steps, output
from warp_rods.kernels.layout import per_rod
from warp_rods.kernels.status import give_up
from warp_rods.rods.clock import Clock
from warp_rods.rods.cosserat.arrays import Arrays, allocate_contact, slice_arrays
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices


class CosseratLaunches:
    """The sequences ``predict``, ``try_step``, ``accept``, ``reject`` of a step, and those of output."""

    def __init__(self, arrays: Arrays, clock: Clock):
        self.arrays, self.clock = arrays, clock
        self.rods, self.nodes = arrays.position.shape
        self.device = arrays.position.device
        self._target = per_rod(1, device=self.device)
        self._launch(equal_steps.start, _tiles(arrays), arrays.rods, arrays.now, arrays.past)
        self.show_at(clock.time)
        self._record()

    def enable_contact(self) -> None:
        """Allocate the stiffness of contact."""
        allocate_contact(self.arrays)
        self._record()

    def _record(self) -> None:
        slices = thread_slices(self.rods, self.nodes, self.device)
        parts = [slice_arrays(self.arrays, rods) for rods in slices] if len(slices) > 1 else [self.arrays]

        def in_threads(launch: Any) -> RecordedInThreads:
            return RecordedInThreads([partial(launch, a) for a in parts], self.device)

        self.settle = in_threads(self._launch_settle)
        self.predict = in_threads(self._launch_predict)
        self.try_step = in_threads(self._launch_try)
        self.accept = in_threads(self._launch_accept)
        self.reject = Recorded(self._launch_reject, self.device)
        self.find_frames = Recorded(self._launch_frames, self.device)
        self.find_output = Recorded(self._launch_output, self.device)

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self.try_step.threads

    def give_up(self, allowed: float) -> None:
        """Make results with an error above ``allowed`` invalid."""
        with exclusive:
            self._launch(give_up, self.rods, self.arrays.trial.error, allowed, self.arrays.trial.status)

    def show_at(self, time: float) -> None:
        """Make output that of this time within the last step."""
        with exclusive:
            self._target.assign([time])

    def _launch(self, kernel: Any, dim: Any, *inputs: Any) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def _launch_settle(self, a: Arrays) -> None:
        self._launch(equal_steps.settle, _tiles(a), a.rods, a.now, a.past, a.trial, a.star, a.work)

    def _launch_predict(self, a: Arrays) -> None:
        inputs = (a.rods, a.now, a.past, a.pace, self.clock.array, a.trial, a.star, a.rotation, a.position)
        self._launch(equal_steps.predict, _tiles(a), *inputs)

    def _launch_try(self, a: Arrays) -> None:
        self._launch(equal_steps.try_step, _tiles(a), a.rods, a.past, a.pace, a.trial, a.star, a.work)

    def _launch_accept(self, a: Arrays) -> None:
        inputs = (a.rods, a.now, a.past, a.pace, a.trial, a.star, a.failed_at)
        self._launch(equal_steps.accept_step, _tiles(a), *inputs)

    def _launch_reject(self) -> None:
        self._launch(equal_steps.reject_step, self.rods, self.arrays.rods, self.arrays.pace)

    def _launch_frames(self) -> None:
        a = self.arrays
        inputs = (a.rods, a.now, a.past, a.pace, self._target, a.shown, a.rotation, a.position)
        self._launch(output.show_frames, _tiles(a), *inputs)

    def _launch_output(self) -> None:
        a = self.arrays
        self._launch_frames()
        self._launch(output.find_rates, _tiles(a), a.rods, a.past, a.pace, a.rates)
        self._launch(output.find_output, _tiles(a), a.rods, a.shown, a.rates, a.output)
        self._launch(output.find_quaternions, (self.rods, self.nodes), a.rotation, a.orientation)


def _tiles(a: Arrays) -> int:
    """The number of tiles of rods."""
    return a.now.rotation.shape[0]
