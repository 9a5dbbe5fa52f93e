"""Measures of a trajectory against closed forms, and the known classes of motion of swimmers."""

import numpy as np
import pytest
import xarray as xr
from examples.free import in_space, slope
from reference.exact import STEADY_U
from scipy.spatial.transform import Rotation

from warp_rods.analysis.diagnostics import MEASURES, measure
from warp_rods.analysis.motion import speed
from warp_rods.analysis.motion_class import period, shape_class
from warp_rods.analysis.shape import mode_coefficients
from warp_rods.frames import writhe
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.rods.modes import beam_mode
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner
from warp_rods.theory.symmetry import gauge_strain

ARC = np.linspace(-0.5, 0.5, 65)


def integrate(rods: FreeRods, end: float, save_every: float, dt: float = 1e-3) -> xr.Dataset:
    """The group of a trajectory of rods up to the time ``end``."""
    frames, times = [rods.variables()], [rods.time]
    for _ in range(round(end / save_every)):
        rods.step(dt, round(save_every / dt))
        frames.append(rods.variables())
        times.append(rods.time)
    arrays = {name: np.stack([frame[name] for frame in frames]) for name in rods.saved if name in frames[0]}
    data = {name: (rods.saved[name].dims, values, {"units": rods.saved[name].units}) for name, values in arrays.items()}
    s = np.linspace(-0.5, 0.5, rods.nodes)
    return xr.Dataset(data, coords={"time": ("frame", times), "s": ("node", s)})


def prescribed(first, second, twist=0.0, times=(0.0,)) -> xr.Dataset:
    """A group of swimmers with one rod and prescribed strains [frame, node]."""
    t, s = np.asarray(times, dtype=float)[:, None], ARC
    strain = np.stack(np.broadcast_arrays(twist + 0.0 * t * s, first + 0.0 * t * s, second + 0.0 * t * s), axis=-1)
    return xr.Dataset(
        {
            "strain": (("frame", "rod", "node", "strain_component"), strain[:, None]),
            "activity": (("frame", "rod", "node"), np.zeros((len(t), 1, 65))),
            "status": (("frame", "rod"), np.zeros((len(t), 1), int)),
        },
        coords={"time": ("frame", t[:, 0]), "s": ("node", s)},
    )


BENT = {"kind": "mode", "mode": 0, "amplitude": 3.0}
COILED = {"kind": "writhe", "amplitude": 6.0}
WAVY = {"kind": "mode", "mode": 2, "amplitude": 2.0}
# name: β⊥, β∥, M, ηr, start, class. At β⊥ = 7.6e-5 flapping and waving are both stable; the start decides.
KNOWN = {
    "swimmer": (5e-3, 1e-3, 0.0, 3e-3, BENT, "U"),
    "stiff": (2e-2, 1e-3, 0.0, 3e-3, BENT, "straight"),
    "waving": (1.3e-4, 1e-3, 0.0, 3e-3, BENT, "waving"),
    "flapping": (7.6e-5, 1e-3, 0.0, 3e-3, WAVY, "flapping"),
    "waving at flapping's": (7.6e-5, 1e-3, 0.0, 3e-3, BENT, "waving"),
    "Fig 4.3a": (2.5e-4, 1e-4, 6e-3, 3e-3, COILED, "twisted-U"),
    "Fig 4.3b": (8e-5, 1e-5, 1.35e-2, 3e-3, BENT, "waving"),
    "Fig 4.3c": (5.45e-5, 1e-3, 1e-2, 1e-2, COILED, "S"),
    "Fig 4.3d": (1.25e-4, 1e-3, 2e-2, 1e-3, COILED, "flapping"),
}


@pytest.fixture(scope="module")
def settled(device) -> xr.Dataset:
    """All swimmers of KNOWN in one batch, to t = 16."""
    bend, twist, moment, rotational_drag = np.array([row[:4] for row in KNOWN.values()]).T
    given = {"bend": bend, "twist": twist, "moment": moment}
    shapes = [
        initial_strain(start, 65, {name: values[[rod]] for name, values in given.items()})[0]
        for rod, (*_, start, _) in enumerate(KNOWN.values())
    ]
    rods = FreeRods(len(KNOWN), **given, rotational_drag=rotational_drag, shape=shapes, symmetric=True, device=device)
    return integrate(rods, 16.0, 0.02)


def test_known_motions_are_named(settled):
    found = dict(zip(KNOWN, shape_class(settled).to_numpy(), strict=True))
    assert found == {name: row[-1] for name, row in KNOWN.items()}


def test_known_periods_and_speeds(settled):
    """A flapping swimmer has almost no net displacement, a waving one swims; periods agree with those of a₀."""
    late = dict(zip(KNOWN, speed(settled, since=8.0).to_numpy(), strict=True))
    midpoint = dict(zip(KNOWN, MEASURES["instantaneous_speed"](settled)[-400:].mean("frame").to_numpy(), strict=True))
    assert late["swimmer"] == pytest.approx(STEADY_U[5e-3][1], rel=5e-3)
    assert late["waving"] > 0.98 * midpoint["waving"]
    assert late["flapping"] < 0.2 * midpoint["flapping"] and late["Fig 4.3d"] < 0.2 * midpoint["Fig 4.3d"]
    periods = dict(zip(KNOWN, period(settled).to_numpy(), strict=True))
    assert np.isnan([periods[name] for name in ("swimmer", "stiff", "Fig 4.3a", "Fig 4.3c")]).all()
    a0 = mode_coefficients(settled)[-400:, :, 1, 0].to_numpy()
    for rod in (2, 3, 4):
        # Upward crossings of the mean, interpolated; their distances are the periods.
        wave = a0[:, rod] - a0[:, rod].mean()
        at = np.flatnonzero((wave[:-1] < 0) & (wave[1:] >= 0))
        crossings = at - wave[at] / (wave[at + 1] - wave[at])
        assert list(periods.values())[rod] == pytest.approx(0.02 * np.diff(crossings).mean(), rel=3e-3)


def test_a_run_is_measured(tmp_path):
    """All measures of the swimmers of a run with time, units and sources; some measures of its filaments."""
    swimmer = {"name": "cell", "count": 2, "nodes": 17, "bend": 1e-3, "twist": 1e-3, "moment": 2e-3}
    sensor = {"name": "f", "count": 2, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0]}
    sphere = {"surface": {"kind": "sphere", "radius": 1.0}, "filaments": [sensor]}
    time = {"end": 0.125, "step": 1e-3, "save_every": 0.01}
    scene = Scene.parse({"swimmers": [swimmer], **sphere, "time": time})
    data = runner.simulate(scene, tmp_path / "run", device="cpu").data
    found = measure(data["cell"].to_dataset(), *MEASURES)
    assert set(found.data_vars) == set(MEASURES)
    assert all(array.attrs.keys() >= {"units", "long_name", "source"} for array in found.data_vars.values())
    assert found["writhe"].dims == ("frame", "rod") and "time" in found["writhe"].coords
    both = found["bending_energy"] + found["twist_energy"]
    np.testing.assert_allclose(both, data["cell"]["energy"], rtol=1e-5)
    filaments = measure(data["f"].to_dataset(), "speed", "writhe", "arc_length", "energy_balance", "mode_coefficients")
    assert all(np.isfinite(array).all() for array in filaments.data_vars.values())
    with pytest.raises(ValueError, match="no activity"):
        measure(data["f"].to_dataset(), "period")


def test_an_unknown_measure_names_the_known_ones():
    with pytest.raises(ValueError, match=r"no measure called beauty: there are .*writhe"):
        measure(prescribed(0.0, 1.0), "beauty")


def test_coefficients_do_not_depend_on_the_gauge():
    """A symmetric state in a rotated gauge has the same (4.48)–(4.50), up to a common sign of both bendings."""
    data = prescribed(2 * beam_mode(1, ARC), 3 * beam_mode(0, ARC) - beam_mode(2, ARC), 5 * np.cos(np.pi * ARC))
    expected = np.array([[0, 2, 0, 0, 0, 0], [3, 0, -1, 0, 0, 0]])
    for angle in (0.0, 0.7, 2.0, 4.0):
        turned = data.assign(strain=(data["strain"].dims, gauge_strain(data["strain"].to_numpy(), angle)))
        found = mode_coefficients(turned)[0, 0].to_numpy()
        np.testing.assert_allclose(found * np.sign(found[1, 0]), expected, atol=1e-6)
    harmonics = MEASURES["twist_harmonics"](data)[0, 0]
    np.testing.assert_allclose(harmonics, [5 / np.sqrt(2), 0, 0, 0, 0, 0], atol=1e-6)
    # ∫ 5 cos(πs) ds = 10/π, by the trapezoid rule.
    assert MEASURES["total_twist"](data).item() == pytest.approx(10 / np.pi / (2 * np.pi), rel=1e-3)


def test_twist_free_coefficients_of_a_strongly_twisted_rod():
    """A planar bow with a twist of 9 radians per node spacing has a single mode in the twist-free frame."""
    twist = 580.0
    bow = 3 * beam_mode(0, ARC) * np.exp(1j * (np.pi / 2 - twist * ARC))
    data = prescribed(bow.real, bow.imag, twist)
    np.testing.assert_allclose(mode_coefficients(data, twist_free=True)[0, 0, 1, :2], [3, 0], atol=1e-6)
    assert abs(mode_coefficients(data)[0, 0, 1, 0]) < 1


def helix(turns: float, nodes: int) -> np.ndarray:
    angle = 2 * np.pi * turns * np.linspace(0, 1, nodes)
    return np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), 0.2 * angle], axis=-1)


def gauss_integral(curve: np.ndarray, parts: int) -> float:
    """The double integral by the midpoint rule on each segment cut into ``parts``; the diagonal contributes nothing."""
    along = (np.arange(parts) + 0.5) / parts
    points = (curve[:-1, None] + along[:, None] * np.diff(curve, axis=0)[:, None]).reshape(-1, 3)
    steps = np.repeat(np.diff(curve, axis=0) / parts, parts, axis=0)
    gap = points[:, None] - points[None]
    distance = np.linalg.norm(gap, axis=-1) + np.eye(len(points))
    integrand = np.sum(gap * np.cross(steps[:, None], steps[None]), axis=-1) / distance**3
    return integrand.sum() / (4 * np.pi)


def test_writhe_is_the_gauss_integral(verified):
    """Positive for right-handed coils, negative for mirror images, and exact for the polygon."""
    curve = helix(1.7, 21)
    coarse, fine = (gauss_integral(curve, parts) for parts in (16, 32))
    verified(
        "independent", "writhe of a coiled polygon", measured=writhe(curve), expected=(4 * fine - coarse) / 3,
        relative=1e-4, reference="Gauss' double integral by the midpoint rule, extrapolated",
    )  # fmt: skip
    assert writhe(curve) > 0.1
    assert writhe(curve * [1, 1, -1]) == pytest.approx(-writhe(curve), rel=1e-12)
    np.testing.assert_allclose(writhe(np.stack([curve, curve[::-1]])), writhe(curve), rtol=1e-12)


def test_writhe_of_a_helix_converges_at_second_order(verified):
    """A long helix has a writhe of 1 − sin(pitch angle) per turn."""
    turns = np.array([20.0, 40.0])
    found = [writhe(helix(n, int(40 * n) + 1)) for n in turns]
    a, h = 0.3, 0.2
    verified(
        "exact", "writhe of a long helix, per turn", measured=np.diff(found)[0] / np.diff(turns)[0],
        expected=1 - h / np.hypot(a, h), relative=1e-2, reference="1 − sin(pitch angle)",
    )  # fmt: skip
    nodes = np.array([65, 129, 257])
    values = np.array([writhe(helix(2.0, n)) for n in nodes])
    fine = writhe(helix(2.0, 1025))
    verified.order("writhe of a helix: order in Δs", measured=slope(nodes, abs(values - fine)), reference="1025 nodes")


def test_planar_and_straight_lines_do_not_writhe():
    spiral = np.stack([(1 + ARC) * np.cos(9 * ARC), (1 + ARC) * np.sin(9 * ARC), 0 * ARC], axis=-1)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    lines = np.stack([spiral @ turn.T, ARC[:, None] * turn[0], np.zeros((65, 3))])
    np.testing.assert_allclose(writhe(lines), 0.0, atol=1e-12)


@pytest.mark.parametrize("true", [0.437, 1.3])
def test_period_of_a_known_wave(true):
    """An anharmonic wave, to 1e-2 of the time between frames."""
    t = 0.02 * np.arange(500)[:, None]
    phase = 2 * np.pi * t / true
    data = prescribed(np.sin(2 * phase) * beam_mode(1, ARC), (4 + np.cos(phase)) * beam_mode(0, ARC), times=t[:, 0])
    assert period(data).item() == pytest.approx(true, abs=2e-4)
    assert shape_class(data) == "waving"


def test_a_mirrored_shape_is_half_a_period():
    t = 0.02 * np.arange(500)[:, None]
    data = prescribed(0.0, 5 * np.cos(2 * np.pi * t) * beam_mode(0, ARC), times=t[:, 0])
    assert period(data).item() == pytest.approx(1.0, abs=2e-4)
    assert shape_class(data) == "flapping"


def test_aperiodic_motion_and_failed_rods_are_irregular():
    """A random walk, and the steady shape of a failed rod."""
    t = 0.02 * np.arange(500)
    walk = np.cumsum(np.random.default_rng(3).normal(size=(500, 1)), axis=0)
    assert shape_class(prescribed(0.0, walk * beam_mode(0, ARC), times=t)) == "irregular"
    with pytest.raises(ValueError, match="6 frames or more"):
        shape_class(prescribed(0.0, 0.0, times=t[:8]))
    steady = prescribed(0.0, 3 * beam_mode(0, ARC), times=t)
    assert shape_class(steady) == "U"
    assert shape_class(steady.assign(status=steady["status"] + 1)) == "irregular"


def test_balances_and_residuals_of_a_run(device, verified):
    """Energy balance of second order in the time between frames; arc lengths to double precision.

    The norm of a quaternion that is made from a frame says nothing of the frame: tangents of orientations are compared
    with the chords of the centre line, and ``orthonormality`` is that of quaternions that are not of norm 1.
    """
    rods = in_space(device, count=2)
    rods.step(1e-4, 500)
    data = integrate(rods, 0.08, 0.001, dt=1e-4)
    inner = [abs(MEASURES["energy_balance"](data.isel(frame=slice(None, None, n))))[1:-1] for n in (4, 8, 16)]
    at = [float(part.isel(frame=part.sizes["frame"] // 2, rod=0)) for part in inner]
    verified.order(
        "energy balance of a trajectory: order in the time between frames",
        measured=slope(1 / np.array([4, 8, 16]), at), reference="dE/dt by differences of frames − power + dissipation",
    )  # fmt: skip
    assert MEASURES["arc_length"](data).max() < 1e-12
    tangent = Rotation.from_quat(data["orientation"].to_numpy().reshape(-1, 4)).as_matrix()[:, :, 0]
    tangent = tangent.reshape(data["position"].shape)
    middle = tangent[:, :, 1:] + tangent[:, :, :-1]
    middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
    chord = np.diff(data["position"].to_numpy(), axis=2)
    chord /= np.linalg.norm(chord, axis=-1, keepdims=True)
    turn = np.abs(data["strain"].to_numpy()[..., 1:]).max() / 64
    assert np.abs(middle - chord).max() < turn**2 / 4
    enlarged = data.assign(orientation=data["orientation"] * (1 + 1e-4))
    assert MEASURES["orthonormality"](enlarged).to_numpy() == pytest.approx(2e-4, rel=5e-3)
    at_rest = measure(integrate(in_space(device, flagella=None, bend=1.0), 40.0, 10.0), "energy_balance")[
        "energy_balance"
    ]
    assert np.isnan(at_rest[-1])
    stretched = data.assign(position=data["position"] * (1 + 1e-6))
    assert MEASURES["arc_length"](stretched).max() == pytest.approx(1e-6, rel=1e-3)


def test_speed_over_a_window():
    t = np.linspace(0, 2, 41)
    middle = np.stack([np.where(t < 1, t, 2 - t), 0 * t, 0 * t], axis=-1)
    data = xr.Dataset(
        {"position": (("frame", "rod", "node", "axis"), np.repeat(middle[:, None, None], 3, axis=2))},
        coords={"time": ("frame", t)},
    )
    assert speed(data).item() == pytest.approx(0.0, abs=1e-12)
    assert speed(data, until=1.0).item() == speed(data, since=1.0).item() == pytest.approx(1.0)
    np.testing.assert_allclose(MEASURES["instantaneous_speed"](data)[:19, 0], 1.0)
    with pytest.raises(ValueError, match="no two frames"):
        speed(data, since=5.0)
