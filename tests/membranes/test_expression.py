"""Membranes with a formula for φ: against the built-in ones and SymPy, and refusal of unusable ones."""

import math
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
import warp as wp
from reference.surface import POINT, differentiated

from warp_rods.errors import SceneError
from warp_rods.kernels.bound import frames as bound_frames
from warp_rods.kernels.surface.geometry import sampler
from warp_rods.membranes import surfaces
from warp_rods.membranes.formula_fields import field
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.scene.scene import Scene

BOX = [[-2.0, 2.0]] * 3

BUILT_IN = {
    "sphere": ("(x**2 + y**2 + z**2 - radius**2)/(2*radius)", {"radius": 1.3}),
    "torus": (
        "((sqrt(x**2 + y**2) - major)**2 + z**2 - minor**2)/(2*minor)",
        {"major": 1.1, "minor": 0.4},
    ),
    "cassini": ("(x**2 + y**2 + z**2 + a**2)**2 - 4*a**2*z**2 - b**4", {"a": 1.0, "b": 1.1}),
    "undulated": (
        "x**2 + y**2 + z**2 - radius**2 + amplitude*(cos(wavenumber*x) + cos(wavenumber*y) + cos(wavenumber*z))",
        {"radius": 1.0, "amplitude": 0.16, "wavenumber": 5.0},
    ),
}
"""Kind: the same φ as a formula, and its parameters."""


def from_formula(phi: str, box=BOX, **parameters) -> surfaces.Surface:
    return surfaces.make("expression", {"phi": phi, "box": box, "parameters": parameters})


def sphere(radius: float = 1.3) -> surfaces.Surface:
    return from_formula(BUILT_IN["sphere"][0], radius=radius)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_formula_agrees_with_the_built_in_surface(kind):
    text, values = BUILT_IN[kind]
    surface, built_in = from_formula(text, **values), surfaces.make(kind, values)
    assert surface.closed
    points = np.random.default_rng(1).uniform(-2, 2, size=(300, 3))
    for quantity in ("phi", "gradient", "hessian"):
        exact = getattr(built_in, quantity)(points)
        error = np.abs(getattr(surface, quantity)(points) - exact).max()
        assert error < 1e-12 * max(1, np.abs(exact).max())


def test_filaments_move_as_on_the_built_in_sphere(device):
    position = []
    for surface in (sphere(), surfaces.make("sphere", {"radius": 1.3})):
        rods = BoundRods(
            surface, [[1.3, 0, 0], [0, 1, 1]], [[0, 1, 1], [1, 0.2, 0]], geodesic_curvature=1.5, device=device
        )
        start = rods.position
        rods.step(2e-3, 50)
        assert np.abs(rods.position - start).max() > 1e-3
        position.append(rods.position)
    assert np.abs(position[0] - position[1]).max() < 1e-12


def test_equal_formulas_share_one_function_whatever_their_parameters():
    small, large = sphere(0.5), sphere(1.5)
    assert small.field is large.field
    assert sampler(small.field) is sampler(large.field)
    assert bound_frames.on_surface(small.field) is bound_frames.on_surface(large.field)
    assert small.phi(np.array([1.0, 0, 0])) == pytest.approx(0.75, abs=1e-15)
    assert large.phi(np.array([1.0, 0, 0])) == pytest.approx(-1.25 / 3, abs=1e-15)


def test_every_function_against_sympy():
    text = (
        "sqrt(2 + x**2) + exp(x*y/3) - log(9 + x + y) + sin(x)*cos(y)*tan(z/4) + sinh(x/2) - cosh(z)/2 + tanh(x*z)"
        " + atan(x - y) + 1.5*atan2(y + 5, x + 5) + (x + 4)**-1.5 - (y + 4)**(1/3)/x**-3 + 0.1*pi*x**2.0"
    )
    points = np.random.default_rng(3).uniform(-2, 2, size=(200, 3))
    exact = differentiated(sp.sympify(text).subs(dict(zip(sp.symbols("x y z"), POINT, strict=True))))(points)
    surface = from_formula(text)
    for found, expected in zip((surface.phi, surface.gradient, surface.hessian), exact, strict=True):
        error = np.abs(found(points) - expected).max()
        assert error < 1e-13 * np.abs(expected).max()


WRONG = [
    ({"phi": None}, ["surface.phi: missing; must be text"]),
    ({"phi": 3}, ["surface.phi = 3: must be text in quotes"]),
    ({"box": None}, ["surface.box: missing; must be [[x0, x1]"]),
    ({"box": [[-1, 1], [-1, 1]]}, ["surface.box"]),
    ({"box": [[1, -1], [-1, 1], [-1, 1]]}, ["surface.box = [[1, -1], [-1, 1], [-1, 1]]", "increase"]),
    ({"box": [[-1, math.inf], [-1, 1], [-1, 1]]}, ["surface.box"]),
    ({"box": 2.0}, ["surface.box"]),
    ({"bx": 2.0}, ["surface.bx", "phi, box, parameters"]),
    (
        {"parameters": {"R": "1"}},
        ['surface.parameters.R = "1": must be a number, or a formula in t; t does not occur in it'],
    ),
    ({"parameters": {"R": math.nan}}, ["surface.parameters.R"]),
    ({"parameters": {"R": 1.0, "x": 1.0}}, ["surface.parameters.x: cannot be the name of a parameter"]),
    ({"parameters": {"R": 1.0, "sin": 1.0}}, ["surface.parameters.sin"]),
    ({"parameters": {"R": 1.0, "lambda": 1.0}}, ["surface.parameters.lambda"]),
    ({"parameters": {"R": 1.0, "a-b": 1.0}}, ["surface.parameters.a-b"]),
    ({"parameters": {"R": 1.0, "k": 1.0}}, ["surface.phi: parameters.k does not occur"]),
    ({"parameters": {f"a{i}": 1.0 for i in range(9)}}, ["surface.parameters", "8 at most"]),
    ({"parameters": [1.0]}, ["surface.parameters"]),
    ({"phi": "q", "box": 1, "parameters": {"pi": 1.0}}, ["surface.phi", "surface.box", "surface.parameters.pi"]),
]


@pytest.mark.parametrize(("changes", "lines"), WRONG)
def test_every_wrong_value_is_named(changes, lines):
    values = {"phi": "x**2 + y**2 + z**2 - R**2", "box": BOX, "parameters": {"R": 1.0}} | changes
    with pytest.raises(SceneError) as caught:
        surfaces.make("expression", {key: value for key, value in values.items() if value is not None})
    for line in lines:
        assert line in str(caught.value)


UNUSABLE = [
    ("x**2 + y**2 + z**2 + 1", "positive at the 49³ points"),
    ("x**2 + y**2 + z**2 - 100", "never positive"),
    ("(x**2 + y**2 + z**2 - 1.1)**2", "positive at the 49³ points"),
    ("1 - x**2 - y**2 - z**2", "outward is where φ > 0"),
    ("(x**2 + y**2 + z**2 - 1)**3", "∇φ vanishes"),
    ("x**2 + y**2 - z**2", "∇φ vanishes on the surface at (0, 0, 0)"),
    ("(x**2 + y**2 + z**2 + 1)**2 - 4*z**2 - 1", "∇φ vanishes on the surface"),
    ("x**2 - y**3 + 0*z", "∇φ vanishes on the surface"),
    ("sqrt(x**2 + y**2) + z", "not smooth"),
    ("1/x", "not smooth"),
    ("log(x) + y", "not a number at (-2, -2, -2)"),
]


@pytest.mark.parametrize(("text", "words"), UNUSABLE)
def test_an_unusable_surface_is_refused(text, words):
    with pytest.raises(SceneError) as caught:
        from_formula(text)
    assert str(caught.value).startswith("surface.phi: ") and words in str(caught.value)


def test_a_very_narrow_neck_is_accepted():
    """A Cassini dumbbell with b → a, whose waist has the radius √(b² − a²) = 1.4e-2."""
    assert from_formula("(x**2 + y**2 + z**2 + 1)**2 - 4*z**2 - b**4", b=1.0001).closed


CLOSED = [
    ("x**2 + y**2 + z**2 - 1", True),
    ("x**2 + y**2 + z**2 - 4", True),  # touches its box from inside
    ("sqrt(x**2 + y**2 + z**2) - 1", True),
    ("x**2 + y**2 - 1 + 0*z", False),
    ("z", False),
    ("sin(2*x)*cos(2*y) + sin(2*y)*cos(2*z) + sin(2*z)*cos(2*x)", False),
]


@pytest.mark.parametrize(("text", "closed"), CLOSED)
def test_a_surface_is_closed_where_phi_is_positive_on_its_whole_box(text, closed):
    assert from_formula(text).closed is closed


def test_a_scene_names_faults_of_the_formula_with_others_and_converts_to_text():
    path = Path(__file__).parents[2] / "scenes" / "expression.toml"
    scene = Scene.load(path)
    again = Scene.parse(scene.to_toml())
    assert again == scene and again.hash() == scene.hash()
    bad = path.read_text(encoding="utf-8").replace("x**4", "x^4").replace("end = 4.0", "end = -4.0")
    with pytest.raises(SceneError) as caught:
        Scene.parse(bad)
    assert "2 faults" in str(caught.value)
    assert "surface.phi: column 1: ^ is not known here" in str(caught.value) and "time.end" in str(caught.value)


needs_compiler = pytest.mark.skipif(80 not in wp.get_cuda_supported_archs(), reason="no CUDA code generation here")


@pytest.mark.long
@needs_compiler
def test_compiles_to_ptx(tmp_path):
    kernels = vars(bound_frames.on_surface(field("x**2 + sin(R*y)**2 + z**2/R - 1", ("R",))))
    for name, kernel in kernels.items():
        (path,) = wp.compile_aot_module(kernel.module, arch=80, module_dir=tmp_path / name, use_ptx=True)
        assert ".entry" in path.read_text()
