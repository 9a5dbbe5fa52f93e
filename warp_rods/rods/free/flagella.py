"""The flagella of active rods: laws of their field f, and how it starts (thesis 4.12).

A law is a row of ``LAWS`` and a function in ``kernels/free/flagella.py``; a profile is a row of ``PROFILES``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warp_rods.kernels.free import flagella as kernel

LAWS: dict[str, int] = {
    "relaxing": int(kernel.RELAXING),
    "held": int(kernel.HELD),
}
"""``relaxing``: τf ∂t f = (1 − f²) u0 + D f'' (4.12). ``held``: only the diffusion; with D = 0, f stays."""

PROFILES: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "tanh": lambda s, sharpness: -np.tanh(sharpness * s),
    "piecewise": lambda s, sharpness: -np.sign(s),
    "uniform": lambda s, sharpness: np.ones_like(s),
}
"""f(s, 0) by name: compressive, smooth or with a jump at the middle (4.38), and pushing one way."""


@dataclass(frozen=True)
class Flagella:
    """How the flagellar field of an ensemble starts and evolves, dimensionless.

    relaxation τf > 0, diffusion D ≥ 0: a number or one a rod. profile: a name in ``PROFILES``, a function of
    s in [−1/2, 1/2], or values [node] or [rod, node]. sharpness: of the profile ``tanh``. law: in ``LAWS``.
    """

    relaxation: Any = 1e-2
    diffusion: Any = 1e-3
    profile: str | Callable[[np.ndarray], ArrayLike] | ArrayLike = "tanh"
    sharpness: float = 10.0
    law: str = "relaxing"

    def start(self, s: np.ndarray) -> np.ndarray:
        """f at the start at arc lengths ``s`` [node]; raises ValueError for an unknown name."""
        if isinstance(self.profile, str):
            return named(PROFILES, "profile", self.profile)(s, self.sharpness)
        values = self.profile(s) if callable(self.profile) else self.profile
        return np.asarray(values, dtype=float)

    @property
    def number(self) -> int:
        """The law's number in the kernels; raises ValueError for an unknown name."""
        return named(LAWS, "law", self.law)


PASSIVE = Flagella(profile=np.zeros_like, diffusion=0.0, law="held")
"""No flagella: f = 0 always."""


def named(table: dict[str, Any], what: str, name: str) -> Any:
    """A row of a table; raises ValueError with the names there are."""
    if name not in table:
        raise ValueError(f'{what} "{name}" is not one of {", ".join(table)}')
    return table[name]
