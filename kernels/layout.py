"""Types of the arrays in kernels, and the order of their elements in memory.

One-dimensional arrays are indexed ``[rod]``, or ``[point]`` where all nodes of a scene form one list. Two-dimensional
arrays are indexed ``[rod, node]``; those of fields, ``lanes.py``, ``[tile, node]``. On the CPU one thread handles a
tile, so the nodes of a tile are adjacent in memory. On a GPU adjacent threads handle adjacent rods, so the rods are.
Kernels do not depend on this order, because Warp arrays carry their strides.
"""

from typing import Any

import warp as wp

real = wp.float64
"""Floating-point type of all fields and linear systems."""

Integers1D = wp.array(dtype=wp.int32)
Scalars1D = wp.array(dtype=real)
Vectors1D = wp.array(dtype=wp.vec3d)
Matrices1D = wp.array(dtype=wp.mat33d)

Integers2D = wp.array2d(dtype=wp.int32)
Scalars2D = wp.array2d(dtype=real)
Pairs2D = wp.array2d(dtype=wp.vec2d)
Vectors2D = wp.array2d(dtype=wp.vec3d)
Matrices2D = wp.array2d(dtype=wp.mat33d)
Quaternions2D = wp.array2d(dtype=wp.quatd)
Values2D = wp.array2d(dtype=Any)
"""Scalars, pairs or vectors."""


def per_node(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """Zeros of shape ``[rods, nodes]`` in the memory order that suits the device."""
    if wp.get_device(device).is_cuda:
        return wp.zeros((nodes, rods), dtype=dtype, device=device).transpose()
    return wp.zeros((rods, nodes), dtype=dtype, device=device)


def per_rod(rods: int, dtype=real, device=None) -> wp.array:
    """Zeros of shape ``[rods]``."""
    return wp.zeros(rods, dtype=dtype, device=device)


def workspace(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """An array [rods, nodes] whose values are not needed after the launch that wrote them.

    A launch on the CPU handles one rod after another. There one row serves all rods, and stays in the nearest cache.
    """
    if wp.get_device(device).is_cuda:
        return per_node(rods, nodes, dtype, device)
    row = wp.zeros(nodes, dtype=dtype, device=device)
    return _view(row, (rods, nodes), (0, row.strides[0]))


def constant_zero(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """An array [rods, nodes] of zeros that is stored as a single zero; it must not be written to."""
    return _view(wp.zeros(1, dtype=dtype, device=device), (rods, nodes), (0, 0))


def along_rods(values: wp.array, nodes: int) -> wp.array:
    """A field [tile, node] of one value for each tile [tile], which is stored once."""
    return _view(values, (values.shape[0], nodes), (values.strides[0], 0))


def _view(base: wp.array, shape: tuple[int, int], strides: tuple[int, int]) -> wp.array:
    """A view of another shape. It does not own its memory: its deleter keeps the base alive, and deletes nothing."""

    def deleter(_pointer: int, _size: int, _base: wp.array = base) -> None: ...

    return wp.array(ptr=base.ptr, shape=shape, strides=strides, dtype=base.dtype, device=base.device, deleter=deleter)


def to_host(array: wp.array):
    """A NumPy copy of an array; on the CPU ``array.numpy()`` would be a view of memory that the next step changes."""
    return array.numpy().copy()
