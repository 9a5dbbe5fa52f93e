"""Rods at rest for tests of the steric sums, and the comparison of sums with all pairs."""

import numpy as np
import warp as wp
from reference.steric import Pairs, Rods

from warp_rods.contact.neighbours import Neighbours
from warp_rods.kernels.layout import per_node

STERIC = {"strength": 0.7, "range": 0.1, "core": 0.05}


class Held:
    """Rods at given positions: the part of an ``Ensemble`` that ``Neighbours`` and ``Walls`` use."""

    def __init__(self, rods: Rods, device):
        self.count, self.nodes = rods.position.shape[:2]
        self.position_array = per_node(self.count, self.nodes, wp.vec3d, device)
        self.force_array = per_node(self.count, self.nodes, wp.vec3d, device)
        self.contact_stiffness_array = per_node(self.count, self.nodes, wp.mat33d, device)
        self.spacing_array = wp.array(rods.spacing, dtype=wp.float64, device=device)
        self.status_array = wp.zeros(self.count, dtype=wp.int32, device=device)
        self.place(rods.position)

    def place(self, position: np.ndarray) -> None:
        self.position_array.assign(position)

    @property
    def force(self) -> np.ndarray:
        return self.force_array.numpy().copy()

    @property
    def stiffness(self) -> np.ndarray:
        return self.contact_stiffness_array.numpy().copy()


def random_walks(rng: np.random.Generator, count: int, nodes: int, lengths, spread) -> Rods:
    """Random walks of nodes one spacing apart, from starts in a box with these half widths; they cross themselves."""
    length = np.broadcast_to(np.asarray(lengths, dtype=float), (count,))
    steps = rng.normal(size=(count, nodes, 3))
    steps *= (length / (nodes - 1))[:, None, None] / np.linalg.norm(steps, axis=-1, keepdims=True)
    spread = np.broadcast_to(np.asarray(spread, dtype=float), (3,))
    return Rods(rng.uniform(-spread, spread, size=(count, 1, 3)) + np.cumsum(steps, axis=1), length)


def entangled(spread=0.25, seed=1) -> list[Rods]:
    """Two entangled ensembles with different nodes, lengths and spacings; 2ε is 3.2 to 9.8 spacings."""
    rng = np.random.default_rng(seed)
    return [
        random_walks(rng, 12, 17, np.linspace(0.3, 0.5, 12), spread),
        random_walks(rng, 7, 30, np.linspace(0.3, 0.6, 7), spread),
    ]


def applied(ensembles: list[Rods], device, **steric) -> tuple[Neighbours, list[Held]]:
    """The neighbour lists and the held ensembles after one evaluation of the forces."""
    held = [Held(e, device) for e in ensembles]
    neighbours = Neighbours(held, **(STERIC | steric), device=device)
    neighbours.apply()
    return neighbours, held


def all_forces(held: list[Held]) -> np.ndarray:
    return np.concatenate([h.force.reshape(-1, 3) for h in held])


def assert_agrees(neighbours: Neighbours, held: list[Held], pairs: Pairs, tolerance: float = 1e-13) -> None:
    expected = pairs.forces()
    np.testing.assert_allclose(all_forces(held), expected, rtol=0, atol=tolerance * np.abs(expected).max())
    energies, first = pairs.energies(), 0
    for e, found in zip(pairs.ensembles, neighbours.energies(), strict=True):
        size = e.position.shape[0] * e.position.shape[1]
        expected_energies = energies[first : first + size].reshape(e.position.shape[:2]).sum(axis=1)
        np.testing.assert_allclose(found, expected_energies, rtol=tolerance, atol=tolerance * energies.sum())
        first += size
