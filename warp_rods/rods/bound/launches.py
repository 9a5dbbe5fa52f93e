"""Sequences of kernels of an ensemble of surface-bound filaments, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial

import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.banded import solve_pentadiagonal, solve_tridiagonal
from warp_rods.kernels.bound import energy, frames, linear_systems, load, rod, step
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.arrays import ENDS, Arrays, slice_arrays
from warp_rods.rods.clock import Clock
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices


class BoundLaunches:
    """``evaluate``: velocities and rates; ``advance``: a step; ``find_output``: the variables of a frame."""

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
        self.version = object()
        parts = self._slices()
        self._advance = RecordedInThreads([partial(self._launch_advance, a) for a in parts], self.device)
        # On a moving membrane the host updates the parameters of the membrane between the two halves of a step.
        self._rates = RecordedInThreads([partial(self._launch_evaluate, a) for a in parts], self.device)
        self._shapes = RecordedInThreads([partial(self._launch_shape, a) for a in parts], self.device)
        self._tick = Recorded(clock.launch_tick, self.device)
        self.evaluate = Recorded(partial(self._launch_evaluate, arrays), self.device)
        self.find_output = Recorded(self._launch_output, self.device)

    def _slices(self) -> list[Arrays]:
        """The arrays in slices of rods, one for each thread."""
        parts = thread_slices(self.rods, self.nodes, self.device)
        return [slice_arrays(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """The number of threads that share a step."""
        return self._advance.threads

    def _launch(self, kernel, dim, *inputs) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def place(self, node: int) -> None:
        """Project the frame of one node onto the surface, and compute the other frames from it outwards."""
        f = self.arrays.f
        self._launch(self._surface.place, self.rods, f, self.arrays.past, self._parameters, node)
        self._launch_rebuild(self.arrays, node, laid_out=1)

    def set_membrane_time(self, time: float) -> None:
        """Set the parameters of a moving membrane to those at this time; nothing to do for a membrane at rest."""
        if self._membrane.moving and time != self._parameters_time:
            with exclusive:
                wp.copy(self._parameters, self._membrane.device_parameters(self.device, time))
            self._parameters_time = time

    def advance(self, end: float) -> None:
        """One step of every rod that is not frozen, to the time ``end``."""
        if self._membrane.moving:
            self._rates()
            self.set_membrane_time(end)
            self._shapes()
        else:
            self._advance()
        self._tick()

    def _launch_advance(self, a: Arrays) -> None:
        self._launch_evaluate(a)
        self._launch_shape(a)

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

    def _launch_shape(self, a: Arrays) -> None:
        f, past, clock = a.f, a.past, self.clock.array
        count, grid = a.f.geodesic.shape[0], a.f.geodesic.shape
        self._launch(linear_systems.set_bending_rows, grid, f, clock, *a.bands)
        self._launch(step.set_increment_rhs, grid, f, past, clock)
        self._launch(solve_pentadiagonal, count, *a.bands, past.increment, a.work_pairs, past.increment)
        self._launch(step.freeze_failing, count, f, past, clock)
        if not (f.start_clamped or f.end_clamped):
            self._launch(self._surface.advance_tracked, count, f, past, self._parameters, clock)
        self._launch(step.advance_geodesic, grid, f, past, clock)
        self._launch(step.grow, count, f, a.growth, clock)
        self._launch_rebuild(a, f.tracked, laid_out=0)

    def _launch_rebuild(self, a: Arrays, node: int, laid_out: int) -> None:
        """Frames from that of ``node`` outwards; rods that cannot follow the surface are frozen."""
        count = a.f.geodesic.shape[0]
        self._launch(self._surface.rebuild, (count, 2), a.f, a.past, self._parameters, node, *self._ends)
        self._launch(step.freeze_unfit, count, a.f, a.past, a.growth, self.clock.array, laid_out)

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
