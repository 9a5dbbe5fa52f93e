"""Formulas in t: exact time derivatives of parameters, of φ and of ∇φ, against SymPy."""

import numpy as np
import pytest
import sympy as sp
from examples.bound import read

from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError
from warp_rods.membranes import surfaces
from warp_rods.membranes.motion import DERIVATIVES, rate, rates_at
from warp_rods.membranes.symbolic import unchecked
from warp_rods.rods.bound.rods import BoundRods

FORMULAS = [
    *(f"{name}(0.3 + 0.2*t)" for name in DERIVATIVES),
    "atan2(t, 2 - t)", "-t**3/(1 + t)", "(2 + t)**-1.5*t", "+(t - 2)**0 + 3*t**1", "exp(-t)*sin(3e9*t)/3e9", "2*t/4-t",
]  # fmt: skip


@pytest.mark.parametrize("text", FORMULAS)
@pytest.mark.parametrize("time", [0.0, 0.7])
def test_the_rate_of_a_formula_against_sympy(text, time):
    t = sp.Symbol("t")
    exact = float(sp.diff(sp.sympify(text), t).subs(t, time))
    assert rate(text, time) == pytest.approx(exact, rel=1e-14, abs=1e-15)


def test_a_formula_without_a_finite_rate_is_refused():
    for text in ("sqrt(t)", "t**0.5", "log(t)", "1/t"):
        with pytest.raises(FormulaError, match="not a finite real number"):
            rate(text, 0.0)
    with pytest.raises(SceneError, match=r"surface.radius at t = 0: column 5: not a finite"):
        surfaces.make("sphere", {"radius": "1 + t**0.5"})


def test_rates_of_nested_values():
    values = {"phi": "x*a - t", "parameters": {"a": "2*t", "b": 3.0}, "radii": (1.0, "t**2", 2.0)}
    assert rates_at(values, 2.0) == {"phi": "x*a - t", "parameters": {"a": 2.0, "b": 0.0}, "radii": (0.0, 4.0, 0.0)}


MOVING = {
    "sphere": {"radius": "1 + 0.2*sin(3*t)"},
    "ellipsoid": {"radii": [1.0, "1.2 + 0.3*t", "0.9 - t**2"]},
    "cylinder": {"radius": "1 + t", "length": 6.0},
    "torus": {"major": "1 + 0.5*t", "minor": "0.4 - 0.1*t"},
    "cassini": {"a": "1 + 0.1*t", "b": "1.2 - 0.2*t"},
    "bridge": {"neck": "0.4 - 0.1*t", "body": 1.0, "width": "1 + 0.3*t"},
    "undulated": {"radius": "1 + 0.1*t", "amplitude": "0.16 + t/20", "wavenumber": "5 - t"},
    "expression": {"phi": "x**2 + y**2*k + (z - c)**2 - 1", "box": [[-3, 3]] * 3, "parameters": {"k": "1+t", "c": "t"}},
}


@pytest.mark.parametrize("kind", MOVING)
def test_the_normal_velocity_of_a_moving_membrane_is_exact(kind, verified):
    """V = −∂tφ/|∇φ| and V_1 = q1·∇V at all nodes, at a time when everything moves."""
    surface, time = surfaces.make(kind, MOVING[kind]), 0.1
    rods = BoundRods(surface, [[0.8, 0.3, 0.2]], [[0.1, 0.4, 1.0]], nodes=17, length=0.4)
    rods.step(time)
    rods.evaluate()
    names = surfaces.SURFACES[kind].names if kind in surfaces.SURFACES else ("c", "k")
    phi = unchecked(surfaces.SURFACES[kind].phi if kind in surfaces.SURFACES else MOVING[kind]["phi"], names)
    x, numbers = sp.symbols("x:3"), sp.symbols("p:8")[: len(names)]
    phi_t = sum(sp.diff(phi, p) * q for p, q in zip(numbers, surface.parameter_rates(time), strict=False))
    velocity = -phi_t / sp.sqrt(sum(sp.diff(phi, a) ** 2 for a in x))
    now = dict(zip(numbers, surface.parameters_at(time), strict=False))
    parts = [velocity, *(sp.diff(velocity, a) for a in x)]
    places = [now | dict(zip(x, point, strict=True)) for point in rods.position[0]]
    exact = np.array([[part.subs(place).evalf() for place in places] for part in parts], dtype=float)
    verified(
        "independent", f"moving {kind}: normal velocity", measured=read(rods, "normal_velocity")[0], expected=exact[0],
        relative=1e-11, reference="−∂tφ/|∇φ| by SymPy",
    )  # fmt: skip
    across = rods.rotation[0, :, :, 1]
    np.testing.assert_allclose(read(rods, "normal_velocity_slope")[0], np.sum(across.T * exact[1:], axis=0), atol=1e-10)
