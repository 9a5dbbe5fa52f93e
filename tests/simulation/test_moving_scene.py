"""Moving membranes in scenes: formulas in t, a mesh that follows, refused scenes (docs/moving_membranes.md)."""

import numpy as np
import pytest

from warp_rods import workflow
from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.membranes.mesh import follow, triangulate
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation


def test_a_moving_surface_at_a_given_time():
    surface = surfaces.make("torus", {"major": "1.0 + t**2", "minor": 0.4})
    assert surface.moving
    np.testing.assert_array_equal(surface.parameters_at(0.5)[:3], [1.25, 0.4, 0.0])
    later = surface.at(0.5)
    assert not later.moving and later.values == {"major": 1.25, "minor": 0.4}
    assert later.phi([1.65, 0.0, 0.0]) == pytest.approx(0.0, abs=1e-15)
    assert later.box[1][0] > 1.65 > surface.box[1][0]
    resting = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    assert not resting.moving and resting.at(3.0) is resting


def test_a_mesh_follows_its_membrane():
    surface = surfaces.make("torus", {"major": 1.0, "minor": "0.4 + 0.2*sin(t)"})
    mesh = triangulate(surface, cells=24)
    for time in np.linspace(0.0, 1.0, 11):
        mesh, failed = follow(mesh, surface.at(time))
        assert failed == 0
    end = surface.at(1.0)
    assert np.abs(end.phi(mesh.points)).max() < 1e-12
    np.testing.assert_allclose(mesh.normals, end.normal(mesh.points), atol=1e-12)
    _, failed = follow(mesh, surfaces.make("sphere", {"radius": 10.0}))
    assert failed == len(mesh.points)


SCENE = """
[surface]
kind = "sphere"
radius = "{radius}"
[[filaments]]
name = "arcs"
count = 3
nodes = 17
length = 0.5
stiffness = [1.0, 1.0, 1.0]
drag = [1.0, 2.0, 0.1]
ends = ["free", "{end}"]
[time]
end = 0.2
save_every = 0.02
"""


def scene(radius: str = "1.0 - 2*t", end: str = "free") -> Scene:
    return Scene.parse(SCENE.format(radius=radius, end=end))


def test_a_scene_with_formulas_in_time_runs_without_warnings_and_its_mesh_moves(tmp_path):
    given = scene()
    assert Scene.parse(given.to_toml()) == given
    run = workflow.run(given, tmp_path / "run", device="cpu")
    data = run.data["arcs"].to_dataset()
    assert not run.lost and float(data.constraint.max()) < 1e-9
    np.testing.assert_allclose(np.linalg.norm(data.position[-1], axis=-1), 0.6, atol=1e-9)
    assert (data.energy.diff("frame") > 0).all()  # on a membrane at rest this would be a warning

    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(tmp_path / "run" / "animation.usdc"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Membrane"))
    for frame, time in enumerate(data.time.values):
        points = np.array(mesh.GetPointsAttr().Get(frame))
        np.testing.assert_allclose(np.linalg.norm(points, axis=-1), 1.0 - 2 * time, atol=1e-6)
        np.testing.assert_allclose(mesh.GetExtentAttr().Get(frame), [points.min(0), points.max(0)], atol=1e-6)
        gauss = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("gaussianCurvature").Get(frame)
        np.testing.assert_allclose(gauss, (1.0 - 2 * time) ** -2, rtol=1e-5)


def test_energy_from_a_moving_membrane_is_not_warned_of():
    simulation = Simulation(scene(), "cpu")
    simulation.variables()
    for _ in range(2):
        list(simulation.to_next_frame())
        simulation.variables()
    assert simulation.new_warnings() == []


@pytest.mark.parametrize(
    ("radius", "said"),
    [
        ("1.0 - 6*t", "surface at t = 0.1673: radius = -0.004"),
        ("1.0 - t.real", "a formula in t: column 7: a dot is not allowed; allowed are numbers, pi, t,"),
        (
            "1.0 + x",
            'surface.radius = "1.0 + x": must be a positive number, or a formula in t: column 7: x is not known',
        ),
        ("2.0", "t does not occur in it; write a constant without quotes"),
        ("t - 1", 'surface.radius = "t - 1": must be a positive number, but is -1 at t = 0'),
        ("sqrt(0.1 - t) + 1", "surface.radius at t = 0.102041: column 1: not a finite real number"),
    ],
)
def test_impossible_motion_is_refused(radius, said):
    with pytest.raises(SceneError) as error:
        scene(radius)
    assert said in str(error.value)


def test_two_clamped_ends_on_a_moving_membrane_are_refused():
    tables = scene(end="clamped").to_toml().replace('"free"', '"clamped"')
    with pytest.raises(SceneError, match=r'filaments\[0\]\.ends = \["clamped", "clamped"\]: a filament keeps'):
        Simulation(Scene.parse(tables), "cpu")


def test_defaults_and_line_breaks_are_allowed_in_moving_surfaces():
    assert surfaces.make("undulated", {"radius": " 1.0 + 0.1*t"}, end=1.0).moving
    values = {"phi": "\n  x**2 + y**2\n  + z**2 - R**2", "box": [[-2, 2]] * 3, "parameters": {"R": "1 + t"}}
    assert surfaces.make("expression", values, end=0.5).moving


def test_a_formula_that_leaves_its_box_is_refused():
    values = {"phi": "x**2 + y**2 + z**2 - R**2", "box": [[-1.2, 1.2]] * 3, "parameters": {"R": "1 + t"}}
    assert surfaces.make("expression", values, end=0.1).closed
    with pytest.raises(SceneError, match=r"surface at t = 0\.4: has left its box.*widen the box"):
        surfaces.make("expression", values, end=0.4)
