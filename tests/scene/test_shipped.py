"""The scenes that are installed: what they are called, and copies of them."""

from pathlib import Path

import pytest

import warp_rods as wr
from warp_rods.scene.shipped import copy_scene, find_scene, shipped

TREE = Path(__file__).parents[2] / "scenes"


def test_all_scenes_of_the_tree_are_shipped_with_a_title_and_a_time():
    known = shipped()
    assert set(known) == {path.stem for path in TREE.glob("*.toml")}
    assert all(scene.title and scene.time.split()[1] in ("s", "min") for scene in known.values())
    assert known["swimmer"].title == "Steady U-swimmer"


def test_a_copy_stands_by_itself(tmp_path):
    copied = copy_scene("real_shape", tmp_path / "mine")
    assert {path.name for path in copied} >= {"real_shape.toml", "real_shape.ply", "scene.schema.json"}
    assert wr.Scene.load(copied[0]).surface.parameters["file"] == str(tmp_path / "mine" / "real_shape.ply")
    copied[0].write_text("# mine")
    with pytest.raises(wr.SceneError, match=r"real_shape\.toml is there already: rename it, or give another folder"):
        copy_scene("real_shape", tmp_path / "mine")
    assert copied[0].read_text() == "# mine"
    copy_scene("swimmer", tmp_path / "mine")
    with pytest.raises(wr.SceneError, match=r"must be one of .*did you mean swimmer\?"):
        copy_scene("swimer", tmp_path)


def test_a_name_stands_for_a_shipped_scene_where_there_is_no_such_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert find_scene(Path("swimmer")).samefile(TREE / "swimmer.toml")
    assert find_scene(Path("swimmer.toml")) == Path("swimmer.toml")  # a file, which is not there
    assert find_scene(Path("sub/swimmer")) == Path("sub/swimmer")
    with pytest.raises(wr.SceneError, match=r"no shipped scene of this name \(did you mean proteins\?\); warp-rods sc"):
        find_scene(Path("protein"))
    Path("swimmer").write_text("mine")
    assert find_scene(Path("swimmer")) == Path("swimmer")
