"""No step has become three times slower: CPU time over that of a fixed NumPy kernel in the same run.

The only test that holds a time. A ratio to work of the same machine, in turns, at the same moment, hardly depends on
the machine or on what else it does. Where steps become quicker, set ``RECORDED`` to what a failure, or the command

    python -m pytest -n 0 -s tests/bench/test_regression.py

prints. Slower on purpose: say in the commit why.
"""

import numpy as np
import pytest

from warp_rods.bench import rods
from warp_rods.bench.timing import Work, ratio_in_turns

RECORDED = {"free": 8.0, "bound": 22.0}
"""Time of a node in a step over that of a number in ``polynomial``."""
SLOWER = 3.0
TURNS = 7
MAKE = {"free": lambda: rods.swimmers(100, True), "bound": lambda: rods.sensors(20, rods.dumbbell)}
NUMBERS = np.linspace(0.0, 1.0, 4096)
REPEATED = 64


def polynomial() -> None:
    """Horner's scheme on arrays that fit into the nearest cache."""
    for _ in range(REPEATED):
        total = np.ones_like(NUMBERS)
        for _ in range(10):
            total *= NUMBERS
            total += 1.0


@pytest.mark.parametrize("kind", RECORDED)
def test_a_step_is_not_slower_than_it_was(kind):
    stepped = rods.Stepped(MAKE[kind](), "own")
    ratio = ratio_in_turns(Work(stepped.run, stepped.restore), Work(polynomial), TURNS)
    ratio *= REPEATED * len(NUMBERS) / stepped.node_steps
    print(f"{kind}: {ratio:.3g}, recorded {RECORDED[kind]:g}")
    assert ratio < SLOWER * RECORDED[kind], f"{ratio:.3g} times a number of the polynomial; recorded: {RECORDED[kind]}"
