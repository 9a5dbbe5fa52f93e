"""Pores and ducts: forces of walls, places at the start, and the way out of one end and into the other."""

import numpy as np
import pytest
from examples.steric import Held, random_walks
from reference.steric import Rods
from test_arrangements import CELLS, STERIC, closest, directions, laid_out, lines, middles
from test_walls import Pushed

from warp_rods.contact.arrangements import Region
from warp_rods.contact.rooms import WALLED, turned_to
from warp_rods.contact.walls import Walls
from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.together import Together
from warp_rods.scene.box import ROOMS, Box
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

STRENGTH, RANGE = 2000.0, 0.1
BOXES = {
    "pore": {"kind": "pore", "radius": 0.4, "length": 3.0},
    "closed pore": {"kind": "pore", "radius": 0.4, "length": 2.0, "ends": "closed"},
    "duct": {"kind": "duct", "sides": [0.6, 0.9], "length": 3.0},
    "closed duct": {"kind": "duct", "sides": [0.6, 0.9], "length": 2.0, "ends": "closed"},
}


def depths(box: dict, points: np.ndarray) -> np.ndarray:
    """Distance [..., wall] beyond each wall of a room along x, negative inside."""
    half = box["length"] / 2 if box.get("ends") == "closed" else np.inf
    beyond = [np.abs(points[..., 0]) - half]
    if box["kind"] == "pore":
        beyond.append(np.sqrt(points[..., 1] ** 2 + points[..., 2] ** 2) - box["radius"])
    else:
        beyond += [np.abs(points[..., k + 1]) - side / 2 for k, side in enumerate(box["sides"])]
    return np.stack(beyond, axis=-1)


def energy_density(box: dict, points: np.ndarray) -> np.ndarray:
    """Σ ½ k (d + δ)² over the walls, where d > −δ."""
    return 0.5 * STRENGTH * (np.maximum(depths(box, points) + RANGE, 0.0) ** 2).sum(axis=-1)


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize("name", BOXES)
def test_the_force_is_minus_the_gradient_of_the_energy(name, axis, device, verified):
    """Against central differences in NumPy; corners, where two walls push, and the axis of a pore included."""
    box, turn = BOXES[name], turned_to("xyz".index(axis))
    rng = np.random.default_rng(5)
    starts = rng.uniform(-1, 1, (8, 3)) * [1.1, 0.3, 0.45]
    starts[0] = 0.0
    walk = random_walks(rng, 8, 9, 0.4, 0.0)
    x = walk.position - walk.position[:, :1] + starts[:, None]
    held = Held(Rods(x @ turn.T, walk.length), device)
    walls = Walls([held], WALLED[box["kind"]](Box(**box, axis=axis)), STRENGTH, RANGE, device=device)
    walls.add_forces()
    weights = np.repeat(walk.spacing[:, None], 9, axis=1)
    weights[:, [0, -1]] /= 2
    density = energy_density(box, x)
    np.testing.assert_allclose(walls.energies()[0], (weights * density).sum(axis=1), rtol=1e-12, atol=1e-12)
    moves = 1e-5 * np.eye(3)
    slopes = sum(s * energy_density(box, x[..., None, :] + s * moves) for s in (1, -1)) / 2e-5
    pushed = (depths(box, x) > -RANGE).sum(axis=-1)
    assert (pushed == 0).any() and (pushed == 1).any() and ((pushed == 2).any() or name == "pore")
    assert not held.force[pushed == 0].any()
    smooth = (np.abs(depths(box, x) + RANGE) > 2e-5).all(axis=-1)
    verified.below(
        "conservation", f"force of the walls of a {name} along {axis}, against minus the gradient of the energy",
        measured=np.abs(held.force + slopes @ turn.T)[smooth].max() / np.abs(slopes).max(), bound=1e-7,
        reference="central differences in NumPy",
    )  # fmt: skip
    beyond = depths(box, x)[..., 1]
    outward = x * [0, 1, 1] / np.hypot(x[..., 1], x[..., 2])[..., None].clip(1e-30)
    if name == "pore":  # along the radius, to round-off
        expected = -STRENGTH * np.maximum(beyond + RANGE, 0)[..., None] * outward
        np.testing.assert_allclose(held.force @ turn, expected, atol=1e-12 * STRENGTH)


@pytest.mark.parametrize("arrangement", ["random", "aligned", "bands"])
@pytest.mark.parametrize("name", BOXES)
def test_placed_rods_are_inside_and_apart(name, arrangement):
    """Out of the range of the walls, and a core away from each other's nearest images."""
    box = BOXES[name]
    simulation = laid_out({**box, "axis": "y"}, {**CELLS, "count": 12, "placement": arrangement})
    x = np.concatenate(lines(simulation)) @ turned_to(1)
    assert depths(box, x).max() <= -0.05 + 1e-12
    assert closest(simulation) >= 0.08 * (1 - 1e-12)
    if arrangement == "aligned":
        np.testing.assert_allclose(directions(simulation), [[0, 1, 0]] * 12, atol=1e-15)
    assert np.ptp(middles(simulation)[:, 1]) > 0.3


def region(box: dict) -> Region:
    scene = Scene(swimmers=[{**CELLS, "placement": "random"}], steric=STERIC, box=box, time={"end": 1.0})
    return Region.of(scene, None, 0.04)


def numbers(position: np.ndarray, rotation: np.ndarray) -> list[np.ndarray]:
    """Cosine from the axis, roll, distance from the axis, and place along it."""
    return [rotation[:, 0, 0], rotation[:, 0, 1], np.hypot(*position[:, 1:].T), position[:, 0]]


def test_random_places_are_uniform_among_those_inside():
    """Directions and distances from the axis as if places and isotropic directions were drawn again and again."""
    from scipy.stats import ks_2samp

    room, n = region({"kind": "pore", "radius": 0.2, "length": 3.0}), 4000
    s = np.linspace(-0.5, 0.5, 17)[:, None]
    rod = s * [1.0, 0, 0] + 0.1 * (1 - 4 * s**2) * [0, 1.0, 0]  # slightly bent
    (position, rotation), found = room.draw("random", np.repeat(rod[None], n, axis=0), np.random.default_rng(1))
    assert room.contains(found).all()
    rng = np.random.default_rng(2)
    kept = []
    while sum(map(len, kept)) < n:
        q = rng.normal(size=(100_000, 4))
        w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
        R = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]).transpose(2, 0, 1)  # fmt: skip
        p = rng.uniform([-1.5, -0.15, -0.15], [1.5, 0.15, 0.15], size=(len(q), 3))
        inside = np.hypot(*np.moveaxis(p[:, None, 1:] + np.einsum("rij,nj->rni", R[:, 1:], rod), -1, 0)) <= 0.15
        good = inside.all(axis=1)
        kept.append(np.concatenate([p[good], R[good].reshape(-1, 9)], axis=1))
    brute = np.concatenate(kept)[:n]
    R = brute[:, 3:].reshape(-1, 3, 3)
    ours = {
        "cos": rotation[:, 0, 0],
        "roll": rotation[:, 0, 1],
        "radius": np.hypot(*position[:, 1:].T),
        "x": position[:, 0],
    }
    theirs = {"cos": R[:, 0, 0], "roll": R[:, 0, 1], "radius": np.hypot(brute[:, 1], brute[:, 2]), "x": brute[:, 0]}
    for name, values in ours.items():
        assert ks_2samp(values, theirs[name]).pvalue > 1e-3, name


def test_random_directions_in_a_wide_pore_are_isotropic():
    """No direction is excluded where the pore is wider than the rods are long: ⟨p pᵀ⟩ = 1/3."""
    room, n = region({"kind": "pore", "radius": 40.0, "length": 3.0}), 4000
    rod = np.linspace(-0.5, 0.5, 17)[:, None] * [1.0, 0, 0]
    (_, rotation), _ = room.draw("random", np.repeat(rod[None], n, axis=0), np.random.default_rng(3))
    np.testing.assert_allclose(np.linalg.det(rotation), 1)
    np.testing.assert_allclose(
        rotation @ np.swapaxes(rotation, 1, 2), np.broadcast_to(np.eye(3), (n, 3, 3)), atol=1e-12
    )
    p = rotation[:, :, 0]
    assert np.sum(p.mean(axis=0) ** 2) < 16.3 / 3 / n
    Q = 1.5 * (np.einsum("ri,rj->ij", p, p) / n - np.eye(3) / 3)
    assert np.trace(Q @ Q) < 20.5 / 5 * 1.5 / n


def test_rods_are_placed_in_a_pore_little_wider_than_they_are_thick():
    simulation = laid_out({"kind": "pore", "radius": 0.052, "length": 30.0}, {**CELLS, "count": 10})
    assert depths({"kind": "pore", "radius": 0.052, "length": 30.0}, np.concatenate(lines(simulation))).max() < -0.0499


@pytest.mark.parametrize(
    ("box", "said"),
    [
        ({"kind": "pore", "radius": 0.05, "length": 9.0}, r"placement: 0\.05 from all walls is no room: make the pore"),
        ({"kind": "duct", "sides": [0.4, 0.4]}, r"placement: the duct is endless: give box\.length"),
        ({"kind": "pore", "radius": 0.2, "length": 2.0}, r"count = 60: .*place fewer, or make the box larger"),
        (
            {"kind": "pore", "radius": 0.1, "length": 0.9, "ends": "closed"},
            r"found no place inside the box, which may be too small for their length: place fewer",
        ),
    ],
)
def test_rods_that_do_not_fit_are_reported(box, said):
    with pytest.raises(SceneError, match=said):
        laid_out(box)


def swimming(box: dict, placement, end: float = 0.1, **changes) -> Simulation:
    time = {"end": end, "step": 1e-3, "save_every": 0.1}
    return Simulation(
        Scene(swimmers=[{**CELLS, "placement": placement, **changes}], steric=STERIC, box=box, time=time), "cpu"
    )


def frames(simulation: Simulation) -> np.ndarray:
    """The positions [frame, rod, node, 3] of all frames, without that of the start."""
    return np.array([simulation.ensembles["cells"].position for _ in simulation.advance()])


def test_a_pore_along_another_axis_gives_the_same_motion_turned():
    """The places at the start to the bit, and those after a while, against walls and each other, to round-off."""
    ends = {}
    for k, axis in enumerate("xyz"):
        simulation = swimming({**BOXES["pore"], "axis": axis}, "random", count=8, bend=2e-3)
        before = simulation.ensembles["cells"].position @ turned_to(k)
        ends[axis] = before, frames(simulation)[-1] @ turned_to(k)
    for axis in "yz":
        np.testing.assert_array_equal(ends[axis][0], ends["x"][0])
        np.testing.assert_allclose(ends[axis][1], ends["x"][1], atol=1e-10)
    assert np.abs(ends["x"][1] - ends["x"][0]).max() > 0.05


def test_a_rod_that_leaves_one_end_meets_those_at_the_other():
    """Places go on beyond the end; forces are those between nearest images, as if the other rod were one period on."""
    length = BOXES["pore"]["length"]
    forces, energies = [], []
    for shift in (0.0, length):
        poses = {"position": [[1.9, 0.05, 0], [-1.2 + shift, -0.02, 0.03]], "direction": [[1, 0, 0], [1, 0.1, 0]]}
        simulation = swimming(BOXES["pore"], poses, count=2)
        energies.append(simulation.variables()["cells"]["steric_energy"])
        forces.append(simulation.ensembles["cells"].force)
    assert np.abs(forces[0]).max() > 1
    np.testing.assert_allclose(forces[0], forces[1], rtol=0, atol=1e-12 * np.abs(forces[0]).max())
    np.testing.assert_allclose(energies[0], energies[1], rtol=1e-12)


def test_a_swimmer_goes_round_a_periodic_pore():
    """Alone it moves by f/ζ∥ = 1 for ever, straight on."""
    x = frames(swimming(BOXES["pore"], {"position": [[1.2, 0, 0]]}, 0.8, count=1))[:, 0, 8, 0]
    np.testing.assert_allclose(np.diff(x), 1e-3, atol=1e-12)
    assert 1.9 < x[-1] < 2.1


def test_a_swimmer_stops_at_the_closed_end(verified):
    """∫ f ds = 1 = Σ w_i k (depth − i Δs)₊."""
    box = {"kind": "duct", "sides": [0.6, 0.9], "length": 1.3, "ends": "closed", "axis": "z", "wall": {"range": 0.05}}
    poses = {"position": [[0, 0, 0]], "direction": [[0, 0, 1]]}
    z = frames(swimming(box, poses, 0.8, count=1))[-1, 0, :, 2]
    weights = np.full(17, 1 / 16)
    weights[[0, -1]] /= 2
    verified(
        "exact", "force of the closed end of a duct on a swimmer at rest", within=1e-8, expected=1,
        measured=2000.0 * weights @ np.maximum(z - (1.3 / 2 - 0.05), 0), reference="∫ f ds = 1",
    )  # fmt: skip


def test_swimmers_stay_in_a_pore():
    simulation = swimming(BOXES["pore"], "random", 0.5, count=8)
    x = frames(simulation)
    assert 0.35 < np.hypot(x[..., 1], x[..., 2]).max() < 0.4 and (simulation.ensembles["cells"].status == 0).all()


@pytest.mark.parametrize("name", ["pore", "duct"])
def test_the_energy_lost_is_dissipated(name, device, verified):
    """A passive bent rod that is too wide for its room straightens and is squeezed; second order in Δs, N = 64."""
    s = np.linspace(-0.5, 0.5, 65)
    shape = np.zeros((1, 65, 3))
    shape[0, :, 1] = 5 * np.cos(np.pi * s) ** 2
    rods = FreeRods(1, 65, bend=1e-2, twist=1e-3, flagella=None, shape=shape, device=device)
    room = {"radius": 0.15} if name == "pore" else {"sides": [0.2, 0.3]}
    walls = Walls([rods], WALLED[name](Box(kind=name, wall={"range": 0.1}, **room)), 20.0, 0.1, device=device)
    pushed = Pushed(rods, walls)

    def energy() -> float:
        rods.show()
        pushed.apply()
        return float((rods.energy + walls.energies()[0]).sum())

    before, drag = energy(), [rods.dissipation.sum()]
    for _ in Together([rods], pushed).advance(1e-4, 200):
        energy()
        drag.append(rods.dissipation.sum())
    spent = np.trapezoid(drag, dx=1e-4)
    verified.below(
        "conservation", f"passive rod in a {name}: energy lost − ∫ dissipation, relative, N = 64",
        measured=abs(before - energy() - spent) / spent, bound=2e-3, reference="0",
    )  # fmt: skip


def test_the_tables_of_rooms_agree():
    walls = {kind for kind, room in ROOMS.items() if "wall" in room.keys}
    assert walls == {*WALLED, "slab", "container"}


def test_a_rod_longer_than_a_period_is_told():
    """It would lie on its own image."""
    box = {"kind": "pore", "radius": 0.5, "length": 0.9, "ends": "periodic"}
    place = {"position": [[0, 0, 0]], "direction": [[1, 0, 0]]}
    assert any("reaches its own image" in line for line in swimming(box, place, count=1).warnings)
    assert not any("own image" in line for line in swimming(box | {"length": 4.0}, place, count=1).warnings)
