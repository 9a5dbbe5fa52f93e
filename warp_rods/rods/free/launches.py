"""Sequences of kernels of an ensemble of free rods, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.free import motion, output
from warp_rods.kernels.layout import per_rod
from warp_rods.kernels.lie import integrate_frames
from warp_rods.rods.clock import Clock
from warp_rods.rods.free.arrays import Arrays, allocate_force, slice_arrays
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices


class FreeLaunches:
    """The sequences ``advance``, ``find_frames``, ``find_output`` and ``find_material_frame`` of an ensemble.

    Without external forces a step needs no frames in space and computes none. After ``enable_forces`` a step uses
    the present frames and ``force`` [rod, node], in space, and computes the frames at its end.
    """

    def __init__(self, arrays: Arrays, clock: Clock):
        self.arrays, self.clock = arrays, clock
        self.rods, self.nodes = arrays.position.shape
        self.device = arrays.position.device
        self._field: Any = None
        self._target = per_rod(3, device=self.device)
        self.show_at(np.inf)
        self._record()

    def enable_forces(self, field: Any = None) -> None:
        """Allocate external forces. A ``field`` kernel, if given, evaluates them before each step."""
        allocate_force(self.arrays)
        self._field = field
        self._record()
        self.find_frames()

    def _record(self) -> None:
        self.version = object()
        self._advance = RecordedInThreads([partial(self._launch_advance, a) for a in self._slices()], self.device)
        parts = [partial(self._launch_advance_past, a) for a in self._slices()]
        self._advance_past = RecordedInThreads(parts, self.device)
        self._tick = Recorded(self.clock.launch_tick, self.device)
        self.find_frames = Recorded(partial(self._launch_frames, self.arrays), self.device)
        self.find_force = Recorded(partial(self._launch_force, self.arrays), self.device)
        self.find_output = Recorded(self._launch_output, self.device)
        self.find_material_frame = Recorded(self._launch_material_frame, self.device)

    def _slices(self) -> list[Arrays]:
        """The arrays in slices of rods, one for each thread."""
        parts = thread_slices(self.rods, self.nodes, self.device)
        return [slice_arrays(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._advance.threads

    def advance(self) -> None:
        """One step of every rod that is not frozen."""
        self._advance()
        self._tick()

    def advance_past(self, time: float, tolerance: float, unit: float) -> None:
        """Steps of every rod that is not frozen until it reaches ``time``; output is then that of ``time``."""
        self._target.assign([time, tolerance, unit])
        self._advance_past()

    def show_at(self, time: float) -> None:
        """Make output that of this time within the last step of each rod; infinity: that of its end."""
        self._target.assign([time, 0.0, 0.0])

    def _launch(self, kernel: Any, dim: Any, *inputs: Any) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def _launch_force(self, a: Arrays) -> None:
        if self._field is not None:
            self._launch(self._field, a.position.shape, a.position, a.rotation, self.clock.array, a.force)
        if a.force is not None:
            self._launch(output.rotate_force_to_bishop, a.position.shape, a.rotation, a.force, a.external)

    def _launch_advance(self, a: Arrays) -> None:
        self._launch_force(a)
        state = (a.rods, a.now, a.past, a.midpoint, a.pace, a.external, self.clock.array, a.failed_at)
        self._launch(motion.advance, a.position.shape[0], *state, a.star, a.slope, a.step_balance)
        if a.force is not None:
            self._launch_frames(a)

    def _launch_advance_past(self, a: Arrays) -> None:
        state = (a.rods, a.now, a.past, a.midpoint, a.pace, self._target, a.failed_at)
        self._launch(motion.advance_past, a.position.shape[0], *state, a.star, a.slope, a.step_balance)

    def _launch_show(self, a: Arrays) -> None:
        frame = (a.shown_midpoint.rotation, a.shown_midpoint.position, a.shown_midpoint.angle)
        state = (a.now, a.past, a.midpoint, a.pace, self._target, a.shown)
        self._launch(motion.show, a.position.shape[0], *state, *frame)

    def _launch_frames(self, a: Arrays) -> None:
        self._launch_show(a)
        middle = (a.shown, a.shown_midpoint, a.bishop_strain, a.rotation, a.position)
        self._launch(output.set_bishop_strain, a.position.shape, *middle)
        self._launch(
            integrate_frames, a.position.shape[0], a.bishop_strain, a.spacing, self.nodes // 2, a.rotation, a.position
        )

    def _launch_output(self) -> None:
        a = self.arrays
        self._launch_force(a)
        self._launch_show(a)
        self._launch(output.find_output, self.rods, a.rods, a.shown, a.balance, a.output)

    def _launch_material_frame(self) -> None:
        a = self.arrays
        self._launch_frames(a)
        frames = (a.rods, a.shown, a.shown_midpoint, a.rotation, a.strain, a.orientation)
        self._launch(output.find_material_frame, (self.rods, self.nodes), *frames)
