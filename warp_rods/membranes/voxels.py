"""Segmented stacks: which voxels are inside, and a smooth membrane of triangles between them and the others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage, sparse

from warp_rods.membranes.bodies import Bodies, oriented
from warp_rods.membranes.files import MOST_NODES, FileError, counted
from warp_rods.membranes.triangles import iso_surface

__all__ = ["Mask", "mask_of", "membrane"]

FEWEST_VOXELS = 27
"""Smaller bodies and cavities have no shape and are left out."""
SHRINK, GROW, ROUNDS = 0.5, -0.51, 100
"""Taubin's filter: shrinking and growing steps in turn remove what is shorter than about ten edges and keep volumes."""
FARTHEST = 0.5
"""Largest displacement of a point by the filter along each axis, in voxels."""
AVERAGED = 8
"""Rounds by which normals are averaged for the finest part, over steps between voxels."""
CONTINUED = 16
"""Voxels (of the largest size) by which a stack is continued where the membrane leaves it."""


class Mask(NamedTuple):
    """A segmented stack."""

    inside: np.ndarray
    """The fraction of each voxel [x, y, z] that is inside, 0 to 1; the membrane is at 1/2."""
    notes: list[str]


def mask_of(values: np.ndarray, label: int | None) -> Mask | None:
    """The mask that an array [x, y, z] is, or None for a level set; raises FileError where it cannot be either."""
    if values.dtype.kind == "b" and label is None:
        return Mask(values.astype(np.float32), [])
    if values.dtype.kind != "f":
        return _labelled(values.astype(np.uint8) if values.dtype.kind == "b" else values, label)
    if not np.isfinite(values).all():
        raise FileError("contains values that are not finite")
    low, high = float(values.min()), float(values.max())
    if low == 0 and high > 0 and (values == np.round(values)).all():
        return _labelled(values, label)
    if label is not None:
        raise FileError(f"has floats from {low:.4g} to {high:.4g}, no labels: leave out label")
    if low < 0 < high and ((values == low) | (values == high)).all():
        return Mask((values < 0).astype(np.float32), [f"two values, {low:g} inside and {high:g} outside: a mask"])
    if low == 0 and 0.5 < high <= 1:
        return Mask(values.astype(np.float32), ["values from 0 to 1, taken as the fraction inside: membrane at 1/2"])
    return None


def _labelled(values: np.ndarray, label: int | None) -> Mask:
    labels = np.unique(values)
    if labels[0] < 0:
        raise FileError(
            f"has whole numbers from {labels[0]:g} to {labels[-1]:g}: labels are 0 outside and positive inside; a "
            f"level set is saved as floats"
        )
    present = ", ".join(f"{value:g}" for value in labels[labels > 0][:10])
    if label is not None:
        if label not in labels:
            raise FileError(f"has no voxel with label = {label}; there are {present or 'none'}")
        return Mask((values == label).astype(np.float32), [])
    many = int((labels > 0).sum())
    notes = [f"{many} labels ({present}{', …' if many > 10 else ''}) taken together; label = … takes one"]
    return Mask((values != 0).astype(np.float32), notes if many > 1 else [])


def membrane(inside: np.ndarray, spacing: np.ndarray, origin: np.ndarray) -> tuple[Bodies, np.ndarray, list[str]]:
    """The membrane around voxels, whether it leaves the stack at its first and last slices [axis, end], and notes.

    inside: fractions [x, y, z]; voxels have their middles at origin + (i, j, k) spacing. Where the membrane leaves the
    stack it goes straight on for ``CONTINUED`` voxels. Raises FileError where there is none.
    """
    cleaned, notes = _without_specks(inside)
    if (inside > 0.5).any() and not (cleaned > 0.5).any():
        raise FileError(f"has only specks of fewer than {FEWEST_VOXELS} voxels inside: too few for a shape")
    if not (cleaned > 0.5).any() or (cleaned > 0.5).all():
        raise FileError("has voxels that are all inside or all outside: there is no boundary")
    if all((np.take(cleaned, (0, -1), axis) > 0.5).all() for axis in range(3)):
        raise FileError("is inside all over the faces of the array: exchange inside and outside (outward is φ > 0)")
    leaves = np.array([[(np.take(cleaned, end, axis) > 0.5).any() for end in (0, -1)] for axis in range(3)])
    cleaned, first = _fitting(cleaned, spacing, leaves)
    field, finer = _between_slices(cleaned, spacing)
    points, faces = iso_surface(field, finer, origin + first * spacing, cubic=False)
    bodies = oriented(_smoothed(points, faces, finer), faces)[0]
    volume = float(cleaned.sum(dtype=float) * spacing.prod())
    return bodies.with_volume(volume, FARTHEST * float(finer.min())), leaves, notes


def _fitting(inside: np.ndarray, spacing: np.ndarray, leaves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The stack cropped to what is inside, continued where that leaves it; and the first voxel [3]."""
    beyond = np.ceil(CONTINUED * spacing.max() / spacing).astype(int)
    ends = [np.flatnonzero((inside > 0.5).any(axis=tuple({0, 1, 2} - {axis})))[[0, -1]] for axis in range(3)]
    around = np.pad(inside, 2)  # two voxels outside on each side
    cropped = around[tuple(slice(first, last + 5) for first, last in ends)]
    trimmed = tuple(slice(2 * a, n - 2 * b) for (a, b), n in zip(leaves.astype(int), cropped.shape, strict=True))
    added = np.where(leaves, beyond[:, None], 0)
    first = np.array([start - (0 if leaf else 2) for (start, _), leaf in zip(ends, leaves[:, 0], strict=True)])
    return np.pad(cropped[trimmed], added, mode="edge"), first - added[:, 0]


def _between_slices(inside: np.ndarray, spacing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A field, negative inside, on a grid with slices in between along axes of large spacing; and its spacing.

    Between two slices the distances to their outlines are interpolated, so that an outline that shifts from slice to
    slice becomes a slope and not a step.
    """
    field, finer = 0.5 - inside, spacing.astype(float)
    for axis in np.argsort(-spacing):
        times = min(int(np.round(spacing[axis] / spacing.min())), int(MOST_NODES / field.size))
        if times > 1:
            outlines = _outlines(np.moveaxis(field < 0, axis, 0), np.delete(finer, axis))
            field = np.moveaxis(_interpolated(outlines, times), 0, axis)
            finer[axis] /= times
    return field, finer


def _interpolated(slices: np.ndarray, times: int) -> np.ndarray:
    """Slices [n, y, z] with others between them, ``times`` as many, linear between two."""
    i, part = np.divmod(np.arange((len(slices) - 1) * times + 1), times)
    part = (part / times)[:, None, None]
    return (1 - part) * slices[i] + part * slices[np.minimum(i + 1, len(slices) - 1)]


def _outlines(slices: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """In each slice [n, y, z] the distance to the outline, negative inside.

    A slice without an outline counts as far from it as the deepest point of its neighbours, so that ends are rounded.
    """
    half, found = spacing.min() / 2, np.zeros(slices.shape)
    for k, inside in enumerate(slices):
        if inside.any() and not inside.all():
            outer = ndimage.distance_transform_edt(~inside, sampling=spacing) - half
            inner = ndimage.distance_transform_edt(inside, sampling=spacing) - half
            found[k] = np.where(inside, -inner, outer)
    deepest = np.maximum(-found.min(axis=(1, 2)), half)
    for k, inside in enumerate(slices):
        if not inside.any() or inside.all():
            depth = max(deepest[max(k - 1, 0)], deepest[min(k + 1, len(slices) - 1)])
            found[k] = depth if not inside.any() else -depth
    return found


def _without_specks(inside: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """The stack without bodies and cavities of a few voxels, and how many they were."""
    cleaned, notes = inside, []
    for what, filled in (("speck", 0.0), ("cavity", 1.0)):
        pieces, count = ndimage.label((cleaned > 0.5) if what == "speck" else (cleaned <= 0.5))
        small = np.bincount(pieces.ravel(), minlength=count + 1) < FEWEST_VOXELS
        small[0] = False
        if small.any():
            word = counted(int(small.sum()), what).replace("cavitys", "cavities")
            notes.append(f"{word} of fewer than {FEWEST_VOXELS} voxels left out")
            cleaned = np.where(small[pieces], np.float32(filled), cleaned)
    return cleaned, notes


def _smoothed(points: np.ndarray, faces: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """The points [v, 3] after Taubin's filter, none moved beyond its voxel."""
    i, j = faces[:, [0, 1, 2]].ravel(), faces[:, [1, 2, 0]].ravel()
    links = sparse.coo_matrix((np.ones(len(i)), (i, j)), shape=(len(points),) * 2).tocsr()
    links.data[:] = 1.0
    mean = sparse.diags(1 / np.maximum(np.asarray(links.sum(axis=1)).ravel(), 1)) @ links
    x = points
    for k in range(ROUNDS):
        x = x + (GROW if k % 2 else SHRINK) * (mean @ x - x)
    return points + np.clip(x - points, -FARTHEST * spacing, FARTHEST * spacing)
