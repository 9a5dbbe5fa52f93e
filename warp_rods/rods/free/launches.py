"""What an ensemble of free rods launches: sequences of kernels, each recorded once and then replayed."""

from __future__ import annotations

from functools import partial
from typing import Any

import warp as wp

from warp_rods.kernels.free import motion, output
from warp_rods.kernels.lie import integrate_frames
from warp_rods.rods.clock import Clock
from warp_rods.rods.free.arrays import Arrays, make_room_for_forces, part
from warp_rods.rods.recorded import Recorded, SideBySide, slices


class FreeLaunches:
    """The sequences of an ensemble: ``advance``, ``frames``, ``measure`` and ``materialise``.

    Without external forces a step needs no frames in space and makes none. ``accept_forces`` changes that: from
    then on a step starts from present frames and ``force`` [rod, node], in space, and leaves present frames.
    """

    def __init__(self, arrays: Arrays, clock: Clock):
        self.arrays, self.clock = arrays, clock
        self.rods, self.nodes = arrays.position.shape
        self.device = arrays.position.device
        self._field: Any = None
        self._record()

    def accept_forces(self, field: Any = None) -> None:
        """Make room for external forces, and have a ``field`` kernel make them anew for each step, if one is given."""
        make_room_for_forces(self.arrays)
        self._field = field
        self._record()
        self.frames()

    def _record(self) -> None:
        self.version = object()
        self._move = SideBySide([partial(self._launch_move, a) for a in self._parts()], self.device)
        self._tick = Recorded(self.clock.launch_tick, self.device)
        self.frames = Recorded(partial(self._launch_frames, self.arrays), self.device)
        self.measure = Recorded(self._launch_measure, self.device)
        self.materialise = Recorded(self._launch_materialise, self.device)

    def _parts(self) -> list[Arrays]:
        """The arrays in slices of rods, one a thread."""
        parts = slices(self.rods, self.nodes, self.device)
        return [part(self.arrays, rods) for rods in parts] if len(parts) > 1 else [self.arrays]

    @property
    def threads(self) -> int:
        """How many share a step."""
        return self._move.threads

    def advance(self) -> None:
        """One step of every sound rod."""
        self._move()
        self._tick()

    def _launch(self, kernel: Any, dim: Any, *inputs: Any) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def _launch_force(self, a: Arrays) -> None:
        if self._field is not None:
            self._launch(self._field, a.position.shape, a.position, a.rotation, self.clock.array, a.force)
        if a.force is not None:
            self._launch(output.to_body, a.position.shape, a.rotation, a.force, a.applied)

    def _launch_move(self, a: Arrays) -> None:
        self._launch_force(a)
        state = (a.rods, a.now, a.change, a.midpoint, a.applied, self.clock.array, a.failed_at)
        self._launch(motion.advance, a.position.shape[0], *state, a.star, a.scratch)
        if a.force is not None:
            self._launch_frames(a)

    def _launch_frames(self, a: Arrays) -> None:
        self._launch(output.lay_out, a.position.shape, a.now, a.midpoint, a.bishop_strain, a.rotation, a.position)
        self._launch(
            integrate_frames, a.position.shape[0], a.bishop_strain, a.spacing, self.nodes // 2, a.rotation, a.position
        )

    def _launch_measure(self) -> None:
        a = self.arrays
        self._launch_force(a)
        self._launch(output.measure, self.rods, a.rods, a.now, a.flow, a.measures)

    def _launch_materialise(self) -> None:
        a, grid = self.arrays, (self.rods, self.nodes)
        self._launch_frames(a)
        self._launch(output.materialise, grid, a.rods, a.now, a.midpoint, a.rotation, a.strain, a.orientation)
