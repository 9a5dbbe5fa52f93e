"""Fixed shapes of swimmers: zeros of the equations of the time stepper, known answers, eigenvalues."""

import re

import numpy as np
import pytest
from examples.free import in_space, slope
from reference.steady_s import rigid_body_rate, turning_rate
from reference.steady_u import amplitude_and_speed

from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import coefficients
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.loop import Simulation
from warp_rods.theory.floquet import asymmetric_exponents
from warp_rods.theory.steady import FixedShape, Swimmer, at_rest, settled, start
from warp_rods.theory.steady_equations import Equations
from warp_rods.theory.twisted_stability import growth_rates

ROTATING = {"bend": 2e-4, "twist": 1e-3, "moment": 2e-3}
"""A swimmer whose bent shape rotates about its own tangent."""


def symmetric_u(nodes, bend):
    swimmer = Swimmer(nodes, {"bend": bend, "twist": 1e-3}, symmetric=True)
    return settled(swimmer, {"kind": "mode", "amplitude": 3.0}, time=6.0)


@pytest.fixture(scope="module")
def rotating():
    """A fixed shape in space without symmetry."""
    swimmer = Swimmer(65, ROTATING, planar=False)
    s = np.linspace(-0.5, 0.5, 65)
    k = 3 * np.cos(np.pi * s) ** 2 * np.exp(2j * s) + np.sin(2 * np.pi * s)
    return settled(swimmer, np.stack([0 * s, k.real, k.imag], axis=-1), time=12.0)


def test_rates_are_those_of_the_ensemble():
    rods = in_space("cpu")
    rates = rods.rates()
    swimmer = Swimmer(65, rods.parameters(0), planar=False)
    equations = Equations(swimmer)
    state = equations.state(start(swimmer, rods.strain[0], rods.activity[0]).fields)
    fields = equations.fields(equations.rates(state[None], swimmer.parameters))[0]
    # Round-off of k, amplified by ∂⁴.
    round_off = np.finfo(float).eps * 16 * swimmer.parameters["bend"] / 2 * 64**4 * abs(rates["bending"]).max()
    found = {"bending_rate": fields[0] + 1j * fields[1], "twist_rate": fields[2], "activity_rate": fields[3]}
    for name, values in found.items():
        np.testing.assert_allclose(values, rates[name][0], atol=round_off, rtol=0)


def test_symmetric_shapes_stay_symmetric():
    """The rates of a symmetric shape are symmetric, so that half of the unknowns are enough."""
    half, whole = (Equations(Swimmer(65, ROTATING, planar=False, symmetric=symmetric)) for symmetric in (True, False))
    state = np.cos(np.arange(half.basis.shape[1]) ** 2.0)
    rate = half.rates(state[None], half.swimmer.parameters)
    same = whole.rates(whole.state(half.fields(state[None])[0])[None], half.swimmer.parameters)
    np.testing.assert_allclose(half.fields(rate), whole.fields(same), atol=1e-12 * abs(rate).max(), rtol=0)
    assert abs(2 * half.basis.shape[1] - whole.basis.shape[1]) <= 2


def test_the_jacobian_is_the_derivative_of_the_rates():
    swimmer = Swimmer(33, ROTATING, planar=False)
    equations = Equations(swimmer)
    state, along = np.cos(np.arange(equations.basis.shape[1])), np.sin(np.arange(equations.basis.shape[1]) ** 1.5)
    _, jacobian, _ = equations.linearise(state, swimmer.parameters)
    near = equations.rates(state + np.array([[1e-4], [-1e-4]]) * along, swimmer.parameters)
    slopes = (near[0] - near[1]) / 2e-4
    np.testing.assert_allclose(jacobian @ along, slopes, atol=1e-7 * abs(slopes).max(), rtol=0)


@pytest.mark.parametrize("bend", [5e-3, 1e-3])
def test_the_steady_u_converges_at_second_order_to_the_solution_of_a_boundary_value_problem(bend, verified):
    """a₀ and |U|."""
    shapes = [symmetric_u(nodes, bend) for nodes in (33, 65, 129)]
    found = np.array(
        [[coefficients(u.curvature, np.linspace(-0.5, 0.5, u.swimmer.nodes), 1)[0], u.speed] for u in shapes]
    )
    limit = found[2] + (found[2] - found[1]) / 3
    verified(
        "independent", f"steady U at β⊥ = {bend:g} by Newton's method: a₀ and speed", measured=limit,
        expected=amplitude_and_speed(bend), within=1e-5,
        reference="boundary value problem of half a rod by SciPy's `solve_bvp` (tests/reference/steady_u.py)",
    )  # fmt: skip
    verified.order(
        f"steady U at β⊥ = {bend:g}: order in Δs of a₀", measured=slope([32, 64], np.abs(np.diff(found[:, 0]))),
        reference="N = 32, 64, 128",
    )  # fmt: skip
    for u in shapes:
        equations = Equations(u.swimmer)
        rates = equations.rates(equations.state(u.fields)[None], u.swimmer.parameters)
        assert np.abs(rates).max() < 1e-11 * bend * (u.swimmer.nodes - 1) ** 4


@pytest.fixture(scope="module")
def rotor():
    """The planar S at β⊥ = 2.5e-3 on two grids; it has the symmetry about the axis about which it turns."""
    parameters = {"bend": 2.5e-3, "twist": 1e-3}
    swimmers = [Swimmer(nodes, parameters, planar=False, symmetric=True) for nodes in (33, 65)]
    return [settled(swimmer, {"bend1": "15*sin(2*pi*s)"}, time=3.0) for swimmer in swimmers]


def test_the_s_turns_at_the_rate_of_a_boundary_value_problem(rotor, verified):
    exact, found = turning_rate(2.5e-3), np.array([s.angular_speed for s in rotor])
    verified(
        "independent", "planar S at β⊥ = 2.5e-3 by Newton's method: |ω|", measured=(4 * found[1] - found[0]) / 3,
        expected=exact, within=2e-4, reference="boundary value problem by `solve_bvp` (tests/reference/steady_s.py)",
    )  # fmt: skip
    verified.order("planar S: order in Δs of ω", measured=slope([32, 64], abs(found - exact)), reference="N = 32, 64")
    assert all(not s.fields[1:3].any() and s.speed < 1e-12 for s in rotor)
    balance = [rigid_body_rate(s.fields[0], s.activity) for s in rotor]
    verified(
        "independent", "planar S: |ω| of a rigid body of its shape and f", measured=(4 * balance[1] - balance[0]) / 3,
        expected=exact, within=5e-4, reference="the same boundary value problem",
    )  # fmt: skip


def test_angular_speed_is_that_of_a_simulation(rotating, verified):
    """Of a shape in space, which also rotates about its tangent: from the places of its nodes."""
    rods = rotating.rods()
    arms = []
    for _ in range(2):
        places = rods.position[0].astype(float)
        arms.append(places - places.mean(axis=0))
        rods.step(1e-3, 100)
    u, _, vt = np.linalg.svd(arms[0].T @ arms[1])
    turned = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ vt))]) @ vt
    verified(
        "independent", "fixed shape in space: |ω|", measured=rotating.angular_speed,
        expected=np.arccos((np.trace(turned) - 1) / 2) / 0.1, relative=2e-3, reference="a simulation, Δt = 1e-3",
    )  # fmt: skip


def test_what_the_symmetry_hides_grows_at_the_rate_of_its_eigenvalue(rotor, verified):
    """Perturbations without the symmetry, in a run that does not impose it; without them the S stays."""
    shape = rotor[1]
    leading = shape.released().eigenvalues(1)[0]
    assert leading.real > 30 and shape.eigenvalues(1)[0].real < 4
    s = np.linspace(-0.5, 0.5, 65)
    bent = 1e-8 * np.cos(np.pi * s) ** 2 * np.array([[1.0], [0.0], [0.0], [0.0]])
    rods = FixedShape(shape.released().swimmer, shape.fields + bent).rods()
    sizes = []
    for _ in range(16):
        rods.step(2e-4, 100)
        k = rods.rates()["bending"][0].real
        sizes.append(abs(k + k[::-1]).max())
    assert 1e-6 < sizes[-1] < 1e-2
    verified(
        "independent", "planar S without its symmetry: growth rate",
        measured=np.polyfit(0.02 * np.arange(10), np.log(sizes[6:]), 1)[0], expected=leading.real, relative=0.01,
        reference="Re μ of the Jacobian; Δt = 2e-4",
    )  # fmt: skip
    exponents = asymmetric_exponents(shape.swimmer, np.array(3 * [shape.fields]), 0.06, 1)
    np.testing.assert_allclose(exponents, leading, rtol=1e-6)  # of a motion that is periodic in any time


def test_a_cycle_without_the_symmetry_is_refused(rotor):
    with pytest.raises(SceneError, match="cycle: must have the symmetry"):
        asymmetric_exponents(rotor[0].swimmer, rotor[0].fields[None] + 0.1, 1.0)


def test_a_fixed_shape_in_space_only_rotates(rotating, verified):
    """A simulation from the shape keeps k exp(−iΩt), τ and f up to second order in Δt; Ω is of order one."""
    assert abs(rotating.spin) == pytest.approx(0.45, abs=0.05)
    turned, errors, steps = rotating.bending * np.exp(0.5j * rotating.spin), [], np.array([125, 250, 500])
    for number in steps:
        rods = rotating.rods()
        rods.step(0.5 / number, number)
        later = rods.rates()
        kept = ((later["bending"], turned), (later["twist"], rotating.twist), (later["activity"], rotating.activity))
        errors.append(max(abs(now[0] - then).max() for now, then in kept))
    verified.below(
        "independent", "fixed shape in space, after half a unit of time: k exp(−iΩt), τ, f", measured=errors[-1],
        bound=1e-5, reference="Newton's method; Δt = 1e-3",
    )  # fmt: skip
    verified.order("fixed shape in space: order in Δt", measured=slope(steps, errors), reference="Newton's method")


def test_only_the_neutral_mode_of_rotation_is_dropped(rotating):
    equations = Equations(rotating.swimmer)
    state = equations.state(rotating.fields)
    jacobian = equations.linearise(state, rotating.swimmer.parameters)[1] - rotating.spin * equations.rotation.toarray()
    everything = np.linalg.eigvals(jacobian)
    kept = rotating.eigenvalues(len(state))
    assert len(kept) == len(state) - 1
    neutral = np.argmin(abs(everything))
    assert abs(everything[neutral]) < 1e-6
    leading = np.delete(everything, neutral)
    leading = leading[np.argsort(-leading.real)][:6]
    np.testing.assert_allclose(np.sort_complex(leading), np.sort_complex(kept[:6]), rtol=1e-5)


def test_a_rotated_shape_is_an_equivalent_fixed_shape(rotating, verified):
    turned = rotating.bending * np.exp(0.7j)
    fields = np.stack([turned.real, turned.imag, rotating.twist, rotating.activity])
    again = at_rest(FixedShape(rotating.swimmer, fields))
    np.testing.assert_allclose(again.bending, turned, atol=1e-7)
    verified(
        "symmetry", "fixed shape turned about its tangent: spin and speed", measured=[again.spin, again.speed],
        expected=[rotating.spin, rotating.speed], relative=1e-7, reference="those before",
    )  # fmt: skip
    np.testing.assert_allclose(again.eigenvalues(4).real, rotating.eigenvalues(4).real, rtol=1e-5)


def test_a_straight_twisted_rod_has_its_known_growth_rates(verified):
    s = np.linspace(-0.5, 0.5, 65)
    parameters = {"bend": 2e-3, "twist": 1e-3, "moment": 1e-2}
    swimmer = Swimmer(65, parameters, planar=False, held=tuple(-np.tanh(10 * s)))
    twist = 10 * (np.log(np.cosh(10 * s)) - np.log(np.cosh(5.0))) / 10
    straight = at_rest(start(swimmer, np.stack([twist, 0 * s, 0 * s], axis=-1), -np.tanh(10 * s)))
    known = growth_rates(**parameters, nodes=65, count=4)
    verified(
        "independent", "straight twisted rod: leading eigenvalues of the Jacobian",
        measured=np.sort(straight.eigenvalues(4).real), expected=np.sort(known.real), relative=2e-3,
        reference="linear theory of a twisted rod (`growth_rates`)",
    )  # fmt: skip


def test_a_swimmer_from_a_scene_has_the_parameters_of_its_rod():
    table = SwimmersTable(
        name="cells", count=2, nodes=65, bend=[1e-3, 2e-3], twist=1e-3, flagella={"diffusion": [1e-3, 2e-3]}
    )
    swimmer = Swimmer.of(table, 1)
    assert (swimmer.planar, swimmer.parameters["bend"], swimmer.parameters["diffusion"]) == (True, 2e-3, 2e-3)
    assert Swimmer.of(table, planar=False).planar is False


@pytest.mark.parametrize("given", [
    Swimmer(65, {"bend": 5e-3, "twist": 1e-3}, symmetric=True),
    Swimmer(33, {"bend": 4e-3, "twist": 1e-3, "drag_ratio": 1.7, "relaxation": 2e-2, "diffusion": 2e-3}),
    Swimmer(65, {"bend": 5e-3, "twist": 1e-3}, symmetric=True, held=tuple(-np.tanh(8 * np.linspace(-0.5, 0.5, 65)))),
], ids=["symmetric", "other parameters", "held"])  # fmt: skip
def test_a_fixed_shape_written_as_a_scene_stays_there(given, tmp_path, verified, request):
    """It starts from exactly that shape; the drift of its strains over a time 0.1 is round-off."""
    shape = settled(given, {"kind": "mode", "amplitude": 3.0}, time=8.0)
    simulation = Simulation(Scene.load(shape.write_scene(tmp_path / "u.toml", end=0.1)), "cpu")
    rods = simulation.ensembles["cell"]
    start = rods.strain
    np.testing.assert_array_equal(start, shape.rods().strain)
    np.testing.assert_array_equal(rods.activity[0], shape.activity)
    # The law of held flagella has no diffusion.
    same = [name for name in given.parameters if name != "diffusion" or given.held is None]
    assert [rods.parameters(0)[name] for name in same] == [given.parameters[name] for name in same]
    for _ in simulation.advance():
        pass
    assert simulation.finished and np.abs(start).max() > 0.5
    verified.below(
        "independent", f"fixed shape ({request.node.callspec.id}) as a scene: drift of strains in a time of 0.1",
        measured=np.abs(rods.strain - start).max(), bound=1e-9, reference="Newton's method",
    )  # fmt: skip


def test_a_scene_of_a_fixed_shape_stands_beside_its_shape(tmp_path):
    shape = symmetric_u(33, 5e-3)
    for path, said in ((tmp_path / "u.txt", "must end in .toml"), (tmp_path / "no" / "u.toml", "there is no folder")):
        with pytest.raises(SceneError, match=said):
            shape.write_scene(path)
    path = shape.write_scene(tmp_path / "u.toml", name="u")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["u.npz", "u.toml"]
    path.write_text(path.read_text().replace("nodes = 33", "nodes = 65"))
    rods = Simulation(Scene.load(path), "cpu").ensembles["u"]  # resampled
    np.testing.assert_allclose(rods.strain[0, ::2], shape.rods().strain[0], rtol=0, atol=1e-12)


def test_impossible_arguments_are_refused():
    with pytest.raises(SceneError, match="planar = False"):
        Swimmer(65, {"bend": 1e-3, "twist": 1e-3, "moment": 1e-3})
    with pytest.raises(SceneError, match="bending, twist"):
        Swimmer(65, {"bending": 1e-3, "bend": 1e-3})
    swimmer = Swimmer(65, {"bend": 1e-3, "twist": 1e-3})
    with pytest.raises(SceneError, match="at 33 nodes"):
        start(swimmer, np.zeros((33, 3)), np.zeros(33))
    with pytest.raises(ArithmeticError, match="start closer"):
        at_rest(FixedShape(swimmer, 50 * np.cos(np.arange(260.0)).reshape(4, 65)))


def test_swimmers_with_what_is_not_in_the_equations_are_refused():
    """Instead of the fixed shapes of another law; from the parameters of rods."""
    driven = {"law": "driven", "front": 1.0, "back": -1.0}
    made = [
        ({"flagella": driven}, 'flagella.law = "driven": fixed shapes are found for the laws relaxing, held only'),
        ({"flagella": {"law": "held"}}, 'flagella.law = "held": needs held'),
        ({"bend": "1e-3*(2 + s)"}, "bend: fixed shapes are found for uniform swimmers"),
    ]
    for given, said in made:
        rods = FreeRods(1, 17, **{"bend": 1e-3, "twist": 1e-3, **given}, device="cpu")
        with pytest.raises(SceneError, match=re.escape(said)):
            Swimmer(17, rods.parameters(0))
    rods = FreeRods(1, 17, bend=1e-3, twist=1e-3, flagella=driven, behaviour={"reversal": {"rate": 1.0}}, device="cpu")
    parameters = rods.parameters(0) | {"flagella": {"law": "relaxing"}}
    with pytest.raises(SceneError, match="behaviour: fixed shapes are found for uniform"):
        Swimmer(17, parameters)
