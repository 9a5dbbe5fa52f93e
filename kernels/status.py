"""The status of a rod: ok, or why it was frozen. The words are in ``warp_rods/rods/status.py``."""

import warp as wp

from warp_rods.kernels.layout import Integers1D, Scalars1D, real

wp.set_module_options({"enable_backward": False})

OK = wp.constant(0)
NOT_FINITE = wp.constant(1)
OFF_SURFACE = wp.constant(2)
TOO_BENT = wp.constant(3)
TOO_FAST = wp.constant(4)
KINK = wp.constant(5)
LEFT_DATA = wp.constant(6)
UNRESOLVED = wp.constant(7)

HALF_TURN = wp.constant(real(wp.pi))
"""A rod that bends by more between two adjacent nodes is ``TOO_BENT``."""


@wp.func
def why_frozen(status: int) -> int:
    """The status of a rod whose shortest step is not taken, from the status of that step: OK, but for its error."""
    if status == OK:
        return UNRESOLVED
    return status


@wp.kernel
def give_up(error: Scalars1D, allowed: real, status: Integers1D):
    """Mark the results of a step whose error is too large, in a step that cannot be shorter; ``dim = rods``."""
    rod = wp.tid()
    if error[rod] > allowed:
        status[rod] = why_frozen(status[rod])
