"""What an ensemble of free rods launches: sequences of kernels, each recorded once and then replayed."""

from __future__ import annotations

from typing import Any

import warp as wp

from warp_rods.free_arrays import Arrays
from warp_rods.kernels import free_motion, free_output
from warp_rods.kernels.layout import per_node
from warp_rods.kernels.lie import integrate_frames
from warp_rods.recorded import Recorded


class FreeLaunches:
    """The sequences of an ensemble: ``advance``, ``frames``, ``measure`` and ``materialise``.

    Without external forces a step needs no frames in space and makes none. ``bear_loads`` changes that: from
    then on a step starts from present frames and ``force`` [rod, node], in space, and leaves present frames.
    """

    def __init__(self, arrays: Arrays):
        self.arrays = arrays
        self.rods, self.nodes = arrays.position.shape
        self.device = arrays.position.device
        self.force: wp.array | None = None
        self._field: Any = None
        self._record()

    def bear_loads(self, field: Any = None) -> None:
        """Give external forces room, and a ``field`` kernel that makes them anew for each step, if one is given."""
        shape = (self.rods, self.nodes, wp.vec3d, self.device)
        self.force = per_node(*shape)
        self.arrays.load.now, self.arrays.load.before = per_node(*shape), per_node(*shape)
        self.arrays.flow.force = self.arrays.load.now
        self._field = field
        self._record()
        self.frames()

    def _record(self) -> None:
        self.advance = Recorded(self._launch_advance, self.device)
        self.frames = Recorded(self._launch_frames, self.device)
        self.measure = Recorded(self._launch_measure, self.device)
        self.materialise = Recorded(self._launch_materialise, self.device)

    def _launch(self, kernel: Any, dim: Any, *inputs: Any) -> None:
        wp.launch(kernel, dim=dim, inputs=list(inputs), device=self.device)

    def _launch_load(self) -> None:
        a, grid = self.arrays, (self.rods, self.nodes)
        if self._field is not None:
            self._launch(self._field, grid, a.position, a.rotation, a.clock, self.force)
        if self.force is not None:
            self._launch(free_output.to_body, grid, a.rotation, self.force, a.load)

    def _launch_advance(self) -> None:
        a = self.arrays
        self._launch_load()
        state = (a.rods, a.now, a.change, a.midpoint, a.load, a.clock, a.failed_at)
        self._launch(free_motion.advance, self.rods, *state, a.star, a.scratch)
        self._launch(free_motion.tick, 1, a.clock)
        if self.force is not None:
            self._launch_frames()

    def _launch_frames(self) -> None:
        a = self.arrays
        self._launch(
            free_output.lay_out, (self.rods, self.nodes), a.now, a.midpoint, a.bishop_strain, a.rotation, a.position
        )
        self._launch(
            integrate_frames, self.rods, a.bishop_strain, a.spacing, self.nodes // 2, a.rotation, a.position
        )

    def _launch_measure(self) -> None:
        a = self.arrays
        self._launch_load()
        self._launch(free_output.measure, self.rods, a.rods, a.now, a.flow, a.measures)

    def _launch_materialise(self) -> None:
        a, grid = self.arrays, (self.rods, self.nodes)
        self._launch_frames()
        self._launch(
            free_output.materialise, grid, a.rods, a.now, a.midpoint, a.rotation, a.strain, a.orientation
        )
