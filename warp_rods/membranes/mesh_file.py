"""Closed triangles from an OBJ, STL or PLY file: small defects are mended, others are named with their place."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csgraph

from warp_rods.membranes.bodies import Bodies, oriented
from warp_rods.membranes.files import FileError, check_distance, counted, shown_point
from warp_rods.values import LARGEST

__all__ = ["read_mesh"]

MERGED = (8, 6, 5)
"""Decimals, in units of the size of a mesh, to which vertices are merged; the next ones while the mesh is open."""
LARGEST_FILE = 500_000_000
"""Bytes of a file, at most: ten million triangles in STL."""
HEADER = 80
"""Bytes before the number of triangles in binary STL."""
ASCII = bytes(range(128)) + b"?" * 128
SMALLEST_SIZE = 1e-30
"""Smallest size of a mesh."""
LOOSE = 0.01
"""Largest fraction of the area that is left out because it hangs loose."""

Place = Callable[[np.ndarray], str]
"""Words for a point in the coordinates of the mended mesh."""


def read_mesh(path: Path) -> tuple[Bodies, list[str]]:
    """The bodies in a file, and what was mended; raises FileError where the triangles are not closed."""
    raw = _triangles_in(path)
    # Tolerances of the mesh library are absolute, hence a mesh is looked at in units of its size.
    centre, size = raw.bounds.mean(axis=0), float(raw.extents.max())
    if size == 0:
        raise FileError("contains no triangle that has an area")
    if size < SMALLEST_SIZE:
        raise FileError(f"has a size of {size:.3g}: must be at least {SMALLEST_SIZE:g}: use other units")
    check_distance(size, float(np.abs(raw.vertices).max()))

    def place(x: np.ndarray) -> str:
        return shown_point(centre + size * x)

    mesh, notes = _mended((raw.vertices - centre) / size, raw.faces, place)
    if wrong := _not_closed(mesh, place) or _not_of_one_side(mesh, place):
        raise FileError(wrong)
    bodies, turned = oriented(centre + size * mesh.vertices, np.asarray(mesh.faces))
    if 0 < turned < len(bodies):  # where all face inwards, the file only has another convention
        notes.append(f"{turned} of {len(bodies)} bodies turned: outer ones face outwards, cavities inwards")
    return bodies, notes


def _triangles_in(path: Path) -> Any:
    """The mesh as it is in the file; raises FileError where it has no triangles between finite points."""
    import trimesh

    if (size := path.stat().st_size) > LARGEST_FILE:
        raise FileError(f"has {size / 1e9:.3g} GB: at most {LARGEST_FILE / 1e6:g} MB: use a coarser mesh")
    kind = path.suffix.lower()
    data = _with_plain_text(path.read_bytes(), kind)
    look = {} if kind == ".stl" else {"skip_materials": True}
    try:  # not by its path, or the files of materials and textures that a mesh names would be read, whatever they are
        raw = trimesh.load_mesh(io.BytesIO(data), file_type=kind[1:], process=False, **look)
    except Exception as error:  # each reader of trimesh raises its own
        raise FileError(f"cannot be read as a mesh: {error}") from None
    if not isinstance(raw, trimesh.Trimesh) or not len(raw.faces):
        raise FileError("contains no triangles")
    if not 0 <= raw.faces.min() <= raw.faces.max() < len(raw.vertices):
        raise FileError(f"has triangles between vertices {raw.faces.min()} to {raw.faces.max()} of {len(raw.vertices)}")
    if not np.isfinite(raw.vertices).all():
        raise FileError("contains vertices that are not finite")
    if (far := float(np.abs(raw.vertices).max())) > LARGEST:
        raise FileError(f"contains coordinates up to {far:.3g}; at most {LARGEST:g}: use other units")
    return raw


def _with_plain_text(data: bytes, kind: str) -> bytes:
    """The content of a file whose names and comments, which may be in any encoding, can be decoded."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    if kind == ".ply":
        end = data.find(b"end_header")
    else:
        triangles = int.from_bytes(data[HEADER : HEADER + 4], "little")
        end = HEADER if kind == ".stl" and len(data) == HEADER + 4 + 50 * triangles else len(data)
    try:
        data[:end].decode()
    except UnicodeDecodeError:
        return data[:end].translate(ASCII) + data[end:]
    return data


def _mended(vertices: np.ndarray, faces: np.ndarray, place: Place) -> tuple[Any, list[str]]:
    """A mesh without small defects, and what was done; vertices are merged no more than is necessary to close it."""
    first = None
    for decimals in MERGED:
        mesh, notes = _cleaned(vertices, faces, decimals, place)
        if first is None:
            first = mesh, notes
        elif mesh.is_watertight:
            return mesh, [f"vertices closer than 1e-{decimals} of the size of the mesh merged", *notes]
        if mesh.is_watertight:
            break
    assert first
    return first


def _cleaned(vertices: np.ndarray, faces: np.ndarray, decimals: int, place: Place) -> tuple[Any, list[str]]:
    """The mesh with equal vertices merged, without triangles that are flat, double or loose; and what was left out."""
    import trimesh

    mesh, notes = trimesh.Trimesh(vertices, faces, process=False), []
    mesh.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=decimals)
    for what, left_out in (("without area", _flat), ("given twice", _double), ("that hung loose", _loose)):
        if (out := left_out(mesh)).any():
            if what != "without area":
                near = place(mesh.triangles_center[out][0])
                notes.append(f"{counted(int(out.sum()), 'triangle')} {what} left out, near {near}")
            mesh.update_faces(~out)
    mesh.remove_unreferenced_vertices()
    return mesh, notes


def _flat(mesh: Any) -> np.ndarray:
    """Triangles with a corner twice, as is left of slivers when vertices are merged."""
    return (mesh.faces == mesh.faces[:, [1, 2, 0]]).any(axis=1)


def _double(mesh: Any) -> np.ndarray:
    return ~mesh.unique_faces()


def _loose(mesh: Any) -> np.ndarray:
    """Triangles in small open pieces, connected to each other where an edge has two triangles."""
    links, count = mesh.face_adjacency, len(mesh.faces)
    if not count:
        return np.zeros(0, dtype=bool)
    graph = coo_matrix((np.ones(len(links), dtype=bool), links.T), shape=(count, count))
    piece = csgraph.connected_components(graph, directed=False)[1]
    edges, uses = _edges(mesh)
    is_open = np.zeros(piece.max() + 1, dtype=bool)
    is_open[piece[mesh.edges_face[(uses == 1)[edges]]]] = True
    area = np.bincount(piece, weights=mesh.area_faces)
    return (is_open & (area < LOOSE * area.sum()))[piece]


def _edges(mesh: Any) -> tuple[np.ndarray, np.ndarray]:
    """For each side of a triangle the number of its edge, and for each edge the number of triangles."""
    _, edges, uses = np.unique(mesh.edges_sorted, axis=0, return_inverse=True, return_counts=True)
    return edges.ravel(), uses


def _not_closed(mesh: Any, place: Place) -> str:
    """Words on edges that do not have two triangles, or none."""
    edges, uses = _edges(mesh)
    if not len(edges):
        return "contains no triangle that has an area"
    words = []
    if (uses == 1).any():
        words.append(
            f"is not closed: {counted(int((uses == 1).sum()), 'edge')} with one triangle, "
            f"the first near {_first(mesh, (uses == 1)[edges], place)}: close the holes (trimesh.repair.fill_holes, "
            f"or a mesh editor)"
        )
    if (uses > 2).any():
        words.append(
            f"has {counted(int((uses > 2).sum()), 'edge')} with {uses.max()} triangles, "
            f"the first near {_first(mesh, (uses > 2)[edges], place)}, where parts touch along a line so that there "
            f"is no normal: move the parts apart, or join them (a union in a mesh editor)"
        )
    return "; ".join(words)


def _not_of_one_side(mesh: Any, place: Place) -> str:
    """Words on neighbours that face opposite sides, or none."""
    if mesh.is_winding_consistent:
        return ""
    _, way, times = np.unique(mesh.edges, axis=0, return_inverse=True, return_counts=True)
    wrong = (times > 1)[way.ravel()]
    return (
        f"has triangles that face inwards and others that face outwards: neighbours differ across "
        f"{counted(int(wrong.sum()) // 2, 'edge')}, the first near {_first(mesh, wrong, place)}: turn them "
        f"(trimesh.repair.fix_normals, or a mesh editor)"
    )


def _first(mesh: Any, sides: np.ndarray, place: Place) -> str:
    """The middle of the first of these sides of triangles."""
    return place(mesh.vertices[mesh.edges[np.flatnonzero(sides)[0]]].mean(axis=0))
