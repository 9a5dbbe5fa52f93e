"""The contract of an ensemble, fulfilled the same way by every kind of rod."""

import numpy as np
import pytest
from examples.free import in_space

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.status import Status
from warp_rods.scene import flagella
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

STEP = 1e-3


def free(device, **given) -> Ensemble:
    return in_space(device, count=2, bend=[1e-3, 2e-3], **given)


def bound(device, **given) -> Ensemble:
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    position, direction = [[1.4, 0, 0], [0, 1.4, 0]], [[0, 1, 0.3], [0, 0.2, 1]]
    return BoundRods(
        torus,
        position,
        direction,
        length=[1.2, 0.9],
        intrinsic=(0.7, 1.0, 0.2),
        drag=(1, 2, 0.3),
        device=device,
        **given,
    )


KINDS = {"free": free, "bound": bound}
FORCE = np.array([0.3, -0.2, 0.1])
READINGS = (
    *("position", "orientation", "strain", "tension", "energy", "energy_density", "dissipation", "power", "status"),
)


@pytest.fixture(params=KINDS)
def make(request, device):
    return lambda **given: KINDS[request.param](device, **given)


def assert_same(ours: dict, theirs: dict) -> None:
    assert ours.keys() == theirs.keys()
    for name, values in theirs.items():
        np.testing.assert_array_equal(ours[name], values, err_msg=name)


def test_setting_a_step_is_free_of_side_effects(make):
    """Twice, of another length first, and after steps of another length: what counts is the step that is taken."""
    plain, wavering = make(), make()
    for dt in (STEP, STEP, 2 * STEP, STEP / 2):
        plain.step(dt, 3)
        wavering.set_step(7 * dt)
        wavering.set_step(dt)
        wavering.set_step(dt)
        wavering.step(dt, 3)
    assert_same(wavering.state(), plain.state())


def test_restoring_an_earlier_state_leaves_no_trace(make):
    """Through a change of step and of the force after the state was taken."""
    rods = make()
    rods.force = FORCE
    rods.step(STEP, 5)
    kept = rods.state()
    rods.step(STEP, 5)
    expected = rods.state()
    rods.force = 3 * FORCE
    rods.step(3 * STEP, 4)
    rods.restore(kept)
    assert rods.time == pytest.approx(5 * STEP)
    assert_same(rods.state(), kept)
    rods.step(STEP, 5)
    assert_same(rods.state(), expected)


def test_a_state_holds_the_external_force(make):
    """Another ensemble, which never felt a force, goes on from it to the same bits."""
    pushed, other = make(), make()
    pushed.force = FORCE
    pushed.step(STEP, 5)
    other.restore(pushed.state())
    np.testing.assert_array_equal(other.force, pushed.force)
    pushed.step(STEP, 5)
    other.step(STEP, 5)
    assert_same(other.state(), pushed.state())


def test_a_state_without_a_force_ends_one(make):
    rods, free_of_force = make(), make()
    kept = free_of_force.state()
    rods.force = FORCE
    rods.step(STEP, 2)
    rods.restore(kept)
    assert not rods.force.any()
    rods.step(STEP, 5)
    free_of_force.step(STEP, 5)
    np.testing.assert_array_equal(rods.position, free_of_force.position)


def test_asking_for_a_force_changes_nothing(make):
    plain, asked = make(), make()
    for _ in range(3):
        assert not asked.force.any()
        _ = asked.force_array
        plain.step(STEP, 2)
        asked.step(STEP, 2)
    np.testing.assert_array_equal(asked.position, plain.position)
    np.testing.assert_array_equal(asked.strain, plain.strain)


def test_readings_are_those_of_a_frame(make):
    rods = make()
    rods.force = FORCE
    rods.step(STEP, 3)
    frame = rods.variables()
    for name in READINGS:
        np.testing.assert_array_equal(getattr(rods, name), frame[name], err_msg=name)
    before = rods.state()
    rods.variables()
    assert_same(rods.state(), before)


def test_power_is_what_energy_gains_and_drag_loses(make):
    """dE/dt = power − dissipation under an external force, to second order in the spacing: 2 % on these grids."""
    rods = make(nodes=65)
    rods.force = 20 * FORCE
    rods.step(2e-5, 500)
    before, rate = rods.energy, rods.power - rods.dissipation
    gain = []
    for _ in range(2):
        rods.step(2e-5, 20)
        gain.append((rods.energy - before) / (rods.time - 0.01))
    expected = (rate + rods.power - rods.dissipation) / 2
    np.testing.assert_allclose(gain[-1], expected, rtol=0.02, atol=0.02 * np.abs(rods.dissipation).max())
    assert np.abs(rods.power).max() > 0.1 * rods.dissipation.max()


def test_parameters_are_fixed(make):
    rods = make()
    for name in rods.parameters(0):
        values = getattr(rods, name)
        assert len(values) == rods.count
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
        with pytest.raises(AttributeError, match=f"{name} is fixed"):
            setattr(rods, name, values)


def test_a_rod_that_fails_has_a_status_with_words(make):
    rods = make()
    force = np.zeros((rods.count, rods.nodes, 3))
    force[1, 8] = np.nan
    rods.force = force
    rods.step(STEP, 3)
    assert rods.status.tolist() == [Status.SOUND, Status.NOT_FINITE]
    [failure] = rods.failures()
    assert (failure.rod, failure.what) == (1, Status.NOT_FINITE.words)
    assert "1 of them frozen" in repr(rods)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"bend": [1e-3, 0.0]}, "bend = 0: must be positive"),
        ({"bend": [1e-3, 1e-3, 1e-3]}, r"bend: values of shape \(3,\) do not fit 2 rods"),
        ({"bend": "soft"}, "bend: "),
        ({"nodes": 64}, "nodes = 64: must be an odd whole number"),
        ({"shape": {"kind": "spiral"}}, "shape.kind = 'spiral': must be one of mode, writhe, straight"),
        ({"shape": {"amplitud": 2.0}}, r"shape of kind mode: unknown key 'amplitud' \(did you mean amplitude\?\)"),
        ({"shape": {"mode": -1}}, "shape.mode = -1: must be a whole number"),
        ({"shape": np.zeros((2, 60, 3))}, r"shape: must be a table .* or strains \(2, 65, 3\)"),
        ({"shape": np.full((2, 65, 3), np.nan)}, "shape: strains must be finite"),
        ({"flagella": {"relaxatoin": 1e-2}}, r"flagella: unknown key 'relaxatoin' \(did you mean relaxation\?\)"),
        ({"flagella": {"law": "relaxed"}}, r"flagella.law = 'relaxed': must be one of relaxing, held \(did you mean"),
        ({"flagella": {"profile": "step"}}, "flagella.profile = 'step': must be one of tanh"),
        ({"flagella": {"profile": [1.0, np.nan]}}, "flagella.profile: must be one of"),
        ({"flagella": {"profile": np.full(65, np.nan)}}, "flagella.profile: must be finite"),
        ({"flagella": {"relaxation": -1.0}}, "relaxation = -1: must be positive"),
        ({"flagella": 3}, "flagella = 3: must be a mapping"),
        ({"position": [1.0, 2.0]}, r"position: values of shape \(2,\)"),
        ({"rotation": 2 * np.eye(3)}, r"rotation\[0\] = .*: must be a rotation"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "must be a rotation"),
        ({"rotation": np.eye(2)}, r"rotation: must be a matrix \[3, 3\]"),
    ],
)
def test_mistakes_with_free_rods_name_the_parameter(given, said):
    with pytest.raises(SceneError, match=said):
        FreeRods(**({"count": 2, "nodes": 65, "bend": 1e-3, "twist": 1e-3} | given), device="cpu")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"stiffness": (1.0, 1.0)}, r"stiffness: values of shape \(2,\) do not fit 1 rods"),
        ({"stiffness": (1.0, 1.0, -1.0)}, "stiffness = -1: must be positive"),
        ({"drag": (1.0, 2.0, -0.1)}, "drag = -0.1: must be zero or more"),
        ({"length": np.nan}, "length = nan: must be positive"),
        ({"intrinsic": (0.0, np.inf, 0.0)}, "intrinsic = inf: must be any finite number"),
        ({"nodes": 5}, "nodes = 5: must be 9 or more"),
        ({"nodes": 33.5}, "nodes = 33.5: must be a whole number"),
        ({"position": [[1.4, 0]]}, r"position: must be finite numbers \[rod, 3\]; has shape \(1, 2\)"),
        ({"direction": [[0, 1, 0], [0, 1, 0]]}, r"direction: must be finite numbers \(1, 3\)"),
        ({"geodesic_curvature": [1.0, 2.0]}, "geodesic_curvature: must be a number, or numbers"),
        ({"geodesic_curvature": np.nan}, "geodesic_curvature: must be finite"),
        ({"ends": "free"}, "ends = 'free': must be a pair"),
        ({"ends": ("free", "pinned")}, "ends = 'pinned': must be one of free, clamped"),
        ({"at": "end"}, "at = 'end': must be one of start, middle"),
    ],
)
def test_mistakes_with_filaments_name_the_parameter(given, said):
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    with pytest.raises(SceneError, match=said):
        BoundRods(torus, **({"position": [[1.4, 0, 0]], "direction": [[0, 1, 0]]} | given), device="cpu")


BIASED = flagella.Law(
    "RELAXING", {"threshold": flagella.LawParameter(0.5, "positive"), "bias": flagella.LawParameter(-1.0)}
)


def test_a_law_may_have_parameters_of_its_own(monkeypatch):
    """A row of the table with two parameters: from a mapping to the array that the kernels read."""
    monkeypatch.setitem(flagella.LAWS, "biased", BIASED)
    rods = FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "biased", "threshold": [0.2, 0.3]}, device="cpu")
    np.testing.assert_array_equal(rods._arrays.rods.law_numbers.numpy(), [[0.2, -1, 0, 0], [0.3, -1, 0, 0]])
    with pytest.raises(SceneError, match=r"flagella\.threshold = -1: must be positive"):
        FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "biased", "threshold": -1.0}, device="cpu")
    with pytest.raises(SceneError, match="unknown key 'threshold'"):
        FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "relaxing", "threshold": 1.0}, device="cpu")


def test_a_law_with_parameters_is_used_from_a_scene(monkeypatch):
    """As a table in TOML: defaults filled in, one value a rod, faults named, numbers where kernels read them."""
    monkeypatch.setitem(flagella.LAWS, "biased", BIASED)
    text = """
        time = {{ end = 0.1, step = 1e-3 }}
        [[swimmers]]
        name = "cells"
        count = 2
        nodes = 33
        bend = 1e-3
        twist = 1e-3
        flagella = {{ {} }}
    """
    scene = Scene.parse(text.format('law = "biased", threshold = [0.2, 0.3]'))
    assert Scene.parse(scene.to_toml()) == scene
    rods = Simulation(scene, "cpu").ensembles["cells"]
    np.testing.assert_array_equal(rods._arrays.rods.law_numbers.numpy(), [[0.2, -1, 0, 0], [0.3, -1, 0, 0]])
    for given, said in (
        ('law = "biased", threshold = 0', r"swimmers\[0\].flagella.threshold = 0: must be a positive number"),
        (
            'law = "biased", threshold = [1.0]',
            r"swimmers\[0\].flagella.threshold = .*: needs one entry for each of 2 rods",
        ),
        ('law = "biased", treshold = 1.0', r"flagella.treshold: unknown key \(did you mean threshold\?\)"),
        ("threshold = 1.0", r"flagella.threshold: unknown key; known here, with the law relaxing: relaxation"),
        ('law = "biasd"', r'flagella.law = "biasd": must be one of "relaxing", "held"'),
    ):
        with pytest.raises(SceneError, match=said):
            Scene.parse(text.format(given))
