"""Surfaces from files that are kept on disk: the same numbers and words; what is damaged or another is not used."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_rods.membranes import surface_cache
from warp_rods.membranes.data import from_file
from warp_rods.membranes.level_set import LevelSet
from warp_rods.membranes.surface_cache import kept_surface

VALUES = (None, (0.0, 0.0, 0.0), None, None)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(surface_cache, "_folder", lambda: tmp_path / "cache")
    return tmp_path / "cache"


@pytest.fixture(scope="module")
def mesh(tmp_path_factory) -> Path:
    """Two spheres, one of them in the other: a body and a cavity."""
    path = tmp_path_factory.mktemp("mesh") / "shell.ply"
    shells = [trimesh.creation.icosphere(subdivisions=3, radius=r) for r in (1.0, 0.5)]
    trimesh.util.concatenate(shells).export(path)
    return path


@pytest.fixture(scope="module")
def fresh(mesh) -> LevelSet:
    return from_file(mesh, *VALUES)


def never() -> LevelSet:
    raise AssertionError("a surface was made again")


def test_a_kept_surface_has_the_same_numbers_and_words(folder, mesh, fresh):
    assert kept_surface(mesh, VALUES, lambda: fresh) is fresh
    found = kept_surface(mesh, VALUES, never)
    assert found.field is fresh.field and found.closed is fresh.closed
    for one, other in ((found.grid, fresh.grid), (found.numbers, fresh.numbers), (found.box, fresh.box)):
        assert np.array(one).tobytes() == np.array(other).tobytes()
    data, made = found.data, fresh.data
    assert (data.notes, data.warnings, data.metres) == (made.notes, made.warnings, made.metres) and made.notes
    assert data.bodies.listed() == made.bodies.listed() and "cavity" in data.bodies.listed()
    x = np.random.default_rng(0).normal(size=(50, 3))
    assert (data.bodies.nearest(x) == made.bodies.nearest(x)).all()
    assert [np.array_equal(a, b) for a, b in zip(data.bodies.box([1]), made.bodies.box([1]), strict=True)] == [True] * 2


def test_other_files_values_and_programs_have_surfaces_of_their_own(folder, mesh, fresh, tmp_path, monkeypatch):
    made = []

    def again() -> LevelSet:
        made.append(1)
        return fresh

    other = tmp_path / "shell.ply"
    other.write_bytes(mesh.read_bytes() + b" ")
    for path, values in ((mesh, VALUES), (other, VALUES), (mesh, (0.1, *VALUES[1:])), (mesh, VALUES)):
        kept_surface(path, values, again)
    assert len(made) == 3
    monkeypatch.setattr(surface_cache, "_makers", lambda: "a later version")
    kept_surface(mesh, VALUES, again)
    assert len(made) == 4


@pytest.mark.parametrize("damage", ["cut", "empty", "a bit", "another archive"])
def test_a_damaged_surface_is_made_again(folder, mesh, fresh, damage):
    kept_surface(mesh, VALUES, lambda: fresh)
    [file] = folder.iterdir()
    content = file.read_bytes()
    middle = len(content) // 2
    flipped = content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]
    if damage == "another archive":
        np.savez(file, x=np.zeros(3))
    else:
        file.write_bytes({"cut": content[:middle], "empty": b"", "a bit": flipped}[damage])
    assert kept_surface(mesh, VALUES, lambda: fresh) is fresh
    assert kept_surface(mesh, VALUES, never).grid is not None


@pytest.mark.parametrize("what", ["LARGEST", "LARGEST_FILE"])
def test_large_surfaces_are_not_kept(folder, mesh, fresh, monkeypatch, what):
    monkeypatch.setattr(surface_cache, what, 1000)
    assert kept_surface(mesh, VALUES, lambda: fresh) is fresh and not folder.exists()


def test_a_cache_that_cannot_be_written_is_no_fault(folder, mesh, fresh):
    folder.write_text("a file, not a folder")
    assert kept_surface(mesh, VALUES, lambda: fresh) is fresh
