"""Sequences of kernels of an ensemble of free rods, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial
from typing import Any

import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.free import equal_steps, holding, load, output, outside, own_steps
from warp_rods.kernels.layout import per_rod
from warp_rods.kernels.status import give_up
from warp_rods.rods.clock import Clock
from warp_rods.rods.free.arrays import (
    Arrays,
    allocate_contact,
    allocate_force,
    allocate_hold,
    allocate_outside,
    slice_arrays,
)
from warp_rods.rods.outside import Outside
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices


class FreeLaunches:
    """The sequences ``predict``, ``try_step``, ``accept``, ``reject``, ``advance_past`` of steps, and those of output.

    Without external forces a step needs no frames in space and computes none. After ``enable_forces`` it extrapolates
    the frames to its end and takes ``force`` [rod, node], in space, there; after ``enable_contact`` also the stiffness.
    """

    def __init__(self, arrays: Arrays, clock: Clock):
        self.arrays, self.clock = arrays, clock
        self.rods, self.nodes = arrays.position.shape
        self.device = arrays.position.device
        self._field: Any = None
        self._fields: list[Any] = []
        self._target = per_rod(3, device=self.device)
        self.show_at(clock.time)
        self.record()

    def enable_forces(self, field: Any = None) -> None:
        """Allocate external forces. A ``field`` kernel, if given, evaluates them in each step."""
        allocate_force(self.arrays)
        self._field = field
        self.record()
        self.find_frames()

    def enable_hold(self) -> None:
        """Allocate what holds ends in space; external forces must be enabled."""
        allocate_hold(self.arrays)
        self.record()

    def enable_outside(self, given: Outside) -> None:
        """Allocate what acts from outside; external forces must be enabled."""
        fields = given.fields()
        allocate_outside(self.arrays, given)
        self._fields = fields
        self.record()

    def enable_contact(self) -> None:
        """Allocate the stiffness of contact; external forces must be enabled."""
        allocate_contact(self.arrays)
        self.record()

    def record(self) -> None:
        """Record the sequences anew, after a change of the structs."""
        parts = self._slices()

        def in_threads(launch: Any, parts: Any = parts) -> RecordedInThreads:
            return RecordedInThreads([partial(launch, a) for a in parts], self.device)

        self.predict = in_threads(self._launch_predict)
        self.try_step = in_threads(self._launch_try)
        self._accept = in_threads(self._launch_accept)
        self._advance_past = in_threads(self._launch_advance_past, self._slices(own_pace=True))
        self.reject = Recorded(self._launch_reject, self.device)
        self.find_frames = Recorded(partial(self._launch_frames, self.arrays), self.device)
        self.find_force = Recorded(partial(self._launch_present_force, self.arrays), self.device)
        self.find_output = Recorded(self._launch_output, self.device)
        self.find_material_frame = Recorded(self._launch_material_frame, self.device)

    def _slices(self, own_pace: bool = False) -> list[Arrays]:
        """The arrays in slices of rods, one for each thread."""
        parts = thread_slices(self.rods, self.nodes, self.device, own_pace)
        return [slice_arrays(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self.try_step.threads

    def give_up(self, allowed: float) -> None:
        """Make results with an error above ``allowed`` invalid."""
        with exclusive:
            self._launch(give_up, self.rods, self.arrays.trial.error, allowed, self.arrays.trial.status)

    def accept(self) -> None:
        """Make the result of the step tried the present state of every rod that is not frozen."""
        self._accept()

    def advance_past(self, time: float, tolerance: float, unit: float) -> None:
        """Steps of every rod that is not frozen until it reaches ``time``; output is then that of ``time``."""
        self._target.assign([time, tolerance, unit])
        self._advance_past()

    def show_at(self, time: float) -> None:
        """Make output that of this time within the last step of each rod."""
        with exclusive:
            self._target.assign([time, 0.0, 0.0])

    def _launch(self, kernel: Any, dim: Any, *inputs: Any) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    # --- a step -----------------------------------------------------------------------------------------------------

    def _launch_predict(self, a: Arrays) -> None:
        if a.hold is not None:
            self._launch(output.lay_out, _tiles(a), a.rods, a.now, a.midpoint, a.rotation, a.position)
            present = (a.rods, a.now, a.midpoint, a.rotation, a.position, a.hold)
            self._launch(holding.find_drift, (a.position.shape[0], 2), *present)
        self._launch(equal_steps.predict, _tiles(a), a.rods, a.now, a.past, a.pace, self.clock.array, a.trial, a.star)
        if a.force is None and not a.rods.bent:
            return
        foretold = (a.rods, a.pace, a.midpoint, a.trial)
        self._launch(equal_steps.predict_midpoint, a.position.shape[0], *foretold, *_frame(a))
        if a.force is not None:
            self._launch_lay_out(a, a.star)
            self._launch_field(a, self.clock.array)
            self._launch_outside(a, a.trial.end)

    def _launch_try(self, a: Arrays) -> None:
        if a.force is not None:
            self._launch_load(a, a.step_balance.load)
        if a.hold is not None:
            held = (a.rods, a.star, a.trial.angle, a.pace, self.clock.array, a.rotation, a.hold)
            self._launch(holding.set_ends, _tiles(a), *held)
        if a.contact.present:
            contact = (a.rods, a.rotation, a.pace, a.trial, a.contact, a.step_balance.load)
            self._launch(load.add_contact_drag, _tiles(a), *contact)
        state = (a.rods, a.now, a.past, a.midpoint, a.pace, a.trial, a.contact, a.star)
        self._launch(equal_steps.try_step, _tiles(a), *state, a.slope, a.step_balance)

    def _launch_accept(self, a: Arrays) -> None:
        state = (a.rods, a.now, a.past, a.midpoint, a.pace, a.trial, a.contact, a.star)
        self._launch(equal_steps.accept_step, _tiles(a), *state, a.failed_at)

    def _launch_reject(self) -> None:
        self._launch(equal_steps.reject_step, self.rods, self.arrays.rods, self.arrays.pace)

    def _launch_advance_past(self, a: Arrays) -> None:
        state = (a.rods, a.now, a.past, a.midpoint, a.pace, self._target, a.failed_at)
        self._launch(own_steps.advance_past, _tiles(a), *state, a.trial, a.star, a.slope, a.step_balance)

    def _launch_field(self, a: Arrays, time: wp.array) -> None:
        if self._field is not None:
            self._launch(self._field, a.position.shape, a.position, a.rotation, time, a.force)

    def _launch_outside(self, a: Arrays, end: wp.array) -> None:
        """What acts from outside at the places in the arrays and these times [rod] or [1]."""
        for field in self._fields:
            self._launch(field, a.position.shape, a.position, end, a.outside)

    def _launch_load(self, a: Arrays, balanced: Any) -> None:
        """All forces and couples in the frames in the arrays."""
        self._launch(load.find_force, _tiles(a), a.rotation, a.force, balanced)
        if a.outside is None:
            return
        if a.outside.flowing or a.outside.turning:
            self._launch(outside.set_couple, _tiles(a), a.couple, a.across, a.outside, balanced)
        if a.outside.flowing:
            self._launch(outside.add_flow, _tiles(a), a.rods, a.rotation, a.outside, balanced)
        if a.outside.pushing:
            self._launch(outside.add_outside, _tiles(a), a.rotation, a.outside, balanced)

    # --- output -----------------------------------------------------------------------------------------------------

    def _launch_show(self, a: Arrays) -> None:
        self._launch(own_steps.show_shape, _tiles(a), a.now, a.past, a.pace, self._target, a.shown)
        self._launch(own_steps.show_midpoint, a.position.shape[0], a.midpoint, a.pace, self._target, *_frame(a))

    def _launch_frames(self, a: Arrays) -> None:
        self._launch_show(a)
        self._launch_lay_out(a, a.shown)

    def _launch_present_force(self, a: Arrays) -> None:
        self._launch_frames(a)
        self._launch_field(a, self._target)
        self._launch_outside(a, self._target[:1])

    def _launch_lay_out(self, a: Arrays, shape: Any) -> None:
        """Frames at all nodes from those of the middle."""
        self._launch(output.lay_out, _tiles(a), a.rods, shape, a.shown_midpoint, a.rotation, a.position)

    def _launch_output(self) -> None:
        a = self.arrays
        if a.force is None:
            self._launch_show(a)
        else:
            self._launch_present_force(a)
            self._launch_load(a, a.balance.load)
        if a.hold is not None:
            held = (a.rods, a.shown, a.shown_midpoint.angle, a.pace, self.clock.array, a.rotation, a.hold)
            self._launch(holding.set_ends, _tiles(a), *held)
        self._launch(output.find_output, _tiles(a), a.rods, a.shown, a.shown_midpoint.angle, a.balance, a.output)

    def _launch_material_frame(self) -> None:
        a = self.arrays
        self._launch_frames(a)
        frames = (a.rods, a.shown, a.shown_midpoint, a.rotation, a.strain, a.orientation)
        self._launch(output.find_material_frame, (self.rods, self.nodes), *frames)


def _tiles(a: Arrays) -> int:
    """The number of tiles of rods."""
    return a.now.twist.shape[0]


def _frame(a: Arrays) -> tuple[wp.array, wp.array, wp.array]:
    """The middle frame from which frames are laid out."""
    return a.shown_midpoint.rotation, a.shown_midpoint.position, a.shown_midpoint.angle
