"""Kinks, tips and edges of formulas: refused where they lie on the surface, with their place; accepted elsewhere."""

import numpy as np
import pytest

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.membranes.inspection import _crossings, _samples
from warp_rods.membranes.kinks import kinks

BOX = [[-1.93, 2.07], [-2.01, 1.89], [-1.97, 2.11]]
"""Not symmetric, so that no sample is on a kink."""
LEFT, RIGHT = "((x - 0.41)**2 + y**2 + z**2 - 1)", "((x + 0.43)**2 + y**2 + z**2 - 1)"


def on(*conditions):
    """Whether all conditions, functions of x, y, z, vanish at a place."""
    return lambda place: all(abs(condition(*place)) < 1e-5 for condition in conditions)


def sphere(x, y, z):
    return x * x + y * y + z * z - 1


KINKS = {
    "cone": ("sqrt(x**2 + y**2) + z - 1", on(lambda x, y, z: np.hypot(x, y), lambda x, y, z: z - 1)),
    "lens": (f"({LEFT} + {RIGHT} + sqrt(({LEFT} - {RIGHT})**2))/2", on(lambda x, y, z: x + 0.01)),
    "union": (f"({LEFT} + {RIGHT} - sqrt(({LEFT} - {RIGHT})**2))/2", on(lambda x, y, z: x + 0.01)),
    "rim": (
        "((x**2 + y**2 - 0.5) + (z**2 - 1) + sqrt(((x**2 + y**2 - 0.5) - (z**2 - 1))**2))/2",
        on(lambda x, y, z: x * x + y * y - 0.5, lambda x, y, z: abs(z) - 1),
    ),
    "square of a sum": ("sqrt(x**2 + 2*x*y + y**2) + x**2 + y**2 + z**2 - 1", on(lambda x, y, z: x + y)),
    "slight": ("x**2 + y**2 + z**2 - 1 + 0.05*sqrt((z - 0.3123)**2)", on(lambda x, y, z: z - 0.3123, sphere)),
    "cusp": ("((x - 0.1)**2)**(1/3) + y**2 + z**2 - 1", on(lambda x, y, z: x - 0.1)),
    "tip": ("(x**2 + y**2)**(1/4) + z - 0.5", on(lambda x, y, z: np.hypot(x, y), lambda x, y, z: z - 0.5)),
    "spindle": ("(sqrt(x**2 + y**2) - 0.5)**2 + z**2 - 1", on(lambda x, y, z: abs(z) - np.sqrt(0.75))),
    "edges": ("sqrt(x**2) + sqrt(y**2) + sqrt(z**2) - 1", on(lambda x, y, z: x * y * z)),
    "of parameters": ("x**2 + y**2 + z**2 - R**2 + a*sqrt((z - h)**2)", on(lambda x, y, z: z - 0.2)),
}
PARAMETERS = {"of parameters": {"R": 1.0, "a": 0.3, "h": 0.2}}


@pytest.mark.parametrize("name", KINKS)
def test_a_kink_on_the_surface_is_refused_with_its_place(name):
    text, is_there = KINKS[name]
    values = {"phi": text, "box": BOX, "parameters": PARAMETERS.get(name, {})}
    with pytest.raises(SceneError, match=r"surface.phi: the surface has a kink, a tip or an edge at \("):
        surfaces.make("expression", values)
    surface = surfaces.Surface(
        "expression", surfaces.read("expression", surfaces.plain(values))[0], surfaces.KINDS["expression"]
    )
    places = kinks(surface, _crossings(surface, *_samples(surface)))
    assert len(places) and all(map(is_there, places))


SMOOTH = {
    "torus, whose axis is off it": "(sqrt(x**2 + y**2) - 1)**2 + z**2 - 0.16",
    "distance": "sqrt(x**2 + y**2 + z**2) - 1",
    "a kink beside it": "x**2 + y**2 + z**2 - 1 + 0.3*sqrt((x - 1.8)**2)",
    "the root of a square that is positive": "sqrt((x**2 + y**2 + 1)**2) + z**2 - 2",
    "the root of a square that touches zero": "sqrt((x**2 + y**2)**2) + z**2 - 1",
    "a rounded kink": "x**2 + y**2 + z**2 - 1 + 0.3*sqrt(x**2 + 0.01)",
    "a wave of an angle": "sqrt(x**2 + y**2) - 1 - 0.1*cos(4*atan2(y, x)) + 0*z",
    "charges": "1 - 0.8/sqrt((x - 0.5)**2 + y**2 + z**2) - 0.4/sqrt((x + 0.5)**2 + y**2 + z**2)",
    "a capsule": "sqrt(x**2 + y**2 + ((sqrt((z - 0.5)**2) - sqrt((z + 0.5)**2))/2 + z)**2) - 0.6",  # curvature jumps
    "a logarithm": "log(x**2 + y**2 + z**2)",
}


@pytest.mark.parametrize("name", SMOOTH)
def test_a_surface_that_is_smooth_is_accepted(name):
    assert surfaces.make("expression", {"phi": SMOOTH[name], "box": BOX}).values["phi"] == SMOOTH[name]


def test_a_moving_surface_that_gets_a_kink_later_is_refused():
    values = {"phi": "x**2 + y**2 + z**2 - 1 + 0.3*sqrt((z - h)**2)", "box": BOX, "parameters": {"h": "1.5 - t"}}
    surfaces.make("expression", values, end=0.2)
    with pytest.raises(SceneError, match=r"surface at t = 1: the surface has a kink"):
        surfaces.make("expression", values, end=1.0)
