"""Damage to every kind of file of a run: it is read right, or told with the place; never silent, never a traceback."""

import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_rods.analysis.membrane import membrane_of
from warp_rods.errors import RunFolderError, WarpRodsError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.simulation.check import check_run
from warp_rods.simulation.reading import open_run

FILAMENT = {"name": "one", "count": 2, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
# Large frames are chunks of their own, small ones share a chunk: both kinds are here.
FILAMENTS = [FILAMENT, {**FILAMENT, "name": "many", "count": 12, "placement": "random"}]
TIME = {"end": 0.03, "step": 1e-3, "save_every": 0.01}


@pytest.fixture(scope="module")
def sound(tmp_path_factory) -> Path:
    """A small run on a mesh."""
    folder = tmp_path_factory.mktemp("sound")
    trimesh.creation.icosphere(subdivisions=2).export(folder / "cell.ply")
    surface = {"kind": "grid", "file": folder / "cell.ply", "spacing": 0.2}
    scene = Scene.parse({"surface": surface, "filaments": FILAMENTS, "time": TIME, "seed": 2})
    return runner.simulate(scene, folder / "run", device="cpu").folder


def everything(folder: Path) -> list[np.ndarray]:
    """All that is read of a run: data, labels, attributes and the membrane."""
    run = open_run(folder)
    found = [np.array(sorted(map(str, run.attrs.items())))]
    for _, group in sorted(run.children.items()):
        found += [values.to_numpy() for _, values in sorted(group.variables.items())]
        found += [np.array(sorted(map(str, v.attrs.items()))) for _, v in sorted(group.variables.items())]
    surface = membrane_of(run)
    points = np.random.default_rng(0).uniform(-1.2, 1.2, (50, 3))
    return [*found, surface.phi(points), np.array(surface.box)]


def damaged(data: bytes, rng: np.random.Generator, flips: int):
    """Contents of a damaged file: missing, empty, cut at several places, and with one byte changed."""
    yield "deleted", None
    for keep in sorted({0, len(data) // 3, len(data) // 2, len(data) - 1}):
        yield f"cut to {keep} bytes", data[:keep]
    for place in rng.choice(len(data), min(flips, len(data)), replace=False):
        changed = bytearray(data)
        changed[place] ^= 1 << int(rng.integers(8))
        yield f"byte {place} changed", bytes(changed)


KINDS = [
    "scene.toml", "checkpoint.npz", "membrane.npz", "trajectory.zarr/zarr.json", "trajectory.zarr/one/zarr.json",
    "trajectory.zarr/many/position/zarr.json",
    "trajectory.zarr/many/position/c.0.0.0.0",  # each frame a chunk of a shard
    "trajectory.zarr/one/status/c.0.0",  # all frames in one chunk
    "trajectory.zarr/one/time/c.0",
    "trajectory.zarr/one/s/c.0",  # without frames
    "trajectory.zarr/one/axis/c.0",  # labels
]  # fmt: skip
"""A file of each kind in a run folder."""


def outcome(folder: Path, right: list[np.ndarray], case: tuple[Path, str]) -> tuple[str, bool]:
    """How a damaged run is read, and whether the check finds the damage."""
    try:
        found = everything(folder)
    except WarpRodsError as error:
        assert error.exit_code == 2 and str(error), case
        how = "told"
    else:
        for a, b in zip(found, right, strict=True):
            assert a.dtype == b.dtype and a.tobytes() == b.tobytes(), case
        how = "read right"
    try:
        check_run(folder)
    except RunFolderError:
        return how, True
    return how, False


def damage_all(folder: Path, files: list[Path], flips: int) -> Counter:
    """Damage files one at a time; counts the outcomes. Each is read right or told, and the check finds it."""
    rng, outcomes = np.random.default_rng(flips), Counter()
    right = [values.copy() for values in everything(folder)]
    for file in files:
        data = file.read_bytes()
        for what, content in damaged(data, rng, flips):
            file.unlink() if content is None else file.write_bytes(content)
            how, seen = outcome(folder, right, (file, what))
            if not seen:  # one byte without a meaning, such as a time stamp in an archive
                assert how == "read right" and content is not None and len(content) == len(data), (file, what)
            outcomes[how, seen] += 1
            file.write_bytes(data)
    return outcomes


@pytest.mark.long
def test_damage_of_each_kind_of_file_is_read_right_or_told(sound, tmp_path):
    """A file of each kind is deleted, cut, or changed in one byte."""
    shutil.copytree(sound, tmp_path / "run")
    folder = tmp_path / "run"
    assert "no damage" in check_run(folder)
    assert {kind for kind in KINDS if not (folder / kind).is_file()} == set()
    outcomes = damage_all(folder, [folder / kind for kind in KINDS], 3)
    assert sum(outcomes.values()) > 70 and outcomes["told", True] > 35
    assert outcomes["read right", False] <= 3
    assert "no damage" in check_run(folder)


@pytest.mark.long
def test_damage_of_every_file_is_read_right_or_told(sound, tmp_path):
    shutil.copytree(sound, tmp_path / "run")
    files = [f for f in sorted((tmp_path / "run").rglob("*")) if f.is_file() and f.name != ".lock"]
    outcomes = damage_all(tmp_path / "run", files, 3)
    print(outcomes)
    assert sum(outcomes.values()) > 700


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("many/position/c.0.0.0.0", "frame 2 of many/position is damaged"),
        ("one/status/c.0.0", "frame 0 of one/status is damaged"),
        ("one/s/c.0", "one/s is damaged"),
        ("zarr.json", "trajectory.zarr/zarr.json is damaged"),
    ],
)
def test_the_message_names_frame_and_variable(sound, tmp_path, file, said):
    """For a changed byte and for a file that ends too early; other frames and variables can still be read."""
    folder = tmp_path / "run"
    shutil.copytree(sound, folder)
    path = folder / "trajectory.zarr" / file
    data = bytearray(path.read_bytes())
    place = -(12 * 9 * 24 + 4) - 50 if "position" in file else len(data) // 2
    if file == "zarr.json":  # a digit of the version, so that the text stays JSON
        place = data.index(b'"warp_rods_version": "') + len(b'"warp_rods_version": "')
    data[place] ^= 4
    path.write_bytes(data)
    with pytest.raises(RunFolderError, match=said):
        everything(folder)
    with pytest.raises(RunFolderError, match=said):
        check_run(folder)
    if "position" in file:
        position = open_run(folder)["many"].position
        assert np.isfinite(position[[0, 1, 3]]).all()
        path.write_bytes(data[: place - 3000])
        with pytest.raises(RunFolderError, match="frame 1 of many/position is damaged: it is missing"):
            position[1].load()
