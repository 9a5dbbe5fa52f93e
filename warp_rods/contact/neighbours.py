"""Steric forces between the rods of all ensembles of a scene, over one grid of neighbours."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np
import warp as wp

from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.kernels.contact import neighbour_list, steric
from warp_rods.kernels.layout import per_node, to_host
from warp_rods.rods.recorded import Recorded, SideBySide, slices

CELLS = 64
"""Cells of the grid along an axis without a period; space wraps round it, so its extent does not matter."""
MOST_CELLS = 2**21
"""Cells of the grid at most: 16 MB."""
PLACES = 32
"""Places for neighbours that lists begin with."""
SPARE = 1.25
"""Places made when lists turn out too short, over those needed."""


class Crowd(Protocol):
    """What an ensemble must show to be pushed: device arrays [rod, node], and [rod]."""

    count: int
    nodes: int

    @property
    def position_array(self) -> wp.array: ...
    @property
    def force_array(self) -> wp.array: ...
    @property
    def spacing_array(self) -> wp.array: ...
    @property
    def transverse_drag(self) -> np.ndarray: ...


class Neighbours:
    """Repulsion of strength g0, range a and core ε between the nodes of ``ensembles`` (5.39), regularised.

    ``apply`` writes the force per length of the present positions into each ensemble's force. It works from lists of
    neighbours within reach and a ``skin`` (default ε), made anew once a node has moved by half of it. period [3] of
    the box along each axis, 0 where there is none: of a pair the nearest images count.

    A loop that looks after that itself, as ``contact.Contact`` does, calls ``push`` and asks ``moved`` now and then.
    """

    def __init__(
        self,
        ensembles: Sequence[Crowd],
        strength: float,
        range: float,
        core: float,
        device: Any = None,
        *,
        period: Any = (0.0, 0.0, 0.0),
        skin: float | None = None,
    ):
        self.strength, self.range, self.core = strength, range, core
        self.skin = core if skin is None else skin
        self._ensembles, self._device = list(ensembles), device_of(device)
        # Asked for here and not under capture: an ensemble may have to make room for forces, and then lay out frames.
        forces = [e.force_array for e in self._ensembles]
        self._arrays = [(e.position_array, e.spacing_array, f) for e, f in zip(self._ensembles, forces, strict=True)]
        self._yukawa = _yukawa(strength, range, core)
        self._first = [0, *np.cumsum([e.count * e.nodes for e in self._ensembles]).tolist()]
        with exclusive:
            self._allocate(np.asarray(period, dtype=float))
        self._record()
        self._listed = False

    @property
    def stale(self) -> bool:
        """Whether an ensemble has other arrays than when this was built: then build it anew."""
        kept = (position for position, _, _ in self._arrays)
        return any(e.position_array is not position for e, position in zip(self._ensembles, kept, strict=True))

    @property
    def reach(self) -> float:
        """Pairs farther apart do not push each other."""
        return steric.REACH * self.range

    @property
    def threads(self) -> int:
        """How many share ``push``."""
        return self._gather.threads

    @property
    def points(self) -> int:
        """Nodes of all ensembles."""
        return self._first[-1]

    def _allocate(self, period: np.ndarray) -> None:
        points, device = self.points, self._device
        cloud = neighbour_list.Cloud()
        for name in ("position", "reference", "cell"):
            setattr(cloud, name, wp.zeros(points, dtype=wp.vec3d, device=device))
        for name in ("weight", "arc", "apart"):
            setattr(cloud, name, wp.zeros(points, dtype=wp.float64, device=device))
        cloud.moved = wp.zeros(2, dtype=wp.float64, device=device)
        nodes = [np.repeat(e.nodes, e.count) for e in self._ensembles]
        owner = np.repeat(np.arange(sum(map(len, nodes))), np.concatenate(nodes))
        cloud.rod = wp.array(owner.astype(np.int32), device=device)
        drag = np.concatenate([np.repeat(e.transverse_drag, e.nodes) for e in self._ensembles])
        cloud.drag = wp.array(drag, dtype=wp.float64, device=device)
        # On an axis with a period the cells divide it, none narrower than what a list reaches over.
        width = self.reach + self.skin
        cells = np.where(period > 0, np.clip(period // width, 1, MOST_CELLS), CELLS).astype(int)
        while cells.prod() > MOST_CELLS:  # wider ones do as well, and a wide box of few rods needs no more
            cells[np.argmax(cells)] //= 2
        cloud.period = wp.vec3d(*period)
        cloud.cells_per_length = wp.vec3d(*np.where(period > 0, cells / np.where(period > 0, period, 1), 1 / width))
        self._cloud = cloud
        x, y, z = cells.tolist()
        self._grid = wp.HashGrid(x, y, z, device=device, dtype=wp.float64)
        self._grid.reserve(points)
        self._pairs = steric.Pairs()
        self._pairs.force = wp.zeros(points, dtype=wp.vec3d, device=device)
        self._pairs.energy = wp.zeros(points, dtype=wp.float64, device=device)
        self._stiff = wp.zeros(points, dtype=wp.float64, device=device)
        self._make_room(PLACES)

    def _make_room(self, places: int) -> None:
        self._lists = neighbour_list.Lists()
        self._lists.near = per_node(self.points, places, wp.int32, self._device)
        self._lists.count = wp.zeros(self.points, dtype=wp.int32, device=self._device)

    def _record(self) -> None:
        self.version = object()
        """Another one when what ``push`` launches has changed."""
        self._look = Recorded(self._launch_pack, self._device)
        points = slices(self.points, 1, self._device)
        self._gather = SideBySide([partial(self._launch_gather, p) for p in points], self._device)
        self._unpack = Recorded(self._launch_unpack, self._device)

    def apply(self) -> None:
        """Write the forces of the present positions, by lists that hold."""
        if not self._listed or self.moved()[1] > self.skin / 2:
            self.renew()
        self.push()

    def push(self) -> None:
        """Write the forces of the present positions, by the lists at hand."""
        self._look()
        self._gather()
        self._unpack()

    def moved(self) -> tuple[float, float]:
        """The longest way of a node in one step since this was last asked, and since lists were made; length.

        A step is from one ``push`` to the next, or to this.
        """
        with exclusive:
            self._look()
            step, drift = np.sqrt(self._cloud.moved.numpy()).tolist()
            self._cloud.moved.assign([0.0, drift * drift])
            return step, drift

    def settle(self) -> None:
        """Take the present positions, to which nodes did not step, for those that the next step is measured from."""
        with exclusive:
            self._cloud.moved.zero_()
            self._look()
            drift = float(self._cloud.moved.numpy()[int(neighbour_list.DRIFT)])
            self._cloud.moved.assign([0.0, drift])

    def renew(self) -> None:
        """Make the lists of the present positions."""
        with exclusive:
            self._look()
            cloud = self._cloud
            wp.launch(neighbour_list.settle, dim=self.points, inputs=[cloud], device=self._device)
            self._grid.build(cloud.cell, wp.float64(1.0))
            while not self._list():
                pass
            cloud.moved.zero_()
            self._listed = True

    def _list(self) -> bool:
        """Fill the lists; where they are too short make longer ones and say no."""
        inputs = [self._grid.id, self._cloud, self.reach + self.skin, self._lists]
        wp.launch(neighbour_list.list_neighbours, dim=self.points, inputs=inputs, device=self._device)
        longest = int(self._lists.count.numpy().max(initial=0))
        if longest <= self._lists.near.shape[1]:
            return True
        self._make_room(int(SPARE * longest) + 1)
        self._record()
        return False

    def _launch_pack(self) -> None:
        for first, (position, spacing, _) in zip(self._first, self._arrays, strict=False):
            inputs = [position, spacing, first, self.core, self._cloud]
            wp.launch(neighbour_list.pack, dim=position.shape, inputs=inputs, device=self._device)

    def _launch_gather(self, points: slice) -> None:
        inputs = [self._cloud, self._lists, self._yukawa, points.start, self._pairs]
        wp.launch(steric.gather, dim=points.stop - points.start, inputs=inputs, device=self._device)

    def _launch_unpack(self) -> None:
        for first, (_, _, force) in zip(self._first, self._arrays, strict=False):
            wp.launch(steric.unpack, dim=force.shape, inputs=[self._pairs, first, force], device=self._device)

    def stiffness(self) -> float:
        """How fast contact pulls a node back, Σ_j w_j |∂f_i/∂r_j|/ζ⊥, the largest over all nodes; 1/time.

        At the positions of the last ``push``. The fastest rate of the system is at most twice that, as both nodes of a
        pair move; along a rod they do not move singly, so that ζ∥ plays no part.
        """
        with exclusive:
            inputs = [self._cloud, self._lists, self._yukawa, self._stiff]
            wp.launch(steric.stiffnesses, dim=self.points, inputs=inputs, device=self._device)
            return float(self._stiff.numpy().max(initial=0.0))

    def energies(self) -> list[np.ndarray]:
        """Each ensemble's steric energy [rod] as of the last ``apply``: a pair's energy is shared by halves."""
        with exclusive:
            found = []
            for first, e in zip(self._first, self._ensembles, strict=False):
                energy = wp.zeros(e.count, dtype=wp.float64, device=self._device)
                inputs = [self._cloud, self._pairs, first, e.nodes, energy]
                wp.launch(steric.rod_energies, dim=e.count, inputs=inputs, device=self._device)
                found.append(to_host(energy))
            return found


def _yukawa(strength: float, range: float, core: float) -> Any:
    """The numbers of G(ρ) = g0 e^(−ρ/a)/4πρ for the kernels."""
    y = steric.Yukawa()
    y.strength, y.per_range, y.core_square = strength / (4 * np.pi), 1 / range, core**2
    y.reach_square = (steric.REACH * range) ** 2
    y.rho_end = np.sqrt(y.reach_square + y.core_square)
    y.G_end = y.strength * np.exp(-y.rho_end / range) / y.rho_end
    y.F_end = (1 / y.rho_end + 1 / range) * y.G_end
    return y
