"""Steric forces: agreement with all pairs in NumPy, conservation laws, and the hash grid."""

import numpy as np
import pytest
import warp as wp
from examples.steric import STERIC, all_forces, applied, assert_agrees, entangled, random_walks
from reference.steric import Pairs, Rods

from warp_rods.contact.neighbours import CELLS, Neighbours
from warp_rods.kernels.contact.steric import PairSums, sum_pairs
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods


def test_forces_and_energies_agree_with_all_pairs(device, verified):
    ensembles = entangled()
    pairs = Pairs(ensembles, **STERIC)
    neighbours, held = applied(ensembles, device)
    expected = pairs.forces()
    assert np.abs(expected).max() > 0.1
    assert_agrees(neighbours, held, pairs)
    verified.below(
        "independent", "steric forces of entangled rods, over the largest",
        measured=np.abs(all_forces(held) - expected).max() / np.abs(expected).max(), bound=1e-13,
        reference="sums over all pairs in NumPy",
    )  # fmt: skip
    energy = sum(energies.sum() for energies in neighbours.energies())
    verified(
        "exact", "steric energy of entangled rods", measured=energy, expected=pairs.energies().sum(), relative=1e-13,
        reference="½ Σ w_i w_j G(ρ), G = g0 exp(−ρ/a)/4πρ less its tangent at the cut-off",
    )  # fmt: skip


@pytest.mark.parametrize("core", [0.01, 0.05, 0.0501, 0.12])
def test_close_neighbours_along_one_rod_are_left_out(core, device):
    """One straight rod of spacing 0.025, with cores around two and four spacings."""
    line = np.linspace(0, 0.8, 33)[:, None] * np.array([0.6, 0.8, 0.0])
    ensembles = [Rods(line[None], np.array([0.8]))]
    neighbours, held = applied(ensembles, device, core=core)
    assert_agrees(neighbours, held, Pairs(ensembles, **(STERIC | {"core": core})))


def test_forces_and_energies_vanish_continuously_at_the_cutoff(device):
    """Linearly and quadratically, for cores smaller and larger than the range."""
    for core in (0.02, 0.1, 0.4):
        steric = {"strength": 1.0, "range": 0.1, "core": core}
        one = Rods(np.zeros((1, 2, 3)), np.ones(1))

        def at(fraction, one=one, steric=steric):
            other = Rods(one.position + np.array([8 * 0.1 * fraction, 0, 0]), one.length)
            neighbours, held = applied([one, other], device, **steric)
            return np.abs(all_forces(held)).max(), neighbours.energies()[0].sum()

        (force, energy), (closer_force, closer_energy) = at(1 - 1e-3), at(1 - 1e-4)
        assert closer_force == pytest.approx(force / 10, rel=0.02)
        assert closer_energy == pytest.approx(energy / 100, rel=0.02)
        assert at(1 + 1e-9) == (0.0, 0.0)
        assert at(1 - 1e-9)[0] < 1e-10 * at(0.25)[0]


def test_total_force_and_moment_vanish(device, verified):
    ensembles = entangled()
    _, held = applied(ensembles, device)
    pairs = Pairs(ensembles, **STERIC)
    force = pairs.weights[:, None] * all_forces(held)
    scale = np.abs(force).sum()
    total = np.stack([force.sum(axis=0), np.cross(pairs.points, force).sum(axis=0)])
    verified.below(
        "conservation", "total force and moment of steric forces, over the sum of all", measured=np.abs(total) / scale,
        bound=1e-14, reference="0 (third law)",
    )  # fmt: skip


def test_force_is_minus_the_gradient_of_the_energy(device, verified):
    ensembles = entangled()
    _, held = applied(ensembles, device)
    pairs = Pairs(ensembles, **STERIC)
    force = pairs.weights[:, None] * all_forces(held)
    step, errors = 1e-30, []
    for i in np.random.default_rng(2).choice(len(force), size=12, replace=False):
        for axis in range(3):
            moved = pairs.points.astype(complex)
            moved[i, axis] += 1j * step
            slope = pairs.energies(moved).sum().imag / step
            errors.append(abs(force[i, axis] + slope) / np.abs(force).max())
    verified.below(
        "conservation", "steric forces against minus the gradient of the energy, over the largest", measured=errors,
        bound=1e-13, reference="complex steps of the energy of all pairs",
    )  # fmt: skip


def test_the_grid_misses_no_pair_beyond_its_period(device):
    """The grid wraps around: rods over four of its periods, with partners close by and exactly one period away."""
    steric = STERIC | {"range": 0.01, "core": 0.02}
    period = CELLS * 8 * steric["range"]
    rng = np.random.default_rng(3)
    far = random_walks(rng, 25, 9, 0.3, 2 * period)
    near = Rods(far.position + rng.normal(scale=0.01, size=(25, 1, 3)), far.length)
    image = Rods(far.position + np.array([period, 0, 0]), far.length)
    ensembles = [far, near, image]
    assert np.ptp(far.position, axis=(0, 1)).min() > 3 * period
    neighbours, held = applied(ensembles, device, **steric)
    assert np.abs(held[0].force).max(axis=(1, 2)).min() > 0
    assert_agrees(neighbours, held, Pairs(ensembles, **steric))


def test_the_force_between_coincident_nodes_vanishes(device):
    rods = random_walks(np.random.default_rng(4), 3, 9, 0.3, 1.0)
    twice = [rods, Rods(rods.position.copy(), rods.length)]
    neighbours, held = applied(twice, device)
    assert np.isfinite(all_forces(held)).all()
    assert_agrees(neighbours, held, Pairs(twice, **STERIC))
    point = [Rods(np.zeros((2, 9, 3)), np.array([0.3, 0.3]))]
    assert not all_forces(applied(point, device)[1]).any()


def test_forces_have_the_same_bits_at_the_same_positions_and_follow_new_ones(device, verified):
    """The second call replays a recorded graph with the present positions."""
    first, second = entangled()
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
    found = {"force": all_forces(held), "energy": np.concatenate(neighbours.energies())}
    verified.same(
        "steric forces where rods have been before", found, {"force": before, "energy": energies}, reference="before"
    )


@pytest.mark.parametrize("steric", [{}, {"range": 0.4}, {"range": 1e-4, "core": 0.2}], ids=["few", "many", "tiny"])
@pytest.mark.parametrize("period", [(0.0, 0.0, 0.0), (0.9, 0.0, 0.7)])
def test_the_sums_in_lanes_are_those_pair_by_pair(steric, period):
    """With up to 700 neighbours, which are summed in batches, some at distance zero, and e^(−2000)."""
    rng = np.random.default_rng(2)
    walks = [random_walks(rng, 40, 17, 0.4, 0.15), random_walks(rng, 7, 30, 0.5, 0.15)]
    walks[0].position[1] = walks[0].position[0]
    neighbours, _ = applied(walks, "cpu", **steric, period=period)
    lanes, one = neighbours._sums, PairSums()
    for name in ("force", "energy", "stiffness"):
        setattr(one, name, wp.zeros_like(getattr(lanes, name)))
    inputs = [neighbours._points, neighbours._lists, neighbours._yukawa, 0, one]
    wp.launch(sum_pairs, dim=neighbours.count, inputs=inputs, device="cpu")
    if steric.get("range") == 0.4:
        assert neighbours._lists.count.numpy().max() > 600
    for name in ("force", "energy", "stiffness"):
        found, expected = getattr(lanes, name).numpy(), getattr(one, name).numpy()
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max() + 1e-300, err_msg=name)


def test_ensembles_interact_if_they_are_close(device):
    rng = np.random.default_rng(5)
    one = random_walks(rng, 1, 4, 0.1, 0.0)  # too few nodes to interact with itself
    beside, far = (Rods(one.position + np.array([x, 0, 0]), one.length) for x in (0.1, 2.0))
    assert np.abs(applied([one, beside], device)[1][0].force).min() > 0
    assert not all_forces(applied([one, far], device)[1]).any()


def test_two_filaments_on_a_sphere_move_apart_and_lose_energy(device):
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
