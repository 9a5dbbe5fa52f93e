"""Free rods in background flows: exact answers, the same forces in NumPy, the energy law, and steps."""

from itertools import pairwise

import numpy as np
import pytest
from examples.free import in_space, passive, planar, slope
from reference.outside import curl, flow_on_rods, straining_rates
from scipy.spatial.transform import Rotation

from warp_rods.errors import SceneError
from warp_rods.kernels.lanes import WIDTH
from warp_rods.rods import slices
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import coefficients

SHEAR = {"kind": "shear", "rate": 1.0}
TURNING = {"kind": "formula", "velocity": ["-0.8*y - 0.3*z", "0.8*x", "0.3*x"]}
"""A turn of the fluid as a whole, at (0, −0.3, 0.8)."""
WAVES = {"kind": "formula", "velocity": ["sin(2*y) - z*t", "cos(x - t)", "x*y"]}
S = np.linspace(-0.5, 0.5, 65)


def waves(x, t):
    return np.stack([np.sin(2 * x[..., 1]) - x[..., 2] * t, np.cos(x[..., 0] - t), x[..., 0] * x[..., 1]], axis=-1)


def pipe(x, t):
    axis = np.array([1.0, 2.0, -1.0]) / np.sqrt(6)
    y = x - [0.2, -0.1, 0.3]
    off = y - (y @ axis)[..., None] * axis
    return (1.5 * (1 - np.sum(off**2, axis=-1) / 0.8**2))[..., None] * axis


def sheared(x, t):
    return 1.3 * ((x - [0.2, 0.1, 0.3]) @ [0, 0.6, 0.8])[..., None] * np.array([0, 0.8, -0.6])


def strained(x, t):
    return -0.7 * (x - [0.1, 0.1, 0]) * [1, -0.5, -0.5]


def squeezed(x, t):
    return 2 * x * [0, 1, -1]


FLOWS = {
    "shear": (
        {"kind": "shear", "rate": 1.3, "direction": [0, 4, -3], "gradient": [0, 3, 4], "centre": [0.2, 0.1, 0.3]},
        sheared,
    ),
    "extension": ({"kind": "extension", "rate": -0.7, "centre": [0.1, 0.1, 0]}, strained),
    "planar": ({"kind": "extension", "rate": 2.0, "axis": [0, 1, 0], "across": [0, 0, 3]}, squeezed),
    "poiseuille": (
        {"kind": "poiseuille", "speed": 1.5, "radius": 0.8, "axis": [1, 2, -1], "centre": [0.2, -0.1, 0.3]},
        pipe,
    ),
    "formula": (WAVES, waves),
}  # fmt: skip


def rough(device, **other):
    """Two rods that are bent and twisted at random, passive where nothing else is given."""
    given = {"bend": [1e-3, 4e-3], "twist": 2e-3, "drag_along": 1.3, "drag_ratio": 1.7, "flagella": None}
    given |= {"shape": 3 * np.random.default_rng(1).normal(size=(2, 65, 3))}
    given |= {"position": [[0.3, 0.2, -0.1], [0.0, 0.5, 0.2]]}
    given |= {"rotation": Rotation.random(2, random_state=1).as_matrix()}
    return FreeRods(2, 65, device=device, **(given | other))


@pytest.mark.parametrize("name", FLOWS)
def test_forces_of_a_flow_agree_with_numpy(device, name):
    """The rates of rods under force and couple per length that follow from the flow and its curl in NumPy."""
    table, velocity = FLOWS[name]
    flowing = rough(device, flow=table)
    x, R = flowing.position, flowing.rotation
    u, spin = velocity(x, 0.0), curl(lambda y: velocity(y, 0.0), x) / 2
    force, couple = flow_on_rods(u, spin, R, 1.3, 1.3 * 1.7, 3e-3, 32)
    pushed = rough(device, couple=couple)
    pushed.force = force
    found, expected = flowing.rates(), pushed.rates()
    for key, bound in {"bending_rate": 1e-9, "twist_rate": 1e-7, "tension": 1e-10, "angular_velocity": 1e-9}.items():
        scale = abs(expected[key]).max()
        np.testing.assert_allclose(found[key], expected[key], rtol=0, atol=bound * scale, err_msg=key)
    np.testing.assert_allclose(found["transverse"] - expected["transverse"], _across(u, R), rtol=0, atol=1e-9)


def _across(u, R):
    """The velocity of the tracked node's fluid across the rod at every node."""
    at = np.einsum("rnij,ri->rnj", R, u[:, 32])
    return at[..., 1] + 1j * at[..., 2]


@pytest.mark.parametrize("by_error", [False, True], ids=["given steps", "own steps"])
def test_a_uniform_flow_carries_a_rod_without_changing_its_shape(device, by_error, verified):
    velocity = np.array([1.0, -2.0, 0.5])
    still, moved = in_space(device, count=2), in_space(device, count=2, flow={"kind": "uniform", "velocity": velocity})
    for rods in (still, moved):
        rods.advance_to(0.2) if by_error else rods.step(1e-3, 200)
    which = "steps of its own" if by_error else "steps of given length"
    names = ("strain", "activity", "orientation", "tension", "dissipation", "power")
    verified.same(
        f"swimmer in a uniform flow, {which}: strains, frames, powers", {name: getattr(moved, name) for name in names},
        {name: getattr(still, name) for name in names}, reference="the same swimmer in still fluid",
    )  # fmt: skip
    verified.below(
        "exact", f"swimmer in a uniform flow, {which}: place",
        measured=abs(moved.position - still.position - 0.2 * velocity), bound=1e-14, reference="shifted by u t",
    )  # fmt: skip
    for name, found in moved.rates().items():
        if name not in ("axial", "transverse"):
            np.testing.assert_array_equal(found, still.rates()[name], err_msg=name)


def test_a_uniform_flow_that_changes_in_time(device):
    """Strains have the same bits in steps of given length; the place follows ∫ u dt to second order."""
    still, errors, steps = planar(device, 33), [], np.array([25, 50, 100])
    for count in steps:
        still = planar(device, 33)
        moved = planar(device, 33, flow={"kind": "formula", "velocity": ["cos(20*t)", "-sin(20*t)", "3"]})
        for rods in (still, moved):
            rods.step(0.1 / count, int(count))
        np.testing.assert_array_equal(moved.strain, still.strain)
        shift = np.array([np.sin(2), np.cos(2) - 1, 6]) / 20
        errors.append(abs(moved.position - still.position - shift).max())
    assert slope(steps, errors) == pytest.approx(2, abs=0.2)


def test_fluid_that_turns_as_a_whole_turns_the_rod(device):
    """Strains in the material frame change as in still fluid, to second order in Δs, couple of vorticity included."""
    sizes, errors, turns = np.array([33, 65, 129]), [], []
    omega = np.array([0, -0.3, 0.8])
    for nodes in sizes:
        still = in_space(device, int(nodes), moment=0.0, flagella=None)
        turned = in_space(device, int(nodes), moment=0.0, flagella=None, flow=TURNING)
        for rods in (still, turned):
            rods.step(1e-3, 300)
        errors.append(abs(turned.strain - still.strain).max())
        expected = Rotation.from_rotvec(0.3 * omega).as_matrix() @ Rotation.from_quat(still.orientation[0]).as_matrix()
        turns.append(abs(Rotation.from_quat(turned.orientation[0]).as_matrix() - expected).max())
    assert errors[-1] < 2e-3 and turns[-1] < 1e-3, (errors, turns)
    assert slope(sizes - 1, errors) == pytest.approx(2, abs=0.2), errors


def test_vorticity_spins_a_rod_along_it(device, verified):
    """A straight rod along ∇×u spins at half of it; one across it turns with the fluid."""
    rods = passive(device, shape={"kind": "straight"}, rotation=Rotation.from_rotvec([0, -np.pi / 2, 0]).as_matrix(),
                   flow={"kind": "shear", "rate": 3.0})  # fmt: skip
    before = Rotation.from_quat(rods.orientation[0, 32])
    rods.step(1e-3, 200)
    turn = Rotation.from_quat(rods.orientation[0, 32]) * before.inv()
    verified(
        "exact", "straight rod along the vorticity of shear: its spin", measured=turn.as_rotvec()[2], expected=-0.3,
        within=1e-12, reference="½∇×u t, of u = (3 y, 0, 0)",
    )  # fmt: skip
    assert abs(rods.strain).max() == 0


def test_a_straight_rod_in_shear(device, verified):
    """cot θ = cot θ₀ + γ̇t about a centre that is carried along: with local drag it comes to rest along the flow."""
    steps, errors = np.array([25, 50, 100]), []
    for count in steps:
        rotation = Rotation.from_rotvec([0, 0, 2.0]).as_matrix()
        rods = passive(device, shape={"kind": "straight"}, rotation=rotation, position=[1.0, 4.0, 0.0], flow=SHEAR)
        rods.step(2 / count, int(count))
        tangent = rods.rotation[0, 32, :, 0]
        errors.append(abs(tangent[0] / tangent[1] - (1 / np.tan(2.0) + 2)))
        assert abs(rods.position[0, 32] - [9, 4, 0]).max() < 1e-12
    verified.order(
        "straight rod in [flow] shear: order in Δt", measured=slope(steps, errors), reference="cot θ = cot θ₀ + γ̇t"
    )


def straining_growth(device, bend, nodes, steps):
    """The rate at which the even mode grows in the middle of the last tenth of a run."""
    s = np.linspace(-0.5, 0.5, nodes)
    flow = {"kind": "extension", "rate": -1.0, "across": [0, 1, 0]}
    rods = passive(device, nodes, bend=bend, shape={"kind": "mode", "amplitude": 1e-9}, flow=flow)
    rods.step(1.0 / steps, steps)
    early = coefficients(rods.strain[0, :, 2], s, 1)[0]
    rods.step(1.0 / steps, steps // 4)
    late = coefficients(rods.strain[0, :, 2], s, 1)[0]
    return np.log(late / early) / 0.25


def check_growth(device, verified, bend, known):
    assert straining_rates(bend)[np.argmin(abs(straining_rates(bend) - known))] == pytest.approx(known, abs=3e-5)
    coarse, fine = (straining_growth(device, bend, nodes, 100) for nodes in (33, 65))
    longer = straining_growth(device, bend, 33, 60)
    rates = (4 * fine - coarse) / 3 + (coarse - longer) / (100**2 / 60**2 - 1)
    verified(
        "independent", f"straining flow: growth of a free rod, b = {bend:g}", measured=rates, expected=known,
        within=1e-3, reference="linear theory; N = 33, 65 and Δt = 1/60, 1/100, extrapolated",
    )  # fmt: skip


def test_straining_flow_buckles_a_rod(device, verified):
    check_growth(device, verified, 0.008, 1.26000)


@pytest.mark.long
@pytest.mark.parametrize(("bend", "known"), [(0.02, -1.73563), (0.003, 2.48574)])
def test_growth_in_straining_flow(device, verified, bend, known):
    check_growth(device, verified, bend, known)


@pytest.mark.long
def test_threshold_of_straining_flow(device, verified):
    """The growth vanishes at ζ⊥ ε̇ L⁴/B = 153.2."""
    found = []
    for nodes in (33, 65):
        at = np.array([0.0128, 0.0133])
        rates = [straining_growth(device, bend, nodes, 100) for bend in at]
        found.append(2 / np.interp(0.0, rates[::-1], at[::-1]))
    verified(
        "independent", "straining flow: ζ⊥ ε̇ L⁴/B at which a free rod buckles", measured=(4 * found[1] - found[0]) / 3,
        expected=153.2, relative=2e-3, reference="linear theory; N = 33, 65 extrapolated",
    )  # fmt: skip


def test_a_stiff_rod_on_the_axis_of_a_pipe(device, verified):
    """Along the axis it moves with the fluid there; across it with the mean of u over the rod."""
    flow = {"kind": "poiseuille", "speed": 2.0, "radius": 1.0, "axis": [0, 0, 1]}
    along = passive(
        device, shape={"kind": "straight"}, flow=flow, rotation=Rotation.from_rotvec([0, -np.pi / 2, 0]).as_matrix()
    )
    along.step(1e-2, 50)
    assert abs(along.position[0, 32] - [0, 0, 1]).max() < 1e-13 and abs(along.strain).max() < 1e-13
    sizes, errors = np.array([33, 65, 129]), []
    for nodes in sizes:
        across = passive(device, int(nodes), bend=1e3, shape={"kind": "straight"}, flow=flow)
        across.step(1e-2, 50)
        errors.append(abs(across.position[0, :, 2].mean() - 1.0 * (1 - 1 / 12)))
    verified.order(
        "stiff rod across the axis of a pipe: order of its speed in Δs", measured=slope(sizes - 1, errors),
        reference="U (1 − L²/12R²)",
    )  # fmt: skip


ENDS = {"free": None, "clamped": ("clamped", "free"), "hinged": ("free", "hinged")}


@pytest.mark.parametrize("ends", ENDS)
def test_energy_law_with_all_that_acts_from_outside(device, ends, verified):
    """dE/dt = power − dissipation, with the dissipation ζ|u − u∞|², for rough rods, graded drag and any flow."""
    profile = np.random.default_rng(7).normal(size=65)
    rods = rough(
        device, ends=ENDS[ends], flow=WAVES, gravity=[0.3, -1.0, 2.0], couple="1e-2*cos(3*s)",
        forces=[{"force": ["x", "s", "t - z"], "couple": ["1e-2*y", "1e-2", "1e-2*s"]}], moment=[1e-2, -5e-3],
        flagella={"profile": profile}, drag_along="1 + s", rotational_drag="4e-3 - 2e-3*s",
    )  # fmt: skip
    rods.force = np.random.default_rng(5).normal(size=(2, 65, 3))
    found = rods.rates()
    weight = np.where((np.arange(65) == 0) | (np.arange(65) == 64), 0.5, 1.0) / 64
    bent = rods.bend[:, None] * (found["bending"].conj() * found["bending_rate"]).real
    change = np.sum(weight * (bent + rods.twist[:, None] * found["twist"] * found["twist_rate"]), axis=1)
    verified.below(
        "conservation", f"free rods in flow, gravity and couples, {ends} end: dE/dt = power − dissipation",
        measured=abs(change - rods.power + rods.dissipation) / rods.dissipation, bound=1e-11,
        reference="rates of k and τ",
    )  # fmt: skip
    assert (rods.dissipation > 0).all() and (abs(rods.flow_power) > 0).all()


def test_flagella_feel_the_velocity_against_the_fluid(device):
    """τf ∂f/∂t = (1 − f²)(u0 − u∞0) + D f'': in a flow along the rod that changes along it."""
    rods = passive(device, shape={"kind": "straight"}, flagella={"profile": 0.3 * np.cos(2 * S), "relaxation": 0.1},
                   flow={"kind": "extension", "rate": 2.0})  # fmt: skip
    found = rods.rates()
    fluid = 2 * (S[1:] + S[:-1]) / 2
    against = found["axial"][0] - fluid
    at_nodes = np.concatenate([against[:1], (against[1:] + against[:-1]) / 2, against[-1:]])
    f = 0.3 * np.cos(2 * S)
    mirrored = np.concatenate([f[1:2], f, f[-2:-1]])
    expected = ((1 - f**2) * at_nodes + 1e-3 * np.diff(mirrored, 2) * 64**2) / 0.1
    np.testing.assert_allclose(found["activity_rate"][0], expected, rtol=0, atol=1e-10)


def test_steps_in_a_flow_are_of_second_order(device, verified):
    steps, runs = np.array([50, 100, 200, 400]), []
    for count in steps:
        rods = in_space(device, 33, flow=WAVES, position=[0.5, -0.5, 1.0])
        rods.step(0.2 / count, int(count))
        runs.append(rods.variables())
    found = [
        slope(steps[:-1], [abs(b[name] - a[name]).max() for a, b in pairwise(runs)])
        for name in ("position", "orientation", "strain")
    ]
    verified.order(
        "swimmer in a flow of place and time: order in Δt", measured=found, reference="successive differences"
    )


def test_steps_by_error_in_a_flow(device):
    """They agree with short steps of given length within the tolerance."""
    made = {"nodes": 33, "flow": WAVES, "position": [0.5, -0.5, 1.0]}
    exact, found = in_space(device, **made), in_space(device, **made)
    exact.step(2.5e-4, 800)
    found.advance_to(0.2, 1e-3)
    assert abs(found.position - exact.position).max() < 1e-3
    found.advance_to(0.1 + 0.2)  # shown within a step
    exact.step(2.5e-4, 400)
    assert abs(found.position - exact.position).max() < 1e-2


def test_a_restored_rod_continues_in_a_flow(device):
    made = {"nodes": 33, "count": 2, "flow": WAVES, "gravity": [0, 0, 1.0]}
    rods, other = in_space(device, **made), in_space(device, **made)
    rods.step(1e-3, 3)
    kept = rods.state()
    _ = rods.power, rods.rates()
    rods.step(2e-3, 3)
    other.restore(kept)
    other.step(2e-3, 3)
    theirs = other.state()
    for key, values in rods.state().items():
        np.testing.assert_array_equal(theirs[key], values, err_msg=key)


def test_threads_that_share_rods_in_a_flow_give_the_bits_of_one(monkeypatch):
    found = []
    for count in (1, 3):
        monkeypatch.setattr(slices, "cores", lambda count=count: count)
        monkeypatch.setattr(slices, "NODES_PER_THREAD", 10)
        rods = in_space("cpu", 17, 3 * WIDTH - 2, flow=WAVES, gravity=[0, 0, 1.0], couple="1e-3*s")
        assert rods.threads == min(count, 3)
        rods.step(1e-3, 5)
        found.append(rods.variables())
    for name, values in found[0].items():
        np.testing.assert_array_equal(found[1][name], values, err_msg=name)


def test_a_start_without_past_keeps_the_place(device):
    """A force that is set in the middle of steps begins anew; what the flow has carried stays."""
    for flow in (SHEAR, {"kind": "uniform", "velocity": [0, 3.0, 0]}):
        rods = in_space(device, 33, flow=flow, position=[0, 1.0, 0])
        rods.advance_to(0.1)
        before = rods.position
        rods.force = [0, 0, 1e-9]
        np.testing.assert_allclose(rods.position, before, rtol=0, atol=1e-13)
        rods.step(1e-3, 2)
        assert abs(rods.position - before).max() < 2e-2


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"kind": "shaer"}, r"flow.kind = \"shaer\": must be one of uniform, shear, .* \(did you mean shear\?\)"),
        ({"kind": "shear"}, "flow.rate: missing; must be a number"),
        ({"kind": "shear", "rate": 1.0, "speed": 2.0}, "flow.speed: a flow of kind shear has no speed; it has rate"),
        ({"kind": "shear", "rate": 1.0, "gradient": [1, 1, 0]}, "flow.gradient = .*: must be perpendicular to dir"),
        ({"kind": "poiseuille", "speed": 1.0, "radius": -1.0}, "flow.radius = -1.0: must be a positive number"),
        ({"kind": "formula", "velocity": ["s", 0, 0]}, "flow.velocity = .*: must be three numbers or formulas"),
        ({"kind": "formula", "velocity": ["1/(x - x)", 0, 0]}, "flow.velocity: .*divides by zero"),
        ("shear", "flow = 'shear': must be a table"),
    ],
)  # fmt: skip
def test_faults_of_flows_are_named(device, table, message):
    with pytest.raises(SceneError, match=message):
        in_space(device, 33, flow=table)


def test_a_symmetric_rod_refuses_all_but_a_uniform_flow(device):
    planar(
        device,
        33,
        flagella={"profile": "tanh"},
        symmetric=True,
        flow={"kind": "uniform", "velocity": [1, 0, 0]},
    )
    with pytest.raises(SceneError, match="symmetric = true: an external force could break the symmetry"):
        planar(device, 33, flagella={"profile": "tanh"}, symmetric=True, flow=SHEAR)
