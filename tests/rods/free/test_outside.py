"""Gravity, and forces and couples per length by formula, on free rods: exact answers and elastica."""

import numpy as np
import pytest
from examples.free import in_space, passive, slope
from scipy.integrate import solve_bvp
from scipy.spatial.transform import Rotation

from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods

S = np.linspace(-0.5, 0.5, 65)
STRAIGHT = {"kind": "straight"}


def held(device, nodes=65, **other):
    """A passive rod that is clamped at its first end, along x, with the other end free."""
    return passive(device, nodes, shape=STRAIGHT, **({"ends": ("clamped", "free")} | other))


@pytest.mark.parametrize("which", ["gravity", "forces"])
def test_a_straight_rod_sinks(device, which, verified):
    """A uniform force F moves it with F∥/ζ∥ + F⊥/ζ⊥, and does not turn it."""
    rotation = Rotation.from_rotvec([0.3, -0.7, 0.2]).as_matrix()
    tangent, force = rotation[:, 0], np.array([0.1, 0.0, -0.3])
    given = {"gravity": force} if which == "gravity" else {"forces": [{"force": list(force)}]}
    rods = passive(device, shape=STRAIGHT, rotation=rotation, drag_along=1.5, drag_ratio=1.8, **given)
    rods.step(1e-2, 100)
    along = tangent * (tangent @ force)
    expected = along / 1.5 + (force - along) / 2.7
    verified.below(
        "exact", f"straight rod under {which}: velocity", measured=abs(rods.position[0, 32] - expected).max(),
        bound=1e-13, reference="F∥/ζ∥ + F⊥/ζ⊥",
    )  # fmt: skip
    np.testing.assert_allclose(rods.rotation[0, :, :, 0], np.broadcast_to(tangent, (65, 3)), rtol=0, atol=1e-13)
    verified.below(
        "exact", f"straight rod under {which}: power", measured=abs(rods.power - rods.dissipation),
        bound=1e-14, reference="power = dissipation",
    )  # fmt: skip


def heavy_elastica(bend, weight):
    """The angle θ(s) of a rod clamped along x under a weight along −z: b θ'' = w (1/2 − s) cos θ."""

    def slopes(s, y):
        return np.stack([y[1], weight * (0.5 - s) * np.cos(y[0]) / bend])

    def ends(first, last):
        return np.array([first[0], last[1]])

    grid = np.linspace(-0.5, 0.5, 201)
    found = solve_bvp(slopes, ends, grid, np.zeros((2, 201)), tol=1e-10, max_nodes=100000)
    assert found.success
    return found.sol


def test_a_heavy_rod_hangs_as_its_elastica(device, verified):
    bend, weight = 2e-2, 0.3
    exact = heavy_elastica(bend, weight)
    sizes, errors = np.array([33, 65, 129]), []
    for nodes in sizes:
        s = np.linspace(-0.5, 0.5, nodes)
        rods = held(device, int(nodes), bend=bend, gravity=[0, 0, -weight])
        rods.step(0.5, 200)
        assert abs(rods.rates()["transverse"]).max() < 1e-9
        tangent = rods.rotation[0, :, :, 0]
        assert abs(tangent[:, 1]).max() < 1e-12
        errors.append(abs(np.arctan2(tangent[:, 2], tangent[:, 0]) - exact(s)[0]).max())
    assert exact(0.5)[0] < -0.5
    verified.order("heavy elastica: order in Δs", measured=slope(sizes - 1, errors), reference="boundary value problem")
    verified.below(
        "independent",
        "heavy elastica: angle, N = 129",
        measured=errors[-1],
        bound=3e-4,
        reference="boundary value problem",
    )


def test_a_couple_per_length_in_space_bends(device, verified):
    """b κ = µ (1/2 − s) about z: what acts beyond a section bends it, towards positive Ω[2]."""
    rods = held(device, bend=5e-2, forces=[{"couple": [0, 0, "2e-2"]}])
    rods.step(1.0, 100)
    verified.below(
        "exact", "couple per length across: bending", measured=abs(rods.strain[0, :, 2] - 0.4 * (0.5 - S)).max(),
        bound=1e-10, reference="b κ = µ (1/2 − s)",
    )  # fmt: skip
    assert rods.position[0, -1, 1] > 0.05


@pytest.mark.parametrize("which", ["couple", "forces"])
def test_a_couple_per_length_about_the_tangent_twists(device, which, verified):
    """c τ = µ0 (1/2 − s)."""
    given = {"couple": 2e-3} if which == "couple" else {"forces": [{"couple": ["2e-3", 0, 0]}]}
    rods = held(device, **given)
    rods.advance_to(30.0)
    verified.below(
        "exact", f"couple per length about the tangent, by {which}: twist",
        measured=abs(rods.strain[0, :, 0] - 2 * (0.5 - S)).max(), bound=1e-3, reference="c τ = µ0 (1/2 − s)",
    )  # fmt: skip


def test_a_couple_along_the_rod_turns_a_free_one(device):
    """A couple about the tangent spins a straight rod at µ0/ζr: in steps of its own, if it does not change."""
    rods = passive(device, shape=STRAIGHT, couple=3e-3)
    assert rods.has_own_steps
    rods.advance_to(0.5)
    assert Rotation.from_quat(rods.orientation[0, 32]).as_rotvec() == pytest.approx([0.5, 0, 0], abs=1e-12)
    rods = passive(device, shape=STRAIGHT, couple="3e-3*cos(5*t)")
    assert not rods.has_own_steps
    rods.step(1e-3, 400)
    assert Rotation.from_quat(rods.orientation[0, 32]).as_rotvec() == pytest.approx([np.sin(2) / 5, 0, 0], abs=1e-5)


def test_a_couple_of_odd_shape_twists_as_the_active_moment_does(device):
    """µ0 = M f of a held profile gives the motion that M gives."""
    f = -np.tanh(4 * S)
    flagella = {"profile": f, "law": "held"}
    active = in_space(device, moment=4e-3, flagella=flagella)
    turned = in_space(device, moment=0.0, flagella=flagella, couple=np.stack([4e-3 * f]))
    for rods in (active, turned):
        rods.step(1e-3, 100)
    np.testing.assert_allclose(turned.strain, active.strain, rtol=0, atol=1e-10)


def test_forces_by_formula_agree_with_functions(device):
    """Of place, arc length and time; gravity and several tables add up."""

    def push(t, x, R):
        f = np.stack([np.sin(x[..., 1] - t), x[..., 0] * x[..., 2], np.cos(3 * t) + 0 * x[..., 0]], axis=-1)
        return 0.2 * f + S[:, None] * [0.0, 0.1, 0.0] + [0, 0, -0.3]

    tables = [{"force": ["0.2*sin(y - t)", "0.2*x*z", "0.2*cos(3*t)"]}, {"force": [0, "0.1*s", 0]}]
    first = in_space(device, external=push)
    second = in_space(device, forces=tables, gravity=[0, 0, -0.3])
    for rods in (first, second):
        rods.step(1e-3, 50)
    np.testing.assert_allclose(second.position, first.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(second.power, first.power, rtol=1e-9)


def test_a_force_can_be_set_besides_gravity(device):
    both, one = in_space(device, gravity=[0, 0, 1.0]), in_space(device, gravity=[0, 2.0, 1.0])
    both.force = [0, 2.0, 0]
    for rods in (both, one):
        rods.step(1e-3, 20)
    np.testing.assert_allclose(both.position, one.position, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(both.force[0, 0], [0, 2, 0])


def test_each_rod_may_have_a_weight_of_its_own(device):
    rods = FreeRods(
        2, 17, bend=1e-2, twist=1e-3, flagella=None, shape=STRAIGHT, gravity=[[0, 0, 1], [0, 0, -3]], device=device
    )
    rods.step(1e-2, 10)
    np.testing.assert_allclose(rods.position[:, 8, 2], [0.05, -0.15], rtol=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"gravity": 1.0}, "gravity: "),
        ({"forces": {"force": [0, 0, 1]}}, r"forces = .*: must be a list of tables"),
        ({"forces": [{}]}, r"forces\[0\]: force or couple: missing; give one of them, or both"),
        (
            {"forces": [{"force": ["q", 0, 0]}]},
            r"forces\[0\].force = .*: must be three numbers or formulas in x, y, z, s",
        ),
        ({"forces": [{"force": ["sqrt(0*x - 1)/(x - x)", 0, 0]}]}, "forces: .*divides by zero"),
        ({"couple": "x"}, "couple = 'x': .*x is not known here"),
        ({"couple": [1.0, 2.0, 3.0]}, "couple: must be a number, numbers"),
        ({"couple": 1.0, "symmetric": True}, "symmetric = true: a couple could break the symmetry"),
    ],
)
def test_faults_are_named(device, given, message):
    with pytest.raises(SceneError, match=message):
        FreeRods(1, 17, bend=1e-2, twist=1e-3, device=device, **given)
