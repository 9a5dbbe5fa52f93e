"""Soft walls: forces are minus the gradient of the energy, rods stop where forces balance, energy is conserved."""

import numpy as np
import pytest
from examples.free import slope
from examples.steric import Held, random_walks
from reference.steric import Rods

from warp_rods.contact.arrangements import about_z
from warp_rods.contact.neighbours import Neighbours
from warp_rods.contact.walls import Walls, caps_of
from warp_rods.membranes import surfaces
from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.together import Together, exhaust
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

STRENGTH, RANGE = 2000.0, 0.05
HEIGHT = 0.5
CONTAINERS = {
    "sphere": {"radius": 1.0},
    "ellipsoid": {"radii": [0.7, 1.0, 1.3]},
    "cassini": {"a": 1.0, "b": 1.1},
    "torus": {"major": 1.0, "minor": 0.4},
}


def distance(wall: Surface | float, side: float, points: np.ndarray) -> np.ndarray:
    """φ/|∇φ| outside the wall; |z| − h/2 for a slab."""
    if not isinstance(wall, Surface):
        return np.abs(points[..., 2]) - wall / 2
    return side * wall.phi(points) / np.linalg.norm(wall.gradient(points), axis=-1)


def energy_density(wall: Surface | float, side: float, points: np.ndarray, wall_range: float) -> np.ndarray:
    """W = ½ k (d + δ)² where d > −δ."""
    return 0.5 * STRENGTH * np.maximum(distance(wall, side, points) + wall_range, 0.0) ** 2


def near_the_wall(wall: Surface | float, nodes: int = 9) -> Rods:
    """Short random walks from the wall, with nodes within its range, beyond it and out of its range."""
    rng = np.random.default_rng(5)
    rods = random_walks(rng, 8, nodes, 0.4, 0.0)
    if isinstance(wall, Surface):
        start = wall.project(rng.uniform(*wall.box, size=(8, 3)))
    else:
        start = np.array([[x, -x, z * wall / 2] for x, z in enumerate([1.0, -1.0] * 4)])
    return Rods(rods.position + start[:, None], rods.length)


@pytest.mark.parametrize(
    ("kind", "outside"), [("slab", False), *((kind, outside) for kind in CONTAINERS for outside in (False, True))]
)
def test_force_is_minus_the_gradient_of_the_energy(kind, outside, device, verified):
    """By central differences, with errors of second order in the step."""
    wall = HEIGHT if kind == "slab" else surfaces.make(kind, CONTAINERS[kind])
    wall_range, side, rods = 0.1, -1.0 if outside else 1.0, near_the_wall(wall)
    held = Held(rods, device)
    walls = Walls([held], wall, STRENGTH, wall_range, outside, device)
    walls.add_forces()
    weights = np.repeat(rods.spacing[:, None], 9, axis=1)
    weights[:, [0, -1]] /= 2
    density = energy_density(wall, side, rods.position, wall_range)
    inside = density > 0
    assert 0.1 < inside.mean() < 0.99
    np.testing.assert_allclose(walls.energies()[0], (weights * density).sum(axis=1), rtol=1e-12, atol=1e-12)
    assert not held.force[~inside].any()
    smooth = density > 0.5 * STRENGTH * 0.01**2  # away from the edge of the range, where W″ jumps
    errors, steps = [], np.array([1e-3, 5e-4, 2.5e-4])
    for step in steps:
        moves = step * np.eye(3)
        ahead, behind = (
            energy_density(wall, side, rods.position[..., None, :] + s * moves, wall_range) for s in (1, -1)
        )
        slopes = (ahead - behind) / (2 * step)
        errors.append(np.abs(held.force + slopes)[smooth].max() / np.abs(held.force).max())
    name = f"force of a wall, {kind}{' from outside' if outside else ''}, against minus the gradient of the energy"
    if isinstance(wall, Surface):
        assert slope(1 / steps, errors) == pytest.approx(2, abs=0.2)
        verified.below("conservation", name, measured=errors[-1], bound=1e-4, reference="central differences in NumPy")
    else:
        verified.below(
            "conservation", name, measured=errors, bound=1e-11, reference="central differences, exact for a slab"
        )


def test_slab_and_sphere_have_their_exact_forces(device, verified):
    """k (d + δ) along the normal: d = |z| − h/2 for a slab; φ = (r² − R²)/2 and d = (r − R²/r)/2 for a sphere."""
    for wall in (HEIGHT, surfaces.make("sphere", {"radius": 1.0})):
        rods = near_the_wall(wall)
        held = Held(rods, device)
        Walls([held], wall, STRENGTH, RANGE, device=device).add_forces()
        x = rods.position
        if isinstance(wall, Surface):
            r = np.linalg.norm(x, axis=-1, keepdims=True)
            d, gradient = (r - 1 / r) / 2, x / r * (1 + 1 / r**2) / 2
        else:
            d, gradient = np.abs(x[..., 2:]) - HEIGHT / 2, np.sign(x[..., 2:]) * np.array([0.0, 0.0, 1.0])
        expected = -STRENGTH * np.maximum(d + RANGE, 0) * gradient
        verified.below(
            "exact", f"force of a wall, {'sphere' if isinstance(wall, Surface) else 'slab'}, over the largest",
            measured=np.abs(held.force - expected).max() / np.abs(expected).max(), bound=1e-13,
            reference="k (d + δ); d = |z| − h/2, or (r − R²/r)/2",
        )  # fmt: skip


def test_walls_add_to_the_present_forces_and_distant_walls_add_nothing(device):
    sphere = surfaces.make("sphere", {"radius": 1.0})
    centre = Rods(np.zeros((1, 9, 3)), np.array([0.4]))
    for outside in (False, True):  # ∇φ vanishes at the centre
        held = Held(centre, device)
        held.force_array.fill_([1.0, 2.0, 3.0])
        walls = Walls([held], sphere, STRENGTH, RANGE, outside, device)
        walls.add_forces()
        np.testing.assert_array_equal(held.force, np.broadcast_to([1.0, 2.0, 3.0], (1, 9, 3)))
        assert not walls.energies()[0].any()


class Pushed:
    """Walls as the forces of steps."""

    def __init__(self, rods: FreeRods, walls: Walls):
        self._rods, self._walls = rods, walls

    def apply(self) -> float:
        self._rods.force_array.zero_()
        self._rods.contact_stiffness_array.zero_()
        self._walls.add_forces()
        return 0.0

    def keep(self) -> None:
        pass


def upright(nodes: int, device, **other) -> FreeRods:
    """A straight rod that swims along z with f = 1."""
    R = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    given = {"bend": 0.1, "twist": 0.1, "flagella": {"profile": "uniform"}, "shape": {"kind": "straight"}}
    return FreeRods(1, nodes, **(given | other), rotation=R, device=device)


@pytest.mark.parametrize("nodes", [17, 33, 65])
def test_a_rod_that_swims_into_a_wall_stops_where_forces_balance(nodes, device, verified):
    """Σ w_i k (depth − i Δs)₊ = ∫ f ds = 1; for many nodes the tip is √(2/k) deep, less than the range of the wall."""
    rod, height = upright(nodes, device), 1.3
    walls = Walls([rod], height, STRENGTH, RANGE, device=device)
    exhaust(Together([rod], Pushed(rod, walls)).advance(6e-4, 1000))
    h = 1 / (nodes - 1)
    deep = rod.position[0, -1, 2] - (height / 2 - RANGE)
    weights = np.full(nodes, h)
    weights[[0, -1]] /= 2
    push = STRENGTH * weights @ np.maximum(deep - h * np.arange(nodes), 0)
    verified(
        "exact", f"force of a wall on a swimmer at rest, N = {nodes - 1}", measured=push, expected=1, within=1e-9,
        reference="∫ f ds = 1",
    )  # fmt: skip
    assert deep == pytest.approx(np.sqrt(2 / STRENGTH), abs=h)
    assert deep < RANGE and rod.status[0] == 0
    assert np.abs(rod.position[0, :, :2]).max() < 1e-9


def test_walls_without_steric_forces_give_the_same_force_each_time():
    """Nothing else sets the force to which walls add."""
    cell = {"name": "cell", "count": 1, "nodes": 17, "bend": 1e-2, "twist": 1e-3, "shape": {"kind": "straight"},
            "placement": {"position": [[0, 0, 0.1]]}}  # fmt: skip
    simulation = Simulation(Scene(swimmers=[cell], box={"kind": "slab", "height": 0.2}, time={"end": 1.0}), "cpu")
    forces = []
    for _ in range(2):
        simulation.variables()
        forces.append(simulation.ensembles["cell"].force)
    assert np.abs(forces[0]).max() > 0
    np.testing.assert_array_equal(*forces)


def test_swimmers_stay_in_a_sphere(device):
    """Straight, bent and twisted swimmers push against the wall for the time of ten crossings of the sphere."""
    sphere = surfaces.make("sphere", {"radius": 1.0})
    shape = np.zeros((4, 33, 3))
    s = np.linspace(-0.5, 0.5, 33)
    shape[1:, :, 1] = np.array([0.5, -1.0, 2.0])[:, None] * np.cos(np.pi * s)
    rods = FreeRods(
        4, 33, bend=[2e-2, 1e-3, 2e-2, 5e-3], twist=1e-3, moment=[0.0, 0.0, 5e-3, 5e-3],
        flagella={"profile": "uniform"}, shape=shape, device=device,
    )  # fmt: skip
    walls = Walls([rods], sphere, STRENGTH, RANGE, device=device)
    farthest, contacts = np.zeros(4), np.zeros(4)
    steps = Together([rods], Pushed(rods, walls))
    for _ in range(100):
        exhaust(steps.advance(1e-3, 100))
        rods.show()
        walls.add_forces()
        farthest = np.maximum(farthest, np.linalg.norm(rods.position, axis=-1).max(axis=1))
        contacts += walls.energies()[0] > 0
    assert (rods.status == 0).all()
    assert (contacts > 90).all()
    assert ((farthest > 1 - RANGE) & (farthest < 1.0)).all()


class PassiveRods:
    """Three passive bent rods that cross in a slab too low for them; their energy is dissipated."""

    def __init__(self, nodes: int, device):
        s = np.linspace(-0.5, 0.5, nodes)
        shape = np.zeros((3, nodes, 3))
        shape[:, :, 1] = np.array([[2.0], [-3.0], [2.0]]) * np.cos(np.pi * s) ** 2
        self.rods = FreeRods(
            3, nodes, bend=[5e-3, 1e-2, 2e-2], twist=1e-3, flagella=None, shape=shape, device=device,
            position=[[0, 0, 0], [0.1, 0.02, 0.03], [-0.1, -0.02, -0.04]],
            rotation=about_z(np.array([0.0, 0.9, -0.6])),
        )  # fmt: skip
        self.neighbours = Neighbours([self.rods], 2.0, 0.1, 0.15, device)
        self.walls = Walls([self.rods], 0.25, 20.0, 0.1, device=device)

    def apply(self) -> float:
        move = self.neighbours.apply() / self.neighbours.core
        self.walls.add_forces()
        return move

    def keep(self) -> None:
        self.neighbours.keep()

    @property
    def energies(self) -> np.ndarray:
        """Elastic, steric and wall energy under the present forces."""
        parts = (self.rods.energy, self.neighbours.energies()[0], self.walls.energies()[0])
        return np.array([part.sum() for part in parts])

    def run(self, end: float, steps: int) -> tuple[np.ndarray, float]:
        """The decrease of the energies, and the dissipated energy by the trapezoid rule."""
        self.apply()
        before, drag = self.energies, [self.rods.dissipation.sum()]
        for _ in Together([self.rods], self).advance(end / steps, steps):
            self.rods.show()
            self.apply()
            drag.append(self.rods.dissipation.sum())
        return before - self.energies, float(np.trapezoid(drag, dx=end / steps))


def test_the_energy_lost_is_dissipated_to_second_order_in_the_spacing(device, verified):
    """Velocities of nodes are means over half nodes, so the external power balances to the order of the grid."""
    sizes, errors = np.array([16, 32, 64]), []
    for size in sizes:
        lost, drag = PassiveRods(int(size) + 1, device).run(0.01, 400)
        assert (np.abs(lost) > 5e-3 * drag).all()
        errors.append(abs(lost.sum() - drag) / drag)
    verified.order(
        "rods in contact with each other and walls: energy lost − ∫ dissipation, order in Δs",
        measured=slope(sizes, errors), within=0.3, reference="elastic, steric and wall energy, N = 16, 32, 64",
    )  # fmt: skip
    verified.below(
        "conservation", "rods in contact with each other and walls: energy lost − ∫ dissipation, relative, N = 64",
        measured=errors[-1], bound=2e-3, reference="0",
    )  # fmt: skip


def test_the_energy_lost_is_dissipated_to_second_order_in_time(device, verified):
    """On one grid; its error does not depend on Δt, so successive differences are compared."""
    steps, defects = np.array([50, 100, 200, 400]), []
    for count in steps:
        lost, drag = PassiveRods(17, device).run(0.04, int(count))
        defects.append(lost.sum() - drag)
    errors = np.abs(np.diff(defects))
    verified.order(
        "rods in contact with each other and walls: energy lost − ∫ dissipation, order in Δt",
        measured=slope(steps[:-1], errors), within=0.3, reference="successive differences, N = 16",
    )  # fmt: skip


def in_a_cylinder(placement) -> Scene:
    swimmers = {
        "name": "cells", "count": 4, "nodes": 33, "bend": 5e-3, "twist": 1e-3, "shape": {"kind": "straight"},
        "flagella": {"profile": "uniform"}, "placement": placement,
    }  # fmt: skip
    surface = {"kind": "cylinder", "radius": 0.7, "length": 3.0}
    box = {"kind": "container", "surface": surface}
    return Scene.parse({"seed": 2, "swimmers": [swimmers], "box": box, "time": {"end": 2.0, "step": 5e-4}})


def test_a_cylinder_ends_at_its_length():
    """Swimmers along its axis are held by the caps: the wall pushes with the force of a swimmer, k ∫ (d + δ) = 1."""
    poses = {"position": [[0, 0, z] for z in (-0.8, 0.0, 0.4, 0.9)], "direction": [[0, 0, 1]] * 4}
    simulation = Simulation(in_a_cylinder(poses), "cpu")
    for _ in simulation.advance():
        pass
    z = simulation.ensembles["cells"].position[..., 2]
    assert 1.45 < z.max() < 1.53


def test_swimmers_are_placed_in_a_cylinder_and_counted_beyond_its_caps():
    simulation = Simulation(in_a_cylinder("random"), "cpu")
    x = simulation.ensembles["cells"].position
    assert (np.abs(x[..., 2]) <= 1.5).all() and (np.hypot(x[..., 0], x[..., 1]) <= 0.7).all()
    poses = {"position": [[0, 0, z] for z in (-0.8, 0.0, 1.2, 1.4)], "direction": [[0, 0, 1]] * 4}
    assert "cells: 2 rods start beyond a wall" in Simulation(in_a_cylinder(poses), "cpu").warnings[0]


def test_caps_are_where_an_open_container_passes_through_its_box():
    inf = np.inf
    tube = surfaces.make("cylinder", {"radius": 1.0, "length": 4.0})
    np.testing.assert_array_equal(caps_of(tube, False), [[-inf, -inf, -2], [inf, inf, 2]])
    assert not np.isfinite(caps_of(tube, True)).any()
    assert not np.isfinite(caps_of(surfaces.make("plane", {}), False)).any()
    half = surfaces.make("expression", {"phi": "x**2 + y**2 - 1 - z", "box": [[-3, 3], [-3, 3], [-2, 1]]})
    np.testing.assert_array_equal(caps_of(half, False), [[-inf] * 3, [inf, inf, 1]])


def test_the_force_of_caps_is_minus_the_gradient_of_their_energy(device):
    tube = surfaces.make("cylinder", {"radius": 1.0, "length": 1.0})
    line = np.stack([0.3 * np.ones(9), np.zeros(9), np.linspace(0.3, 0.7, 9)], axis=-1)
    held = Held(Rods(line[None], np.array([0.4])), device)
    walls = Walls([held], tube, STRENGTH, RANGE, device=device)
    walls.add_forces()
    depth = np.maximum(line[:, 2] - 0.5 + RANGE, 0.0)
    np.testing.assert_allclose(held.force[0], -STRENGTH * depth[:, None] * [0, 0, 1], atol=1e-12 * STRENGTH)
    weights = np.full(9, 0.05) * ([0.5] + [1.0] * 7 + [0.5])
    assert walls.energies()[0][0] == pytest.approx(0.5 * STRENGTH * (weights * depth**2).sum(), rel=1e-12)


def test_a_body_from_a_file_has_no_mirror_images(tmp_path):
    """Outside its box the spline of a grid is continued by reflection, but there is one body only."""
    x = np.linspace(-1.5, 1.5, 31)
    np.save(tmp_path / "ball.npy", np.sqrt(sum(a**2 for a in np.meshgrid(x, x, x, indexing="ij"))) - 1)
    ball = surfaces.make("grid", {"file": str(tmp_path / "ball.npy"), "spacing": 0.1})
    far = np.stack([np.linspace(1.6, 8.0, 2000), np.zeros(2000), np.zeros(2000)], axis=-1)
    image = far[np.argmin(ball.phi(far))]
    along = np.linspace(-0.2, 0.2, 9)[:, None] * [0, 0, 1]
    held = Held(Rods((image + along)[None], np.array([0.4])), "cpu")
    walls = Walls([held], ball, STRENGTH, RANGE, outside=True, device="cpu")
    walls.add_forces()
    assert not held.force.any() and not walls.energies()[0].any()
    held.place((np.array([0.9, 0, 0]) + along)[None])
    walls.add_forces()
    assert held.force[0, 4, 0] == pytest.approx(STRENGTH * (0.1 + RANGE), rel=0.02)
