"""Filaments whose stiffness, intrinsic strains and drag change along them and in time: exact answers, power, errors."""

from itertools import pairwise

import numpy as np
import pytest
from examples.bound import energy_defect, order
from scipy.integrate import solve_bvp

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.checks import along_rods
from warp_rods.rods.bound.rods import BoundRods

RADIUS = 0.6
NODES = (17, 33, 65)
BEND = ("1.2 + 0.8*s", "0.9 - 0.5*s**2", "0.5*exp(1.5*s)")
REST = ("0.6 + sin(3*s)", "1.1 + s", "0.7*cos(4*s)")
"""B and σ of a filament, as formulas in s, and the same as functions."""


def B(s):
    return np.stack([1.2 + 0.8 * s, 0.9 - 0.5 * s**2, 0.5 * np.exp(1.5 * s)])


def sigma(s):
    return np.stack([0.6 + np.sin(3 * s), 1.1 + s, 0.7 * np.cos(4 * s)])


def share(nodes):
    return np.linspace(-0.5, 0.5, nodes)


def on_plane(nodes, device=None, **given):
    plane = surfaces.make("plane", {"size": 20.0})
    given = {"length": 1.0, "at": "start"} | given
    return BoundRods(plane, [[0, 0, 0]], [[1, 0, 0]], nodes=nodes, device=device, **given)


def relaxed(rods, time):
    """The filament at rest, after steps by error."""
    rods.advance_to(time)
    assert not rods.status.any()
    return rods


def angles_on_cylinder(alpha, s):
    """dα/ds and d(m3)/ds of a filament at rest at the angle α from the hoop: m3' = ∂e/∂α of the energy per length.

    A cylinder looks the same everywhere and rolls onto a plane: the energy is a functional of α alone.
    """
    stiff, rest = B(s), sigma(s)
    twist, bend = np.sin(2 * alpha[0]) / (2 * RADIUS) - rest[0], np.cos(alpha[0]) ** 2 / RADIUS - rest[1]
    slope = stiff[0] * twist * np.cos(2 * alpha[0]) / RADIUS - stiff[1] * bend * np.sin(2 * alpha[0]) / RADIUS
    return np.stack([rest[2] + alpha[1] / stiff[2], slope])


def test_a_graded_filament_on_a_cylinder_minimises_its_energy(device, verified):
    """Clamped at an angle of 0.3 from the hoop, with a free tip; all of B and σ change along it."""
    cylinder, errors = surfaces.make("cylinder", {"radius": RADIUS, "length": 10.0}), []
    exact = solve_bvp(
        lambda s, y: angles_on_cylinder(y, s), lambda a, b: np.array([a[0] - 0.3, b[1]]), share(65),
        np.stack([0.3 + 0 * share(65), 0 * share(65)]), tol=1e-10, max_nodes=10**5,
    )  # fmt: skip
    for nodes in NODES:
        direction = [[0, np.cos(0.3), np.sin(0.3)]]
        rods = BoundRods(
            cylinder, [[RADIUS, 0, 0]], direction, nodes=nodes, length=1.0, at="start", ends=("clamped", "free"),
            stiffness=BEND, intrinsic=REST, device=device,
        )  # fmt: skip
        tangent, r = relaxed(rods, 40.0).rotation[0, :, :, 0], rods.position[0]
        hoop = np.stack([-r[:, 1], r[:, 0], 0 * r[:, 0]], -1) / RADIUS
        angle = np.arctan2(tangent[:, 2], np.sum(tangent * hoop, -1))
        errors.append(np.abs(np.abs(angle) - np.abs(exact.sol(share(nodes))[0])).max())
    name = "graded filament at rest on a cylinder: angles"
    verified.order(f"{name}, order in Δs", measured=order(np.array(NODES) - 1, errors), reference="SciPy's solve_bvp")
    verified.below("exact", f"{name}, N = 64", measured=errors[-1], bound=1e-3, reference="SciPy's solve_bvp")


def test_a_graded_cantilever_bends_as_an_elastica_by_quadrature(device, verified):
    """On a plane under a load along y: (B3 (θ' − σ3))' = −f (L − s) cos θ, θ = 0 at the clamp, m3 = 0 at the tip."""
    load, errors = 4.0, []

    def slopes(s, y):
        return np.stack([sigma(s)[2] + y[1] / B(s)[2], -load * (0.5 - s) * np.cos(y[0])])

    exact = solve_bvp(
        slopes, lambda a, b: np.array([a[0], b[1]]), share(65), np.zeros((2, 65)), tol=1e-10, max_nodes=10**5
    )
    for nodes in NODES:
        rods = on_plane(nodes, device, ends=("clamped", "free"), stiffness=BEND, intrinsic=(0, 0, REST[2]))
        rods.force = [0.0, load, 0.0]
        tangent = relaxed(rods, 40.0).rotation[0, :, :, 0]
        errors.append(np.abs(np.arctan2(tangent[:, 1], tangent[:, 0]) - exact.sol(share(nodes))[0]).max())
    name = "graded cantilever under a dead load on a plane: angles"
    verified.order(f"{name}, order in Δs", measured=order(np.array(NODES) - 1, errors), reference="SciPy's solve_bvp")
    verified.below("exact", f"{name}, N = 64", measured=errors[-1], bound=1e-3, reference="SciPy's solve_bvp")


def test_a_natural_geodesic_curvature_is_taken_on_a_plane(device, verified):
    """At rest Ω = σ3(s) whatever B(s): a spiral whose curvature grows along it."""
    rods = on_plane(33, device, stiffness=(1.0, 1.0, BEND[2]), intrinsic=(0.0, 0.0, "2 + 3*s"), length=1.5)
    relaxed(rods, 200.0)
    verified.below(
        "exact", "filament at rest on a plane: Ω − σ3(s)",
        measured=np.abs(rods.strain[0, :, 2] - 2 - 3 * share(33)).max(), bound=1e-5, reference="m3 = 0",
    )  # fmt: skip


def test_a_filament_lags_behind_a_natural_curvature_that_grows(device, verified):
    """σ3 = ct on a plane, slightly bent: m'''' = −ζ⊥c/B3 with m = m' = 0 at free ends."""
    rate, errors = 1e-2, []
    for nodes in NODES:
        rods = on_plane(nodes, device, intrinsic=(0.0, 0.0, f"{rate}*t"), stiffness=(1.0, 1.0, 0.8))
        rods.step(2e-3, 60)
        lag = rods.strain[0, :, 2] - rate * rods.time
        exact = -2.0 * rate / (24 * 0.8) * (share(nodes) ** 2 - 0.25) ** 2
        errors.append(np.abs(lag - exact).max() / np.abs(exact).max())
    name = "lag of a filament behind σ3 = ct"
    verified.order(f"{name}, order in Δs", measured=order(np.array(NODES) - 1, errors), reference="−ζ⊥c(s² − ¼)²/24B3")
    verified.below("exact", f"{name}, relative, N = 64", measured=errors[-1], bound=1e-2, reference="the same")


WAVE = {
    "stiffness": ("1 + 0.3*sin(20*t)", 1.2, "0.8 + 0.3*s"),
    "intrinsic": ("0.7 + 0.5*cos(15*t)", "1 + s*sin(30*t)", "0.3 + sin(4*s - 25*t)"),
    "drag": (1.0, "2 + s", 0.3),
}
"""Waves along a filament."""


def on_torus(nodes, device=None, **given):
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    given = {"length": 1.2} | WAVE | given
    return BoundRods(torus, [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], nodes=nodes, device=device, **given)


def test_second_order_in_time_where_stiffness_and_natural_shape_change(device, verified):
    lines = []
    for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
        rods = on_torus(17, device)
        rods.step(2.5e-4, 80)  # the fast initial relaxation, with the same steps in every run
        rods.step(step, round(0.06 / step))
        lines.append(rods.position[0])
    differences = [np.abs(a - b).max() for a, b in pairwise(lines)]
    found = -np.polyfit(np.arange(3), np.log2(differences), 1)[0]
    verified.order("filament with waves of σ and B: order in Δt", measured=found, reference="Δt = 2e-3 to 2.5e-4")


def test_steps_by_error_follow_a_natural_shape_in_time(device, verified):
    rods, fine = on_torus(17, device), on_torus(17, device)
    rods.advance_to(0.1)
    fine.step(4e-4, 250)
    assert not rods.has_own_steps
    error = np.abs(rods.position - fine.position).max() / 1.2
    verified.below(
        "independent", "filament with waves of σ and B in steps by error: places over L", measured=error, bound=0.01,
        reference="250 equal steps",
    )  # fmt: skip


def test_the_energy_balance_includes_the_power_of_what_changes(verified):
    residuals = []
    for nodes in (33, 65, 129):
        rods = on_torus(nodes)
        rods.step(2e-4, 100)
        residuals.append(energy_defect(rods, 2e-5))
    name = "filament with waves of σ and B: |dE/dt + dissipation − power|"
    verified.order(f"{name}, order in Δs", measured=order([32, 64, 128], residuals), reference="N = 32, 64, 128")
    verified.below(
        "conservation", f"{name} over the dissipation, N = 128", measured=residuals[-1], bound=1e-3, reference="0"
    )


def test_a_restored_state_continues_with_the_same_bits_where_the_shape_changes(device):
    rods = on_torus(17, device)
    rods.step(1e-3, 20)
    state = rods.state()
    rods.step(1e-3, 10)
    other = on_torus(17, device)
    other.restore(state)
    np.testing.assert_array_equal(other.energy, BoundRods.energy.fget(other))
    other.step(1e-3, 10)
    np.testing.assert_array_equal(other.position, rods.position)


def test_uniform_values_at_nodes_have_the_bits_of_one_number(device):
    given = {"stiffness": (1.0, 1.2, 0.8), "intrinsic": (0.7, 1.0, 0.3), "drag": (1.0, 2.0, 0.3)}
    lines = []
    for change in (lambda v: v, lambda v: np.tile(v, (1, 17, 1)), lambda v: (v[0], f"{v[1]}", [v[2]] * 17)):
        rods = on_torus(17, device, **{name: change(values) for name, values in given.items()})
        rods.step(1e-3, 20)
        rods.advance_to(0.05)
        lines.append(rods.variables())
    for other in lines[1:]:
        for name, values in lines[0].items():
            np.testing.assert_array_equal(other[name], values)


def test_each_rod_has_its_own_values_along_it():
    s = share(17)
    rods = BoundRods(
        surfaces.make("plane", {"size": 20.0}), np.zeros((2, 3)), [[1, 0, 0]] * 2, nodes=17,
        intrinsic=[(0, "s", [*(2 * s)]), ("1 - s", 0, 3)], stiffness=(1, 1, "1 + t"),
    )  # fmt: skip
    np.testing.assert_array_equal(rods.intrinsic[0], np.stack([0 * s, s, 2 * s], -1))
    np.testing.assert_array_equal(rods.intrinsic[1], np.stack([1 - s, 0 * s, 3 + 0 * s], -1))
    assert rods.stiffness.shape == (2, 17, 3)
    assert rods.parameters(1)["intrinsic"][0] == [1.5, 0.0, 3.0]


def test_rows_for_another_number_of_rods_are_refused_with_parameters_too():
    rows = [["k*s", 0.0, 0.0], ["2*k*s", 0.0, 0.0], ["3*k*s", 0.0, 0.0]]
    for k in (1.0, [1.0, 2.0]):
        with pytest.raises(SceneError, match="intrinsic: has entries for 3 rods; give one, or 2"):
            along_rods({"intrinsic": rows}, 2, 17, False, {"k": np.broadcast_to(k, 2)})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"stiffness": (1, "s", 1)}, r"stiffness\[1\] = -0.5: must be positive"),
        ({"stiffness": ("1/s", 1, 1)}, r"stiffness\[0\]: a formula has no finite value at t = 0"),
        ({"intrinsic": (0, "x", 0)}, r"intrinsic\[1\] = 'x': column 1: x is not known here"),
        ({"intrinsic": (0, [1.0] * 9, 0)}, r"intrinsic\[1\]: must be .* has shape \(1, 9\), for 1 rods of 17 nodes"),
        ({"intrinsic": np.zeros((1, 9, 3))}, r"intrinsic: must be three components.* has shape \(1, 9, 3\)"),
        ({"intrinsic": [(0, "s", 0)] * 2}, "intrinsic: has entries for 2 rods; give one, or 1"),
        ({"drag": (1, 1, [-1.0] * 17)}, r"drag\[2\] = -1: must be zero or more"),
        ({"intrinsic": (0, "s", 0), "growth": {"rate": 1, "until": 2}}, "intrinsic: must be uniform along filaments"),
    ],
)
def test_wrong_values_are_named(given, message):
    with pytest.raises(SceneError, match=message):
        on_plane(17, **given)


def test_a_stiffness_that_becomes_negative_is_named():
    rods = on_plane(17, stiffness=(1, 1, "1 - 10*t"))
    with pytest.raises(SceneError, match=r"stiffness\[2\] at t = 0\.1.* must be positive"):
        rods.step(1e-2, 20)


def test_growing_filaments_may_change_in_time():
    rods = on_plane(17, growth={"rate": 1.0, "until": 1.6, "spacing": 0.09}, intrinsic=(0, 0, "t"))
    rods.step(1e-2, 60)
    assert rods.nodes == 33
    np.testing.assert_allclose(rods.strain[0, [0, -1], 2], 0.6, rtol=1e-12)
