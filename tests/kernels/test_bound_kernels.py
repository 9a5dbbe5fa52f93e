"""Kernels of surface-bound filaments, stage by stage and in whole steps, against the NumPy twin."""

import numpy as np
import pytest
import warp as wp
from examples.bound import (
    LENGTH,
    TWINS,
    compatible_turn,
    order,
    random_filaments,
    read,
    smooth_filaments,
    start_frame,
    trace,
    twin_rod,
    twin_state,
)
from examples.contact_steps import lengths_of_steps, take_one
from numpy.polynomial import Chebyshev
from reference import bound as twin
from reference.bound_step import angle_operators, rebuild, start, state_of, step

from warp_rods.kernels.bound.angles import find_turn_to_velocity, set_angle_rows
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.lanes import Lanes
from warp_rods.kernels.layout import real
from warp_rods.rods.tiles import Tiled

NODES = 33
KINDS = ("torus", "cassini")
ALL = (*((kind,) for kind in KINDS), *((kind, "graded") for kind in KINDS))
"""Uniform rods, and rods whose parameters change along them."""
ROUND_OFF = 1e-13
SOLVED = 1e-12
"""Round-off, relative to the largest value, of a field that follows from a banded system or from differences in s."""


def close(ours, theirs, tolerance):
    """Agreement relative to the largest value of the field."""
    assert np.abs(ours - theirs).max() <= tolerance * np.abs(theirs).max()


@pytest.fixture(params=ALL, ids=" ".join)
def evaluated(request, device):
    """Rods in a random state with their velocities, and the parameters, state and motion of the twin of each."""
    kind, along = request.param[0], len(request.param) > 1
    rods = random_filaments(kind, NODES, device, along=along)
    rods.evaluate()
    cases = [(twin_rod(kind, b, NODES, along), twin_state(rods, b)) for b in range(rods.count)]
    return rods, [(rod, state, twin.evaluate(rod, state, f)) for (rod, state), f in zip(cases, rods.force, strict=True)]


STAGES = {
    "curvature": ("curvature", ROUND_OFF),
    "moment": ("moment", ROUND_OFF),
    "transverse_force": ("transverse_force", SOLVED),
    "tension": ("tension", SOLVED),
    "velocity_along": ("along", SOLVED),
    "geodesic_rate": ("rate", SOLVED),
}
"""Name in the kernels → name in the twin, and tolerance."""


def test_geodesic_rate_agrees_with_twin(evaluated, request, verified):
    """The last stage, into which all others go."""
    rods, twins = evaluated
    ours = read(rods, "geodesic_rate")
    errors = [np.abs(ours[b] - motion.rate).max() / np.abs(motion.rate).max() for b, (_, _, motion) in enumerate(twins)]
    kind = " ".join(request.node.callspec.params["evaluated"])
    verified.below(
        "independent", f"filaments on {kind}: ∂tΩ, relative", measured=errors, bound=SOLVED,
        reference="the same equations in NumPy (tests/reference/bound.py), symbolic surface",
    )  # fmt: skip


@pytest.mark.parametrize("name", STAGES)
def test_stage_agrees_with_twin(evaluated, name):
    rods, twins = evaluated
    name_in_twin, tolerance = STAGES[name]
    for b, (_rod, _state, motion) in enumerate(twins):
        theirs = getattr(motion, name_in_twin)
        close(read(rods, name)[b, : len(theirs)], theirs, tolerance)


def test_velocity_across_agrees_with_twin(evaluated):
    rods, twins = evaluated
    for b, (_rod, _state, motion) in enumerate(twins):
        close(read(rods, "velocity_across")[b], motion.velocity[:, 1], SOLVED)


def test_energy_and_dissipation_agree_with_twin(evaluated):
    rods, twins = evaluated
    ours = rods.variables()
    for b, (rod, state, motion) in enumerate(twins):
        density = twin.energy_density(rod, state, motion)
        close(ours["energy_density"][b], density, SOLVED)
        close(ours["energy"][b], twin.total(density, rod.spacing), SOLVED)
        close(ours["dissipation"][b], twin.dissipation(rod, motion), SOLVED)


def test_load_agrees_with_twin(evaluated):
    rods, twins = evaluated
    ours, force = rods.variables()["load"], rods.force
    for b, (rod, state, motion) in enumerate(twins):
        close(ours[b], twin.membrane_load(rod, state, motion, force[b]), SOLVED)


@wp.kernel
def angle_rows(f: Filaments, systems: Systems, rate: real):
    """Rows of a − J of a tile."""
    tile = wp.tid()
    find_turn_to_velocity(f, tile, systems.weights)
    set_angle_rows(f, tile, Lanes(rate), systems)


def test_implicit_matrix_agrees_with_twin(evaluated, device):
    """a − J of the angle at half nodes, for a = 1500."""
    rods, twins = evaluated
    a, systems = 1500.0, rods._arrays.systems
    wp.launch(angle_rows, rods._arrays.tiles, inputs=[rods._f, systems, a], device=device)
    names = ("lower2", "lower", "diagonal", "upper", "upper2")
    bands = [Tiled(getattr(systems, name), rods.count).numpy() for name in names]
    for b, (rod, _state, motion) in enumerate(twins):
        _to_nodes, to_velocity = angle_operators(rod, motion.curvature)
        matrix = a * np.eye(NODES - 1) - np.diff(to_velocity, axis=0) / rod.spacing
        for offset, band in zip(range(-2, 3), bands, strict=True):
            rows = np.arange(max(0, -offset), NODES - 1 - max(0, offset))
            close(band[b, rows], matrix[rows, rows + offset], ROUND_OFF)
            matrix[rows, rows + offset] = 0.0
        assert not matrix.any()


def apart(ours, theirs):
    """Relative differences; round-off of a few steps, each of which solves a system with stiffness of order Δs⁻⁴."""
    return [
        np.abs(getattr(ours, name) - getattr(theirs, name)).max() / np.abs(getattr(theirs, name)).max()
        for name in ("geodesic", "rotation", "position")
    ]


@pytest.mark.parametrize("case", [*ALL[:2], ALL[2]], ids=" ".join)
def test_steps_agree_with_twin(case, device, verified):
    """The first step of first order, then steps of second order that grow, are equal, and change."""
    kind, along = case[0], len(case) > 1
    rods = random_filaments(kind, NODES, device, along=along)
    cases = [twin_rod(kind, b, NODES, along) for b in range(rods.count)]
    pasts = [start(rod, twin_state(rods, b)) for b, rod in enumerate(cases)]
    force, errors = rods.force.copy(), []
    for dt in (*lengths_of_steps(rods, 1e-3, 2), 1.7e-3, 6e-4, 6e-4):
        take_one(rods, dt)
        rods.show()
        for b, rod in enumerate(cases):
            pasts[b] = step(rod, pasts[b], pasts[b].times[0] + dt, force[b])
            errors += apart(twin_state(rods, b), state_of(rod, pasts[b]))
    assert not rods.status.any()
    verified.below(
        "independent", f"filaments on {' '.join(case)}: Ω, frames and places over steps that change, relative",
        measured=errors, bound=1e-11, reference="the same steps in NumPy",
    )  # fmt: skip


@pytest.fixture(scope="module")
def refined(device):
    """Rods of one smooth shape on the torus with three spacings, and Ω(s) of the shape."""
    turns = [compatible_turn("torus", rod) for rod in range(len(LENGTH))]
    return turns, {nodes: smooth_filaments("torus", nodes, device, turns) for nodes in (17, 33, 65)}


def test_two_sweeps_reach_the_fixed_point_beyond_the_order_of_the_scheme(refined, verified):
    """Further iteration of (D.81), (D.82) changes the frames in fifth order; the scheme is of second order."""
    _turns, runs = refined
    errors = []
    for nodes, rods in runs.items():
        worst, m = 0.0, nodes // 2
        for b in range(rods.count):
            ours = twin_state(rods, b)
            whole = rebuild(twin_rod("torus", b, nodes), ours.geodesic, m, ours.rotation[m], ours.position[m], sweeps=6)
            worst = max(worst, np.abs(ours.position - whole.position).max())
        errors.append(worst)
    assert order([nodes - 1 for nodes in runs], errors) == pytest.approx(5.0, abs=0.2)
    verified.below(
        "independent", "filament laid out by two sweeps, N = 64: places", measured=errors[-1], bound=1e-8,
        reference="the fixed point of (D.81), (D.82), six sweeps in NumPy",
    )  # fmt: skip


def test_rebuilding_follows_the_curve_to_second_order(refined, verified):
    """Against (5.46) integrated to round-off for the same Ω(s)."""
    turns, runs = refined
    errors = []
    for nodes, rods in runs.items():
        x = np.linspace(-1, 1, nodes)
        found = [0.0, 0.0]
        for b, half in enumerate(LENGTH / 2):
            geodesic = Chebyshev(turns[b].coef, domain=[-half, half])
            curve = trace(TWINS["torus"], geodesic, *start_frame("torus", b), half * x)
            ours = twin_state(rods, b)
            errors_of = (ours.position - curve[0], ours.rotation[:, :, 0] - curve[1])
            found = [max(worst, np.abs(e).max()) for worst, e in zip(found, errors_of, strict=True)]
        errors.append(found)
    verified.order(
        "filament laid out on a torus: order in Δs of places and tangents",
        measured=order([nodes - 1 for nodes in runs], errors), reference="(5.46) by SciPy's DOP853, two filaments",
    )  # fmt: skip
