"""The flagella of an ensemble: the law of their field f, and how it starts (thesis 4.12).

The tables of laws and profiles are in ``scene/flagella.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warp_rods.errors import SceneError, named, refuse_unknown
from warp_rods.kernels.free import flagella as kernel
from warp_rods.rods.per_rod import parameter
from warp_rods.scene.flagella import LAWS, PROFILES

MOST_NUMBERS = 4
"""Parameters of its own that a law may have."""
RULES = {"any number": "any finite number", "positive": "positive", "zero or more": "zero or more"}
"""What a law asks of a parameter → the rule of ``per_rod``."""


@dataclass(frozen=True)
class Flagella:
    """How the flagellar field of an ensemble starts and evolves, dimensionless.

    relaxation τf > 0, diffusion D ≥ 0: a number or one a rod. profile: a name in ``PROFILES``, a function of
    s in [−1/2, 1/2], or values [node] or [rod, node]. sharpness: of the profile ``tanh``. law: in ``LAWS``;
    numbers: the law's own parameters by name. Raises SceneError for a law that is not known.
    """

    relaxation: Any = 1e-2
    diffusion: Any = 1e-3
    profile: str | Callable[[np.ndarray], ArrayLike] | ArrayLike = "tanh"
    sharpness: float = 10.0
    law: str = "relaxing"
    numbers: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        own = named(LAWS, "flagella.law", self.law).parameters
        refuse_unknown(self.numbers, own, f"flagella.numbers of the law {self.law!r}")

    @classmethod
    def read(cls, given: Flagella | Mapping[str, Any] | None) -> Flagella:
        """From a mapping with the names of the fields and of the law's own parameters; None: no flagella.

        Raises SceneError naming a key that is not known.
        """
        if given is None:
            return PASSIVE
        if isinstance(given, cls):
            return given
        if not isinstance(given, Mapping):
            raise SceneError(f"flagella = {given!r}: must be a mapping, Flagella or None")
        own = [one.name for one in fields(cls) if one.name != "numbers"]
        given = {name: value for name, value in given.items() if value is not None}
        law = named(LAWS, "flagella.law", given.get("law", cls.law))
        refuse_unknown(given, [*own, *law.parameters, "numbers"], "flagella")
        numbers = {name: value for name, value in given.items() if name in law.parameters}
        return cls(
            **{name: value for name, value in given.items() if name in own},
            numbers={**given.get("numbers", {}), **numbers},
        )

    def start(self, s: np.ndarray, count: int) -> np.ndarray:
        """f at the start [rod, node] at arc lengths ``s`` [node]; raises SceneError for values that do not fit."""
        profile = self.profile
        if isinstance(profile, str):
            profile = named(PROFILES, "flagella.profile", profile)(s, self.sharpness)
        try:
            given = np.asarray(profile(s) if callable(profile) else profile, dtype=float)
            values = np.broadcast_to(given, (count, len(s)))
        except (TypeError, ValueError) as error:
            raise SceneError(
                f"flagella.profile: must be one of {', '.join(PROFILES)}, a function of s, or numbers [node] or "
                f"[rod, node] for {count} rods of {len(s)} nodes: {error}"
            ) from None
        if not np.isfinite(values).all():
            raise SceneError("flagella.profile: must be finite at every node")
        return np.ascontiguousarray(values)

    @property
    def number(self) -> int:
        """The law's number in the kernels."""
        return int(getattr(kernel, LAWS[self.law].kernel))

    def law_numbers(self, count: int) -> np.ndarray:
        """The law's own parameters [rod, 4] in its order, zeros after them; raises SceneError for impossible ones."""
        values = np.zeros((count, MOST_NUMBERS))
        for column, (name, row) in enumerate(LAWS[self.law].parameters.items()):
            given = self.numbers.get(name, row.default)
            values[:, column] = parameter(f"flagella.{name}", given, count, RULES[row.allowed])
        return values


PASSIVE = Flagella(profile=np.zeros_like, diffusion=0.0, law="held")
"""No flagella: f = 0 always."""
