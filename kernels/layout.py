"""Where an array's words lie in memory: decided here and nowhere else.

Every per-node array of an ensemble is indexed ``[rod, node]``. On the CPU, where one thread walks a rod,
a rod's nodes are neighbours in memory; on a GPU, where neighbouring threads hold neighbouring rods, the
rods are. Kernels never notice: Warp arrays carry their strides.
"""

import warp as wp

real = wp.float64
"""The number type of everything that a derivative or a solve is taken of."""


def per_node(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """Zeros of shape ``[rods, nodes]`` in the memory order that suits the device."""
    if wp.get_device(device).is_cuda:
        return wp.zeros((nodes, rods), dtype=dtype, device=device).transpose()
    return wp.zeros((rods, nodes), dtype=dtype, device=device)


def per_rod(rods: int, dtype=real, device=None) -> wp.array:
    """Zeros of shape ``[rods]``."""
    return wp.zeros(rods, dtype=dtype, device=device)


def scratch(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """Room [rods, nodes] that no rod keeps beyond one launch: on a CPU, where rods take turns, one row serves them all.

    It then stays in the nearest cache: what a step reads and writes in memory is the state alone.
    """
    if wp.get_device(device).is_cuda:
        return per_node(rods, nodes, dtype, device)
    row = wp.zeros(nodes, dtype=dtype, device=device)
    return _view(row, (rods, nodes), (0, row.strides[0]))


def one_zero(rods: int, nodes: int, dtype=real, device=None) -> wp.array:
    """Zero for every rod and node, stored once; never write to it."""
    return _view(wp.zeros(1, dtype=dtype, device=device), (rods, nodes), (0, 0))


def _view(base: wp.array, shape: tuple[int, int], strides: tuple[int, int]) -> wp.array:
    view = wp.array(ptr=base.ptr, shape=shape, strides=strides, dtype=base.dtype, device=base.device)
    view._ref = base  # a view does not own its memory
    return view


def to_host(array: wp.array):
    """A NumPy copy of an array; on the CPU ``array.numpy()`` would be a view of memory that the next step changes."""
    return array.numpy().copy()
