"""Filaments on chosen bodies of a membrane, and what a run says of the data it was made from."""

import numpy as np
import pytest
import trimesh

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

FILAMENTS = {"name": "f", "count": 20, "nodes": 17, "length": 0.3, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
PLACES = np.array([[-1.5, 0, 0], [1.5, 0, 0], [1.5, 0, 0]])
RADII = (0.8, 1.0, 0.6)


@pytest.fixture
def cells(tmp_path) -> str:
    """A ball of radius 0.8 at x = −1.5, and one of radius 1 at x = 1.5 with a cavity of radius 0.6 in it."""
    balls = [trimesh.creation.icosphere(subdivisions=3, radius=radius) for radius in RADII]
    for ball, place in zip(balls, PLACES, strict=True):
        ball.apply_translation(place)
    trimesh.util.concatenate(balls).export(tmp_path / "cells.ply")
    return str(tmp_path / "cells.ply")


def scene(cells: str, **filaments) -> Scene:
    tables = {"surface": {"kind": "grid", "file": cells}, "filaments": [FILAMENTS | filaments], "time": {"end": 0.01}}
    return Scene.parse(tables | {"units": {"length": "1 um"}})


def carriers(simulation: Simulation) -> set[int]:
    """The numbers of the balls on which the middles of the filaments are."""
    x = simulation.ensembles["f"].position[:, 4]
    off = np.abs(np.linalg.norm(x[:, None] - PLACES, axis=-1) - RADII)
    assert off.min(axis=1).max() < 0.01
    return set(np.argmin(off, axis=1))


@pytest.mark.parametrize(("bodies", "balls"), [(None, {0, 1, 2}), ([0], {1}), ([1, 2], {0, 2}), ([2], {2})])
def test_filaments_are_placed_on_the_chosen_bodies(bodies, balls, cells):
    """Bodies are numbered by volume: 0 is the ball of radius 1, 1 that of 0.8, 2 the cavity."""
    given = scene(cells, **({} if bodies is None else {"bodies": bodies}))
    assert Scene.parse(given.to_toml()) == given
    simulation = Simulation(given, "cpu")
    assert carriers(simulation) == balls
    notes = "\n".join(simulation.notes)
    assert "surface: before smoothing: volume" in notes and "surface: after smoothing: volume" in notes
    assert "surface: bodies 0 (body, volume 4.15" in notes and "2 (cavity, volume 0.89" in notes
    assert not simulation.warnings


def test_bodies_that_are_not_there_are_refused(cells):
    with pytest.raises(SceneError, match=r"filaments\[0\].bodies = \[3\]: the membrane has 0 \(body, volume"):
        Simulation(scene(cells, bodies=[3]), "cpu")
    with pytest.raises(SceneError, match=r"bodies = .*must be a list of whole numbers"):
        scene(cells, bodies=[-1])
    placed = {"position": [[2.5, 0, 0]] * 20, "direction": [[0, 1, 0]] * 20}
    with pytest.raises(SceneError, match=r"bodies = \[0\]: is for random placement"):
        scene(cells, bodies=[0], placement=placed)


def test_voxel_sizes_in_another_unit_than_the_scene_are_warned_of(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    inside = np.linalg.norm(np.indices((30, 30, 30)) - 14.5, axis=0) < 9
    about = {"axes": "ZYX", "PhysicalSizeX": 0.1, "PhysicalSizeY": 0.1, "PhysicalSizeZ": 0.1}
    for unit, warned in (("µm", False), ("nm", True)):
        units = {f"PhysicalSize{axis}Unit": unit for axis in "XYZ"}
        tifffile.imwrite(tmp_path / "cell.ome.tif", inside.astype("u1"), metadata=about | units)
        simulation = Simulation(scene(str(tmp_path / "cell.ome.tif")), "cpu")
        assert any("one unit of length is 1e-09 m in the file" in line for line in simulation.warnings) == warned
