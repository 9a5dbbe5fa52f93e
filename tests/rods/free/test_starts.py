"""Symmetric starts, whose direction round-off chooses, and perturbed ones, whose direction the seed chooses."""

import numpy as np
import pytest

from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import coefficients
from warp_rods.scene.scene import Scene
from warp_rods.simulation import Simulation

S = np.linspace(-0.5, 0.5, 65)
CELL = {"bend": 2e-3, "twist": 1e-3}
TILT = np.exp(0.7j)
EVEN, ODD = np.cos(np.pi * S) ** 2, np.sin(2 * np.pi * S)


def strains(k, twist=0.0) -> np.ndarray:
    return np.stack(np.broadcast_arrays(twist, k.real, k.imag), axis=-1)[None]


SYMMETRIC = {
    "even": {"shape": {"kind": "mode", "mode": 0}},
    "odd": {"shape": {"kind": "mode", "mode": 1}},
    "straight": {"shape": {"kind": "straight"}},
    "writhe": {"shape": {"kind": "writhe", "amplitude": 6.0}, "moment": 1e-3},
    "about a tilted axis": {"shape": strains((EVEN * 1j + 0.3 * ODD) * TILT)},
    "piecewise": {"shape": {"kind": "mode", "mode": 2}, "flagella": {"profile": "piecewise"}},
    "with an odd target": {"flagella": {"law": "driven", "front": -0.3, "back": 0.3}},
}
OTHER = {
    "even and odd in one plane": {"shape": strains(1j * (EVEN + 0.3 * ODD))},
    "odd twist": {"shape": strains(1j * EVEN, 0.1 * ODD)},
    "uniform flagella": {"flagella": {"profile": "uniform"}},
    "off by more than round-off": {"shape": strains(1j * (EVEN + 1e-7 * ODD))},
    "perturbed": {"shape": {"kind": "mode", "perturbation": 1e-5}},
    "passive": {"flagella": None},
    "held": {"ends": ["clamped", "free"], "shape": {"kind": "straight"}},
    "with a couple": {"couple": 1e-3},
    "with a target that is not odd": {"flagella": {"law": "driven"}},
    "that tumbles": {
        "flagella": {"law": "driven", "back": -1.0},
        "behaviour": {"tumble": {"rate": 1.0, "duration": 0.1, "turn": 0.0}},
    },
}


@pytest.mark.parametrize("given", SYMMETRIC.values(), ids=SYMMETRIC)
def test_symmetric_starts_are_found(device, given):
    assert FreeRods(1, 65, **CELL | given, device=device).symmetric_start.all()


@pytest.mark.parametrize("given", OTHER.values(), ids=OTHER)
def test_starts_without_the_symmetry_are_not(device, given):
    assert not FreeRods(1, 65, **CELL | given, device=device).symmetric_start.any()


def test_a_perturbation_has_its_size_and_depends_on_the_seed_alone():
    """In the plane of a planar start, and in space where there is twist or a moment."""

    def start(seed=0, size=(1e-2, 2e-3, 0.0), moment=(0.0, 0.0, 0.0)) -> np.ndarray:
        shape = {"kind": "mode", "amplitude": 1.0, "perturbation": size, "seed": seed}
        plain = FreeRods(3, 65, **CELL, moment=moment, shape={"kind": "mode", "amplitude": 1.0})
        return FreeRods(3, 65, **CELL, moment=moment, shape=shape).strain - plain.strain

    added = start()
    np.testing.assert_allclose(coefficients(added[..., 2], S, 6), coefficients(start()[..., 2], S, 6), rtol=0, atol=0)
    assert not added[..., :2].any() and not added[2].any()
    a = coefficients(added[..., 2], S, 8)
    np.testing.assert_allclose(np.linalg.norm(a, axis=-1), [1e-2, 2e-3, 0.0], rtol=1e-4)
    assert (np.abs(a[:2, :6]) > 0).all() and np.abs(a[:, 6:]).max() < 1e-5
    assert np.abs(start(seed=1) - added).max() > 1e-3
    turned = start(moment=(0.0, 1e-3, 0.0))
    assert not turned[0, :, 1].any() and np.abs(turned[1, :, 1]).max() > 1e-4
    with pytest.raises(SceneError, match=r"shape.perturbation = -1: must be zero or more"):
        start(size=-1)
    with pytest.raises(SceneError, match=r"shape.seed = 'x': must be a whole number"):
        start(seed="x")


def scene(step, seed=1006, **shape) -> Scene:
    cells = {
        "name": "c", "count": 2, "nodes": 65, "bend": [2.1e-3, 2.3e-3], "twist": 1e-4, "drag_ratio": 2.6,
        "shape": {"kind": "mode", "mode": 1, "amplitude": 2.0, **shape},
        "flagella": {"diffusion": 2.2e-3, "profile": "piecewise"}, "placement": {"position": [[0, 0, 0], [3, 0, 0]]},
    }  # fmt: skip
    return Scene.parse({"seed": seed, "swimmers": [cells], "time": {"end": 2.0, "step": step}})


def displaced(of: Scene) -> np.ndarray:
    """Displacement of the middles of the rods [rod, 3] over the run."""
    rods = Simulation(of, "cpu").ensembles["c"]
    start = rods.position[:, 32]
    rods.advance(of.time.step, round(2.0 / of.time.step))
    return rods.position[:, 32] - start


def test_a_run_says_that_round_off_would_choose_the_direction():
    (note,) = Simulation(scene(1e-3), "cpu").notes
    assert note.startswith("c: 2 of 2 rods start with the symmetry under rotation by π")
    assert "shape.perturbation = 1e-3" in note
    assert not Simulation(scene(1e-3, perturbation=1e-3), "cpu").notes
    text = scene(1e-3, perturbation=[1e-3, 0.0]).to_toml()
    assert "1 of 2 rods" in Simulation(Scene.parse(text), "cpu").notes[0]


def test_with_a_perturbation_the_direction_does_not_depend_on_the_step():
    """Without it, half the step reverses swimmers. Another seed may reverse them."""
    whole, half = (displaced(scene(step, perturbation=1e-3)) for step in (1e-3, 5e-4))
    assert np.linalg.norm(whole, axis=-1).min() > 0.5
    np.testing.assert_allclose(whole, half, rtol=0, atol=2e-3)
    others = [displaced(scene(1e-3, seed=seed, perturbation=1e-3)) for seed in range(6)]
    assert {tuple(np.sign(d[:, 0])) for d in others} > {tuple(np.sign(others[0][:, 0]))}
