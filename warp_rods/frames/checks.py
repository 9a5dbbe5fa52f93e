"""Checks of vectors, rotations and curves; each raises SceneError with the name, the value and what is allowed."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError

ORTHONORMAL = 1e-5
"""Largest entry of RᵀR − 1 that counts as round-off of a rotation; frames in single precision pass."""


def finite(name: str, values: Any) -> np.ndarray:
    """Finite numbers of any shape."""
    read = arguments.reals(name, values)
    arguments.check(name, read, arguments.ANY)
    return read


def vectors(name: str, values: Any) -> np.ndarray:
    """Vectors [..., 3]."""
    return shaped(name, values, (3,), "vectors [..., 3]")


def matrices(name: str, values: Any) -> np.ndarray:
    """Matrices [..., 3, 3]."""
    return shaped(name, values, (3, 3), "matrices [..., 3, 3]")


def rotations(name: str, values: Any) -> np.ndarray:
    """Rotations [..., 3, 3]: orthonormal, right-handed."""
    read = shaped(name, values, (3, 3), "rotations [..., 3, 3]")
    gram = np.abs(np.swapaxes(read, -1, -2) @ read - np.eye(3)).max(axis=(-1, -2))
    wrong = (gram > ORTHONORMAL) | (np.linalg.det(read) < 0)
    if wrong.any():
        at = first(wrong)
        how = f"RᵀR − 1 has the entry {gram[at]:.2g}" if gram[at] > ORTHONORMAL else "it is left-handed"
        raise SceneError(f"{name}{place(at)}: must be a rotation, with orthonormal and right-handed columns; {how}")
    return read


def nodal_vectors(name: str, values: Any, least: int) -> np.ndarray:
    """Vectors along curves [..., node, 3], at least this many nodes."""
    read = vectors(name, values)
    return nodal(name, read, least, read.shape[-2] if read.ndim > 1 else 0, "[..., node, 3]")


def nodal_rotations(name: str, values: Any, least: int) -> np.ndarray:
    """Rotations along curves [..., node, 3, 3], at least this many nodes."""
    read = rotations(name, values)
    return nodal(name, read, least, read.shape[-3] if read.ndim > 2 else 0, "[..., node, 3, 3]")


def nodal_numbers(name: str, values: Any, least: int) -> np.ndarray:
    """Numbers along curves [..., node], at least this many nodes."""
    read = finite(name, values)
    return nodal(name, read, least, read.shape[-1] if read.ndim else 0, "[..., node]")


def curves(values: Any, closed: bool, least: int) -> np.ndarray:
    """Points of curves [..., node, 3] whose neighbours differ; of a closed curve the last and the first as well."""
    position = nodal_vectors("position", values, least)
    arguments.truth("closed", closed)
    step = np.diff(position, axis=-2, append=position[..., :1, :]) if closed else np.diff(position, axis=-2)
    same = ~np.any(step != 0, axis=-1)
    if same.any():
        at = first(same)
        node, after = at[-1], (at[-1] + 1) % position.shape[-2]
        hint = "do not repeat the first node of a closed curve" if after == 0 else "leave one of them out"
        point = ", ".join(f"{x:g}" for x in position[at])
        raise SceneError(
            f"position{place(at[:-1])}: nodes {node} and {after} are the same point ({point}): neighbours must differ; "
            f"{hint}"
        )
    return position


def spacings(values: Any, leading: tuple[int, ...]) -> np.ndarray:
    """Δs > 0: a number, or one for each curve; as an array that broadcasts with [..., node]."""
    read = finite("spacing", values)
    arguments.check("spacing", read, "positive")
    try:
        np.broadcast_to(read, leading)
    except ValueError:
        raise SceneError(
            f"spacing: must be one number, or one for each curve {leading}; has shape {read.shape}"
        ) from None
    return read[..., None]


def shaped(name: str, values: Any, shape: tuple[int, ...], allowed: str) -> np.ndarray:
    """Finite numbers whose last axes have this shape."""
    read = finite(name, values)
    if read.shape[-len(shape) :] != shape:
        raise SceneError(f"{name}: must be {allowed}; has shape {read.shape}")
    return read


def nodal(name: str, read: np.ndarray, least: int, nodes: int, shape: str) -> np.ndarray:
    """The array, if it has at least this many nodes."""
    if nodes < least:
        raise SceneError(f"{name}: must have {least} nodes or more, {shape}; has shape {read.shape}")
    return read


def first(wrong: np.ndarray) -> tuple[int, ...]:
    """The index of the first True."""
    return tuple(int(i) for i in np.argwhere(wrong)[0])


def place(at: tuple[int, ...]) -> str:
    """An index as text, empty for a single one."""
    return f"[{', '.join(map(str, at))}]" if at else ""
