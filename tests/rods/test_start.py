"""Steps of a given length keep second order on rough starts, and on starts that contradict the ends of the rods."""

import numpy as np
import pytest
from examples.free import in_space, slope

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods

ORDER = pytest.approx(2, abs=0.2)
END = 0.1
LENGTHS = np.array([1e-3, 5e-4, 2.5e-4, 1.25e-4])
NODES = 33
HIGH_MODES = np.random.default_rng(0).normal(size=NODES)
S = np.linspace(0, 1, NODES)


def on_torus(turn, **given) -> BoundRods:
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    parameters = {"length": 1.2, "intrinsic": (0.5, 0.8, 2.0), "drag": (1.0, 2.0, 0.3)} | given
    return BoundRods(torus, [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], nodes=NODES, geodesic_curvature=turn, **parameters)


def on_plane(turn) -> BoundRods:
    plane = surfaces.make("plane", {})
    return BoundRods(plane, [[0, 0, 0]], [[1, 0, 0]], nodes=NODES, geodesic_curvature=turn, drag=(1.0, 2.0, 0.3))


STARTS = {
    "ends jump to their rest curvature": lambda: on_torus(0.0, intrinsic=(0.5, 0.8, 3.0)),
    "high modes": lambda: on_torus(HIGH_MODES, intrinsic=(0.5, 0.8, 0.0)),
    "bent on a plane": lambda: on_plane(8 * S**1.5),
    "slightly bent on a plane": lambda: on_plane(2 * S),
    "clamped": lambda: on_torus(HIGH_MODES, at="start", ends=("clamped", "free")),
    "both clamped": lambda: on_torus(HIGH_MODES, at="start", ends=("clamped", "clamped")),
    "growing": lambda: on_torus(
        HIGH_MODES, length=0.6, at="start", ends=("clamped", "free"), growth={"rate": 2.0, "until": 1.8}
    ),
}


def errors_of(make, lengths=LENGTHS, end=END, before=None) -> dict[str, list[float]]:
    """Errors of place and strain at ``end`` for these steps, after the steps ``before`` = (length, number) if any.

    Compared with steps by error.
    """
    exact = make()
    exact.advance_to(end, 1e-9)
    errors = {"position": [], "strain": []}
    for dt in lengths:
        rods = make()
        if before:
            rods.step(*before)
        rods.step(dt, round(end / dt))
        assert not rods.status.any() and rods.time == pytest.approx(end, rel=1e-3)
        for name, found in errors.items():
            found.append(float(np.abs(getattr(rods, name) - getattr(exact, name)).max()))
    return errors


SHORT = {"high modes", "bent on a plane", "growing"}
"""The others are long checks."""


@pytest.mark.parametrize(
    "start", [pytest.param(start, marks=[] if start in SHORT else [pytest.mark.long]) for start in STARTS]
)
def test_filaments_keep_second_order_on_rough_starts(start, verified):
    errors = errors_of(STARTS[start])
    verified.order(
        f"filament, rough start ({start}): order in Δt", measured=slope(1 / LENGTHS, errors["position"]),
        reference="steps by error, 1e-9",
    )  # fmt: skip
    assert errors["position"][-1] < 3e-6


def rough(**given) -> FreeRods:
    """Eight random waves in each strain, which relax at rates from 1 to 1e3."""
    rng, s = np.random.default_rng(4), np.linspace(-0.5, 0.5, NODES)
    waves = np.cos(np.pi * np.outer(np.arange(8), s) + rng.uniform(0, 6, (8, 1)))
    shape = ((1 - 4 * s**2) ** 2 * (rng.normal(size=(3, 8)) @ waves)).T
    return in_space("cpu", NODES, shape=shape, **given)


@pytest.mark.parametrize("twist", [1e-3, 1e-1])
def test_free_rods_keep_second_order_on_rough_starts(twist, verified):
    errors = errors_of(lambda: rough(twist=twist))
    verified.order(
        f"swimmer, rough start, β∥ = {twist:g}: order in Δt of places and strains",
        measured=[slope(1 / LENGTHS, errors[name]) for name in errors], reference="steps by error, 1e-9",
    )  # fmt: skip


def test_the_place_at_the_end_of_a_rough_start_does_not_depend_on_the_number_of_steps():
    """A bent rod on a plane settles where steps by error put it, whatever the step."""
    exact = on_plane(8 * S**1.5)
    exact.advance_to(END, 1e-9)
    moved = np.abs(exact.position - on_plane(8 * S**1.5).position).max()
    for dt in (1e-2, 2e-3):
        rods = on_plane(8 * S**1.5)
        rods.step(dt, round(END / dt))
        assert np.abs(rods.position - exact.position).max() < 1e-2 * moved


@pytest.mark.parametrize("make", [STARTS["bent on a plane"], rough], ids=["bound", "free"])
def test_steps_that_become_much_longer_start_again(make):
    """After ten steps of 1e-10 the start is as rough as it was."""
    errors = errors_of(make, before=(1e-10, 10))
    assert slope(1 / LENGTHS, errors["position"]) == ORDER, errors


def test_a_start_of_parts_is_restored():
    """A state within the first steps, and after a step that became longer."""
    rods, other = rough(), rough()
    for dt, steps in ((1e-3, 3), (5e-3, 1)):
        rods.step(dt, steps)
        other.restore(rods.state())
        for one in (rods, other):
            one.step(dt, 3)
        for name, values in rods.state().items():
            np.testing.assert_array_equal(other.state()[name], values, err_msg=name)
        assert rods.steps_taken[0] > 20
