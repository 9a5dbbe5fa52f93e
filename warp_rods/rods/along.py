"""Values along rods: a number for all rods or for each, one for each node, or a formula in s, and perhaps in t."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arrays
from warp_rods.rods.changes import numbers_of_rods

PLACES = 5
"""Places along a rod at which formulas in s and t are sampled."""
ALLOWED = "a number, numbers [rod] or [rod, node], a formula in s, or a list of formulas, one for each rod"


class Along:
    """A parameter along rods: ``values`` [rod], or [rod, node] where it changes along them.

    named: parameters of the formulas [rod] by name. varies: whether it changes in time; ``at(t)`` are the values
    [rod, node] then.
    """

    def __init__(
        self,
        name: str,
        given: Any,
        count: int,
        nodes: int,
        rule: str,
        in_time: bool = False,
        named: Mapping[str, np.ndarray] | None = None,
    ):
        self.name, self._shape, self._named = name, (count, nodes), dict(named or {})
        self._formulas: list[Callable[..., np.ndarray]] = []
        self.varies = False
        texts = _texts(given)
        if texts is None:
            self.values = self._numbers(given)
        else:
            if len(texts) not in (1, count):
                raise SceneError(f"{name}: has {len(texts)} formulas; give one, or {count}, one for each rod")
            names = (*(("s", "t") if in_time else ("s",)), *self._named)
            self._formulas = [self._formula(text, names) for text in texts]
            self.varies = any("t" in formula.names for formula in self._formulas)  # type: ignore[attr-defined]
            self.values = self.at(0.0)
        arguments.check(name, self.values, rule)

    def at(self, time: float) -> np.ndarray:
        """Values [rod, node] of formulas at a time; raises SceneError where one has none."""
        s = np.linspace(-0.5, 0.5, self._shape[1])
        try:
            if len(self._formulas) == 1:
                columns = {name: numbers[:, None] for name, numbers in self._named.items()}
                found = np.array(np.broadcast_to(self._formulas[0](s=s, t=np.float64(time), **columns), self._shape))
            else:
                rows = [self._row(rod, s, time) for rod in range(len(self._formulas))]
                found = np.stack(rows)
        except FormulaError as error:
            raise SceneError(f"{self.name}: {error}") from None
        if not np.isfinite(found).all():
            raise SceneError(f"{self.name}: a formula has no finite value at t = {time:g}")
        return found

    def sampled(self, times: np.ndarray) -> Iterator[np.ndarray]:
        """Values [time, place] of its formulas that change in time, at a few places along the rod, for each rod."""
        s = np.linspace(-0.5, 0.5, PLACES)
        for formula in self._formulas:
            if "t" in formula.names:  # type: ignore[attr-defined]
                for numbers in numbers_of_rods(self._named):
                    yield np.broadcast_to(formula(s=s, t=times[:, None], **numbers), (len(times), PLACES))

    def _row(self, rod: int, s: np.ndarray, time: float) -> np.ndarray:
        """Values [node] of the formula of one rod."""
        own = {name: numbers[rod] for name, numbers in self._named.items()}
        return np.broadcast_to(self._formulas[rod](s=s, t=np.float64(time), **own), s.shape)

    def _numbers(self, given: Any) -> np.ndarray:
        read = arguments.reals(self.name, given)
        count, nodes = self._shape
        if read.ndim == 2 and read.shape in ((count, nodes), (1, nodes)):
            return np.array(np.broadcast_to(read, self._shape))
        if read.shape in ((), (count,)):
            return np.array(np.broadcast_to(read, (count,)))
        raise SceneError(f"{self.name}: must be {ALLOWED}; has shape {read.shape}, for {count} rods of {nodes} nodes")

    def _formula(self, text: str, names: tuple[str, ...]) -> Callable[..., np.ndarray]:
        try:
            return function_of_arrays(text, names)
        except FormulaError as error:
            raise SceneError(f"{self.name} = {text!r}: {error}") from None


def _texts(given: Any) -> list[str] | None:
    if isinstance(given, str):
        return [given]
    if isinstance(given, Sequence) and given and all(isinstance(part, str) for part in given):
        return list(given)
    return None


def at_nodes(values: np.ndarray, nodes: int) -> np.ndarray:
    """Values [rod, node] from those [rod] or [rod, node]."""
    return values if values.ndim == 2 else np.repeat(values[:, None], nodes, axis=1)


def product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Products of values [rod] or [rod, node]: [rod] if both are."""
    if first.ndim == second.ndim:
        return first * second
    return first * second[:, None] if first.ndim == 2 else first[:, None] * second


def at_half_nodes(values: np.ndarray) -> np.ndarray:
    """Means of each node and the next, stored at the node before; those [rod] as they are."""
    if values.ndim == 1:
        return values
    after = np.concatenate([values[:, 1:], values[:, -1:]], axis=1)
    return (values + after) / 2
