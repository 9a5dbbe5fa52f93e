"""Meshes and stacks of voxels in files, sound ones and others."""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import tomli_w

from fuzz.scenes import FILAMENTS, TIME

SUFFIXES = (".obj", ".ply", ".stl")


def _sphere(rings: int, sectors: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a closed sphere."""
    theta, angle = np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(sectors) / sectors
    ring = np.stack([np.outer(np.sin(theta), f(angle)) for f in (np.cos, np.sin)], axis=-1)
    z = np.repeat(np.cos(theta), sectors)
    points = np.concatenate([np.column_stack([ring.reshape(-1, 2), z]), [[0, 0, 1.0], [0, 0, -1.0]]])
    faces = []
    for j in range(sectors):
        k = (j + 1) % sectors
        faces += [(len(points) - 2, j, k), (len(points) - 1, (rings - 2) * sectors + k, (rings - 2) * sectors + j)]
        for i in range(rings - 2):
            a, b, c, d = i * sectors + j, i * sectors + k, (i + 1) * sectors + j, (i + 1) * sectors + k
            faces += [(a, c, d), (a, d, b)]
    return points, np.array(faces)


def _mesh_text(points: np.ndarray, faces: np.ndarray, suffix: str) -> str:
    def row(x: np.ndarray) -> str:
        return " ".join(f"{value:.9g}" for value in x)

    if suffix == ".obj":
        return "\n".join([f"v {row(p)}" for p in points] + ["f " + " ".join(str(i + 1) for i in f) for f in faces])
    if suffix == ".ply":
        head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
        head += "property float x\nproperty float y\nproperty float z\n"
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header"
        return "\n".join([head, *map(row, points), *("3 " + " ".join(map(str, f)) for f in faces)])
    facets = (
        "facet normal 0 0 0\nouter loop\n" + "\n".join(f"vertex {row(points[i])}" for i in f) + "\nendloop\nendfacet"
        for f in faces
        if max(f) < len(points)
    )
    return "\n".join(["solid s", *facets, "endsolid s"])


Mesh = tuple[np.ndarray, np.ndarray]


def _with_point(points: np.ndarray, number: int, value: float | np.ndarray) -> np.ndarray:
    changed = points.copy()
    changed[number] = value
    return changed


def _without_winding(faces: np.ndarray, some: int) -> np.ndarray:
    return np.concatenate([faces[:some, ::-1], faces[some:]])


def _twice(points: np.ndarray, faces: np.ndarray, shift: float) -> Mesh:
    return np.concatenate([points, points + np.array([shift, 0, 0])]), np.concatenate([faces, faces + len(points)])


def _flattened(points: np.ndarray, axis: int, factor: float) -> np.ndarray:
    return points * np.where(np.arange(3) == axis, factor, 1.0)


def _pointing_to(faces: np.ndarray, number: int) -> np.ndarray:
    changed = faces.copy()
    changed[0, 0] = number
    return changed


DAMAGE: tuple[Callable[[np.ndarray, np.ndarray, random.Random], Mesh], ...] = (
    lambda p, f, r: (p, f[: -r.randrange(1, 6)]),
    lambda p, f, r: (p, np.concatenate([f, f[: r.randrange(1, 6)]])),
    lambda p, f, r: (p, _without_winding(f, r.randrange(1, 6))),
    lambda p, f, r: (_with_point(p, r.randrange(len(p)), r.choice((np.nan, np.inf, 1e300, -1e30))), f),
    lambda p, f, r: (_with_point(p, r.randrange(len(p)), p[0]), f),
    lambda p, f, r: (p * 10.0 ** r.choice((-300, -45, -30, 20, 30, 100, 300)), f),
    lambda p, f, r: (_flattened(p, r.randrange(3), r.choice((0.0, 1e-12, 1e-3))), f),
    lambda p, f, r: _twice(p, f, r.choice((0.0, 1.0, 2.0, 2.2))),
    lambda p, f, r: (p, f[: r.randrange(4)]),
    lambda p, f, r: (p, _pointing_to(f, r.choice((len(p), -5, 10**9)))),
    lambda p, f, r: (p + r.choice((1e6, 1e15)), f),
)


def mesh(number: int, folder: Path) -> str:
    """Writes the mesh of this number; returns the scene with it, in TOML."""
    rng = random.Random(f"mesh {number}")
    suffix = rng.choice(SUFFIXES)
    points, faces = _sphere(rng.choice((3, 4, 8)), rng.choice((3, 4, 9)))
    points = points * [1.0, rng.choice((1.0, 0.7)), rng.choice((1.0, 1.4))]
    if rng.random() < 0.85:
        points, faces = rng.choice(DAMAGE)(points, faces, rng)
    data = _mesh_text(points, faces, suffix).encode()
    if rng.random() < 0.15:
        data = rng.choice(
            (
                data[: rng.randrange(len(data) + 1)],
                b"",
                bytes(rng.randrange(256) for _ in range(200)),
                data.replace(b" ", b"\x00", 3),
            )
        )
    path = folder / f"mesh{rng.choice(SUFFIXES) if rng.random() < 0.1 else suffix}"
    path.write_bytes(data)
    surface = {"kind": "grid", "file": str(path)}
    if rng.random() < 0.3:
        surface["spacing"] = rng.choice((0.1, 0.5, 3.0, 1e-3, 1e-9, 1e12))
    return _scene(surface)


def stack(number: int, folder: Path) -> str:
    """Writes the stack or level set of this number; returns the scene with it, in TOML."""
    rng = random.Random(f"stack {number}")
    n = rng.choice((1, 3, 8, 16, 20, 20, 20))
    grid = np.stack(np.meshgrid(*[np.linspace(-1.5, 1.5, n)] * 3, indexing="ij"))
    phi = np.linalg.norm(grid, axis=0) - 1.0
    values = phi if rng.random() < 0.5 else (phi < 0).astype(rng.choice(("u1", "i4", "f4", "?", "u2")))
    values = rng.choice(ODD)(values, rng) if rng.random() < 0.5 else values
    suffix = rng.choice((".npy", ".npy", ".npy", ".tif", ".nii", ".npz", ".nii.gz"))
    path = folder / f"stack{suffix}"
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        _write(path, values, rng)
    if rng.random() < 0.15:
        data = path.read_bytes()
        path.write_bytes(
            rng.choice((data[: rng.randrange(len(data) + 1)], b"", data[:100] + b"\xff" * 40 + data[140:]))
        )
    surface = {
        "kind": "grid",
        "file": str(path),
        "spacing": rng.choice((0.15, 0.15, 0.2, 0.3, [0.1, 0.1, 0.3], 1e-30, 1e20)),
    }
    for key, values_of_key in (
        ("label", (1, 2, 0, 10**30)),
        ("axes", ("zyx", "xyz", "yx")),
        ("origin", ([0, 0, 0], [1e20] * 3, [1])),
    ):
        if rng.random() < 0.2:
            surface[key] = rng.choice(values_of_key)
    return _scene(surface)


def _with_one(values: np.ndarray, value: float) -> np.ndarray:
    return np.where(np.arange(values.size).reshape(values.shape) == 3, value, values.astype(float))


ODD: tuple[Callable[[np.ndarray, random.Random], np.ndarray], ...] = (
    lambda v, r: v[0],
    lambda v, r: v[None],
    lambda v, r: v[:0],
    lambda v, r: np.full_like(v, r.choice((0, 1))),
    lambda v, r: _with_one(v, r.choice((np.nan, np.inf, 1e300))),
    lambda v, r: v.astype(complex),
    lambda v, r: v.astype(str),
    lambda v, r: v.astype("M8[s]"),
    lambda v, r: -v.astype(float),
    lambda v, r: v.astype(float) * r.choice((1e-300, 1e-40, 1e30, 1e300)),
    lambda v, r: np.random.default_rng(r.randrange(10**6)).normal(size=v.shape),
    lambda v, r: np.repeat(v, 3, axis=0)[:, :: r.choice((1, -1))],
)


def _write(path: Path, values: np.ndarray, rng: random.Random) -> None:
    if path.suffix == ".npy":
        np.save(path, values)
    elif path.suffix == ".npz":
        np.savez(path, values=values)
    elif path.suffix == ".tif":
        import tifffile

        readable = values if values.dtype.kind in "uif" and values.size else np.zeros((3, 4, 5), "u1")
        tifffile.imwrite(path, readable.astype("f4") if readable.dtype.kind == "f" else readable)
    else:
        import nibabel

        readable = values.astype("f4") if values.dtype.kind in "uif" and values.size else np.zeros((3, 4, 5), "f4")
        affine = np.diag([rng.choice((0.15, -0.15, 1e-9, 1e20)), 0.15, 0.15, 1.0])
        nibabel.save(nibabel.Nifti1Image(readable, affine if rng.random() < 0.3 else np.eye(4)), path)


def _scene(surface: dict) -> str:
    return tomli_w.dumps({"surface": surface, "filaments": [FILAMENTS | {"count": 1, "length": 0.3}], "time": TIME})
