"""Arrays of a page as text: whole numbers, differences that are small, gzip, base64; ``data.js`` reads them.

Positions are quantised to 65535 steps of the box of a frame. Second differences along a rod are then a few steps, which
gzip stores in less than a byte once low and high bytes are apart.
"""

from __future__ import annotations

import base64
import zlib
from typing import NamedTuple

import numpy as np

__all__ = [
    "LEVELS",
    "Packer",
    "Quantised",
    "packed_points",
    "packed_sheet",
    "packed_triangles",
    "packed_values",
    "quantised",
]

STEPS = 65535
LEVELS = 255
"""Colours, 0 to 254; 255 stands for no value."""


class Quantised(NamedTuple):
    """Whole numbers [..., 3] of points ``low + spacing · numbers``, low [3] and spacing [3]."""

    numbers: np.ndarray
    low: np.ndarray
    spacing: np.ndarray


class Packer:
    """Bytes that come one after the other, compressed as they come (gzip)."""

    def __init__(self) -> None:
        self._compress = zlib.compressobj(6, zlib.DEFLATED, 16 + zlib.MAX_WBITS)
        self._parts: list[bytes] = []

    def add(self, data: bytes) -> None:
        """Add bytes."""
        self._parts.append(self._compress.compress(data))

    def text(self) -> str:
        """All of it in base64; nothing can be added afterwards."""
        self._parts.append(self._compress.flush())
        return base64.b64encode(b"".join(self._parts)).decode("ascii")


def quantised(points: np.ndarray) -> Quantised:
    """Points [..., 3] in 65535 steps of the box that holds them; rounding moves them by half a step at most."""
    flat = points.reshape(-1, 3)
    low, high = flat.min(axis=0), flat.max(axis=0)
    spacing = np.where(high > low, (high - low) / STEPS, 1.0)
    return Quantised(np.rint((points - low) / spacing).astype(np.uint16), low, spacing)


def packed_points(numbers: np.ndarray) -> bytes:
    """Whole numbers [rod, node, 3] of rods at one frame, as second differences along the rods."""
    padded = np.pad(numbers.astype(np.int32), ((0, 0), (1, 0), (0, 0)))
    slopes = np.diff(padded, axis=1)
    bends = slopes.copy()
    bends[:, 2:] -= slopes[:, 1:-1]
    return _planes(_small(bends.astype(np.int16)))


def packed_values(fraction: np.ndarray) -> bytes:
    """Places on the scale of colours [rod, node], from 0 to 1 and NaN for no value, as differences along the rods."""
    with np.errstate(invalid="ignore"):
        levels = np.where(np.isfinite(fraction), np.rint(fraction * (LEVELS - 1)), LEVELS).astype(np.uint8)
    return np.diff(np.pad(levels, ((0, 0), (1, 0))), axis=1).tobytes()


def packed_sheet(numbers: np.ndarray, before: np.ndarray | None) -> bytes:
    """Whole numbers [point, 3] of a mesh at one frame, as differences from the frame before."""
    change = numbers.astype(np.int32) - (0 if before is None else before.astype(np.int32))
    return _planes(_small(change.astype(np.int16)))


def packed_triangles(triangles: np.ndarray) -> bytes:
    """Triangles [t, 3] of a mesh, each index as the difference from the one before."""
    flat = triangles.astype(np.int32).ravel()
    return _planes(_small(np.diff(np.concatenate([[0], flat])).astype(np.int32)))


def _small(change: np.ndarray) -> np.ndarray:
    """0, −1, 1, −2, … as 0, 1, 2, 3, …: small changes of either sign have high bytes of zero."""
    bits = change.dtype.itemsize * 8
    return ((change << 1) ^ (change >> (bits - 1))).astype(f"<u{change.dtype.itemsize}")


def _planes(numbers: np.ndarray) -> bytes:
    """All lowest bytes, then all next ones, …"""
    return np.ascontiguousarray(numbers.reshape(-1, 1).view(np.uint8).T).tobytes()
