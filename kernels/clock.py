"""The clock of an ensemble: the length of a step, its ratio to the step before, and the time.

It is on the device, as a captured graph freezes the numbers that are passed to its kernels.
"""

import warp as wp

from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

per_clock = wp.array(dtype=wp.float64)

STEP = wp.constant(0)
"""Place of Δt in a clock."""
RATIO = wp.constant(1)
"""Place of ρ, the ratio of this step to the one before; 0 where there was none."""
TIME = wp.constant(2)
"""Place of the time t."""


@wp.kernel
def tick(clock: per_clock):
    """Advance the time by one step; the next step is as long unless the host says otherwise; ``dim = 1``."""
    clock[TIME] += clock[STEP]
    clock[RATIO] = real(1.0)
