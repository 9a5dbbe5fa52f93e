"""Filaments that cannot follow their surface, or leave the box in which φ is given, are frozen and named."""

import numpy as np
import pytest

from warp_rods.membranes import surfaces
from warp_rods.membranes.surface import ends_of
from warp_rods.rods.bound.rods import HISTORY, BoundRods
from warp_rods.rods.status import Status

BOX = ((-2.0, 2.0), (-2.0, 2.0), (-2.0, 2.0))


def not_inspected(phi: str, **parameters) -> surfaces.Surface:
    """The surface of a formula whose kinks were not looked for."""
    values = {"phi": phi, "box": BOX, "parameters": parameters}
    return surfaces.Surface("expression", values, surfaces.KINDS["expression"])


def pulled(surface, position, direction, force, **parameters) -> BoundRods:
    rods = BoundRods(surface, [position], [direction], nodes=33, length=0.6, device="cpu", **parameters)
    rods.force = np.array(force)
    return rods


KINKS = {
    "roof": ("z - 0.3 + 0.5*sqrt(x**2)", [-0.5, 0, 0.05], [1, 0.2, 0.5], [3.0, 0, 0]),
    "cone": ("sqrt(x**2 + y**2) + z - 1", [0.45, 0, 0.55], [-1, 0, 1], [-3.0, 0, 0]),
    "rim": (
        "((x**2 + y**2 - 0.5) + (z**2 - 1) + sqrt(((x**2 + y**2 - 0.5) - (z**2 - 1))**2))/2",
        [0.7071, 0, 0.5], [0, 0, 1], [0, 0, 3.0],
    ),
}  # fmt: skip
"""φ, position and direction of a filament beside the kink, and the force that pulls it over."""


@pytest.mark.parametrize("name", KINKS)
def test_a_filament_that_reaches_a_kink_is_frozen_at_its_last_state(name):
    phi, position, direction, force = KINKS[name]
    rods = pulled(not_inspected(phi), position, direction, force)
    last = rods.position
    for _ in range(600):
        state = rods.state()
        rods.step(1e-3)
        if rods.status[0] != Status.OK:
            break
        last = rods.position
    assert Status(rods.status[0]) is Status.KINK
    assert rods.failures()[0].what.startswith("reached a kink of its surface")
    np.testing.assert_array_equal(rods.position, last)
    for array in (*HISTORY, "pace_at"):
        if array != "failed_at":
            np.testing.assert_array_equal(rods.state()[array], state[array], err_msg=array)
    values = rods.variables()
    assert values["constraint"][0] < 1e-3 * 0.6 / 32 and values["arc_length"][0] < 1e-2
    before = rods.position
    rods.step(1e-3, 50)
    np.testing.assert_array_equal(rods.position, before)


def test_the_others_of_an_ensemble_continue_with_the_same_bits():
    roof = not_inspected(KINKS["roof"][0])
    places = [KINKS["roof"][1], [-1.2, 0.5, -0.3]], [KINKS["roof"][2], [0, 1, 0.1]]
    both = BoundRods(roof, *places, nodes=33, length=0.6, device="cpu")
    alone = BoundRods(roof, places[0][1:], places[1][1:], nodes=33, length=0.6, device="cpu")
    both.force = np.array([[[3.0, 0, 0]], [[0, 0.5, 0]]]) * np.ones((1, 33, 1))
    alone.force = np.array([0, 0.5, 0])
    both.step(1e-3, 300)
    alone.step(1e-3, 300)
    assert both.status.tolist() == [Status.KINK, Status.OK]
    np.testing.assert_array_equal(both.position[1], alone.position[0])


def test_a_growing_clamped_filament_keeps_its_length_and_place_at_a_kink():
    roof = not_inspected(KINKS["roof"][0])
    rods = BoundRods(
        roof, [[-0.5, 0, 0.05]], [[1, 0, 0.5]], at="start", ends=("clamped", "free"), nodes=33, length=0.3,
        growth={"rate": 1.0, "until": 2.0}, device="cpu",
    )  # fmt: skip
    rods.step(1e-3, 500)
    assert Status(rods.status[0]) is Status.KINK
    reached = np.sqrt(1.25) * 0.5  # along the roof from the site to its ridge
    assert rods.variables()["length"][0] == pytest.approx(reached, abs=2 * reached / 32)
    np.testing.assert_allclose(rods.position[0, 0], [-0.5, 0, 0.05], atol=1e-12)


def test_a_filament_at_a_healthy_resolution_is_not_frozen():
    """Half a radian a cell, beyond what is resolved well."""
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    rods = BoundRods(torus, [[1.4, 0, 0]], [[0, 0.6, 0.8]], nodes=9, length=1.6, device="cpu")
    rods.step(1e-3, 200)
    assert rods.status[0] == Status.OK


def test_a_filament_that_leaves_the_box_of_a_formula_is_frozen_inside():
    sheet = surfaces.make("expression", {"phi": "z - 0.1*sin(2*x)", "box": BOX})
    assert not sheet.closed
    rods = pulled(sheet, [1.5, 0, 0], [0, 1, 0], [4.0, 0, 0])
    rods.step(1e-3, 1000)
    assert Status(rods.status[0]) is Status.LEFT_DATA
    assert rods.failures()[0].what.startswith("reached the end of its surface, the box")
    assert 1.9 < rods.position[0, :, 0].max() <= 2.0
    after = rods.failed_at[0]
    assert 0.1 < after < 0.5


def test_a_plane_a_cylinder_and_closed_surfaces_have_no_end():
    for kind, values in (("plane", {"size": 1.0}), ("cylinder", {"radius": 0.5, "length": 1.0})):
        assert not np.isfinite(ends_of(surfaces.make(kind, values))).any()
    closed = surfaces.make("expression", {"phi": "x**2 + y**2 + z**2 - 1", "box": BOX})
    assert not np.isfinite(ends_of(closed)).any()
    rods = pulled(surfaces.make("plane", {"size": 1.0}), [0.3, 0, 0], [0, 1, 0], [4.0, 0, 0])
    rods.step(1e-3, 1000)
    assert rods.status[0] == Status.OK and rods.position[0, 0, 0] > 1.0
