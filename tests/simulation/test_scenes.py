"""The scenes of this repository: each one runs, and ensembles behave as expected (docs/model.md §7)."""

from pathlib import Path

import numpy as np
import pytest
from reference.exact import cylinder_angles
from reference.steady_s import turning_rate
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from warp_rods.analysis.crossings import crossings
from warp_rods.membranes import surfaces
from warp_rods.membranes.mesh import area_mean, curvatures, triangulate
from warp_rods.rods.free.rods import FreeRods
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.simulation.loop import Simulation

SCENES = Path(__file__).parents[2] / "scenes"


def shortened(name: str, end: float, save_every: float) -> Scene:
    scene = Scene.load(SCENES / name)
    time = scene.time.model_copy(update={"end": end, "save_every": save_every})
    return scene.model_copy(update={"time": time, "sweep": None})


LARGE = {"proteins", "proteins_negative", "swarm_2d", "swarm_periodic", "real_shape", "expression"}
"""Shipped scenes of which even a few steps take long."""


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.long] if path.stem in LARGE else [])
        for path in sorted(SCENES.glob("*.toml"))
    ],
)
def test_scene_runs(path, tmp_path):
    run = runner.simulate(shortened(path.name, 0.02, 0.01), tmp_path / "run", device="cpu")
    assert not run.lost
    for group in run.data.children.values():
        assert group.sizes["frame"] == 3
        assert np.isfinite(group["position"]).all()


def cells_of(name: str, nodes: int = 65) -> FreeRods:
    """The swimmers of a scene at its start, on this number of nodes."""
    scene = Scene.load(SCENES / name)
    cells = scene.swimmers[0].model_copy(update={"nodes": nodes})
    return Simulation(scene.model_copy(update={"swimmers": (cells,)}), "cpu").ensembles[cells.name]


def turning(rods: FreeRods) -> np.ndarray:
    """Mean angular velocity of the middle frames [rod, 3] over the next time 0.1, in the material frame."""
    before = Rotation.from_quat(rods.orientation[:, rods.nodes // 2])
    rods.step(1e-3, 100)
    return (before.inv() * Rotation.from_quat(rods.orientation[:, rods.nodes // 2])).as_rotvec() / 0.1


def test_s_rotors_turn_at_the_rate_of_a_rigid_body(verified):
    """About the axis of the symmetry, in place."""
    found = []
    for nodes in (33, 65):
        rods = cells_of("s_rotor.toml", nodes)
        rods.advance_to(4.0, 1e-4)
        found.append(turning(rods))
        assert abs(found[-1][:, [0, 2]]).max() < 1e-6
        np.testing.assert_array_equal(rods.position[:, nodes // 2], [[0, 0, 0], [1.2, 0, 0]])
    verified(
        "independent", "`s_rotor.toml`: rate at which the S turns at β⊥ = 2.5e-3 and 1e-3, Δs → 0",
        measured=(4 * found[1] - found[0])[:, 1] / 3, expected=[-turning_rate(bend) for bend in rods.bend], within=3e-4,
        reference="boundary value problem by SciPy's `solve_bvp` (tests/reference/steady_s.py): −2.26595, −3.49432",
    )  # fmt: skip


def test_a_straight_swimmer_swims_and_rolls_at_its_exact_rates(verified):
    rods = cells_of("straight_swimmer.toml")
    rods.advance_to(4.0, 1e-3)
    assert abs(rods.strain).max() < 1e-4
    before = rods.position[0, 32]
    rolled = turning(rods)[0]
    speed = np.linalg.norm(rods.position[0, 32] - before) / 0.1
    verified(
        "exact", "`straight_swimmer.toml`: speed, and rate of rolling", measured=[speed, rolled[0]],
        expected=[1.0, 2 / 3], within=1e-5, reference="f*/ζ∥, and M/ηr",
    )  # fmt: skip


def test_an_s_is_lost_without_its_symmetry():
    """It turns, and then is straight, with flagella that push one way."""
    rods = cells_of("s_lost.toml")
    rods.advance_to(0.1, 1e-3)
    assert turning(rods)[0, 2] < -2
    rods.advance_to(3.0, 1e-3)
    assert abs(rods.strain).max() < 0.1 and abs(rods.activity.mean()) > 0.999 and abs(turning(rods)).max() < 0.05


def closest_approach(position: np.ndarray) -> float:
    """The smallest distance between different rods [rod, node, 3], evaluated at four points of each segment."""
    t = np.linspace(0, 1, 4, endpoint=False)[:, None]
    points = position[:, :-1, None] * (1 - t) + position[:, 1:, None] * t
    tree = cKDTree(points.reshape(-1, 3))
    pairs = tree.query_pairs(0.03, output_type="ndarray")
    apart = pairs // (points.shape[1] * points.shape[2])
    pairs = pairs[apart[:, 0] != apart[:, 1]]
    return float(np.linalg.norm(tree.data[pairs[:, 0]] - tree.data[pairs[:, 1]], axis=1).min(initial=0.03))


@pytest.mark.long
def test_convex_sensors_find_the_bulbs(tmp_path, verified):
    """All end at 𝒦 > 0, and stay on the membrane with their lengths (docs/model.md §7).

    ⟨𝒦⟩ begins at the mean over the area and rises to 2.
    """
    data = runner.simulate(SCENES / "proteins.toml", tmp_path / "run", device="cpu").data["sensors"].to_dataset()
    membrane = surfaces.make("cassini", Scene.load(SCENES / "proteins.toml").surface.parameters)
    mesh = triangulate(membrane, 64)
    gauss = curvatures(membrane, mesh.points).gaussian
    mean = area_mean(mesh, gauss)
    spread = np.sqrt(area_mean(mesh, gauss**2) - mean**2) / np.sqrt(data.sizes["rod"])
    verified(
        "independent", "sensors with σ2 > 0 at the start: ⟨𝒦⟩", measured=float(data.gauss[0].mean()), expected=mean,
        within=3.3 * spread, reference="mean over the area, 3.3 standard errors",
    )  # fmt: skip
    verified(
        "published", "sensors with σ2 > 0 at the end: share at 𝒦 > 0", measured=float((data.gauss[-1] > 0).mean()),
        expected=1, within=0, reference="dissertation §5: they find positive curvature",
    )  # fmt: skip
    # A regression guard: no closed form gives these.
    assert float(data.gauss[0].mean()) == pytest.approx(1.3, abs=0.2)
    assert float(data.gauss[-1].mean()) == pytest.approx(2.0, abs=0.1)
    assert (data.status == 0).all()
    R = Rotation.from_quat(data.orientation[-1].to_numpy().reshape(-1, 4)).as_matrix()
    x = data.position[-1].to_numpy().reshape(-1, 3)
    normal = membrane.gradient(x) / np.linalg.norm(membrane.gradient(x), axis=-1, keepdims=True)
    for name, error, bound in (
        ("|φ|/|∇φ|", float(data.constraint.max()), 1e-9),
        ("saved normals against ∇φ/|∇φ|, single precision", np.abs(R[:, :, 2] - normal).max(), 2e-6),
        ("relative error of the lengths of segments", float(data.arc_length.max()), 1e-9),
    ):
        verified.below("constraint", f"100 proteins: {name}", measured=error, bound=bound, reference="0, whole run")
    total = (data.energy + data.steric_energy).sum("rod")
    assert (total.diff("frame") < 1e-6 * total[0]).all()
    assert (
        min(closest_approach(frame) for frame in data.position.to_numpy()) > 0.3 * 0.03
    )  # in units of the core: no rods cross


@pytest.mark.long
def test_concave_sensors_find_the_neck(tmp_path, verified):
    data = runner.simulate(shortened("proteins_negative.toml", 1.5, 0.05), tmp_path / "run", device="cpu").data
    verified(
        "published", "sensors with σ2 < 0 at the end: share at 𝒦 < 0",
        measured=float((data["sensors"]["gauss"][-1] < 0).mean()), expected=1, within=0,
        reference="dissertation §5: they find negative curvature",
    )  # fmt: skip


@pytest.mark.long
def test_twist_selects_the_hand_of_a_helix(tmp_path, verified):
    data = runner.simulate(SCENES / "helix_on_cylinder.toml", tmp_path / "run", device="cpu").data
    right, left = (data[name]["strain"][-1, :, :, 0].to_numpy() for name in ("right", "left"))
    table = Scene.load(SCENES / "helix_on_cylinder.toml")
    radius, expected = table.surface.parameters["radius"], []
    for filaments in table.filaments:
        angle = cylinder_angles(filaments.stiffness, filaments.intrinsic, radius)[0]
        expected.append(np.sin(2 * angle) / (2 * radius))
    ours = dict(zip((f.name for f in table.filaments), expected, strict=True))
    verified(
        "exact", "helices on a cylinder: twist of both hands", measured=[right.mean(), left.mean()],
        expected=[ours["right"], ours["left"]], relative=1e-2,
        reference="the angle of least energy; its sign is that of σ1",
    )  # fmt: skip
    assert (right > 0.1).all() and (left < -0.1).all()


@pytest.mark.long
@pytest.mark.parametrize(("name", "passes"), [("self_contact.toml", False), ("self_crossing.toml", True)])
def test_a_soft_cell_passes_through_itself_only_without_steric_forces(name, passes, tmp_path, verified):
    data = runner.simulate(SCENES / name, tmp_path / "run", device="cpu").data["cell"].to_dataset()
    found = int(crossings(data).crossings.sum())
    assert (found > 0) == passes
    if not passes:
        verified(
            "constraint", "soft cell with steric forces: crossings of itself", measured=found, expected=0, within=0,
            reference="it passes through itself without",
        )  # fmt: skip
    assert (data.steric_energy.max() > 5e-4) != passes


@pytest.mark.long
def test_cells_stay_in_their_container_and_slide_along_its_wall(tmp_path):
    data = runner.simulate(shortened("container.toml", 2.0, 0.1), tmp_path / "run", device="cpu").data["cells"]
    radius = np.linalg.norm(data["position"].to_numpy(), axis=-1)
    assert radius.max() < 1.5  # the range of the wall is 0.05, where its force exceeds that of a swimmer
    assert np.median(radius[-1]) > 1.3
    assert (data["wall_energy"][-1] > 0).sum() > 40
