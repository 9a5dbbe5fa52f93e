"""Rods as meshes: tubes with rounded ends, for programs that cannot draw curves."""

from __future__ import annotations

import numpy as np

__all__ = ["CAPS", "tube_faces", "tube_points"]

CAPS = np.deg2rad([80.0, 50.0, 20.0])
"""Angles of the rings that form a rounded end, from its pole outwards."""


def tube_points(lines: np.ndarray, radius: float, sides: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and unit normals [rod, ring, side, 3] of tubes round lines [rod, node, 3], and the node of each ring.

    Rings do not turn about the line from node to node; those of the ends are in ``CAPS``.
    """
    tangent = np.gradient(lines, axis=1)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=-1, keepdims=True), 1e-30)
    first = np.eye(3)[np.argmin(np.abs(tangent[:, 0]), axis=-1)]
    across = np.empty_like(lines)
    for node in range(lines.shape[1]):
        last = first if node == 0 else across[:, node - 1]
        flat = last - np.sum(last * tangent[:, node], axis=-1, keepdims=True) * tangent[:, node]
        across[:, node] = flat / np.maximum(np.linalg.norm(flat, axis=-1, keepdims=True), 1e-30)
    other = np.cross(tangent, across)
    angle = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)[:, None]
    outward = np.cos(angle) * across[:, :, None] + np.sin(angle) * other[:, :, None]
    sin, cos = np.sin(CAPS)[:, None, None], np.cos(CAPS)[:, None, None]
    back = cos * outward[:, :1] - sin * tangent[:, :1, None]
    front = cos[::-1] * outward[:, -1:] + sin[::-1] * tangent[:, -1:, None]
    normals = np.concatenate([back, outward, front], axis=1)
    last_node = lines.shape[1] - 1
    nodes = np.concatenate([np.zeros(len(CAPS), int), np.arange(last_node + 1), np.full(len(CAPS), last_node)])
    return lines[:, nodes, None] + radius * normals, normals, nodes


def tube_faces(rods: int, rings: int, sides: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the faces of tubes, one after the other, and how many each face has: quadrilaterals and two ends."""
    ring, side = np.arange(rings - 1)[:, None] * sides, np.arange(sides)
    turned = np.roll(side, -1)
    quads = np.stack([ring + side, ring + turned, ring + sides + turned, ring + sides + side], axis=-1).reshape(-1)
    one = np.concatenate([side[::-1], quads, (rings - 1) * sides + side])
    counts = np.concatenate([[sides], np.full((rings - 1) * sides, 4), [sides]])
    corners = np.arange(rods)[:, None] * rings * sides + one
    return corners.ravel().astype(np.int32), np.tile(counts, rods).astype(np.int32)
