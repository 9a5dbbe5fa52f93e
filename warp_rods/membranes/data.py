"""The surface of a file: a level set, a segmented stack or a closed mesh; what the user is told of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_rods.membranes import voxels
from warp_rods.membranes.bodies import Bodies, oriented
from warp_rods.membranes.comparison import compared
from warp_rods.membranes.files import FEWEST_NODES, MESHES, MOST_NODES, FileError, check_distance
from warp_rods.membranes.fit import AVERAGED, Raw, fitted, interpolated, shape_of
from warp_rods.membranes.images import Header, ending, read_header, read_stack
from warp_rods.membranes.level_set import Data, LevelSet
from warp_rods.membranes.mesh_file import read_mesh
from warp_rods.membranes.triangles import iso_surface

__all__ = ["from_file"]

FACETS = 0.85
"""Width of the smoothing of a mesh in units of the distance between its folds."""
VOXELS = 4.0
"""Width of the smoothing of a stack in its smallest voxel size, where its parts are thick enough."""
VALUES = 1e-30, 1e30
"""Bounds of the largest value of a level set, which single precision can hold."""
Triple = tuple[float, float, float]
NOWHERE = np.full(3, -np.inf), np.full(3, np.inf)


def from_file(path: Path, spacing: Triple | None, origin: Triple, axes: str | None, label: int | None) -> LevelSet:
    """The surface in a file; raises FileError.

    spacing: between nodes, or the size of a voxel; that of a mesh may be left out. origin: the first node, or the
    displacement of a mesh.
    """
    h, start = None if spacing is None else np.array(spacing), np.array(origin)
    if ending(path) in MESHES:
        return _from_mesh(path, h, start)
    assert h is not None
    header = read_header(path, axes)
    if np.prod(header.shape, dtype=float) > MOST_NODES:
        raise FileError(f"has shape {header.shape}: at most {MOST_NODES:.0g} nodes in all; crop it, or make it coarser")
    check_distance(float(np.max(h * header.shape)), float(np.abs(start).max() + np.max(h * header.shape)))
    values, header = read_stack(path, axes)
    if header.spacing != spacing:  # given in the scene, in units of the scene
        header = header._replace(spacing=None, unit="")
    mask = voxels.mask_of(values, label)
    if mask is None:
        return _from_level_set(np.ascontiguousarray(values, dtype=float), h, start, header)
    return _from_mask(mask, h, start, header)


def _from_mesh(path: Path, spacing: np.ndarray | None, origin: np.ndarray) -> LevelSet:
    bodies, notes = read_mesh(path)
    check_distance(bodies.triangles.size, float(np.abs(origin).max()))
    moved = bodies.moved(origin)
    raw = Raw(moved, shape_of(moved, AVERAGED, NOWHERE), FACETS * moved.triangles.facets(), *NOWHERE)
    what = f"mesh of {len(moved.triangles.faces)} triangles"
    return compared(raw, fitted(raw, spacing), what, notes, "a finer spacing, or a finer mesh")


def _from_mask(mask: voxels.Mask, spacing: np.ndarray, origin: np.ndarray, header: Header) -> LevelSet:
    bodies, leaves, notes = voxels.membrane(mask.inside, spacing, origin)
    rounds = round(voxels.AVERAGED * float(spacing.max() / spacing.min()))
    last = origin + (np.array(mask.inside.shape) - 1) * spacing
    low, high = np.where(leaves[:, 0], origin, -np.inf), np.where(leaves[:, 1], last, np.inf)
    shape = shape_of(bodies, rounds, (low, high), _volume(mask.inside, spacing))
    raw = Raw(bodies, shape, max(VOXELS * float(spacing.min()), float(spacing.max())), low, high)
    size = " × ".join(f"{h:.4g}" for h in spacing) + (f" {header.unit}" if header.spacing else "")
    what = f"{int((mask.inside > 0.5).sum())} voxels of {size}"
    # Steps between voxels are noise: a smaller width would only bring them back.
    found = fitted(raw, None, refine=False)
    return compared(raw, found, what, [*mask.notes, *notes], "smaller voxels", header.metres)


def _volume(inside: np.ndarray, spacing: np.ndarray) -> float:
    """The volume of the voxels between the middles of the first and the last ones."""
    weights = [np.r_[0.5, np.ones(n - 2), 0.5] for n in inside.shape]
    return float(np.einsum("ijk,i,j,k->", inside.astype(float), *weights) * spacing.prod())


def _from_level_set(phi: np.ndarray, spacing: np.ndarray, origin: np.ndarray, header: Header) -> LevelSet:
    nodes = " × ".join(map(str, phi.shape))
    if min(phi.shape) < FEWEST_NODES:
        raise FileError(
            f"has shape {phi.shape} of {phi.dtype}: a level set (floats, negative inside) has at least {FEWEST_NODES} "
            f"nodes along each axis"
        )
    if not VALUES[0] <= (largest := float(np.abs(phi).max())) <= VALUES[1]:
        raise FileError(f"has values up to {largest:.3g} in size: must be from {VALUES[0]:g} to {VALUES[1]:g}")
    if (phi >= 0).all():
        raise FileError(
            f"is positive at the {nodes} nodes, from {phi.min():.4g} to {phi.max():.4g}: a level set is negative "
            f"inside, a mask is 0 outside and 1 (or a label) inside; an image has to be segmented before"
        )
    if (phi <= 0).all():
        raise FileError(f"is never positive at the {nodes} nodes: outward is where φ > 0")
    if all((np.take(phi, (0, -1), axis) <= 0).all() for axis in range(3)):
        raise FileError("is negative all over the faces of the array: outward is where φ > 0, so change the sign")
    points, faces = iso_surface(phi, spacing, origin)
    if not len(faces):
        raise FileError(f"is negative only where it is nearly zero, so that there is no membrane at the {nodes} nodes")
    bodies: Bodies = oriented(points, faces)[0]
    count = len(bodies)
    notes = (f"bodies {bodies.listed()}",) if count > 1 else ()
    return interpolated(phi, spacing, origin, data=Data(notes, (), bodies, header.metres))
