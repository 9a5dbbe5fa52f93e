"""The drag by which a step treats contact, in NumPy (docs/model.md §6.4)."""

import numpy as np

from reference import free as twin

MARGIN, SOFT, STIFF = 1.2, 3.0, 10.0


class ContactFormula:
    """What contact needs of a step to ``t`` from levels at ``times``, newest first; of order 2, if there are two."""

    def __init__(self, times, t):
        levels = times[:2]
        values, _ = twin.lagrange(levels, t)
        _, slopes = twin.lagrange([t, *levels], t)
        signs = np.array([1.0, -1.0, 1.0])
        self.rate, self.ratio, self.lag = slopes[0], 0.0, 0.0
        self.foretold = values @ signs[: len(levels)]
        self.slope = slopes @ np.array([-1.0, *signs[: len(levels)]])
        if len(times) > 2:
            last, _ = twin.lagrange(times[1:3], times[0])
            squares = np.square(times[:3])
            self.ratio = min((t**2 - values @ squares[:2]) / (squares[0] - last @ squares[1:]), 1.0)
            self.lag = 1.0 - last @ signs[1:]

    def share(self, stiffness, drag):
        """θ for the largest κ of a node."""
        return np.clip((STIFF - 1.5 * stiffness / (self.rate * drag)) / (STIFF - SOFT), 0.0, 1.0)

    def drag(self, stiffness, own, share):
        """D for κ: places that change sign in each step neither grow nor decay at a stiffness of ``MARGIN`` κ."""
        pulls = own * self.slope + MARGIN * stiffness * self.foretold
        held = 1.0 + self.foretold + share * self.ratio * self.lag
        return np.maximum(pulls, 0.0) / (held * self.rate)

    def drag_of_matrix(self, K, own, share):
        """The same in the principal directions of 2K [..., n, n]."""
        kappa, directions = np.linalg.eigh(2 * K)
        return np.einsum("...ij,...j,...kj->...ik", directions, self.drag(kappa, own, share[..., None]), directions)
