"""Upper bounds of the number of rods that fit: never below what does fit, and near it where the packing is known."""

import numpy as np
import pytest

from warp_rods.contact import arrangements, push
from warp_rods.contact.capacity import extents, refuse_crowd, refuse_crowd_on
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling, surfaces
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

CELLS = {"name": "c", "nodes": 17, "bend": 1e-2, "twist": 1e-3}
FILAMENTS = {"name": "f", "count": 1200, "nodes": 33, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
STERIC = {"strength": 1000.0, "range": 0.02, "core": 0.08}


def test_parallel_rods_that_fit_are_not_refused_and_a_tenth_more_are():
    """Long straight rods on a hexagonal lattice across a periodic box fill π/√12 of it, and no packing is denser."""
    d, count, length = 0.1, 1000, 10.0
    volume = count * np.sqrt(3) / 2 * d**2 * (length + 2 / 3 * d)
    refuse_crowd(np.full(count, length), d, volume)
    with pytest.raises(SceneError, match=r"count = 1100: .* at most 1000 could fit"):
        refuse_crowd(np.full(1100, length), d, volume)


def test_strips_and_discs_that_fit_are_not_refused():
    """Strips side by side on a plane; discs on a hexagonal lattice."""
    refuse_crowd_on(np.full(100, 1.0), 0.1, 100 * 0.1 * (1.0 + 0.1))
    refuse_crowd_on(np.full(100, 1e-9), 0.1, 100 * np.sqrt(3) / 2 * 0.1**2)
    with pytest.raises(SceneError, match=r"at most 1[01]\d could fit"):
        refuse_crowd_on(np.full(200, 1e-9), 0.1, 100 * np.sqrt(3) / 2 * 0.1**2)


def test_the_extent_is_the_distance_of_nodes_from_an_end():
    bent = np.array([[[0, 0, 0], [3, 4, 0], [3, 0, 0]], [[0, 0, 0], [1, 0, 0], [2, 0, 0]]], dtype=float)
    np.testing.assert_allclose(extents(bent), [5, 2])


def test_a_tube_around_a_bent_rod_fills_more_than_its_capsule():
    """The bound rests on it: by points drawn around a half circle, whose ends are a diameter apart."""
    angle, r = np.linspace(0, np.pi, 400), 0.1
    line = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    points = np.random.default_rng(0).uniform([-1.2, -0.2, -0.2], [1.2, 1.2, 0.2], size=(40_000, 3))
    inside = (np.linalg.norm(points[:, None] - line[None, ::4], axis=-1).min(axis=1) < r).mean() * 2.4 * 1.4 * 0.4
    assert inside > np.pi * r**2 * 2 + 4 / 3 * np.pi * r**3


@pytest.mark.parametrize(
    ("tables", "key"),
    [
        ({"swimmers": [CELLS | {"count": 200}], "box": {"kind": "periodic", "fraction": 0.95}}, r"swimmers\[0\]"),
        (
            {
                "swimmers": [CELLS | {"count": 5000, "placement": "aligned"}],
                "box": {"kind": "periodic", "size": [2, 2, 2]},
            },
            r"swimmers\[0\]",
        ),
        (
            {"swimmers": [CELLS | {"count": 900}], "box": {"kind": "slab", "size": [4, 4], "height": 0.2}},
            r"swimmers\[0\]",
        ),
        (
            {
                "swimmers": [CELLS | {"count": 2000}],
                "box": {"kind": "container", "surface": {"kind": "sphere", "radius": 1}},
            },
            r"swimmers\[0\]",
        ),
        (
            {
                "surface": {"kind": "cassini", "a": 1.0, "b": 1.1},
                "filaments": [FILAMENTS],
            },
            r"filaments\[0\]",
        ),
    ],
)
def test_a_hopeless_crowd_is_refused_without_a_try(tables, key, monkeypatch):
    def tried(*_args):
        raise AssertionError("a placement was tried")

    monkeypatch.setattr(arrangements, "without_overlap", tried)
    monkeypatch.setattr("warp_rods.contact.overlap.without_overlap", tried)
    with pytest.raises(
        SceneError, match=key + r".*count = \d+: .* packed as closely as possible; at most \d+ could fit"
    ):
        Simulation(Scene.parse({"time": {"end": 1.0}, "steric": STERIC, **tables}), "cpu")


def test_rods_that_jam_are_told_long_before_the_last_round(monkeypatch):
    """At a third of the volume random rods of this slenderness do not come apart."""
    rounds = 0
    count_round = push._push

    def counted(*args):
        nonlocal rounds
        rounds += 1
        return count_round(*args)

    monkeypatch.setattr(push, "_push", counted)
    tables = {"swimmers": [CELLS | {"count": 60}], "box": {"kind": "periodic", "fraction": 0.3}, "steric": STERIC}
    with pytest.raises(SceneError, match=r'placement = "random": count = 60: too many to be 0\.08 apart'):
        Simulation(Scene.parse({"time": {"end": 1.0}, **tables}), "cpu")
    assert rounds <= 60 < push.MOST_PUSHES


AREAS = {
    "sphere": ({"radius": 1.3}, 4 * np.pi * 1.3**2),
    "plane": ({"size": 3.0}, 9.0),
    "torus": ({"major": 1e4, "minor": 0.4}, 4 * np.pi**2 * 4e3),
    "cylinder": ({"radius": 476.0, "length": 6.0}, 2 * np.pi * 476 * 6),
    "ellipsoid": ({"radii": [1.0, 1.0, 1e-3]}, 2 * np.pi),
    "bridge": ({"neck": 0.4, "body": 1.0, "width": 1.0, "length": 3000.0}, 2 * np.pi * 3000),
}


@pytest.mark.parametrize("kind", AREAS)
def test_the_area_of_a_membrane(kind):
    values, exact = AREAS[kind]
    assert sampling.area(surfaces.make(kind, values)) == pytest.approx(exact, rel=0.06)
