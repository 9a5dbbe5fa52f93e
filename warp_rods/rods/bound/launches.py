"""What an ensemble of surface-bound filaments launches: sequences of kernels, each recorded once and replayed."""

from __future__ import annotations

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal, solve_tridiagonal
from warp_rods.kernels.bound import (
    frames as bound_frames,
)
from warp_rods.kernels.bound import (
    load as bound_load,
)
from warp_rods.kernels.bound import (
    measure as bound_measure,
)
from warp_rods.kernels.bound import (
    rod as bound_rod,
)
from warp_rods.kernels.bound import (
    rows as bound_rows,
)
from warp_rods.kernels.bound import (
    step as bound_step,
)
from warp_rods.membranes.surfaces import INSTANT, Surface
from warp_rods.rods.bound.arrays import Arrays
from warp_rods.rods.recorded import Recorded


class BoundLaunches:
    """``evaluate``: velocities and rates; ``advance``: one step of them; ``measure``: what a saved frame needs."""

    def __init__(self, arrays: Arrays, surface: Surface):
        self.arrays = arrays
        self.rods, self.nodes = arrays.f.geodesic.shape
        self.device = arrays.f.geodesic.device
        self._membrane = surface
        self._parameters = surface.device_parameters(self.device)
        self._seen = 0.0  # the time at which they are
        self._surface = bound_frames.on_surface(surface.field)
        self.evaluate = Recorded(self._launch_evaluate, self.device)
        self.advance = Recorded(self._launch_advance, self.device)
        self.measure = Recorded(self._launch_measure, self.device)

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
            wp.copy(self._parameters, self._membrane.device_parameters(self.device, time))
            self._seen = time

    def _launch_evaluate(self) -> None:
        a, f, grid = self.arrays, self.arrays.f, (self.rods, self.nodes)
        lower, diagonal, upper = a.bands[:3]
        if self._membrane.moving:
            self._launch(self._surface.motion, grid, f, self._parameters, 2 * INSTANT)
        self._launch(bound_rod.moments, grid, f)
        self._launch(bound_rod.transverse_loads, grid, f)
        self._launch(bound_rod.tangential_rows, grid, f)
        self._launch(bound_rows.tension_rows, grid, f, lower, diagonal, upper, a.right)
        self._launch(solve_tridiagonal, self.rods, lower, diagonal, upper, a.right, a.work, f.tension)
        self._launch(bound_rod.velocities_along, grid, f)
        self._launch(bound_rod.velocities_across, grid, f)
        self._launch(bound_rod.rates, grid, f)

    def _launch_advance(self) -> None:
        a, f, past, grid = self.arrays, self.arrays.f, self.arrays.past, (self.rods, self.nodes)
        self._launch(bound_rows.bending_rows, grid, f, past.pace, *a.bands)
        self._launch(bound_step.increment_right_hand_side, grid, f, past)
        self._launch(solve_pentadiagonal, self.rods, *a.bands, past.increment, a.work_pair, past.increment)
        self._launch(bound_step.judge, self.rods, f, past)
        if not (f.start_clamped or f.end_clamped):
            self._launch(self._surface.advance_middle, self.rods, f, past, self._parameters)
        self._launch(bound_step.advance_geodesic, grid, f, past)
        self._launch(bound_step.grow, self.rods, f, past, a.growth)
        self._launch(self._surface.rebuild, (self.rods, 2), f, self._parameters, f.anchor)
        self._launch(bound_step.tick, 1, past)

    def _launch_measure(self) -> None:
        a, f, out, grid = self.arrays, self.arrays.f, self.arrays.out, (self.rods, self.nodes)
        powers = (out["energy"], out["dissipation"], out["growth_power"])
        self._launch(bound_measure.energies, self.rods, f, out["energy_density"], *powers)
        self._launch(bound_measure.orientations, grid, f, out["orientation"])
        self._launch(bound_load.normal_shears, grid, f, a.shear3)
        self._launch(bound_load.membrane_loads, grid, f, a.shear3, out["load"], out["load_moment"])
        if self._membrane.moving:
            self._launch(bound_load.membrane_powers, self.rods, f, a.shear3, out["membrane_power"])
        self._launch(bound_load.midpoint_gauss, self.rods, f, self.nodes // 2, out["gauss"])
        self._launch(self._surface.residuals, self.rods, f, self._parameters, out["residuals"])
