"""Sequences of kernels of an ensemble of surface-bound filaments, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial

import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.banded import solve_pentadiagonal, solve_tridiagonal
from warp_rods.kernels.bound import angles, contact, energy, frames, levels, linear_systems, load, rod, step
from warp_rods.kernels.layout import per_rod
from warp_rods.kernels.status import give_up
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.arrays import ENDS, Arrays, allocate_contact, slice_arrays
from warp_rods.rods.clock import Clock
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices


class BoundLaunches:
    """``predict``, ``try_step``, ``accept``, ``advance_past``: steps; ``evaluate``, ``find_output``: a frame."""

    def __init__(self, arrays: Arrays, surface: Surface, clock: Clock, middle: int):
        self.arrays, self.clock, self.middle = arrays, clock, middle
        self.rods, self.nodes = arrays.f.geodesic.shape
        self.device = arrays.f.geodesic.device
        self._membrane = surface
        self._parameters = surface.device_parameters(self.device)
        self._parameters_time = 0.0
        self._ends = tuple(wp.vec3d(*corner) for corner in ends_of(surface))
        self._surface = frames.on_surface(surface.field)
        self._motion = frames.motion_of(surface.field, surface.rate) if surface.moving else None
        self._target = per_rod(3, device=self.device)
        self._record()

    def _record(self) -> None:
        self.version = object()
        parts = self._slices()
        self._predict = RecordedInThreads([partial(self._launch_predict, a) for a in parts], self.device)
        self._try = RecordedInThreads([partial(self._launch_try, a) for a in parts], self.device)
        self._accept = RecordedInThreads([partial(self._launch_accept, a) for a in parts], self.device)
        self._behind = [per_rod(1, wp.int32, self.device) for _ in parts]
        own = [partial(self._launch_own_step, *pair) for pair in zip(parts, self._behind, strict=True)]
        self._own_step = RecordedInThreads(own, self.device)
        self._reject = Recorded(
            partial(self._launch, levels.count_rejected, self.rods, self.arrays.f, self.arrays.pace), self.device
        )
        self._show = Recorded(self._launch_show, self.device)
        self.evaluate = Recorded(self._launch_shown, self.device)
        self.find_output = Recorded(self._launch_output, self.device)

    def _slices(self) -> list[Arrays]:
        """The arrays in slices of rods, one for each thread."""
        parts = thread_slices(self.rods, self.nodes, self.device)
        return [slice_arrays(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._try.threads

    def enable_contact(self) -> None:
        """Allocate what contact needs."""
        allocate_contact(self.arrays)
        self._record()

    def _launch(self, kernel, dim, *inputs) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def place(self, node: int) -> None:
        """Project the frame of one node onto the surface, and compute the other frames from it outwards."""
        a = self.arrays
        self._launch(levels.activate, self.rods, a.f)
        self._launch(self._surface.place, self.rods, a.f, a.past, self._parameters, node)
        self._launch(self._surface.rebuild, (self.rods, 2), a.f, a.plan, self._parameters, node, *self._ends)

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

    def _launch_evaluate(self, a: Arrays) -> None:
        f, count, grid = a.f, a.f.geodesic.shape[0], a.f.geodesic.shape
        lower, diagonal, upper = a.bands[:3]
        if self._membrane.moving:
            self._launch(self._motion, grid, f, self._parameters)
        self._launch(rod.find_moments, grid, f)
        self._launch(rod.find_transverse_forces, grid, f)
        self._launch(rod.find_velocity_coefficients, grid, f)
        self._launch(linear_systems.set_tension_rows, grid, f, lower, diagonal, upper, a.rhs)
        self._launch(solve_tridiagonal, count, lower, diagonal, upper, a.rhs, a.work, f.tension)
        self._launch(rod.find_velocities_along, grid, f)
        self._launch(rod.find_velocities_across, grid, f)
        self._launch(rod.find_geodesic_rates, grid, f)

    def _launch_predict(self, a: Arrays) -> None:
        self._launch(levels.choose_equal_steps, a.f.geodesic.shape[0], a.f, a.pace, a.plan, self.clock.array)
        self._launch_extrapolate(a)

    def _launch_extrapolate(self, a: Arrays) -> None:
        count, grid = a.f.geodesic.shape[0], a.f.geodesic.shape
        self._launch(self._surface.predict, count, a.f, a.past, a.pace, a.plan, a.growth, self._parameters)
        self._launch(levels.extrapolate, grid, a.f, a.past, a.plan)
        self._launch_rebuild(a)

    def _launch_own_step(self, a: Arrays, behind: wp.array) -> None:
        count = a.f.geodesic.shape[0]
        self._launch(levels.reset, 1, behind)
        self._launch(levels.choose_own_steps, count, a.f, a.pace, a.plan, a.growth, self._target, behind)
        self._launch_extrapolate(a)
        self._launch_try(a)
        self._launch(step.repeat_or_accept, count, a.f, a.past, a.pace, a.plan, self._target)
        self._launch_accept(a)
        self._launch(step.choose_next_steps, count, a.f, a.pace, a.plan, self._target)

    def _launch_rebuild(self, a: Arrays) -> None:
        count = a.f.geodesic.shape[0]
        self._launch(self._surface.rebuild, (count, 2), a.f, a.plan, self._parameters, a.f.tracked, *self._ends)

    def _launch_try(self, a: Arrays) -> None:
        if a.contact_stiffness is not None:
            count = a.f.geodesic.shape[0]
            self._launch(contact.set_contact_drag, count, a.f, a.past, a.pace, a.plan, a.contact_stiffness)
        self._launch_evaluate(a)
        f, plan, count, grid = a.f, a.plan, a.f.geodesic.shape[0], a.f.geodesic.shape
        self._launch(angles.find_turn_to_velocity, grid, f, a.weights)
        self._launch(angles.set_angle_rows, grid, f, plan.rate, a.weights, *a.bands)
        slopes = (plan.geodesic_slope, plan.turn_slope)
        self._launch(angles.set_angle_rhs, count, f, f.geodesic_rate, *slopes, plan.rate, plan.turn)
        self._launch(solve_pentadiagonal, count, *a.bands, plan.turn, a.work_pairs, plan.turn)
        self._launch(step.judge, count, f, a.past, a.pace, plan, a.weights)
        if a.contact_stiffness is not None:
            self._launch(contact.find_contact_errors, count, f, a.past, a.pace, plan, a.weights)

    def _launch_accept(self, a: Arrays) -> None:
        count, grid = a.f.geodesic.shape[0], a.f.geodesic.shape
        if a.contact_stiffness is not None:
            self._launch(contact.keep_contact_velocity, grid, a.f, a.past, a.pace, a.plan, a.weights)
        self._launch(self._surface.take, count, a.f, a.past, a.pace, a.plan, self._parameters)

    def _launch_shown(self) -> None:
        """Velocities and rates of the state shown. The drag of contact belongs to steps."""
        if self.arrays.contact_stiffness is not None:
            self.arrays.f.contact_drag.zero_()
        self._launch_evaluate(self.arrays)

    def _launch_show(self) -> None:
        a = self.arrays
        self._launch(levels.activate, self.rods, a.f)
        self._launch(self._surface.show, self.rods, a.f, a.past, a.pace, a.growth, self._target, self._parameters)
        self._launch_rebuild(a)

    def _launch_output(self) -> None:
        a, f, output, grid = self.arrays, self.arrays.f, self.arrays.output, (self.rods, self.nodes)
        powers = (output["energy"], output["dissipation"], output["growth_power"], output["force_power"])
        self._launch(energy.find_energies, self.rods, f, output["energy_density"], *powers)
        self._launch(energy.find_orientations, grid, f, output["orientation"])
        self._launch(load.find_normal_shear, grid, f, a.normal_shear)
        self._launch(load.find_load, grid, f, a.normal_shear, output["load"], output["load_moment"])
        end_loads = (output["end_load"], output["end_moment"])
        self._launch(load.find_end_loads, (self.rods, ENDS), f, a.normal_shear, *end_loads)
        self._launch(load.find_stretch_force, grid, f, output["stretch_force"])
        if self._membrane.moving:
            self._launch(load.find_membrane_power, self.rods, f, a.normal_shear, output["membrane_power"])
        self._launch(load.find_midpoint_gauss, self.rods, f, self.middle, output["gauss"])
        self._launch(self._surface.residuals, self.rods, f, self._parameters, output["residuals"])


def _is_set(flag: wp.array) -> bool:
    return bool(flag.numpy()[0])
