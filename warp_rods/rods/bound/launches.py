"""Sequences of kernels of an ensemble of surface-bound filaments, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.bound import evaluation, frames, levels, step
from warp_rods.kernels.layout import per_rod
from warp_rods.kernels.status import give_up
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.arrays import Arrays, allocate_contact, allocate_outside, slice_arrays
from warp_rods.rods.clock import Clock
from warp_rods.rods.outside import Outside
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices


class BoundLaunches:
    """``predict``, ``try_step``, ``accept``, ``advance_past``: steps; ``show``, ``find_output``: a frame."""

    def __init__(self, arrays: Arrays, surface: Surface, clock: Clock, middle: int):
        self.arrays, self.clock, self.middle = arrays, clock, middle
        self.rods, self.nodes = arrays.f.position.shape
        self.device = arrays.f.geodesic.device
        self._membrane = surface
        self._parameters = surface.device_parameters(self.device)
        self._parameters_time = 0.0
        self._ends = tuple(wp.vec3d(*corner) for corner in ends_of(surface))
        self._surface = frames.on_surface(surface.field)
        self._motion = frames.motion_of(surface.field, surface.rate) if surface.moving else None
        self._target = per_rod(3, device=self.device)
        self._now = per_rod(1, device=self.device)
        self._fields: list = []
        self._record()

    def _record(self) -> None:
        self.version = object()
        parts = self._slices()
        self._predict = RecordedInThreads(
            [partial(self._launch_predict, a, 0, self.clock.array) for a in parts], self.device
        )
        self._try = RecordedInThreads([partial(self._launch_try, a) for a in parts], self.device)
        self._accept = RecordedInThreads([partial(self._launch_accept, a, 0) for a in parts], self.device)
        alone = self._slices(own_pace=True)
        self._behind = [per_rod(1, wp.int32, self.device) for _ in alone]
        own = [partial(self._launch_own_step, *pair) for pair in zip(alone, self._behind, strict=True)]
        self._own_step = RecordedInThreads(own, self.device)
        self._reject = Recorded(
            partial(self._launch, levels.count_rejected, self.rods, self.arrays.f, self.arrays.pace), self.device
        )
        self._show = Recorded(self._launch_show, self.device)
        self._find_output = Recorded(self._launch_output, self.device)

    def _slices(self, own_pace: bool = False) -> list[Arrays]:
        """The arrays in slices of rods, one for each thread."""
        parts = thread_slices(self.rods, self.nodes, self.device, own_pace)
        return [slice_arrays(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._try.threads

    def enable_contact(self) -> None:
        """Allocate what contact needs."""
        allocate_contact(self.arrays)
        self._record()

    def enable_outside(self, outside: Outside) -> None:
        """Allocate what acts from outside."""
        self._fields = outside.fields()
        allocate_outside(self.arrays, outside)
        self._record()

    def find_output(self, time: float) -> None:
        """Evaluate the frames that are shown, which are those of a time."""
        if self._fields:
            self._now.assign([time])
        self._find_output()

    def _launch_outside(self, a: Arrays, end: wp.array) -> None:
        """What acts from outside at the places of the nodes and at these times [rod] or [1]."""
        for field in self._fields:
            self._launch(field, a.f.position.shape, a.f.position, end, a.f.outside)

    def _launch(self, kernel, dim, *inputs) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def place(self, node: int, direction: np.ndarray) -> None:
        """Project one node and its direction [rod, 3] onto the surface, and lay out the others from it."""
        a = self.arrays
        given: wp.array = wp.array(direction, dtype=wp.vec3d, device=self.device)
        self._launch(self._surface.place, a.tiles, a.f, a.plan, self._parameters, node, given)
        self._launch_lay_out(a, node)

    def set_membrane_time(self, time: float) -> None:
        """Set the parameters of a moving membrane to those at this time; nothing to do for a membrane at rest."""
        if self._membrane.moving and time != self._parameters_time:
            with exclusive:
                wp.copy(self._parameters, self._membrane.device_parameters(self.device, time))
            self._parameters_time = time

    def predict(self, end: float) -> None:
        """Put every rod that is not frozen at the extrapolated state of a step to the time ``end``."""
        self.set_membrane_time(end)
        self._predict()

    def try_step(self) -> None:
        """Find the result of the step and its error, under the forces at the extrapolated state."""
        self._try()

    def reject(self) -> None:
        """Count the step tried as repeated."""
        self._reject()

    def give_up(self, allowed: float) -> None:
        """Make results with an error above ``allowed`` invalid."""
        with exclusive:
            self._launch(give_up, self.rods, self.arrays.plan.error, allowed, self.arrays.plan.status)

    def accept(self) -> None:
        """Make the result the present state."""
        self._accept()

    def advance_past(self, time: float, tolerance: float, unit: float) -> None:
        """Steps of every rod that is not frozen until it reaches ``time``; ``show`` then finds its state."""
        self._target.assign([time, tolerance, unit])
        self._own_step.while_true([partial(_is_set, behind) for behind in self._behind])

    def show(self, time: float) -> None:
        """Find the state at this time within the last step of each rod; infinity: at its end."""
        self.set_membrane_time(min(time, self.clock.reached))
        self._target.assign([time, 0.0, 0.0])
        self._show()

    def _launch_predict(self, a: Arrays, own: int, clock: wp.array, behind: wp.array | None = None) -> None:
        state = (a.f, a.past, a.pace, a.plan, a.growth)
        self._launch(self._surface.predict, a.tiles, *state, own, clock, behind, self._parameters)
        self._launch_lay_out(a, a.f.tracked)

    def _launch_lay_out(self, a: Arrays, node: int) -> None:
        self._launch(self._surface.lay_out, a.tiles, a.f, a.plan, self._parameters, node, *self._ends)

    def _launch_try(self, a: Arrays) -> None:
        self._launch_motion(a)
        self._launch_outside(a, a.plan.end)
        self._launch(step.try_step, a.tiles, a.f, a.past, a.pace, a.plan, a.systems)

    def _launch_accept(self, a: Arrays, own: int) -> None:
        state = (a.f, a.past, a.pace, a.plan)
        self._launch(self._surface.take, a.tiles, *state, own, self._target, self._parameters)

    def _launch_own_step(self, a: Arrays, behind: wp.array) -> None:
        self._launch(levels.reset, 1, behind)
        self._launch_predict(a, 1, self._target, behind)
        self._launch_try(a)
        self._launch_accept(a, 1)

    def _launch_motion(self, a: Arrays) -> None:
        if self._membrane.moving:
            self._launch(self._motion, a.f.position.shape, a.f, self._parameters)

    def _launch_show(self) -> None:
        a = self.arrays
        state = (a.f, a.past, a.pace, a.plan, a.growth)
        self._launch(self._surface.show, a.tiles, *state, self._target, self._parameters)
        self._launch_lay_out(a, a.f.tracked)

    def _launch_output(self) -> None:
        a = self.arrays
        self._launch_motion(a)
        self._launch_outside(a, self._now)
        self._launch(evaluation.find_output, a.tiles, a.f, a.systems, self.middle, a.output)
        self._launch(evaluation.find_orientations, a.f.position.shape, a.f, a.output.orientation)
        self._launch(self._surface.residuals, a.rods, a.f, self._parameters, a.residuals)


def _is_set(flag: wp.array) -> bool:
    return bool(flag.numpy()[0])
