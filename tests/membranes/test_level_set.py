"""Membranes on a grid: the spline against SciPy, the order of its curvature, stacks, meshes, and wrong files.

A cubic spline through samples of spacing h has errors O(h⁴) in φ and O(h²) in its second derivatives, hence in 𝒦.
"""

from pathlib import Path

import numpy as np
import pytest
import trimesh
import warp as wp
from scipy import ndimage
from scipy.interpolate import BSpline

from warp_rods.errors import SceneError
from warp_rods.kernels.bound import frames as bound_frames
from warp_rods.kernels.surface.spline import spline
from warp_rods.membranes import surfaces
from warp_rods.membranes.fit import PAD
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.scene.scene import Scene

SCENES = Path(__file__).parents[2] / "scenes"
HALF = 1.6
RADII = {"sphere": (1.0, 1.0, 1.0), "ellipsoid": (1.0, 1.3, 0.8)}


def nodes(count: int) -> tuple[np.ndarray, float]:
    """Points [n, n, n, 3] of a grid around the origin, and its spacing."""
    axis = np.linspace(-HALF, HALF, count)
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1), float(axis[1] - axis[0])


def distance(x: np.ndarray, radii=RADII["sphere"]) -> np.ndarray:
    """A level set of an ellipsoid that is not a polynomial; for a sphere the signed distance."""
    return np.linalg.norm(x / radii, axis=-1) - 1


def from_array(folder: Path, values: np.ndarray, spacing) -> surfaces.Surface:
    np.save(folder / "phi.npy", values)
    return surfaces.make("grid", {"file": str(folder / "phi.npy"), "spacing": spacing})


def directions(count: int = 1000) -> np.ndarray:
    d = np.random.default_rng(2).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def slope(h, error) -> float:
    return float(np.polyfit(np.log(h), np.log(error), 1)[0])


def test_the_spline_and_its_derivatives_agree_with_scipy(tmp_path, verified):
    rng = np.random.default_rng(1)
    values, h = rng.normal(size=(9, 11, 10)), np.array([0.1, 0.2, 0.3])
    np.save(tmp_path / "phi.npy", values)
    parameters = {"file": str(tmp_path / "phi.npy"), "spacing": h, "origin": (1.0, -1.0, 0.5)}
    surface = surfaces.Surface("grid", parameters, surfaces.KINDS["grid"])
    coefficients = ndimage.spline_filter(np.pad(values, PAD, mode="reflect", reflect_type="odd"), mode="mirror")
    u = rng.uniform(-PAD - 5, 30, size=(200, 3))  # also beyond the ends
    x = np.array([1.0, -1.0, 0.5]) + u * h
    expected = ndimage.map_coordinates(coefficients, (u + PAD).T, order=3, mode="mirror", prefilter=False)
    verified.below(
        "independent", "cubic spline of a grid: φ, relative", reference="SciPy's `map_coordinates`", bound=1e-12,
        measured=np.abs(surface.phi(x) - expected).max() / np.abs(expected).max(),
    )  # fmt: skip

    u = rng.uniform(0, 7, size=(200, 3))
    x = np.array([1.0, -1.0, 0.5]) + u * h
    hat = BSpline.basis_element(np.arange(-2.0, 3.0), extrapolate=False)
    offset = (u + PAD)[:, :, None] - np.arange(max(coefficients.shape))
    weights = [np.nan_to_num((hat.derivative(k) if k else hat)(offset)) / h[:, None] ** k for k in range(3)]

    def derivative(*orders: int) -> np.ndarray:
        rows = [weights[k][:, axis, : coefficients.shape[axis]] for axis, k in enumerate(orders)]
        return np.einsum("ijk,ni,nj,nk->n", coefficients, *rows)

    unit = np.eye(3, dtype=int)
    gradient, hessian = surface.gradient(x), surface.hessian(x)
    for i in range(3):
        exact = derivative(*unit[i])
        np.testing.assert_allclose(gradient[:, i], exact, rtol=0, atol=1e-12 * np.abs(exact).max())
        for j in range(3):
            exact = derivative(*(unit[i] + unit[j]))
            np.testing.assert_allclose(hessian[:, i, j], exact, rtol=0, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize("kind", RADII)
def test_gaussian_curvature_is_of_second_order(kind, tmp_path, verified):
    exact = surfaces.make("ellipsoid", {"radii": list(RADII[kind])})
    error, spacing = [], []
    for count in (41, 61, 81, 121):
        x, h = nodes(count)
        surface = from_array(tmp_path, distance(x, RADII[kind]), h)
        assert surface.closed
        points = surface.project(directions() * RADII[kind])
        error.append(np.abs(surface.gaussian_curvature(points) - exact.gaussian_curvature(exact.project(points))).max())
        spacing.append(h)
    name = f"{kind} on a grid: order of the Gaussian curvature in the spacing"
    verified.order(name, measured=slope(spacing, error), reference="closed form")
    assert error[-1] < 3e-3


def moved(surface: surfaces.Surface, device: str) -> np.ndarray:
    start = directions(60)
    rods = BoundRods(surface, start[:30], start[30:], geodesic_curvature=1.5, device=device)
    rods.step(2e-3, 50)
    assert rods.variables()["constraint"].max() < 1e-9
    return rods.position


@pytest.mark.long
def test_filaments_move_as_on_the_built_in_sphere_to_second_order(tmp_path, device, verified):
    exact = moved(surfaces.make("sphere", {"radius": 1.0}), device)
    error, spacing = [], []
    for count in (41, 61, 81, 121):
        x, h = nodes(count)
        error.append(np.abs(moved(from_array(tmp_path, distance(x), h), device) - exact).max())
        spacing.append(h)
    verified.order(
        "filaments on a sphere from a grid: order in the spacing", measured=slope(spacing, error),
        reference="the built-in sphere",
    )  # fmt: skip
    assert error[-1] < 1e-4


@pytest.mark.parametrize("dtype", [bool, np.uint8, np.int32])
def test_a_segmented_stack_gives_a_smooth_surface_at_its_boundary(dtype, tmp_path):
    """To a fifth of a voxel; the curvature is approximate and improves with the number of voxels per radius."""
    x, h = nodes(61)
    surface = from_array(tmp_path, ((distance(x) < 0) * 3).astype(dtype), h)
    assert surface.closed
    points = surface.project(directions())
    assert np.abs(np.linalg.norm(points, axis=-1) - 1).max() < 0.2 * h
    gauss = surface.gaussian_curvature(points)
    assert gauss.mean() == pytest.approx(1, abs=0.02) and gauss.std() < 0.1


def test_spacing_origin_and_axes_are_those_of_the_array(tmp_path):
    shape, spacing, origin = (30, 40, 50), np.array([0.1, 0.08, 0.05]), np.array([1.0, 2.0, 3.0])
    x = origin + np.moveaxis(np.indices(shape), 0, -1) * spacing
    centre = origin + np.array([1.5, 1.6, 1.1])
    np.save(tmp_path / "phi.npy", np.linalg.norm(x - centre, axis=-1) - 0.6)
    values = {"file": str(tmp_path / "phi.npy"), "spacing": list(spacing)}
    surface = surfaces.make("grid", values | {"origin": list(origin)})
    np.testing.assert_allclose(surface.box, [origin, origin + (np.array(shape) - 1) * spacing], atol=1e-12)
    points = surface.project(centre + 0.7 * directions())
    assert np.abs(np.linalg.norm(points - centre, axis=-1) - 0.6).max() < 1e-4
    low, high = surfaces.make("grid", values).box
    np.testing.assert_allclose(low, -high, atol=1e-15)


@pytest.mark.parametrize("suffix", ["ply", "stl", "obj"])
def test_a_closed_mesh_gives_its_surface(suffix, tmp_path):
    """A triangulated ball, up to 3e-3 below the sphere, smoothed; triangles facing inwards or outwards."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    if suffix == "stl":
        ball.invert()
    ball.export(tmp_path / f"ball.{suffix}")
    centre = np.array([0.0, 0.0, 5.0])
    values = {"file": str(tmp_path / f"ball.{suffix}"), "spacing": 0.06, "origin": list(centre)}
    surface = surfaces.make("grid", values)
    assert surface.closed
    points = surface.project(centre + directions())
    assert np.abs(np.linalg.norm(points - centre, axis=-1) - 1).max() < 6e-3
    assert np.abs(surface.gaussian_curvature(points) - 1).max() < 0.06


def test_the_red_blood_cell_has_the_shape_of_its_formula(verified):
    """The profile of Evans and Fung, within a fifth of a grid spacing."""
    scene = Scene.load(SCENES / "real_shape.toml")
    assert Scene.parse(scene.to_toml()) == scene
    surface = surfaces.make(scene.surface.kind, scene.surface.parameters)
    angle = np.linspace(0, np.pi / 2, 50)
    q = np.sin(angle) ** 2
    profile = 3.91 / 2 * np.cos(angle) * (0.207161 + 2.002558 * q - 1.122762 * q**2)
    x = np.stack([3.91 * np.sin(angle), 0 * q, profile], axis=-1)
    verified.below(
        "published", "red blood cell from its mesh: distance from the profile, in grid spacings",
        measured=np.linalg.norm(surface.project(x) - x, axis=-1) / 0.1, bound=0.2, reference="Evans and Fung 1972",
    )  # fmt: skip


def wrong_files(folder: Path) -> dict[str, Path]:
    ball = trimesh.creation.icosphere(subdivisions=2)
    turned = ball.faces[:, ::-1]
    meshes = {
        "open.ply": trimesh.Trimesh(ball.vertices, ball.faces[1:]),
        "both.ply": trimesh.Trimesh(ball.vertices, np.where(ball.faces.min(axis=1)[:, None] == 0, turned, ball.faces)),
    }
    for name, mesh in meshes.items():
        mesh.export(folder / name)
    arrays = {"flat": np.ones((9, 9)), "small": np.ones((9, 9, 3)), "full": np.ones((9, 9, 9), dtype=bool)}
    arrays |= {"nan": np.full((9, 9, 9), np.nan), "text": np.full((9, 9, 9), "a"), "above": np.ones((9, 9, 9))}
    arrays["inside_out"] = -distance(nodes(21)[0])
    for name, values in arrays.items():
        np.save(folder / f"{name}.npy", values)
    np.save(folder / "pickled.npy", np.array([{}], dtype=object), allow_pickle=True)
    (folder / "empty.npy").write_bytes(b"")
    (folder / "noise.stl").write_bytes(b"no mesh")
    return {path.name: path for path in folder.iterdir()}


WRONG = [
    ("open.ply", {}, ["surface.file", "is not closed"]),
    ("both.ply", {}, ["surface.file", "face inwards and others"]),
    ("noise.stl", {}, ["surface.file"]),
    ("open.ply", {"spacing": 0}, ["surface.spacing = 0: must be a positive number, or three"]),
    ("flat.npy", {}, ["surface.file", "shape (9, 9)"]),
    ("small.npy", {}, ["shape (9, 9, 3)", "at least 8"]),
    ("text.npy", {}, ["<U1"]),
    ("full.npy", {}, ["all inside or all outside"]),
    ("nan.npy", {}, ["not finite"]),
    ("above.npy", {}, ["surface.file", "positive at the"]),
    ("inside_out.npy", {}, ["outward is where φ > 0"]),
    ("pickled.npy", {}, ["cannot be read as an array"]),
    ("empty.npy", {}, ["cannot be read as an array"]),
    ("above.npy", {"spacing": None}, ["surface.spacing: missing"]),
    ("above.npy", {"spacing": [1, 2]}, ["surface.spacing"]),
    ("above.npy", {"origin": 1.0}, ["surface.origin = 1.0: must be three numbers"]),
    ("above.npy", {"size": 1.0}, ["surface.size", "file, spacing, origin"]),
    ("absent.npy", {}, ["there is no file", "absent.npy"]),
    ("shape.czi", {}, ["surface.file", ".npy, .obj, .stl, .ply"]),
]


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, Path]:
    return wrong_files(tmp_path_factory.mktemp("wrong"))


@pytest.mark.parametrize(("name", "changes", "words"), WRONG)
def test_a_file_that_defines_no_membrane_is_refused_with_the_reason(name, changes, words, files):
    values = {"file": str(files.get(name, Path("absent") / name)), "spacing": 0.1} | changes
    with pytest.raises(SceneError) as caught:
        surfaces.make("grid", {key: value for key, value in values.items() if value is not None})
    for word in words:
        assert word in str(caught.value)


@pytest.mark.long
def test_compiles_to_ptx(tmp_path):
    if 80 not in wp.get_cuda_supported_archs():
        pytest.skip("no CUDA code generation here")
    module = bound_frames.on_surface(spline).rebuild.module
    (path,) = wp.compile_aot_module(module, arch=80, module_dir=tmp_path, use_ptx=True)
    assert ".entry" in path.read_text()
