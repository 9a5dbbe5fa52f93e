"""Sums over neighbour lists: agreement with all pairs in periodic boxes, validity of lists, and the contact rate."""

import numpy as np
import pytest
from examples.steric import STERIC, Held, all_forces, applied, assert_agrees, entangled, random_walks
from reference.steric import Pairs, Rods

from warp_rods.contact import neighbours as lists
from warp_rods.contact.neighbours import Neighbours

WIDTH = 8 * STERIC["range"] + STERIC["core"]
"""Cut-off and default skin of a list; cells are at least as wide."""


def moved_by_periods(ensembles: list[Rods], period, most: int) -> list[Rods]:
    """The same rods, each displaced by some periods."""
    rng = np.random.default_rng(11)
    shifts = [rng.integers(-most, most + 1, size=(len(e.length), 1, 3)) * np.array(period) for e in ensembles]
    return [Rods(e.position + shift, e.length) for e, shift in zip(ensembles, shifts, strict=True)]


@pytest.mark.parametrize(
    ("period", "cells"),
    [
        ((1.98 * WIDTH, 1.98 * WIDTH, 1.98 * WIDTH), 1),
        ((2.02 * WIDTH, 2.4 * WIDTH, 2.9 * WIDTH), 2),
        ((3.0 * WIDTH, 3.3 * WIDTH, 3.9 * WIDTH), 3),
        ((1.98 * WIDTH, 2.5 * WIDTH, 3.5 * WIDTH), 1),
        ((2.5 * WIDTH, 4.2 * WIDTH, 0.0), 2),
        ((1.98 * WIDTH, 0.0, 0.0), 1),
    ],
)
def test_periodic_boxes_agree_with_all_pairs(period, cells, device):
    """Three, two or one periodic axes with 1, 2, 3 or more cells; rods fill the box and cross its faces."""
    assert cells == period[0] // WIDTH
    ensembles = entangled(spread=np.where(np.array(period) > 0, np.array(period) / 2, 0.5))
    pairs = Pairs(ensembles, **STERIC, period=period)
    neighbours, held = applied(ensembles, device, period=period)
    assert np.abs(pairs.forces() - Pairs(ensembles, **STERIC).forces()).max() > 1e-3 * np.abs(pairs.forces()).max()
    assert_agrees(neighbours, held, pairs)


def test_a_wide_box_of_few_rods_has_a_small_grid(device):
    """Cells of the smallest width would overflow 32 bits; wider cells miss no pair."""
    rods = random_walks(np.random.default_rng(8), 4, 17, 0.6, 0.02)
    period, held, steric = np.full(3, 60.0), [Held(rods, device)], {"strength": 0.7, "range": 0.003, "core": 0.02}
    neighbours = Neighbours(held, **steric, period=period, device=device)
    neighbours.apply()
    assert np.abs(all_forces(held)).max() > 0
    assert_agrees(neighbours, held, Pairs([rods], **steric, period=period))


def test_forces_do_not_change_over_many_periods(device):
    """Positions are never wrapped; only the digits lost in differences of large positions change."""
    period, most = (2.5, 1.9, 3.1), 1000
    ensembles = entangled(spread=1.0)
    far = moved_by_periods(ensembles, period, most)
    neighbours, held = applied(far, device, period=period)
    assert np.abs(all_forces(held)).max() > 0.1
    assert_agrees(neighbours, held, Pairs(far, **STERIC, period=period))
    assert_agrees(neighbours, held, Pairs(ensembles, **STERIC, period=period), tolerance=1e-13 * 4 * most)


def test_a_rod_longer_than_the_box_interacts_with_its_own_image(device):
    """A straight rod in a box less than half as wide as its length, and one that nearly closes on itself."""
    period = (1.75, 1.75, 1.75)
    line = np.linspace(0, 4.0, 81)[:, None] * np.array([0.8, 0.6, 0.0])
    along = np.linspace(0, 1.75 * 80 / 81, 81)[:, None] * np.array([1.0, 0.0, 0.0]) + [0.0, 0.0, 0.5]
    ensembles = [Rods(line[None], np.array([4.0])), Rods(along[None], np.array([1.75 * 80 / 81]))]
    neighbours, held = applied(ensembles, device, period=period)
    assert np.abs(all_forces(held)).max() > 0.01
    assert_agrees(neighbours, held, Pairs(ensembles, **STERIC, period=period))


def test_total_force_is_zero_in_a_periodic_box(device):
    period = (2.0, 2.2, 0.0)
    ensembles = moved_by_periods(entangled(spread=1.0), period, 3)
    pairs = Pairs(ensembles, **STERIC, period=period)
    _, held = applied(ensembles, device, period=period)
    force = pairs.weights[:, None] * all_forces(held)
    np.testing.assert_allclose(force.sum(axis=0), 0, rtol=0, atol=1e-14 * np.abs(force).sum())


@pytest.mark.parametrize("period", [(0.0, 0.0, 0.0), (2.0, 2.2, 0.0)])
def test_bits_depend_on_positions_only(period, device, monkeypatch):
    """Not on the skin, on the positions for which lists were built, or on the lengths of lists."""
    rods = entangled(spread=0.6)
    _, held = applied(rods, device, period=period)
    expected, rng = all_forces(held), np.random.default_rng(7)
    for skin, places in [(0.0, 32), (1e-3, 32), (0.02, 1), (0.13, 32), (0.4, 7), (0.4, 500)]:
        monkeypatch.setattr(lists, "PLACES", places)
        held = [Held(e, device) for e in rods]
        neighbours = Neighbours(held, **STERIC, device=device, period=period, skin=skin)
        for h, e in zip(held, rods, strict=True):
            move = rng.normal(size=e.position.shape)
            h.place(e.position + 0.49 * skin * move / np.linalg.norm(move, axis=-1, keepdims=True))
        neighbours.rebuild_lists()
        for h, e in zip(held, rods, strict=True):
            h.place(e.position)
        neighbours.apply()
        np.testing.assert_array_equal(all_forces(held), expected)


def test_lists_that_are_too_short_are_made_longer(device, monkeypatch):
    monkeypatch.setattr(lists, "PLACES", 2)
    ensembles = entangled()
    neighbours, held = applied(ensembles, device)
    longest = neighbours._lists.count.numpy().max()
    assert 2 < longest <= neighbours._lists.neighbour.shape[1]
    assert_agrees(neighbours, held, Pairs(ensembles, **STERIC))


@pytest.mark.parametrize("skin", [0.0, 0.05, 0.3])
def test_lists_are_rebuilt_before_they_become_invalid(skin, device):
    """One bundle is moved through another, across the faces of the box, by steps from far below to above the skin."""
    period, steric = (2.0, 0.0, 1.9), STERIC | {"range": 0.05}
    rng = np.random.default_rng(8)
    resting, driven = random_walks(rng, 5, 17, 0.4, 0.2), random_walks(rng, 5, 17, 0.4, 0.2)
    held = [Held(resting, device), Held(driven, device)]
    neighbours = Neighbours(held, **steric, device=device, period=period, skin=skin)
    rebuilt = 0
    rebuild_lists = neighbours.rebuild_lists

    def counted():
        nonlocal rebuilt
        rebuilt += 1
        rebuild_lists()

    neighbours.rebuild_lists = counted
    path = np.cumsum(np.concatenate([np.full(12, 0.01), np.full(5, 0.06), np.full(6, 0.4)]))
    for x in path:
        now = Rods(driven.position + np.array([x - 0.5, 0.0, x / 3]), driven.length)
        held[1].place(now.position)
        neighbours.apply()
        assert_agrees(neighbours, held, Pairs([resting, now], **steric, period=period))
    assert rebuilt < len(path) or skin == 0


def test_largest_displacements_are_measured(device):
    """Since the positions that are kept, which are those of the last step."""
    (rods, _), rng = entangled(), np.random.default_rng(9)
    held = Held(rods, device)
    neighbours = Neighbours([held], **STERIC, device=device)
    neighbours.keep()
    assert neighbours.apply() == 0
    position = rods.position
    for move in rng.normal(scale=[[0.1], [0.3], [0.2]], size=(3, 3)):
        held.place(position + move)
        assert neighbours.apply() == pytest.approx(np.linalg.norm(move), rel=1e-12)
        held.place(position + 2 * move)  # the step is repeated
        assert neighbours.apply() == pytest.approx(2 * np.linalg.norm(move), rel=1e-12)
        neighbours.keep()
        position = position + 2 * move


def own_stiffness(pairs: Pairs) -> np.ndarray:
    """Σ_j w_j max(0, −∂f/∂d along d) d̂d̂ᵀ of every node [point, 3, 3], from the Jacobian of the pair forces of two."""
    count = len(pairs.points)
    found, jacobian = np.zeros((count, 3, 3)), pairs.mobility_jacobian(np.ones(count)).reshape(count, 3, count, 3)
    for i in range(count):
        for j in range(count):
            d = pairs.points[i] - pairs.points[j]
            if i != j and np.any(block := jacobian[i, :, j]):
                along = d / np.linalg.norm(d)
                found[i] += max(along @ block @ along, 0) * np.outer(along, along)
    return found


@pytest.mark.parametrize("scale", [1.0, 2.0, 3.0])
def test_the_stiffness_is_the_derivative_of_the_force_along_the_distance(scale, device, verified):
    rng = np.random.default_rng(10)
    ensembles = [random_walks(rng, 6, 9, 0.4, 0.3 / scale), random_walks(rng, 4, 11, 0.3, 0.3 / scale)]
    held = [Held(e, device) for e in ensembles]
    Neighbours(held, **STERIC, device=device).apply()
    expected = own_stiffness(Pairs(ensembles, **STERIC))
    found = np.concatenate([h.stiffness.reshape(-1, 3, 3) for h in held])
    assert np.abs(expected).max() > 1
    verified.below(
        "independent", f"stiffness of contact of entangled rods, {scale:g} times as dense, over the largest",
        measured=np.abs(found - expected).max() / np.abs(expected).max(), bound=1e-9,
        reference="Jacobian of the pair forces by complex steps",
    )  # fmt: skip
