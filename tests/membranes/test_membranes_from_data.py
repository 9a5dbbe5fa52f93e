"""Membranes from stacks and meshes: volume, necks, curvature, bodies, units and axes, against exact values."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.membranes.mesh import triangulate
from warp_rods.membranes.mesh_file import read_mesh

DIRECTIONS = np.random.default_rng(3).normal(size=(800, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=-1, keepdims=True)


def voxels(spacing, half=(1.6, 1.6, 1.6), shift=(0.013, 0.033, -0.004)) -> tuple[np.ndarray, np.ndarray]:
    """Middles [x, y, z, 3] of voxels around the origin, shifted so that no symmetry helps; and the first one."""
    axes = [np.arange(-int(a / h), int(a / h) + 1) * h + o for a, h, o in zip(half, spacing, shift, strict=True)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return x, x[0, 0, 0]


def saved(folder: Path, values: np.ndarray) -> str:
    np.save(folder / "stack.npy", values)
    return str(folder / "stack.npy")


def exported(folder: Path, *meshes: trimesh.Trimesh, name: str = "mesh.ply") -> str:
    trimesh.util.concatenate(list(meshes)).export(folder / name)
    return str(folder / name)


def volume(surface: surfaces.Surface) -> float:
    """The enclosed volume, from a triangulation whose points are on the surface."""
    mesh = triangulate(surface, 120)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def said(surface: surfaces.Surface) -> str:
    return "\n".join([*surface.data.notes, *surface.data.warnings])


@pytest.mark.parametrize(("slices", "tolerance"), [(1, 0.06), (2, 0.08), (3, 0.1)])
@pytest.mark.parametrize("voxels_per_radius", [4.3, 6.3, 12.3])
def test_a_ball_of_voxels_keeps_their_volume_whatever_the_slices(slices, tolerance, voxels_per_radius, tmp_path):
    """The volume of the voxels within half a per cent; the points of the membrane within a voxel's half diagonal."""
    h = np.array([1, 1, slices]) / voxels_per_radius
    x, first = voxels(h, (1.4, 1.4, 1.4 + 2 * h[2]))
    inside = np.linalg.norm(x, axis=-1) < 1
    surface = surfaces.make("grid", {"file": saved(tmp_path, inside), "spacing": h, "origin": first})
    assert surface.closed and len(surface.data.bodies) == 1
    assert volume(surface) == pytest.approx(inside.sum() * h.prod(), rel=0.01)
    radius = np.linalg.norm(surface.project(DIRECTIONS), axis=-1)
    assert np.abs(radius - 1).max() < np.linalg.norm(h) / 2
    assert np.abs(radius.mean() - 1) < tolerance / 2


def test_curvature_of_a_ball_of_voxels_is_as_good_as_is_said(tmp_path):
    for per_radius, most in ((6.3, 0.15), (18.75, 0.05)):
        x, first = voxels(np.full(3, 1 / per_radius))
        values = {"file": saved(tmp_path, np.linalg.norm(x, axis=-1) < 1), "spacing": 1 / per_radius, "origin": first}
        surface = surfaces.make("grid", values)
        k = -np.linalg.eigvalsh(surface.second_form(surface.project(DIRECTIONS))[2])
        error = np.sqrt(np.mean((k - 1) ** 2))
        assert error < most
        told = float(said(surface).split("curvature to about ")[1].split(" %")[0]) / 100
        assert error / 2 < told < 3 * error


def test_a_cell_that_leaves_the_stack_goes_straight_on(tmp_path):
    """A tube along x in a stack that it fills from end to end: an open patch, its radius that of the voxels."""
    h = 0.1
    x, first = voxels((h, h, h), (2.0, 1.4, 1.4), (0, 0.013, -0.004))
    inside = np.hypot(x[..., 1], x[..., 2]) < 1
    surface = surfaces.make("grid", {"file": saved(tmp_path, inside), "spacing": h, "origin": first})
    assert not surface.closed
    np.testing.assert_allclose(np.array(surface.box)[:, 0], [-2, 2], atol=h)
    points = np.stack([2 * DIRECTIONS[:, 0], DIRECTIONS[:, 1], DIRECTIONS[:, 2]], axis=-1)
    points[:, 1:] /= np.linalg.norm(points[:, 1:], axis=-1, keepdims=True)
    found = surface.project(points)
    assert np.abs(np.linalg.norm(found[:, 1:], axis=-1) - 1).max() < h / 2
    k = np.sort(np.abs(np.linalg.eigvalsh(surface.second_form(found)[2])))
    assert k[:, 1].mean() == pytest.approx(1, abs=0.02) and k[:, 0].max() < 0.1


@pytest.mark.long
@pytest.mark.parametrize(("b", "spacing"), [(1.1, None), (1.01, 0.02), (1.003, None)])
def test_the_neck_of_a_dividing_cell_keeps_its_radius(b, spacing, tmp_path):
    """Cassini's oval with a = 1: a neck of radius √(b² − a²), 𝒦 there as that of the formula."""
    exact, neck = surfaces.make("cassini", {"a": 1.0, "b": b}), np.sqrt(b * b - 1)
    mesh = triangulate(exact, 150)
    values = {"file": exported(tmp_path, trimesh.Trimesh(mesh.points, mesh.triangles))}
    surface = surfaces.make("grid", values | ({"spacing": spacing} if spacing else {}))
    assert len(surface.data.bodies) == 1
    x = surface.project(np.array([[neck, 0, 0.0]]))
    assert x[0, 0] == pytest.approx(neck, rel=0.02)
    assert surface.gaussian_curvature(x)[0] == pytest.approx(exact.gaussian_curvature(x)[0], rel=0.1)


@pytest.mark.long
def test_a_neck_too_fine_for_the_spacing_is_refused_and_one_that_changes_is_warned_of(tmp_path, caplog):
    exact = surfaces.make("cassini", {"a": 1.0, "b": 1.003})
    mesh = triangulate(exact, 150)
    file = exported(tmp_path, trimesh.Trimesh(mesh.points, mesh.triangles))
    with pytest.raises(SceneError, match=r"would fall into 2 pieces.*finer spacing"):
        surfaces.make("grid", {"file": file, "spacing": 0.2})
    surface = surfaces.make("grid", {"file": file, "spacing": 0.1})
    neck = surface.project(np.array([[np.sqrt(1.003**2 - 1), 0, 0]]))[0, 0]
    said_change = float(surface.data.warnings[0].split("finest part by ")[1].split(" %")[0]) / 100
    assert said_change < -0.2 and said_change == pytest.approx(neck / np.sqrt(1.003**2 - 1) - 1, abs=0.05)
    assert surface.data.warnings[0] in caplog.text


@pytest.mark.long
@pytest.mark.parametrize(("subdivisions", "tolerance"), [(2, 0.08), (3, 0.05), (4, 0.04)])
def test_curvature_of_a_coarse_mesh(subdivisions, tolerance, tmp_path):
    """Balls of 320 to 5120 triangles: 𝒦 at every point, relative to the ball of the same volume."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    surface = surfaces.make("grid", {"file": exported(tmp_path, ball)})
    assert volume(surface) == pytest.approx(ball.volume, rel=2e-3)
    radius = (3 * ball.volume / (4 * np.pi)) ** (1 / 3)
    gauss = surface.gaussian_curvature(surface.project(DIRECTIONS)) * radius**2
    assert np.abs(gauss - 1).max() < tolerance and gauss.mean() == pytest.approx(1, abs=0.005)
    assert not surface.data.warnings


@pytest.mark.long
@pytest.mark.parametrize("scale", [1e-9, 1e-6, 1.0, 1e6])
def test_meshes_and_stacks_in_any_unit(scale, tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3)
    ball.apply_scale(scale)
    x, first = voxels((0.1,) * 3)
    for values in (
        {"file": exported(tmp_path, ball, name="ball.stl")},
        {"file": saved(tmp_path, np.linalg.norm(x, axis=-1) < 1), "spacing": 0.1 * scale, "origin": first * scale},
    ):
        surface = surfaces.make("grid", values)
        points = surface.project(DIRECTIONS * scale) / scale
        assert np.abs(np.linalg.norm(points, axis=-1) - 1).max() < 0.05
        assert (np.sum(surface.normal(points * scale) * DIRECTIONS, axis=-1) > 0.9).all()


def balls(*places, radii=None, inwards=()) -> list[trimesh.Trimesh]:
    made = []
    for i, place in enumerate(places):
        ball = trimesh.creation.icosphere(subdivisions=3, radius=1.0 if radii is None else radii[i])
        ball.apply_translation(place)
        if i in inwards:
            ball.invert()
        made.append(ball)
    return made


@pytest.mark.parametrize("inwards", [(), (0,), (1,), (0, 1)])
def test_two_bodies_are_taken_whichever_way_they_face(inwards, tmp_path):
    places = np.array([[-1.5, 0, 0], [1.5, 0, 0]])
    surface = surfaces.make("grid", {"file": exported(tmp_path, *balls(*places, inwards=inwards))})
    assert len(surface.data.bodies) == 2 and "2 bodies" in said(surface)
    assert (surface.phi(places) < -0.5).all()
    assert volume(surface) == pytest.approx(8 * np.pi / 3, rel=0.02)
    assert ("1 of 2 bodies turned" in said(surface)) == (len(inwards) == 1)


@pytest.mark.long
@pytest.mark.parametrize("inwards", [(), (1,), (0, 1, 2)])
def test_a_shell_with_a_body_inside_is_oriented_by_nesting(inwards, tmp_path):
    radii = (2.0, 1.2, 0.6)
    meshes = balls(*np.zeros((3, 3)), radii=radii, inwards=inwards)
    surface = surfaces.make("grid", {"file": exported(tmp_path, *meshes)})
    x = np.zeros((4, 3))
    x[:, 0] = [0, 0.9, 1.6, 2.2]
    assert (np.sign(surface.phi(x)) == [-1, 1, -1, 1]).all()
    assert [body.depth for body in surface.data.bodies.bodies] == [0, 1, 2]
    assert "1 (cavity, volume 7.1" in said(surface)
    assert volume(surface) == pytest.approx(4 / 3 * np.pi * (2**3 - 1.2**3 + 0.6**3), rel=0.02)


def test_bodies_that_would_be_joined_or_lost_are_refused(tmp_path):
    meshes = balls([0, 0, 0], [2.3, 0, 0], [0, 4, 0], radii=(1.0, 1.0, 0.1))
    near, small = exported(tmp_path, *meshes[:2], name="near.ply"), exported(tmp_path, meshes[0], meshes[2])
    with pytest.raises(SceneError, match="2 parts would be joined"):
        surfaces.make("grid", {"file": near, "spacing": 0.4})
    with pytest.raises(SceneError, match=r"1 part of 2 would be gone, the first around \(0, 4, 0\)"):
        surfaces.make("grid", {"file": small, "spacing": 0.2})
    assert len(surfaces.make("grid", {"file": near}).data.bodies) == 2


def test_small_defects_are_mended_and_named(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3)
    edge = ball.edges_unique[0]
    vertices = np.vstack([ball.vertices, 1.2 * ball.vertices[edge].mean(axis=0), ball.vertices[ball.faces[7]]])
    n = len(ball.vertices)
    faces = np.vstack([ball.faces, [*edge, n], [n + 1, n + 2, n + 3], [edge[0], edge[0], edge[1]]])
    trimesh.Trimesh(vertices, faces, process=False).export(tmp_path / "loose.ply")
    surface = surfaces.make("grid", {"file": str(tmp_path / "loose.ply")})
    for words in ("1 triangle that hung loose left out, near (", "1 triangle given twice left out, near ("):
        assert words in said(surface)
    assert volume(surface) == pytest.approx(ball.volume, rel=3e-3)


def test_vertices_that_nearly_agree_are_merged_and_this_is_said(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=3)
    torn = ball.triangles.reshape(-1, 3) + np.random.default_rng(0).uniform(-1e-7, 1e-7, (3 * len(ball.faces), 3))
    trimesh.Trimesh(torn, np.arange(len(torn)).reshape(-1, 3), process=False).export(tmp_path / "torn.obj", digits=10)
    surface = surfaces.make("grid", {"file": str(tmp_path / "torn.obj")})
    assert "of the size of the mesh merged" in said(surface)


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("mesh.obj", b"v ", b"# gr\xf6\xdfe\no f\xfcr\nv "),
        ("mesh.obj", b"v ", b"\xef\xbb\xbfv "),
        ("mesh.ply", b"element vertex", b"comment gr\xf6\xdfe\nelement vertex"),
        ("mesh.stl_ascii", b"solid", b"solid gr\xf6\xdfe"),
    ],
)
def test_names_and_comments_of_a_mesh_may_be_in_any_encoding(name, before, after, tmp_path):
    mesh = trimesh.creation.icosphere(1)
    plain, other = tmp_path / "plain", tmp_path / "other"
    data = mesh.export(file_type=name.partition(".")[2])
    data = data.encode() if isinstance(data, str) else data
    data = data[data.index(b"v ") :] if name.endswith("obj") else data  # a mark of UTF-8 comes first
    suffix = Path(name).suffix.removesuffix("_ascii")
    plain.with_suffix(suffix).write_bytes(data)
    other.with_suffix(suffix).write_bytes(data.replace(before, after, 1))
    expected, found = (read_mesh(path.with_suffix(suffix))[0].bodies for path in (plain, other))
    assert found[0].volume == expected[0].volume == pytest.approx(mesh.volume, rel=1e-6)


@pytest.mark.parametrize(
    ("suffix", "before", "after"),
    [
        (".obj", b"v ", b"mtllib other\nusemtl a\nv "),
        (".ply", b"element vertex", b"comment TextureFile other\nelement vertex"),
    ],
)
def test_files_that_a_mesh_names_are_not_read(suffix, before, after, tmp_path, monkeypatch):
    """They may be devices without an end, and a material has no part in a membrane."""
    read = []
    monkeypatch.setattr(trimesh.visual.resolvers.FilePathResolver, "get", lambda _self, name: read.append(name))
    mesh = trimesh.creation.icosphere(1)
    data = mesh.export(file_type=suffix[1:])
    data = data.encode() if isinstance(data, str) else data
    (tmp_path / f"mesh{suffix}").write_bytes(data.replace(before, after, 1))
    assert read_mesh(tmp_path / f"mesh{suffix}")[0].bodies[0].volume == pytest.approx(mesh.volume, rel=1e-6)
    assert read == []


def test_an_enormous_mesh_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "mesh.stl"
    with path.open("wb") as file:
        file.truncate(20_000_000_000)
    with pytest.raises(SceneError, match=r"mesh\.stl has 20 GB: at most 500 MB: use a coarser mesh"):
        surfaces.make("grid", {"file": str(path)})


def test_an_open_mesh_is_refused_with_count_place_and_remedy(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=2)
    ball.apply_translation([10, 0, 0])
    hole = ball.triangles_center[0]
    with pytest.raises(SceneError) as caught:
        surfaces.make("grid", {"file": exported(tmp_path, trimesh.Trimesh(ball.vertices, ball.faces[1:]))})
    text = str(caught.value)
    assert "is not closed: 3 edges with one triangle, the first near (" in text and "fill_holes" in text
    place = [float(v) for v in text.split("near (")[1].split(")")[0].split(", ")]
    assert np.linalg.norm(np.array(place) - hole) < 0.3


def test_an_edge_of_four_triangles_is_named_as_what_it_is(tmp_path):
    cubes = [trimesh.creation.box((1, 1, 1)) for _ in range(2)]
    cubes[1].apply_translation((1, 1, 0))
    mesh = trimesh.util.concatenate(cubes)
    mesh.merge_vertices()
    with pytest.raises(SceneError, match=r"1 edge with 4 triangles, the first near \(0.5, 0.5, 0\)") as caught:
        surfaces.make("grid", {"file": exported(tmp_path, mesh)})
    assert "not closed" not in str(caught.value) and "join them" in str(caught.value)


BALL = np.linalg.norm(np.indices((30, 30, 30)) - 14.5, axis=0)


@pytest.mark.parametrize(
    "values",
    [
        BALL < 9,
        (BALL < 9).astype("f4"),
        (BALL < 9) * 7.0,
        np.asfortranarray((BALL < 9).astype(">u2") * 255),
        0.5 - (BALL < 9),
        np.clip(9.5 - BALL, 0, 1),
    ],
    ids=["bool", "float 0 and 1", "float label", "big-endian", "two values", "fractions"],
)
def test_masks_of_every_kind_are_the_same_ball(values, tmp_path):
    surface = surfaces.make("grid", {"file": saved(tmp_path, values), "spacing": 1.0})
    assert np.abs(np.linalg.norm(surface.project(9 * DIRECTIONS), axis=-1) - 9).max() < 0.4
    assert (np.sum(surface.normal(9 * DIRECTIONS) * DIRECTIONS, axis=-1) > 0.9).all()


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((BALL < 9) - 0.5, "is inside all over the faces"),
        (9 - BALL, "is negative all over the faces of the array"),
        (BALL, "is positive at the 30 × 30 × 30 nodes"),
        ((BALL < 9) * 1000.5, "is positive at the 30 × 30 × 30 nodes"),
        (np.round(BALL - 9).astype(int), "labels are 0 outside and positive inside"),
        (BALL < 1, "specks of fewer than 27 voxels"),
    ],
)
def test_arrays_that_are_no_membrane_are_named_as_what_they_are(values, words, tmp_path):
    with pytest.raises(SceneError, match=words):
        surfaces.make("grid", {"file": saved(tmp_path, values), "spacing": 1.0})


def test_a_label_picks_a_body_and_labels_taken_together_are_listed(tmp_path):
    x = np.indices((60, 30, 30)).T
    labels = np.zeros((60, 30, 30), dtype=np.uint8)
    for label, place in ((3, 14.5), (8, 44.5)):
        labels[(np.linalg.norm(x - [place, 14.5, 14.5], axis=-1) < 9).T] = label
    values = {"file": saved(tmp_path, labels), "spacing": 1.0, "origin": [0, 0, 0]}
    both = surfaces.make("grid", values)
    assert "2 labels (3, 8) taken together" in said(both) and len(both.data.bodies) == 2
    one = surfaces.make("grid", values | {"label": 8})
    assert one.phi(np.array([[44.5, 14.5, 14.5]]))[0] < -5 < 0 < one.phi(np.array([[14.5, 14.5, 14.5]]))[0]
    with pytest.raises(SceneError, match=r"no voxel with label = 5; there are 3, 8"):
        surfaces.make("grid", values | {"label": 5})
    with pytest.raises(SceneError, match=r"surface.label = 0: must be a whole number, 1 or more"):
        surfaces.make("grid", values | {"label": 0})


ELLIPSOID = np.array([1.4, 1.0, 0.7])


def ellipsoid(spacing) -> np.ndarray:
    return np.linalg.norm(voxels(spacing, (1.8, 1.4, 1.2), (0, 0, 0))[0] / ELLIPSOID, axis=-1) < 1


def check_axes(surface: surfaces.Surface) -> None:
    """An ellipsoid with three axes, its middle at the origin."""
    ends = surface.project(np.diag(ELLIPSOID))
    np.testing.assert_allclose(np.diag(ends), ELLIPSOID, atol=0.08)


@pytest.mark.parametrize("spacing", [(0.1, 0.1, 0.1), (0.1, 0.1, 0.2)])
def test_the_order_of_axes_is_that_of_the_image_tool(spacing, tmp_path):
    inside = ellipsoid(spacing)
    check_axes(surfaces.make("grid", {"file": saved(tmp_path, inside), "spacing": spacing}))
    turned = {"file": saved(tmp_path, inside.transpose()), "spacing": spacing, "axes": "zyx"}
    check_axes(surfaces.make("grid", turned))
    with pytest.raises(SceneError, match=r'surface.axes = "yxz": must be "xyz" or "zyx"'):
        surfaces.make("grid", turned | {"axes": "yxz"})


def test_stacks_of_microscopes_are_taken_with_their_voxel_size(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    spacing = (0.1, 0.1, 0.2)
    stack = ellipsoid(spacing).transpose().astype(np.uint8)
    about = {"PhysicalSizeX": 0.1, "PhysicalSizeY": 0.1, "PhysicalSizeZ": 200.0, "PhysicalSizeZUnit": "nm"}
    tifffile.imwrite(tmp_path / "cell.ome.tif", stack, metadata={"axes": "ZYX", **about})
    imagej = {"resolution": (10.0, 10.0), "metadata": {"axes": "ZYX", "spacing": 0.2, "unit": "um"}}
    tifffile.imwrite(tmp_path / "imagej.tif", stack, imagej=True, **imagej)
    for name in ("cell.ome.tif", "imagej.tif"):
        surface = surfaces.make("grid", {"file": tmp_path / name})
        assert surface.values["spacing"] == pytest.approx(spacing) and surface.data.metres == 1e-6
        check_axes(surface)
    tifffile.imwrite(tmp_path / "plain.tif", stack)
    with pytest.raises(SceneError, match=r"surface.spacing: missing, and .*plain.tif has no voxel size"):
        surfaces.make("grid", {"file": tmp_path / "plain.tif"})
    check_axes(surfaces.make("grid", {"file": tmp_path / "plain.tif", "spacing": spacing}))
    tifffile.imwrite(tmp_path / "film.tif", np.stack([stack] * 2), imagej=True, metadata={"axes": "TZYX"})
    with pytest.raises(SceneError, match=r"has axes TZYX of lengths \(2, .*save one channel at one time"):
        surfaces.make("grid", {"file": tmp_path / "film.tif", "spacing": spacing})


def test_nifti_is_turned_to_right_front_top(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    spacing = (0.1, 0.1, 0.2)
    inside = ellipsoid(spacing)
    inside[inside.shape[0] // 2 :, :, inside.shape[2] // 2 :] = False  # a quarter is missing: x > 0, z > 0
    turned = inside[::-1].transpose(1, 0, 2)  # on disk: y, then x from right to left, then z
    affine = np.array([[0, -0.1, 0, 0], [0.1, 0, 0, 0], [0, 0, 0.2, 0], [0, 0, 0, 1]])
    image = nibabel.Nifti1Image(turned.astype(np.float32), affine)
    image.header.set_xyzt_units("mm")
    nibabel.save(image, tmp_path / "cell.nii.gz")
    surface = surfaces.make("grid", {"file": tmp_path / "cell.nii.gz"})
    assert surface.values["spacing"] == pytest.approx(spacing) and surface.data.metres == 1e-3
    x = np.array([[-0.5, 0, 0.25], [0.5, 0, 0.25], [0.5, 0, -0.25], [0, 0.8, -0.2]])
    assert (np.sign(surface.phi(x)) == [-1, 1, -1, -1]).all()


def test_without_the_extra_its_name_is_said(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "tifffile", None)
    (tmp_path / "cell.tif").write_bytes(b"II*\0")
    with pytest.raises(SceneError, match=r"tifffile, which is not installed: pip install -e '\.\[images\]'"):
        surfaces.make("grid", {"file": tmp_path / "cell.tif"})
