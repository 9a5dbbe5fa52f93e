"""Formulas as text: parsed and differentiated as by SymPy, and refused where not allowed."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from reference.surface import POINT, differentiated

from warp_rods import formula
from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.membranes.field_source import field_source
from warp_rods.membranes.symbolic import expression


@pytest.mark.long
def test_the_source_is_the_same_in_every_process():
    """Otherwise compiled kernels would not be found again, and runs would not have equal bits."""
    text = "sin(k*x)*cos(y) + x*y*z/(1 + x**2) + a*sqrt(x**2 + y**2 + 1)**3 - exp(-z*x)"
    code = (
        "from warp_rods.membranes.field_source import field_source; "
        "from warp_rods.membranes.symbolic import expression; "
        f"print(field_source(expression({text!r}, ('a', 'k'))))"
    )
    sources = [
        subprocess.run(
            [sys.executable, "-c", code], env={"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
        ).stdout
        for seed in ("1", "2")
    ]
    assert sources[0] == sources[1] == field_source(expression(text, ("a", "k"))) + "\n"


numbers = st.integers(-9, 9).map(str) | st.floats(-9, 9).map(lambda value: f"{value:.3f}")
leaves = numbers | st.sampled_from(["x", "y", "z", "k"])
POLYNOMIALS = st.recursive(
    leaves,
    lambda part: (
        st.builds("({} {} {})".format, part, st.sampled_from("+-*"), part)
        | st.builds("({})**{}".format, part, st.integers(2, 3))
        | st.builds("-({})".format, part)
    ),
    max_leaves=12,
)


@settings(max_examples=60, deadline=None)
@given(POLYNOMIALS)
def test_any_polynomial_against_sympy(text):
    """The source runs as Python, where each operation has the same meaning as in Warp."""
    try:
        source = field_source(expression(f"{text} + x + k", ("k",)))
    except formula.FormulaError as error:
        assert "degree" in str(error) or "a power of zero" in str(error)
        return
    meaning = {"float64": float, "vec3d": lambda *v: np.array(v), "mat33d": lambda *v: np.reshape(v, (3, 3))}
    scope = {"wp": SimpleNamespace(**meaning), "Parameters": None}
    exec(source, scope)
    phi = sp.sympify(f"{text} + x + k").subs({"k": sp.Rational(7, 10)})
    phi = phi.subs(dict(zip(sp.symbols("x y z"), POINT, strict=True)))
    points = np.random.default_rng(5).uniform(-1, 1, size=(5, 3))
    exact = differentiated(phi)(points)
    for i, point in enumerate(points):
        for found, expected in zip(scope["field"](point, SimpleNamespace(v=[0.7])), exact, strict=True):
            np.testing.assert_allclose(found, expected[i], rtol=1e-9, atol=1e-9 * max(1, np.abs(expected).max()))


HOSTILE = [
    ("__import__('os').system('echo')", "column 1"),
    ("x.__class__", "a dot"),
    ("x[0]", "brackets"),
    ("(lambda: x)()", "this call"),
    ("[x for x in y]", "column 1"),
    ("x if y else z", "not allowed"),
    ("x and y", "not allowed"),
    ("x < 1", "a comparison"),
    ("x == 1", "a comparison"),
    ("(x := 1)", "not allowed"),
    ("'x'", "this value"),
    ("f'{x}'", "not allowed"),
    ("1j*x", "this value"),
    ("True*x", "this value"),
    ("x % 2", "not allowed"),
    ("x // 2", "not allowed"),
    ("x ^ 2", "a power is **"),
    ("~x", "not allowed"),
    ("eval(x)", "eval() is not known"),
    ("abs(x)", "abs() is not known"),
    ("max(x, y)", "max() is not known"),
    ("sin(x, y)", "sin() takes 1 argument"),
    ("sin(x=1)", "this call"),
    ("sin(*x)", "not allowed"),
    ("atan2(x)", "atan2() takes 2 arguments"),
    ("q*x", "q is not known"),
    ("x*sin", "sin is not known"),
    ("x**y", "the exponent must be a number"),
    ("x**x**2", "the exponent must be a number"),
    ("x**13", "from −12 to 12"),
    ("x + 9**9**9", "from −12 to 12"),
    ("((2*x)**12)**12", "degree"),
    ("x + 1e308*10", "not a finite real number"),
    ("x + 1" + "0" * 400, "not a finite real number"),
    ("x + sqrt(-1)", "not a finite real number"),
    ("x + (0-8)**0.5", "not a finite real number"),
    ("x + log(0)", "not a finite real number"),
    ("x + 1/0", "not a finite real number"),
    ("x/(y - y)", "divides by zero"),
    ("(x - x)**-1", "a power of zero"),
    ("*".join(f"(x + {i})" for i in range(30)), "factors"),
    ("sin(" * 40 + "x" + ")" * 40, "nested at most 30 deep"),
    ("x+" * 400 + "x", "at most 300 parts"),
    ("x" * 1001, "at most 1000"),
    ("(" * 400 + "x" + ")" * 400, "column"),
    ("-" * 900 + "x", "nested at most 30 deep"),
    ("x # + y", "no comments"),
    ("x\0", "allowed are"),
    ("", "column"),
    ("x +", "column 4"),
    ("2x", "column"),
    ("x**2 = 1", "column"),
    ("x; y", "column"),
    ("1 + 2", "none of x, y, z"),
]


@pytest.mark.parametrize(("text", "words"), HOSTILE, ids=[text[:20].strip() for text, _ in HOSTILE])
def test_a_formula_that_is_not_allowed_is_refused_with_the_reason(text, words):
    with pytest.raises(SceneError) as caught:
        surfaces.make("expression", {"phi": text, "box": [[-2, 2]] * 3})
    assert str(caught.value).startswith("surface.phi: ")
    assert words in str(caught.value)


def test_refusals_state_what_is_allowed():
    with pytest.raises(SceneError, match=r"allowed are numbers, pi, x, y, z, .*tanh\(\), atan\(\), atan2\(\)"):
        surfaces.make("expression", {"phi": "x + open(y)", "box": [[-2, 2]] * 3})
