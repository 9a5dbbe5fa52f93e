"""What an ensemble of surface-bound filaments launches: sequences of kernels, each recorded once and replayed."""

from __future__ import annotations

from functools import partial

import warp as wp

from warp_rods.device import exclusive
from warp_rods.kernels.banded import solve_pentadiagonal, solve_tridiagonal
from warp_rods.kernels.bound import frames, load, measure, rod, rows, step
from warp_rods.membranes.surfaces import INSTANT, Surface
from warp_rods.rods.bound.arrays import Arrays, part
from warp_rods.rods.clock import Clock
from warp_rods.rods.recorded import Recorded, SideBySide, slices


class BoundLaunches:
    """``evaluate``: velocities and rates; ``advance``: a step; ``measure``: what a saved frame needs."""

    def __init__(self, arrays: Arrays, surface: Surface, clock: Clock):
        self.arrays, self.clock = arrays, clock
        self.rods, self.nodes = arrays.f.geodesic.shape
        self.device = arrays.f.geodesic.device
        self._membrane = surface
        self._parameters = surface.device_parameters(self.device)
        self._seen = 0.0  # the time at which they are
        self._surface = frames.on_surface(surface.field)
        self.version = object()
        parts = self._parts()
        self._move = SideBySide([partial(self._launch_move, a) for a in parts], self.device)
        # On a moving membrane the host brings its parameters up to date between a step's two halves.
        self._velocities = SideBySide([partial(self._launch_evaluate, a) for a in parts], self.device)
        self._shapes = SideBySide([partial(self._launch_advance, a) for a in parts], self.device)
        self._tick = Recorded(clock.launch_tick, self.device)
        self.evaluate = Recorded(partial(self._launch_evaluate, arrays), self.device)
        self.measure = Recorded(self._launch_measure, self.device)

    def _parts(self) -> list[Arrays]:
        """The arrays in slices of rods, one a thread."""
        parts = slices(self.rods, self.nodes, self.device)
        return [part(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """How many share a step."""
        return self._move.threads

    def _launch(self, kernel, dim, *inputs) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def place(self, node: int) -> None:
        """Put the frame of one node, as given in position and rotation, on the surface; the others outwards from it."""
        f = self.arrays.f
        self._launch(self._surface.place, self.rods, f, self._parameters, node)
        self._launch(self._surface.rebuild, (self.rods, 2), f, self._parameters, node)

    def membrane_at(self, time: float) -> None:
        """Let what follows see the membrane as it is at a time; one that rests is there already."""
        if self._membrane.moving and time != self._seen:
            with exclusive:
                wp.copy(self._parameters, self._membrane.device_parameters(self.device, time))
            self._seen = time

    def advance(self, until: float) -> None:
        """One step of every sound rod, to the time ``until``."""
        if self._membrane.moving:
            self._velocities()
            self.membrane_at(until)
            self._shapes()
        else:
            self._move()
        self._tick()

    def _launch_move(self, a: Arrays) -> None:
        self._launch_evaluate(a)
        self._launch_advance(a)

    def _launch_evaluate(self, a: Arrays) -> None:
        f, count, grid = a.f, a.f.geodesic.shape[0], a.f.geodesic.shape
        lower, diagonal, upper = a.bands[:3]
        if self._membrane.moving:
            self._launch(self._surface.motion, grid, f, self._parameters, 2 * INSTANT)
        self._launch(rod.moments, grid, f)
        self._launch(rod.transverse_forces, grid, f)
        self._launch(rod.tangential_rows, grid, f)
        self._launch(rows.tension_rows, grid, f, lower, diagonal, upper, a.right)
        self._launch(solve_tridiagonal, count, lower, diagonal, upper, a.right, a.work, f.tension)
        self._launch(rod.velocities_along, grid, f)
        self._launch(rod.velocities_across, grid, f)
        self._launch(rod.rates, grid, f)

    def _launch_advance(self, a: Arrays) -> None:
        f, past, clock = a.f, a.past, self.clock.array
        count, grid = a.f.geodesic.shape[0], a.f.geodesic.shape
        self._launch(rows.bending_rows, grid, f, clock, *a.bands)
        self._launch(step.increment_right_hand_side, grid, f, past, clock)
        self._launch(solve_pentadiagonal, count, *a.bands, past.increment, a.work_pair, past.increment)
        self._launch(step.freeze_failing, count, f, past, clock)
        if not (f.start_clamped or f.end_clamped):
            self._launch(self._surface.advance_middle, count, f, past, self._parameters, clock)
        self._launch(step.advance_geodesic, grid, f, past, clock)
        self._launch(step.grow, count, f, a.growth, clock)
        self._launch(self._surface.rebuild, (count, 2), f, self._parameters, f.anchor)

    def _launch_measure(self) -> None:
        a, f, out, grid = self.arrays, self.arrays.f, self.arrays.out, (self.rods, self.nodes)
        powers = (out["energy"], out["dissipation"], out["growth_power"], out["force_power"])
        self._launch(measure.energies, self.rods, f, out["energy_density"], *powers)
        self._launch(measure.orientations, grid, f, out["orientation"])
        self._launch(load.normal_shears, grid, f, a.shear3)
        self._launch(load.membrane_loads, grid, f, a.shear3, out["load"], out["load_moment"])
        if self._membrane.moving:
            self._launch(load.membrane_powers, self.rods, f, a.shear3, out["membrane_power"])
        self._launch(load.midpoint_gauss, self.rods, f, self.nodes // 2, out["gauss"])
        self._launch(self._surface.residuals, self.rods, f, self._parameters, out["residuals"])
