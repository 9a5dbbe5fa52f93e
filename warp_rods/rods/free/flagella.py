"""The flagella of an ensemble: the law of the flagellar field f, and f at the start (4.12).

The tables of laws and profiles are in ``scene/flagella.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.documented import Documented
from warp_rods.errors import SceneError, named, refuse_unknown
from warp_rods.kernels.free import flagella as kernel
from warp_rods.rods.per_rod import parameter
from warp_rods.scene.flagella import DEFAULT_LAW, LAWS, PROFILES, is_odd
from warp_rods.values import plain

MOST_LAW_PARAMETERS = 4
"""The kernels take this many parameters of a law."""
BALANCED = 1e-9
"""A larger ∫ f ds over a rod is not regarded as round-off."""
RULES = {"any number": "any finite number", "positive": "positive", "zero or more": "zero or more"}
"""Condition on a parameter of a law → the rule of ``per_rod``."""
OWN = ("relaxation", "diffusion", "profile", "sharpness", "law")
"""Fields of ``Flagella`` besides the parameters of the law."""


@dataclass(frozen=True)
class Flagella(metaclass=Documented):
    """The flagellar field of an ensemble: profile at the start, law and parameters, dimensionless.

    relaxation τf > 0, diffusion D ≥ 0: one number for all rods or one for each; the law ``held`` has no diffusion.
    profile: a name in ``PROFILES``, a function of s in [−1/2, 1/2], or values [node] or [rod, node]. sharpness: of the
    profile ``tanh``. law: a name in ``LAWS``; numbers: the parameters of that law by name. Arrays are kept as tuples.
    Raises SceneError for an unknown law or parameter, and for a sharpness that is not positive.
    """

    relaxation: Any = 1e-2
    diffusion: Any = 1e-3
    profile: str | Callable[[np.ndarray], ArrayLike] | ArrayLike = "tanh"
    sharpness: float = 10.0
    law: str = "relaxing"
    numbers: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        known = named(LAWS, "flagella.law", self.law).parameters
        if not isinstance(self.numbers, Mapping):
            raise arguments.wrong("flagella.numbers", self.numbers, "a mapping of the parameters of the law")
        refuse_unknown(self.numbers, known, f"flagella.numbers of the law {self.law!r}")
        fixed = {name: plain(getattr(self, name)) for name in ("relaxation", "diffusion", "profile")}
        fixed |= {"sharpness": arguments.real("flagella.sharpness", self.sharpness)}
        fixed |= {"numbers": MappingProxyType(plain(self.numbers))}
        for name, value in fixed.items():
            object.__setattr__(self, name, value)

    def __hash__(self) -> int:
        return hash((*(getattr(self, name) for name in OWN), *sorted(self.numbers.items())))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (*(getattr(self, name) for name in OWN), dict(self.numbers))

    @classmethod
    def read(cls, given: Flagella | Mapping[str, Any] | None) -> Flagella:
        """From a mapping of the fields and of the parameters of the law; None is a rod without flagella.

        Raises SceneError naming an unknown key.
        """
        if given is None:
            return PASSIVE
        if isinstance(given, cls):
            return given
        if not isinstance(given, Mapping):
            raise arguments.wrong("flagella", given, "a mapping, Flagella or None")
        given = {name: value for name, value in given.items() if value is not None}
        law = named(LAWS, "flagella.law", given.get("law", cls.law))
        refuse_unknown(given, [*OWN, *law.parameters, "numbers"], "flagella")
        numbers = given.get("numbers", {})
        if isinstance(numbers, Mapping):
            numbers = {**numbers, **{name: value for name, value in given.items() if name in law.parameters}}
        return cls(**{name: value for name, value in given.items() if name in OWN}, numbers=numbers)

    def as_table(self) -> dict[str, Any]:
        """The table ``flagella`` of a scene."""
        table = {name: getattr(self, name) for name in OWN} | dict(self.numbers)
        return table if self.law != DEFAULT_LAW else {name: value for name, value in table.items() if name != "law"}

    def of_rod(self, rod: int, count: int) -> dict[str, Any]:
        """Profile, law and parameters of the law of one of ``count`` rods."""
        profile = self.profile if isinstance(self.profile, str) else "given"
        numbers = zip(LAWS[self.law].parameters, self.law_parameters(count)[rod].tolist(), strict=False)
        return {"profile": profile, "sharpness": self.sharpness, "law": self.law, **dict(numbers)}

    def start(self, s: np.ndarray, count: int) -> np.ndarray:
        """f at the start [rod, node] for arc lengths ``s`` [node]; raises SceneError for values that do not fit."""
        profile: Any = self.profile
        expected = (
            f"one of {', '.join(PROFILES)}, a function of s, or numbers [node] or [rod, node] for {count} rods of "
            f"{len(s)} nodes"
        )
        if isinstance(profile, str):
            profile = named(PROFILES, "flagella.profile", profile)(s, self.sharpness)
        elif callable(profile):
            try:
                profile = profile(s)
            except (TypeError, ValueError, ArithmeticError, LookupError) as error:
                raise SceneError(f"flagella.profile: must be {expected}; the function fails: {error}") from None
        return arguments.fitted("flagella.profile", profile, (count, len(s)), expected)

    def balancing_twist(self, s: np.ndarray, ratio: np.ndarray, times: float = 1.0) -> np.ndarray:
        """Twist [rod, node] at which c τ' + M f = 0 for f at the start, zero at both ends, multiplied by ``times``.

        ratio: M/c [rod, 1]. (M/c) log(cosh(a s)/cosh(a/2))/a for the profile ``tanh`` of sharpness a, otherwise
        −(M/c) ∫ f ds from the first node, by the trapezoid rule. Raises SceneError where ∫ f ds over the rod is not
        zero, as the ends are free of moments.
        """
        if isinstance(self.profile, str) and self.profile == "tanh":
            a = self.sharpness
            log_cosh = np.logaddexp(a * s, -a * s) - np.logaddexp(a / 2, -a / 2)
            return ratio * log_cosh / (a / times)
        f = self.start(s, len(ratio))
        total = np.pad(np.cumsum((f[:, 1:] + f[:, :-1]) / 2 * np.diff(s), axis=1), ((0, 0), (1, 0)))
        left = ratio[:, 0] * total[:, -1]
        if (wrong := np.abs(left) > BALANCED * np.abs(ratio[:, 0])).any():
            raise SceneError(
                f"shape: no twist balances the active moment of rod {np.argmax(wrong)}, as ∫ f ds = "
                f"{total[np.argmax(wrong), -1]:.3g} along the rod: use odd flagella, moment = 0, or another shape"
            )
        return -ratio * total * times

    @property
    def effective_diffusion(self) -> Any:
        """D, or 0 for a law without diffusion."""
        return self.diffusion if LAWS[self.law].diffuses else 0.0

    @property
    def law_index(self) -> int:
        """The number of the law in the kernels."""
        return int(getattr(kernel, LAWS[self.law].kernel))

    def law_parameters(self, count: int) -> np.ndarray:
        """Parameters of the law [rod, 4] in its order, padded with zeros; raises SceneError for impossible values."""
        values = np.zeros((count, MOST_LAW_PARAMETERS))
        for column, (name, row) in enumerate(LAWS[self.law].parameters.items()):
            given = self.numbers.get(name, row.default)
            values[:, column] = parameter(f"flagella.{name}", given, count, RULES[row.allowed])
        return values


def odd_targets(flagella: Flagella, count: int) -> np.ndarray:
    """Whether f keeps an odd profile [rod]: the target of its law, if it has one, is odd."""
    numbers = flagella.law_parameters(count)
    return is_odd(numbers[:, 0], numbers[:, 1]) if LAWS[flagella.law].has_target else np.ones(count, dtype=bool)


PASSIVE = Flagella(profile=np.zeros_like, law="held")
"""No flagella: f = 0 at all times."""
