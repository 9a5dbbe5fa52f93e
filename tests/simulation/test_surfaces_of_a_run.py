"""The membrane and the container of a run: built and inspected once, kept in memory, or refused."""

import gc
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.membranes.surface import Surface
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.simulation.loop import Simulation

BOX = [[-1.3, 1.3]] * 3
FORMULA = {"kind": "expression", "phi": "x**2 + y**2 + z**2 - R**2", "box": BOX, "parameters": {"R": 1.0}}
FILAMENTS = {"name": "f", "count": 2, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
CELLS = {"name": "c", "count": 6, "nodes": 17, "bend": 5e-3, "twist": 1e-3, "placement": "random"}
TIME = {"end": 0.02, "step": 1e-3, "save_every": 0.01}


@pytest.fixture
def ball(tmp_path) -> Path:
    trimesh.creation.icosphere(subdivisions=3, radius=1.2).export(tmp_path / "ball.ply")
    return tmp_path / "ball.ply"


def scene(surface, container=None, **cells) -> Scene:
    """Filaments on a surface, and swimmers in a container."""
    tables = {"surface": surface, "filaments": [FILAMENTS], "time": TIME}
    if container:
        tables |= {"swimmers": [CELLS | cells], "box": {"kind": "container", "surface": container}}
    return Scene.parse(tables)


@pytest.fixture
def counts(monkeypatch) -> Counter:
    """Numbers of times that surfaces are built and inspected, by kind."""
    found, build, inspect = Counter(), Surface.__init__, surfaces.inspect

    def counted_build(self, kind, values, row):
        found["built", kind] += 1
        build(self, kind, values, row)

    def counted_inspect(surface):
        found["inspected", surface.kind] += 1
        return inspect(surface)

    monkeypatch.setattr(Surface, "__init__", counted_build)
    monkeypatch.setattr(surfaces, "inspect", counted_inspect)
    return found


def test_each_surface_is_built_and_inspected_once(counts, ball):
    given = scene(FORMULA, {"kind": "grid", "file": ball, "spacing": 0.1})
    Scene.parse(given.to_toml())
    assert not counts
    simulation = Simulation(given, "cpu")
    simulation.warm_up()
    simulation.variables()
    list(simulation.to_next_frame())
    assert counts == {(done, kind): 1 for done in ("built", "inspected") for kind in ("expression", "grid")}


def test_a_moving_surface_is_built_once_and_inspected_at_several_times(counts):
    Simulation(scene({**FORMULA, "parameters": {"R": "1.0 + t"}}), "cpu").warm_up()
    assert counts == {("built", "expression"): 1, ("inspected", "expression"): 3}


def test_the_wall_energy_of_a_container_from_a_file(ball):
    """W = ½ k (d + δ)² as in NumPy; the grid of the container stays in memory as long as the walls use it."""
    container = {"kind": "grid", "file": ball, "spacing": 0.1}
    near = {"placement": {"position": [[0, 0, z] for z in (0.9, 1.0, 1.05, 1.1, 1.15, 1.2)]}}
    simulation = Simulation(scene({"kind": "sphere", "radius": 0.2}, container, **near), "cpu")
    gc.collect()
    energies = simulation.variables()["c"]
    x, wall = energies["position"], simulation.scene.box.wall
    level_set = surfaces.make("grid", {key: value for key, value in container.items() if key != "kind"})
    depth = level_set.phi(x) / np.linalg.norm(level_set.gradient(x), axis=-1) + wall.range
    weights = np.r_[0.5, np.ones(15), 0.5] / 16
    expected = (0.5 * wall.strength * np.maximum(depth, 0) ** 2 * weights).sum(axis=1)
    assert (expected > 0).sum() >= 4
    np.testing.assert_allclose(energies["wall_energy"], expected, rtol=1e-9, atol=1e-12)


NOWHERE = {**FORMULA, "phi": "x**2 + y**2 + z**2 + R"}


@pytest.mark.parametrize(
    ("surface", "container", "said"),
    [
        (NOWHERE, None, ["surface.phi: φ is positive at the 49³ points sampled in its box"]),
        (
            NOWHERE,
            {**FORMULA, "phi": "R - x**2 - y**2 - z**2"},
            ["surface.phi: φ is positive", "box.surface.phi: φ is negative all over the faces"],
        ),
        ({"kind": "grid", "file": "open.ply", "spacing": 0.1}, None, ["surface.file: open.ply is not closed"]),
        (
            FORMULA,
            {"kind": "grid", "file": "open.ply", "spacing": 0.1},
            ["box.surface.file: open.ply is not closed"],
        ),
        ({**FORMULA, "phi": "x + R/(y - y)"}, None, ["surface.phi: column 5: divides by zero"]),
        (
            {**FORMULA, "parameters": {"R": "1 + 20*t"}},
            None,
            ["surface at t = 0.02: has left its box and is no longer closed", "widen the box"],
        ),
        (
            {**FORMULA, "parameters": {"R": "1 + 100*t"}, "phi": "z - R"},
            None,
            ["surface at t = 0.01: φ is never positive"],
        ),
    ],
)
def test_an_impossible_surface_is_refused_before_anything_is_written(surface, container, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sphere = trimesh.creation.icosphere(subdivisions=2)
    trimesh.Trimesh(sphere.vertices, sphere.faces[1:]).export("open.ply")
    given = scene(surface, container)
    with pytest.raises(SceneError) as caught:
        runner.simulate(given, tmp_path / "run", device="cpu")
    for words in said:
        assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 2 - (container is None or surface is FORMULA)
    assert not (tmp_path / "run").exists()
