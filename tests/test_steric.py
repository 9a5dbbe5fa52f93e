"""Steric forces against all pairs in NumPy, their conservation laws, and the neighbour grid."""

import numpy as np
import pytest
import warp as wp
from reference_steric import Pairs, Rods

from warp_rods import surfaces
from warp_rods.bound_rods import BoundRods
from warp_rods.kernels.layout import per_node
from warp_rods.neighbours import CELLS, Neighbours

STERIC = {"strength": 0.7, "range": 0.1, "core": 0.05}


class Held:
    """An ensemble that stays where it is put: what ``Neighbours`` asks for and nothing else."""

    def __init__(self, rods: Rods, device):
        self.count, self.nodes = rods.position.shape[:2]
        self.position_array = per_node(self.count, self.nodes, wp.vec3d, device)
        self.force_array = per_node(self.count, self.nodes, wp.vec3d, device)
        self.spacing_array = wp.array(rods.spacing, dtype=wp.float64, device=device)
        self.cross_drag = np.ones(self.count)
        self.place(rods.position)

    def place(self, position: np.ndarray) -> None:
        self.position_array.assign(position)

    @property
    def force(self) -> np.ndarray:
        return self.force_array.numpy().copy()


def walks(rng: np.random.Generator, count: int, nodes: int, lengths, spread: float) -> Rods:
    """Random walks of nodes a spacing apart from starts in a cube of this half width; they cross themselves."""
    length = np.broadcast_to(np.asarray(lengths, dtype=float), (count,))
    steps = rng.normal(size=(count, nodes, 3))
    steps *= (length / (nodes - 1))[:, None, None] / np.linalg.norm(steps, axis=-1, keepdims=True)
    return Rods(rng.uniform(-spread, spread, size=(count, 1, 3)) + np.cumsum(steps, axis=1), length)


def crowd() -> list[Rods]:
    """Two ensembles of other nodes, lengths and spacings, entangled; 2ε is 3.2 to 9.8 spacings."""
    rng = np.random.default_rng(1)
    return [walks(rng, 12, 17, np.linspace(0.3, 0.5, 12), 0.25), walks(rng, 7, 30, np.linspace(0.3, 0.6, 7), 0.25)]


def applied(ensembles: list[Rods], device, **steric) -> tuple[Neighbours, list[Held]]:
    held = [Held(e, device) for e in ensembles]
    neighbours = Neighbours(held, **(STERIC | steric), device=device)
    neighbours.apply()
    return neighbours, held


def all_forces(held: list[Held]) -> np.ndarray:
    return np.concatenate([h.force.reshape(-1, 3) for h in held])


def assert_agrees(neighbours: Neighbours, held: list[Held], pairs: Pairs) -> None:
    expected = pairs.forces()
    np.testing.assert_allclose(all_forces(held), expected, rtol=0, atol=1e-13 * np.abs(expected).max())
    energies, first = pairs.energies(), 0
    for e, found in zip(pairs.ensembles, neighbours.energies(), strict=True):
        size = e.position.shape[0] * e.position.shape[1]
        mine = energies[first : first + size].reshape(e.position.shape[:2]).sum(axis=1)
        np.testing.assert_allclose(found, mine, rtol=1e-13, atol=1e-13 * energies.sum())
        first += size


def test_forces_and_energies_agree_with_all_pairs(device):
    ensembles = crowd()
    pairs = Pairs(ensembles, **STERIC)
    neighbours, held = applied(ensembles, device)
    assert np.abs(pairs.forces()).max() > 0.1
    assert_agrees(neighbours, held, pairs)


@pytest.mark.parametrize("core", [0.01, 0.05, 0.0501, 0.12])
def test_close_neighbours_along_one_rod_are_left_out(core, device):
    """One straight rod of spacing 0.025: cores below, at and above twice and four times it."""
    line = np.linspace(0, 0.8, 33)[:, None] * np.array([0.6, 0.8, 0.0])
    ensembles = [Rods(line[None], np.array([0.8]))]
    neighbours, held = applied(ensembles, device, core=core)
    assert_agrees(neighbours, held, Pairs(ensembles, **(STERIC | {"core": core})))


def test_third_law(device):
    ensembles = crowd()
    _, held = applied(ensembles, device)
    pairs = Pairs(ensembles, **STERIC)
    force = pairs.weights[:, None] * all_forces(held)
    scale = np.abs(force).sum()
    np.testing.assert_allclose(force.sum(axis=0), 0, rtol=0, atol=1e-14 * scale)
    np.testing.assert_allclose(np.cross(pairs.points, force).sum(axis=0), 0, rtol=0, atol=1e-14 * scale)


def test_force_is_minus_the_gradient_of_the_energy(device):
    ensembles = crowd()
    _, held = applied(ensembles, device)
    pairs = Pairs(ensembles, **STERIC)
    force = pairs.weights[:, None] * all_forces(held)
    step = 1e-30
    for i in np.random.default_rng(2).choice(len(force), size=12, replace=False):
        for axis in range(3):
            moved = pairs.points.astype(complex)
            moved[i, axis] += 1j * step
            slope = pairs.energies(moved).sum().imag / step
            assert force[i, axis] == pytest.approx(-slope, rel=0, abs=1e-13 * np.abs(force).max())


def test_grid_misses_no_pair_beyond_its_period(device):
    """Space wraps round the grid: rods over four periods, with partners near by and exactly one period off."""
    steric = STERIC | {"range": 0.01, "core": 0.02}
    period = CELLS * 8 * steric["range"]
    rng = np.random.default_rng(3)
    far = walks(rng, 25, 9, 0.3, 2 * period)
    near = Rods(far.position + rng.normal(scale=0.01, size=(25, 1, 3)), far.length)
    image = Rods(far.position + np.array([period, 0, 0]), far.length)
    ensembles = [far, near, image]
    assert np.ptp(far.position, axis=(0, 1)).min() > 3 * period
    neighbours, held = applied(ensembles, device, **steric)
    assert np.abs(held[0].force).max(axis=(1, 2)).min() > 0
    assert_agrees(neighbours, held, Pairs(ensembles, **steric))


def test_nodes_on_top_of_each_other_do_not_push(device):
    rods = walks(np.random.default_rng(4), 3, 9, 0.3, 1.0)
    twice = [rods, Rods(rods.position.copy(), rods.length)]
    neighbours, held = applied(twice, device)
    assert np.isfinite(all_forces(held)).all()
    assert_agrees(neighbours, held, Pairs(twice, **STERIC))
    point = [Rods(np.zeros((2, 9, 3)), np.array([0.3, 0.3]))]
    assert not all_forces(applied(point, device)[1]).any()


def test_same_positions_same_bits_and_new_positions_are_seen(device):
    """The second call replays a recorded graph, which must rebuild the grid from where the rods are now."""
    first, second = crowd()
    neighbours, held = applied([first, second], device)
    before, energies = all_forces(held), np.concatenate(neighbours.energies())
    neighbours.apply()
    np.testing.assert_array_equal(all_forces(held), before)
    moved = Rods(first.position[::-1] * 1.3 + [0.1, 0.02, 0.0], first.length)
    held[0].place(moved.position)
    neighbours.apply()
    assert_agrees(neighbours, held, Pairs([moved, second], **STERIC))
    held[0].place(first.position)
    neighbours.apply()
    np.testing.assert_array_equal(all_forces(held), before)
    np.testing.assert_array_equal(np.concatenate(neighbours.energies()), energies)


def test_ensembles_of_one_scene_push_each_other_and_far_ones_do_not(device):
    rng = np.random.default_rng(5)
    one = walks(rng, 1, 4, 0.1, 0.0)  # too few nodes to push itself
    beside, far = (Rods(one.position + np.array([x, 0, 0]), one.length) for x in (0.1, 2.0))
    assert np.abs(applied([one, beside], device)[1][0].force).min() > 0
    assert not all_forces(applied([one, far], device)[1]).any()


def test_two_filaments_on_a_sphere_part_and_lose_energy(device):
    core = STERIC["core"]
    sphere = surfaces.make("sphere", {"radius": 1.0})
    r = np.array([[1.0, 0.0, 0.75 * core], [1.0, 0.0, -0.75 * core]])
    rods = BoundRods(sphere, r, [[0, 1, 0.1], [0, 1, 0]], nodes=33, length=0.8, drag=(1, 2, 0.1), device=device)
    neighbours = Neighbours([rods], 0.1, 0.1, core, device=device)
    apart, energy = [], []
    for _ in range(40):
        neighbours.apply()
        state = rods.variables()
        energy.append(state["energy"].sum() + neighbours.energies()[0].sum())
        apart.append(np.linalg.norm(state["position"][0, 16] - state["position"][1, 16]))
        for _ in range(10):
            neighbours.apply()
            rods.step(1e-3)
    assert np.diff(apart).min() > 0 and apart[-1] > 1.2 * apart[0]
    assert np.diff(energy).max() < 0
    assert state["constraint"].max() < 1e-9 and (rods.status == 0).all()
