"""Every surface of the table: derivatives against symbolic ones, geometry against closed forms, faults."""

import numpy as np
import pytest
import sympy as sp
import warp as wp
from examples.surfaces import INSIDE, SURFACES
from reference.surface import Z, curvatures, differentiated

from warp_rods.errors import SceneError
from warp_rods.kernels.layout import real
from warp_rods.kernels.surface import geometry
from warp_rods.membranes import surfaces
from warp_rods.membranes.symbolic import unchecked
from warp_rods.rods.bound.rods import BoundRods

wp.set_module_options({"enable_backward": False})


def made(kind: str) -> surfaces.Surface:
    return surfaces.make(kind, SURFACES[kind][0])


def points_on(surface: surfaces.Surface, count: int = 200) -> np.ndarray:
    """Points [count, 3] on the surface inside its box, not uniformly distributed."""
    low, high = surface.box
    x = np.random.default_rng(4).uniform(0.8 * low, 0.8 * high, size=(4 * count, 3))
    x = surface.project(x)
    good = (np.abs(surface.phi(x)) < 1e-12) & (np.abs(x) <= high).all(axis=-1)
    return x[good][:count]


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def test_every_kind_of_surface_has_a_case():
    assert SURFACES.keys() == surfaces.SURFACES.keys()


@pytest.mark.parametrize("kind", SURFACES)
def test_field_and_its_derivatives(kind, verified):
    surface = made(kind)
    points = np.random.default_rng(1).uniform(-2, 2, size=(300, 3))
    expected = differentiated(SURFACES[kind][1])(points)
    functions = zip((surface.phi, surface.gradient, surface.hessian), expected, strict=True)
    verified.below(
        "independent", f"{kind}: φ, ∇φ, ∇∇φ, relative", bound=1e-12, reference="SymPy's derivatives at 300 points",
        measured=[np.abs(found(points) - exact).max() / max(1, np.abs(exact).max()) for found, exact in functions],
    )  # fmt: skip


@pytest.mark.parametrize("kind", SURFACES)
def test_outward_is_where_phi_is_positive(kind):
    surface = made(kind)
    assert surface.phi(np.array([INSIDE.get(kind, (0, 0, 0))], dtype=float))[0] < 0
    far = 20 * unit(np.array([[1.0, 0.5, 0.5], [-1.0, 0.3, 0.2], [0.4, -1.0, 0.3]]))
    assert (surface.phi(far) > 0).all()
    x = points_on(surface)
    assert (surface.phi(x + 1e-4 * surface.normal(x)) > 0).all()


@pytest.mark.parametrize("kind", [kind for kind, row in surfaces.SURFACES.items() if row.closed])
def test_box_contains_a_closed_surface_and_is_not_much_larger(kind):
    surface = made(kind)
    low, high = surface.box
    face = np.stack(np.meshgrid(*[np.linspace(-1, 1, 101)] * 2), axis=-1).reshape(-1, 2)
    for axis in range(3):
        for side in (-1.0, 1.0):
            corners = np.insert(face, axis, side, axis=-1)
            assert (surface.phi(corners * high) > 0).all()
    extent = np.abs(points_on(surface, 4000)).max(axis=0)
    assert (extent <= high).all() and (extent > 0.7 * high).all()
    np.testing.assert_array_equal(low, -high)


@wp.kernel
def geometry_of(
    gradient: wp.array[wp.vec3d],
    hessian: wp.array[wp.mat33d],
    direction: wp.array[wp.vec3d],
    n: wp.array[wp.vec3d],
    q: wp.array[wp.vec3d],
    frame: wp.array[wp.mat33d],
    K: wp.array[wp.vec3d],
    gauss: wp.array[wp.float64],
):
    i = wp.tid()
    n[i] = geometry.normal(gradient[i])
    q[i] = geometry.to_tangent(direction[i], n[i])
    frame[i] = geometry.frame(q[i], n[i])
    K[i] = geometry.curvature(gradient[i], hessian[i], q[i])
    gauss[i] = geometry.gaussian(K[i])


@pytest.mark.parametrize("kind", SURFACES)
def test_normal_frame_and_curvatures_agree_with_the_shape_operator(kind, device, verified):
    surface = made(kind)
    x = points_on(surface)
    direction = np.random.default_rng(2).normal(size=x.shape)
    _, g, H = differentiated(SURFACES[kind][1])(x)
    inputs = [wp.array(np.ascontiguousarray(v), dtype=t, device=device) for v, t in ((g, wp.vec3d), (H, wp.mat33d))]
    inputs.append(wp.array(direction, dtype=wp.vec3d, device=device))
    types = (wp.vec3d, wp.vec3d, wp.mat33d, wp.vec3d, real)
    outputs = [wp.zeros(len(x), dtype=t, device=device) for t in types]
    wp.launch(geometry_of, dim=len(x), inputs=inputs, outputs=outputs, device=device)
    n, q, frame, K, gauss = (a.numpy() for a in outputs)
    scale = max(1, np.abs(K).max())
    np.testing.assert_allclose(n, unit(g), rtol=0, atol=1e-15)
    np.testing.assert_allclose(q, unit(direction - np.sum(direction * n, axis=-1)[:, None] * n), rtol=0, atol=1e-13)
    np.testing.assert_allclose(frame, np.stack([q, np.cross(n, q), n], axis=-1), rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.swapaxes(frame, 1, 2) @ frame, np.broadcast_to(np.eye(3), frame.shape), atol=1e-13)
    verified.below(
        "independent", f"{kind}: K11, K12, K22 in random frames, relative",
        measured=np.abs(K - curvatures(g, H, q)).max() / scale, bound=1e-12, reference="−q_i·∇n·q_j in NumPy",
    )  # fmt: skip
    np.testing.assert_allclose(gauss, surface.gaussian_curvature(x), rtol=0, atol=1e-12 * scale**2)


def test_one_newton_step_projects_to_second_order(verified):
    surface = made("torus")
    x = points_on(surface)
    error = [np.abs(surface.phi(surface.project(x + h * surface.normal(x), 1))).max() for h in (1e-2, 1e-3)]
    assert error[0] < 1e-3
    order = np.log10(error[0] / error[1])
    verified.order("a Newton step towards a torus: order in the distance", measured=order, reference="φ = 0")


def torus_gauss(x: np.ndarray) -> np.ndarray:
    rho = np.hypot(x[:, 0], x[:, 1])
    return (rho - 1.1) / 0.4 / (0.4 * rho)  # cos θ/(r (R + r cos θ))


def ellipsoid_gauss(x: np.ndarray) -> np.ndarray:
    radii = np.array(SURFACES["ellipsoid"][0]["radii"])
    return 1 / (np.prod(radii) * np.sum((x / radii**2) ** 2, axis=-1)) ** 2


def bridge_gauss(x: np.ndarray) -> np.ndarray:
    """−ρ''/(ρ(1 + ρ'²)²) of a surface of revolution."""
    radius = 0.4 + 0.6 * (1 - sp.exp(-(Z**2) / 0.64))
    rho, slope, bend = (sp.lambdify(Z, sp.diff(radius, Z, k))(x[:, 2]) for k in range(3))
    return -bend / (rho * (1 + slope**2) ** 2)


GAUSS = {
    "plane": lambda x: np.zeros(len(x)),
    "sphere": lambda x: np.full(len(x), 1 / 1.3**2),
    "ellipsoid": ellipsoid_gauss,
    "cylinder": lambda x: np.zeros(len(x)),
    "torus": torus_gauss,
    "bridge": bridge_gauss,
}


@pytest.mark.parametrize("kind", GAUSS)
def test_gaussian_curvature_against_closed_forms(kind, verified):
    x = points_on(made(kind))
    exact = GAUSS[kind](x)
    scale = max(1, np.abs(exact).max())
    verified.below(
        "exact", f"{kind}: Gaussian curvature, relative",
        measured=np.abs(made(kind).gaussian_curvature(x) - exact).max() / scale, bound=1e-11, reference="closed form",
    )  # fmt: skip


def test_an_outward_normal_makes_the_curvature_of_a_sphere_negative():
    """K = −∇n: K11 = −1/R, so that σ2 > 0, with Ω[1] = −K11, prefers convex membrane (docs/model.md §1.3)."""
    t1, t2, second = made("sphere").second_form(points_on(made("sphere")))
    np.testing.assert_allclose(second, np.broadcast_to(-np.eye(2) / 1.3, second.shape), atol=1e-12)
    np.testing.assert_allclose(np.sum(t1 * t2, axis=-1), 0, atol=1e-15)


FAULTS = [
    ("sphere", {"radius": -1.0}, ["surface.radius", "-1.0"]),
    ("sphere", {"radius": 0.0}, ["surface.radius"]),
    ("sphere", {"radius": float("nan")}, ["surface.radius"]),
    ("sphere", {"radius": "big"}, ["surface.radius", "big"]),
    ("sphere", {"radius": "1.0"}, ["surface.radius"]),
    ("sphere", {"radius": [1.0, 2.0]}, ["surface.radius"]),
    ("sphere", {}, ["surface.radius"]),
    ("sphere", {"radius": 1.0, "radios": 2.0}, ["surface.radios", "it has radius"]),
    ("ellipsoid", {"radii": [1.0, 2.0]}, ["surface.radii", "3"]),
    ("ellipsoid", {"radii": [1.0, [2.0], 3.0]}, ["surface.radii"]),
    ("torus", {"major": 0.4, "minor": 0.5}, ["minor = 0.5", "major = 0.4"]),
    ("torus", {"major": -1.0, "minor": "x"}, ["surface.major", "surface.minor"]),
    ("cassini", {"a": 1.0, "b": 1.0}, ["b = 1.0", "a = 1.0"]),
    ("undulated", {"amplitude": 0.4}, ["amplitude = 0.4"]),
    ("saddle", {}, ["saddle", *surfaces.SURFACES]),
]


@pytest.mark.parametrize(("kind", "values", "words"), FAULTS)
def test_impossible_surfaces_are_refused_with_the_faulty_values(kind, values, words):
    with pytest.raises(SceneError) as caught:
        surfaces.make(kind, values)
    for word in words:
        assert word in str(caught.value)


@wp.func
def hyperboloid(x: wp.vec3d, p: geometry.Parameters):
    """φ = ((x² + y²)/a² − z²/c² − 1)/2, a hyperboloid of one sheet."""
    w = wp.vec3d(real(1.0) / (p.v[0] * p.v[0]), real(1.0) / (p.v[0] * p.v[0]), real(-1.0) / (p.v[1] * p.v[1]))
    g = wp.cw_mul(w, x)
    return real(0.5) * (wp.dot(g, x) - real(1.0)), g, wp.diag(w)


def test_one_function_and_one_row_add_a_surface(monkeypatch, device):
    parameters = {"waist": surfaces.Parameter("radius"), "slope": surfaces.Parameter("of the cone", default=1.0)}
    row = surfaces.SurfaceKind(hyperboloid, parameters, lambda v: (3 * v["waist"],) * 3, closed=False)
    monkeypatch.setitem(surfaces.SURFACES, "hyperboloid", row)
    surface = surfaces.make("hyperboloid", {"waist": 0.8})
    np.testing.assert_allclose(surface.gaussian_curvature(np.array([[0.8, 0.0, 0.0]])), [-1.0], atol=1e-14)
    start = np.array([[0.8, 0.0, 0.0], [0.0, 1.0, 0.6]])
    rods = BoundRods(surface, start, [[0, 1, 1], [1, 0, 0.2]], length=0.8, intrinsic=(0.3, -0.5, 0.2), device=device)
    before = rods.position
    rods.step(1e-3, 20)
    found = rods.variables()
    assert np.abs(rods.position - before).max() > 1e-3
    assert (rods.status == 0).all()
    assert found["constraint"].max() < 1e-9 and found["arc_length"].max() < 1e-9
    R = rods.rotation
    np.testing.assert_allclose(np.swapaxes(R, 2, 3) @ R, np.broadcast_to(np.eye(3), R.shape), rtol=0, atol=1e-14)
    normal = surface.normal(rods.position.reshape(-1, 3)).reshape(R.shape[:3])
    np.testing.assert_allclose(R[..., 2], normal, rtol=0, atol=1e-14)


@pytest.mark.parametrize("kind", surfaces.SURFACES)
def test_the_formula_of_a_kind_is_its_field(kind):
    """The formula from which the time derivatives of a moving surface come."""
    row, surface = surfaces.SURFACES[kind], made(kind)
    phi = unchecked(row.phi, row.names).subs(dict(zip(sp.symbols("p:8"), surface.parameters, strict=True)))
    points = np.random.default_rng(1).uniform(-1.5, 1.5, size=(100, 3))
    expected = surface.phi(points)
    found = sp.lambdify(sp.symbols("x:3"), phi)(*points.T)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


def test_a_kind_without_a_formula_cannot_move(monkeypatch):
    row = surfaces.SURFACES["sphere"]
    monkeypatch.setitem(surfaces.SURFACES, "ball", surfaces.SurfaceKind(row.function, row.parameters, row.box))
    assert surfaces.make("ball", {"radius": 1.0}).closed
    with pytest.raises(SceneError, match="cannot move, because this kind has no formula phi"):
        surfaces.make("ball", {"radius": "1 + t"})
