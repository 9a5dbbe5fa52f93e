"""Meshes and stacks of voxels in files, sound ones and others."""

from __future__ import annotations

import random
import warnings
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
        head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header"
        return "\n".join([head, *map(row, points), *("3 " + " ".join(map(str, f)) for f in faces)])
    facets = (
        "facet normal 0 0 0\nouter loop\n" + "\n".join(f"vertex {row(points[i])}" for i in f) + "\nendloop\nendfacet"
        for f in faces
        if max(f) < len(points)
    )
    return "\n".join(["solid s", *facets, "endsolid s"])


def _damaged_mesh(points: np.ndarray, faces: np.ndarray, rng: random.Random) -> tuple[np.ndarray, np.ndarray]:
    some = rng.randrange(1, 6)
    match rng.randrange(12):
        case 0:
            faces = faces[:-some]
        case 1:
            faces = np.concatenate([faces, faces[:some]])
        case 2:
            faces[:some] = faces[:some, ::-1]
        case 3:
            points[rng.randrange(len(points))] = rng.choice((np.nan, np.inf, 1e300, -1e30))
        case 4:
            points = points * 10.0 ** rng.choice((-300, -45, -30, 20, 30, 100, 300))
        case 5:
            points[:, rng.randrange(3)] *= rng.choice((0.0, 1e-12, 1e-3))
        case 6:
            points, faces = (
                np.concatenate([points, points + [rng.choice((0.0, 1.0, 2.0, 2.2)), 0, 0]]),
                np.concatenate([faces, faces + len(points)]),
            )
        case 7:
            faces = faces[: rng.randrange(4)]
        case 8:
            faces[0, 0] = rng.choice((len(points), -5, 10**9))
        case 9:
            points[rng.randrange(len(points))] = points[0]
        case 10:
            points = points + rng.choice((1e6, 1e15))
    return points, faces


def mesh(number: int, folder: Path) -> str:
    """Writes the mesh of this number; returns the scene with it, in TOML."""
    rng = random.Random(f"mesh {number}")
    suffix = rng.choice(SUFFIXES)
    points, faces = _sphere(rng.choice((3, 4, 8)), rng.choice((3, 4, 9)))
    points = points * [1.0, rng.choice((1.0, 0.7)), rng.choice((1.0, 1.4))]
    if rng.random() < 0.85:
        points, faces = _damaged_mesh(points, faces, rng)
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
    values = _odd_values(values, rng)
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
    surface = {"kind": "grid", "file": str(path), "spacing": rng.choice((0.15, 0.15, 0.2, 0.3, [0.1, 0.1, 0.3], 1e-30, 1e20))}
    for key, values_of_key in (
        ("label", (1, 2, 0, 10**30)),
        ("axes", ("zyx", "xyz", "yx")),
        ("origin", ([0, 0, 0], [1e20] * 3, [1])),
    ):
        if rng.random() < 0.2:
            surface[key] = rng.choice(values_of_key)
    return _scene(surface)


def _odd_values(values: np.ndarray, rng: random.Random) -> np.ndarray:
    match rng.randrange(24):
        case 0:
            return values[0] if values.ndim else values
        case 1:
            return values[None]
        case 2:
            return np.full_like(values, rng.choice((0, 1)))
        case 3:
            return np.where(
                np.arange(values.size).reshape(values.shape) == 3,
                rng.choice((np.nan, np.inf, 1e300)),
                values.astype(float),
            )
        case 4:
            return values.astype(complex)
        case 5:
            return values.astype(str)
        case 6:
            return -values.astype(float)
        case 7:
            return values.astype(float) * rng.choice((1e-300, 1e-40, 1e30, 1e300))
        case 8:
            return values[:0]
        case 9:
            return np.random.default_rng(rng.randrange(10**6)).normal(size=values.shape)
        case 10:
            return values.astype("M8[s]")
        case 11:
            return np.repeat(values, 3, axis=0)[:, :: rng.choice((1, -1))]
    return values


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
