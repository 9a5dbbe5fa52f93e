"""The status of a rod: ok, or why it was frozen. The words are in ``warp_rods/rods/status.py``."""

import warp as wp

from warp_rods.kernels.layout import real

OK = wp.constant(0)
NOT_FINITE = wp.constant(1)
OFF_SURFACE = wp.constant(2)
TOO_BENT = wp.constant(3)
TOO_FAST = wp.constant(4)
KINK = wp.constant(5)
LEFT_DATA = wp.constant(6)

HALF_TURN = wp.constant(real(wp.pi))
"""A rod that bends by more between two adjacent nodes is ``TOO_BENT``."""
