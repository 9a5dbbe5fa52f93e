"""Placement of swimmers in a box: clearance, volume fraction, directions, and faults."""

import numpy as np
import pytest
import warp as wp

from warp_rods.errors import SceneError
from warp_rods.kernels.contact.segments import nearest_places
from warp_rods.kernels.layout import Scalars1D, Vectors1D
from warp_rods.scene.scene import Scene
from warp_rods.simulation.layout import lay_out
from warp_rods.simulation.loop import Simulation

CELLS = {
    "name": "cells", "count": 60, "nodes": 17, "bend": 1e-2, "twist": 1e-3, "flagella": {"profile": "uniform"},
    "shape": {"kind": "straight"},
}  # fmt: skip
STERIC = {"strength": 100.0, "range": 0.02, "core": 0.08}
SLAB = {"kind": "slab", "height": 0.3, "fraction": 0.3}
CUBE = {"kind": "periodic", "fraction": 0.05}
SPHERE = {"kind": "sphere", "radius": 1.5}
ARRANGEMENTS = ["random", "aligned", "polar lanes", "nematic lanes", "bands"]


def laid_out(box, *swimmers, **changes) -> Simulation:
    tables = {"swimmers": list(swimmers) or [CELLS], "steric": STERIC, "time": {"end": 0.1, "step": 5e-4}, "box": box}
    return Simulation(Scene.parse({key: v for key, v in (tables | changes).items() if v is not None}), "cpu")


def lines(simulation: Simulation) -> list[np.ndarray]:
    """Centre lines [node, 3] of all rods."""
    return [line for e in simulation.ensembles.values() for line in e.position]


def directions(simulation: Simulation) -> np.ndarray:
    """Unit tangents of the middles [rod, 3]."""
    return np.concatenate([e.rotation[:, e.nodes // 2, :, 0] for e in simulation.ensembles.values()])


def middles(simulation: Simulation) -> np.ndarray:
    return np.array([line[len(line) // 2] for line in lines(simulation)])


def distance_of_segments(p, a, q, b) -> np.ndarray:
    """Distances of segments p + x a and q + y b [..., 3]: at the foot of the common normal, or from an end."""

    def from_point(r, start, along):
        x = np.sum((r - start) * along, axis=-1) / np.sum(along * along, axis=-1)
        return np.linalg.norm(r - start - np.clip(x, 0, 1)[..., None] * along, axis=-1)

    ends = [from_point(p, q, b), from_point(p + a, q, b), from_point(q, p, a), from_point(q + b, p, a)]
    n = np.cross(a, b)
    size = np.maximum(np.sum(n * n, axis=-1), 1e-300)
    x, y = (np.sum(np.cross(q - p, side) * n, axis=-1) / size for side in (b, a))
    skew = size > 1e-12 * np.sum(a * a, axis=-1) * np.sum(b * b, axis=-1)
    inside = skew & (x > 0) & (x < 1) & (y > 0) & (y < 1)
    apart = np.abs(np.sum((q - p) * n, axis=-1)) / np.sqrt(size)
    return np.where(inside, apart, np.min(ends, axis=0))


def closest(simulation: Simulation) -> float:
    """The smallest distance between centre lines of different rods, with nearest images, over all pairs of segments."""
    rods, least = lines(simulation), np.inf
    period = np.array(simulation.scene.period)
    divisor = np.where(period > 0, period, np.inf)
    for k, line in enumerate(rods[:-1]):
        p, a = line[:-1], np.diff(line, axis=0)
        q = np.concatenate([other[:-1] for other in rods[k + 1 :]])[:, None]
        b = np.concatenate([np.diff(other, axis=0) for other in rods[k + 1 :]])[:, None]
        middle = p + a / 2 - q - b / 2
        image = np.where(period > 0, period, 0.0) * np.round(middle / divisor)
        least = min(least, distance_of_segments(p - image, a, q, b).min())
    return float(least)


@wp.kernel(enable_backward=False)
def find_nearest_places(p: Vectors1D, a: Vectors1D, q: Vectors1D, b: Vectors1D, first: Scalars1D, second: Scalars1D):
    i = wp.tid()
    x, y = nearest_places(p[i], a[i], q[i], b[i])
    first[i] = x
    second[i] = y


def nearest_points(*vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where segments p + x a and q + y b [n, 3] are closest: x and y [n]."""
    given = [wp.array(v, dtype=wp.vec3d, device="cpu") for v in vectors]
    found = [wp.zeros(len(vectors[0]), dtype=wp.float64, device="cpu") for _ in range(2)]
    wp.launch(find_nearest_places, dim=len(vectors[0]), inputs=[*given, *found], device="cpu")
    return found[0].numpy(), found[1].numpy()


def test_nearest_points_of_segments(verified):
    """Against an independent formula; parallel segments, segments in one line and points included."""
    rng = np.random.default_rng(4)
    p, q = rng.normal(size=(2, 4000, 3))
    a, b = rng.normal(size=(2, 4000, 3))
    b[:500] = a[:500] * rng.normal(size=(500, 1))
    q[:200] = p[:200] + a[:200] * rng.uniform(-3, 3, size=(200, 1))
    x, y = nearest_points(p, a, q, b)
    found = np.linalg.norm(p + x[:, None] * a - q - y[:, None] * b, axis=-1)
    verified.below(
        "independent", "distances of 4000 pairs of segments", measured=np.abs(found - distance_of_segments(p, a, q, b)),
        bound=1e-12, reference="common normals and ends, in NumPy",
    )  # fmt: skip
    _, y = nearest_points(p, 0 * a, q, b)
    d = np.linalg.norm(p - q - y[:, None] * b, axis=-1)
    np.testing.assert_allclose(d, distance_of_segments(p, 1e-9 * a, q, b), rtol=0, atol=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("count", [200])
def test_centre_lines_keep_the_core_in_a_dense_box(count):
    """Cells of aspect 12 that fill a fifth of the box: between nodes too, where 336 pairs were closer than the core."""
    cells = {**CELLS, "count": count, "nodes": 25}
    simulation = laid_out({"kind": "periodic", "fraction": 0.2}, cells, steric={**STERIC, "strength": 1000.0}, seed=3)
    assert closest(simulation) >= 0.08 * (1 - 1e-12)


def test_rods_whose_nodes_are_apart_but_whose_lines_cross_are_warned_of():
    """Half a spacing from node to node: the crossing lines have no distance at all."""
    h = 0.5 / 16
    cross = {"position": [[0, 0, 0], [h, h, 0]], "direction": [[1, 0, 0], [0, 1, 0]]}
    cells = {**CELLS, "count": 2, "placement": cross}
    layout = lay_out(Scene(swimmers=[cells], steric={**STERIC, "core": 0.06}, time={"end": 1.0}), "cpu")
    assert [line for line in layout.warnings if line.startswith("1 pairs of rods start closer than 0.5 of")]


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
@pytest.mark.parametrize("box", [SLAB, CUBE], ids=["slab", "cube"])
@pytest.mark.parametrize("nodes", [17, 33])
def test_no_rod_is_closer_to_another_than_the_core(arrangement, box, nodes):
    """Across the faces of the box as well; the spacings 1/16 and 1/32 of the nodes are smaller than the core."""
    simulation = laid_out(box, {**CELLS, "placement": arrangement, "nodes": nodes})
    assert closest(simulation) >= max(STERIC["core"], 1 / (nodes - 1)) * (1 - 1e-12)
    assert [note for note in simulation.notes if f"placed {arrangement}" in note]


def test_the_clearance_is_the_larger_of_core_and_spacing():
    simulation = laid_out(SLAB, steric={**STERIC, "core": 0.04})
    assert closest(simulation) >= 1 / 16 * (1 - 1e-12)


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_the_fraction_is_the_one_stated(arrangement):
    flat = laid_out(SLAB, {**CELLS, "placement": arrangement})
    x, y, _ = flat.scene.period
    assert len(lines(flat)) * 0.08 / (x * y) == pytest.approx(0.3, rel=1e-12)
    at = middles(flat)
    assert (np.abs(at[:, 2]) <= 0.1 + 1e-12).all()  # between the walls and clear of their range
    assert np.ptp(at[:, 0]) > 0.7 * x and np.ptp(at[:, 1]) > 0.7 * y
    box = laid_out(CUBE, {**CELLS, "placement": arrangement})
    assert len(lines(box)) * np.pi / 4 * 0.08**2 / np.prod(box.scene.period) == pytest.approx(0.05, rel=1e-12)


def test_random_directions_are_isotropic():
    """n ⟨p⟩² of n directions is χ² over its degrees of freedom, 2 or 3: above ``most`` once in a thousand."""
    for box, most in ((SLAB, 13.8 / 2), (CUBE, 16.3 / 3)):
        p = directions(laid_out(box, {**CELLS, "count": 150}))
        n = len(p)
        assert np.sum(p.mean(axis=0) ** 2) < most / n
        if box is SLAB:
            assert not p[:, 2].any()
            assert np.abs(np.exp(2j * np.angle(p[:, 0] + 1j * p[:, 1])).mean()) ** 2 < most / n
        else:
            Q = 1.5 * (np.einsum("ri,rj->ij", p, p) / n - np.eye(3) / 3)
            assert np.trace(Q @ Q) < 20.5 / 5 * 1.5 / n  # 1.5/n times χ²₅/5; χ²₅ exceeds 20.5 once in a thousand


def test_aligned_swimmers_are_directed_along_x():
    for box in (SLAB, CUBE):
        np.testing.assert_allclose(directions(laid_out(box, {**CELLS, "placement": "aligned"})), [[1, 0, 0]] * 60)


@pytest.mark.parametrize("box", [SLAB, CUBE], ids=["slab", "cube"])
def test_polar_lanes_alternate_in_direction(box):
    simulation = laid_out(box, {**CELLS, "placement": "polar lanes", "count": 80})
    p, at, width = directions(simulation), middles(simulation), simulation.scene.period[1]
    lanes = 2 * max(1, round(width / 2))
    lane = np.floor((at[:, 1] / width + 0.5) * lanes).astype(int)
    np.testing.assert_allclose(p[:, 0], np.where(lane % 2, -1.0, 1.0))
    assert set(lane) == set(range(lanes))
    assert 0.5 < width / lanes < 2  # about the length of a swimmer


def test_swimmers_in_nematic_lanes_have_random_signs():
    p = directions(laid_out(SLAB, {**CELLS, "placement": "nematic lanes", "count": 100}))
    np.testing.assert_allclose(np.abs(p[:, 0]), 1)
    assert abs(p[:, 0].sum()) < 3.3 * np.sqrt(100)


def test_bands_swim_towards_each_other():
    for box in (SLAB, CUBE):
        simulation = laid_out(box, {**CELLS, "placement": "bands"})
        p, x = directions(simulation)[:, 0], middles(simulation)[:, 0]
        np.testing.assert_allclose(p, np.where(x < 0, 1.0, -1.0))
        assert 15 < (x < 0).sum() < 45


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_the_seed_determines_the_placement(arrangement):
    def at(seed):
        return middles(laid_out(SLAB, {**CELLS, "placement": arrangement}, seed=seed))

    one = at(1)
    assert one.tobytes() == at(1).tobytes()
    assert np.abs(one - at(2)).max() > 0.1


def test_ensembles_with_different_numbers_of_nodes_are_placed_together():
    more = {**CELLS, "name": "more", "nodes": 33, "count": 40, "bend": 1e-3}
    bent = {**CELLS, "name": "bent", "count": 20, "shape": {"kind": "mode", "amplitude": 3.0}}
    simulation = laid_out(SLAB, CELLS, more, bent)
    assert closest(simulation) >= 0.08 * (1 - 1e-12)
    assert {name: e.count for name, e in simulation.ensembles.items()} == {"cells": 60, "more": 40, "bent": 20}
    flat = np.concatenate([np.ptp(e.position[..., 2], axis=1) for e in simulation.ensembles.values()])
    assert flat.max() < 1e-12  # bent in the plane of the slab
    for e in simulation.ensembles.values():  # no ensemble is confined to a part of the box
        assert np.ptp(e.position[:, 0, 0]) > 0.6 * simulation.scene.period[0]


def test_different_arrangements_keep_clear_of_each_other():
    lanes = {**CELLS, "name": "lanes", "placement": "polar lanes", "count": 20}
    assert closest(laid_out(SLAB, CELLS, lanes)) >= 0.08 * (1 - 1e-12)


@pytest.mark.parametrize("arrangement", ["random", "aligned"])
def test_arranged_swimmers_keep_clear_of_given_placements(arrangement):
    """In any order of the tables; the order of the ensembles is that of the tables."""
    given = {**CELLS, "name": "given", "count": 2, "placement": {"position": [[0, 0, 0], [0, 0.5, 0]]}}
    first = {**CELLS, "count": 30, "placement": arrangement}
    box = {**SLAB, "height": 0.11, "fraction": 0.4}
    for tables in ((first, given), (given, first)):
        simulation = laid_out(box, *tables)
        assert list(simulation.ensembles) == [table["name"] for table in tables]
        assert closest(simulation) >= 0.08 * (1 - 1e-12)
        np.testing.assert_allclose(simulation.ensembles["given"].position[:, 8], [[0, 0, 0], [0, 0.5, 0]])


def test_swimmers_keep_clear_of_filaments():
    filaments = {
        "name": "f", "count": 5, "nodes": 17, "length": 0.8, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
    }  # fmt: skip
    simulation = laid_out(
        {"kind": "periodic", "size": [3, 3, 3]}, CELLS, filaments=[filaments],
        surface={"kind": "sphere", "radius": 0.8},
    )  # fmt: skip
    assert closest(simulation) >= 0.08 * (1 - 1e-12)


@pytest.mark.parametrize("arrangement", ["random", "aligned", "bands", "nematic lanes", "polar lanes"])
def test_a_container_contains_every_node(arrangement):
    simulation = laid_out({"kind": "container", "surface": SPHERE}, {**CELLS, "count": 40, "placement": arrangement})
    r = np.linalg.norm(np.concatenate(lines(simulation)), axis=-1)
    # φ/|∇φ| = (r − R²/r)/2 is below −ε/2.
    assert ((r - 1.5**2 / r) / 2).max() < -0.04
    assert closest(simulation) >= 0.08 * (1 - 1e-12)


def test_without_steric_forces_swimmers_may_overlap():
    simulation = laid_out({"kind": "slab", "height": 0.11, "size": [2, 2]}, steric=None)
    assert closest(simulation) < 0.04 and "may overlap" in simulation.notes[0]


def test_rods_that_start_beyond_a_wall_are_warned_of():
    given = {"position": [[0, 0, 3.0], [0, 0.5, 0]]}
    cells = {**CELLS, "count": 2, "placement": given}
    for box in ({"kind": "slab", "height": 0.2}, {"kind": "container", "surface": SPHERE}):
        scene = Scene(swimmers=[cells], steric=STERIC, box=box, time={"end": 1.0})
        assert [line for line in lay_out(scene, "cpu").warnings if "1 rods start beyond a wall" in line]


def test_rods_that_start_too_close_are_warned_of():
    """Without a placement all swimmers are at the origin; where they coincide the force between them vanishes."""
    time, cells = {"end": 1.0}, {k: v for k, v in CELLS.items() if k != "placement"}
    layout = lay_out(Scene(swimmers=[{**cells, "count": 3}], steric=STERIC, time=time), "cpu")
    assert [line for line in layout.warnings if line.startswith("3 pairs of rods start closer than 0.5 of")]
    apart = {"position": [[0, 0, 0], [0, 0, 0.08], [0, 0, 1.0]]}
    layout = lay_out(Scene(swimmers=[{**cells, "count": 3, "placement": apart}], steric=STERIC, time=time), "cpu")
    assert not [line for line in layout.warnings if "start closer" in line]


@pytest.mark.parametrize(
    ("box", "changes", "said"),
    [
        (
            {"kind": "slab", "height": 0.1, "fraction": 0.95},
            {},
            r'swimmers\[0\]\.placement = "random": count = 60: .*place fewer, or make the box larger',
        ),
        (
            {"kind": "slab", "height": 0.1, "fraction": 0.95},
            {"placement": "aligned"},
            r'swimmers\[0\]\.placement = "aligned": count = 60: after \d+ draws only \d+ fit 0\.08 apart; place fewer',
        ),
        ({"kind": "slab", "height": 0.3}, {}, r"swimmers\[0\]\.placement: the slab has no bounds: give box\.size or"),
        (
            {"kind": "container", "surface": {"kind": "sphere", "radius": 0.4}},
            {},
            r'swimmers\[0\]\.placement = "random": \d+ rods found no place inside the container.*: place fewer',
        ),
        (
            {"kind": "container", "surface": SPHERE, "side": "outside"},
            {},
            r"swimmers\[0\]\.placement: this container has no bounds: give position and direction of each rod",
        ),
        ({"kind": "container", "surface": {"kind": "plane"}}, {}, "this container has no bounds"),
    ],
)
def test_rods_that_do_not_fit_are_reported(box, changes, said):
    with pytest.raises(SceneError, match=said):
        laid_out(box, {**CELLS, **changes})
