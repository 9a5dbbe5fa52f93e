"""The codes that benchmarks compare with solve the same equations: their rates and forces against twins."""

import numpy as np
import pytest
from reference import free

from warp_rods import BoundRods, FreeRods, surfaces
from warp_rods.bench.peers import chain, dissertation, in_space, loops, planar, planar_steps
from warp_rods.bench.precision import front, time_at
from warp_rods.bench.swimmer_problem import QUICK, Problem, error

NODES = 17
SWIMMER = planar.Swimmer(bend=3e-3, drag_ratio=1.7, relaxation=2e-2, diffusion=3e-3)
PARAMETERS = free.Parameters(bend=3e-3, twist=in_space.TWIST, drag_ratio=1.7, relaxation=2e-2, diffusion=3e-3)


def rates_of(bending, twist, activity):
    """The twin's rates of one rod."""
    shape = free.Shape(bending[None], twist[None], activity[None])
    found = free.evaluate(shape, PARAMETERS, 1 / (len(twist) - 1))
    return found.bending[0], found.twist[0], found.activity[0]


def symmetric_shape():
    """κ even and f odd in s, of no special form; κ = 0 at the ends."""
    s = np.linspace(-0.5, 0.5, NODES)
    return (1 + s**2) * np.cos(np.pi * s) ** 2 * 4, np.sin(2.3 * s) - 0.3 * s**3


def test_rates_of_the_planar_half_are_those_of_the_twin():
    curvature, activity = symmetric_shape()
    bending, _, active = rates_of(1j * curvature, np.zeros(NODES), activity)
    half = NODES // 2
    y = planar.packed(curvature[half:], activity[half:])
    found = planar.rates(y, *SWIMMER, np.empty(half + 1), False)
    expected = planar.packed(bending.imag[half:], active[half:])
    assert abs(found - expected).max() < 1e-10 * abs(expected).max()


def test_rates_in_space_are_those_of_the_twin():
    rng = np.random.default_rng(3)
    k, twist, f = rng.normal(size=NODES) + 1j * rng.normal(size=NODES), rng.normal(size=NODES), rng.normal(size=NODES)
    k[[0, -1]] = twist[[0, -1]] = 0
    found = in_space.rates(in_space.joined(k, twist, f), SWIMMER, NODES)
    expected = in_space.joined(*rates_of(k, twist, f))
    assert abs(found - expected).max() < 1e-10 * abs(expected).max()


def test_the_banded_jacobian_is_the_whole_one_at_given_tension():
    """Without bending the tension does not change with the curvature, and both are the same."""
    y = planar.packed(np.zeros(NODES // 2 + 1), symmetric_shape()[1][NODES // 2 :])
    passive = SWIMMER._replace(bend=1e-3)
    whole, packed = planar.dense_jacobian(y, *passive), planar.banded_jacobian(y, *passive)
    curvatures = slice(0, None, 2)  # f changes the tension, κ does not at κ = 0
    for offset in range(-planar.WIDTH, planar.WIDTH + 1):
        columns = np.arange(len(y))[curvatures]
        columns = columns[(columns + offset >= 0) & (columns + offset < len(y))]
        found, expected = packed[planar.WIDTH + offset, columns], whole[columns + offset, columns]
        assert abs(found - expected).max() < 1e-4 * abs(whole).max()


@pytest.mark.parametrize("method", planar.METHODS)
def test_every_method_of_the_expert_finds_the_same_motion(method):
    problem = Problem(1e-3, QUICK)
    found = planar.solve(problem.swimmer, problem.half, problem.times, method, 1e-5)
    assert error(found, problem.exact()) < 1e-3


def test_the_dissertations_method_is_of_second_order_and_ours_finds_its_limit():
    problem = Problem(1e-2, QUICK)
    exact = problem.exact()
    coarse, fine = (
        error(dissertation.solve(problem.swimmer, problem.half, problem.times, dt), exact) for dt in (5e-3, 2.5e-3)
    )
    assert 1.8 < np.log2(coarse / fine) < 2.2
    rods = problem.rods(1)
    found = []
    for time in problem.times:
        rods.advance_to(time, 1e-4)
        found.append(rods.strain[0, problem.nodes // 2 :, 2])
    assert error(np.array(found), exact) < 1e-4


@pytest.mark.parametrize("membrane", [(1.2, 0.0), (1.0, 1.1)])
def test_forces_of_a_chain_are_derivatives_of_its_energy(membrane):
    a, b = membrane
    made = chain.Chain(a, b, (0.7, 1.1, 0.9), (0.3, 1.5, -0.4), (1.0, 2.0), 0.06, 50.0, 0.0)
    s = np.linspace(0, 0.4, 8)
    x = np.stack([0.5 + 0.1 * s, s, 0.2 + 0.3 * s**2], axis=1)

    def energy(x):
        bent = sum(chain.bending(tuple(p), tuple(q), tuple(r), made) for p, q, r in zip(x, x[1:], x[2:], strict=False))
        stretch = np.linalg.norm(np.diff(x, axis=0), axis=1) / made.spacing - 1
        return made.spacing * (bent + made.stretch / 2 * (stretch**2).sum())

    force = np.empty_like(x)
    chain.forces(x, made, force)
    expected = np.zeros_like(x)
    for place in np.ndindex(x.shape):
        for sign in (-1, 1):
            near = x.copy()
            near[place] += sign * 1e-5
            expected[place] -= sign * energy(near) / 2e-5
    assert abs(force - expected).max() < 1e-7 * abs(expected).max()


def test_a_chain_with_stiff_penalties_moves_as_a_filament_does():
    sphere = surfaces.make("sphere", {"radius": 1.0})
    rods = BoundRods(sphere, [[1.0, 0, 0]], [[0, 1.0, 0.3]], nodes=9, intrinsic=(0, 0, 2.0), drag=(1, 2, 1e-5))
    start = rods.position[0]
    rods.advance_to(0.05)
    made = chain.Chain(1.0, 0.0, (1.0, 1.0, 1.0), (0.0, 0.0, 2.0), (1.0, 2.0), 1 / 8, 1e4, 1e6)
    found = chain.solve(start, made, 0.05, 1e-4)
    moved = np.linalg.norm(found - start, axis=1).max()
    assert moved > 0.1 and np.linalg.norm(found - rods.position[0], axis=1).max() < 0.02 * moved


def test_loops_solve_what_ours_solve():
    rng = np.random.default_rng(4)
    rows, right = rng.normal(size=(5, 2, 9)), rng.normal(size=(2, 9))
    rows[2] += 8
    found, work = np.empty((2, 9)), np.empty(9)
    loops.pentadiagonal(rows, right, work, work.copy(), found)
    for rod in range(2):
        matrix = sum(np.diag(rows[j, rod][max(0, 2 - j) : 9 - max(0, j - 2)], j - 2) for j in range(5))
        assert abs(matrix @ found[rod] - right[rod]).max() < 1e-12
    loops.tridiagonal(rows[1:4], right, work, None, found)
    for rod in range(2):
        matrix = sum(np.diag(rows[j, rod][max(0, 2 - j) : 9 - max(0, j - 2)], j - 2) for j in range(1, 4))
        assert abs(matrix @ found[rod] - right[rod]).max() < 1e-12


def test_frames_of_the_loops_are_those_of_a_rod():
    rods = FreeRods(1, 17, bend=1e-3, twist=1e-3, shape={"kind": "mode", "amplitude": 3.0})
    R, r = rods.rotation.copy(), rods.position.copy()
    expected = r.copy()
    strain = np.stack([0 * rods.strain[..., 0], *np.moveaxis(rods.strain[..., 1:], -1, 0)], axis=-1)
    loops.frames(strain, 1 / 16, R, r)
    assert abs(r - expected).max() < 1e-12


def test_pyelastica_swims_as_we_do():
    pytest.importorskip("elastica")
    from warp_rods.bench.swimmer_elastica import runs

    found = runs(Problem(1e-3, QUICK))
    assert len(found) == 1 and found[0].error < 0.05


def test_times_at_an_error_lie_between_runs_by_powers():
    errors, seconds = [1e-2, 1e-4, 3e-3], [1.0, 100.0, 200.0]
    assert time_at(errors, seconds, 1e-3) == pytest.approx(10.0)
    assert time_at(errors, seconds, 1e-1) == 1.0 and time_at(errors, seconds, 1e-5) is None
    assert time_at([], [], 1e-3) is None and time_at([np.inf], [1.0], 1e-3) is None
    assert [list(column) for column in front(errors, seconds)] == [[1e-2, 1e-4], [1.0, 100.0]]


def test_steps_in_loops_are_of_second_order():
    problem = Problem(1e-2, QUICK)
    exact = problem.exact()
    errors = [
        error(planar_steps.solve(problem.swimmer, problem.half, problem.times, dt), exact) for dt in (2.5e-3, 1.25e-3)
    ]
    assert errors[0] < 1e-3 and 1.8 < np.log2(errors[0] / errors[1]) < 2.2
