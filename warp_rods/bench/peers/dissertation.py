"""The method of the dissertation (§4.2): implicit backward differences of second order, a hybrid solver a step."""

from __future__ import annotations

import numpy as np
from scipy.optimize import root

from warp_rods.bench.peers.planar import Swimmer, right_side


def solve(swimmer: Swimmer, start: np.ndarray, times: np.ndarray, step: float) -> np.ndarray:
    """κ [time, node] of the half rod at ``times``, multiples of the step; right side as in planar.py."""
    rate = right_side(swimmer, len(start) // 2)
    now, before = start, start
    shown, wanted = [], np.round(times / step).astype(int)
    for number in range(1, wanted[-1] + 1):
        if number == 1:
            past, share, guess = now, 1.0, now
        else:
            past, share, guess = (4 * now - before) / 3, 2 / 3, 2 * now - before
        found = root(lambda y, past=past, share=share: y - past - share * step * rate(0.0, y), guess, method="hybr")
        if not found.success:
            raise ArithmeticError(f"step {number}: {found.message}")
        now, before = found.x, now
        if number in wanted:
            shown.append(np.append(now[::2], 0.0))
    return np.array(shown)
