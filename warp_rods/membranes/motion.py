"""Surfaces that move: formulas in t among their values, such as ``neck = "0.4 - 0.1*t"``."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from warp_rods import formula
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError
from warp_rods.membranes.level_set import Fault
from warp_rods.values import key_path

__all__ = ["NOT_NUMBERS", "MotionError", "is_moving", "rates_at", "sampled", "values_at"]

NOT_NUMBERS = ("kind", "phi", "file", "axes")
"""Keys of a [surface] whose text is not a formula in t."""


class MotionError(SceneError):
    """A formula in t that has no value at some time; ``fault`` names the formula and the time."""

    def __init__(self, fault: Fault):
        super().__init__(key_path(("surface", *fault[0])) + fault[1])
        self.fault = fault


def is_moving(values: Mapping[str, Any]) -> bool:
    """Whether the values of a surface, including its lists and tables, contain a formula in t."""
    return any(_has_text(value) for key, value in values.items() if key not in NOT_NUMBERS)


def values_at(values: Mapping[str, Any], time: float) -> dict[str, Any]:
    """The values with formulas in t evaluated at this time; raises MotionError where one has no value."""
    return {
        key: value if key in NOT_NUMBERS else _at((key,), value, time, _value, _same) for key, value in values.items()
    }


def rates_at(values: Mapping[str, Any], time: float) -> dict[str, Any]:
    """The exact time derivatives of the values at this time, 0 for numbers; raises MotionError where one has none."""
    return {
        key: value if key in NOT_NUMBERS else _at((key,), value, time, rate, _zero) for key, value in values.items()
    }


def sampled(values: Mapping[str, Any], times: np.ndarray) -> Iterator[np.ndarray]:
    """Values [time] of each formula in t."""
    for key, value in values.items():
        for text in () if key in NOT_NUMBERS else _texts(value):
            yield formula.function_of_arrays(text, ("t",))(t=times)


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, (Mapping, tuple)):
        for inner in value.values() if isinstance(value, Mapping) else value:
            yield from _texts(inner)


def _has_text(value: Any) -> bool:
    if isinstance(value, Mapping):
        return any(map(_has_text, value.values()))
    if isinstance(value, tuple):
        return any(map(_has_text, value))
    return isinstance(value, str)


def _at(
    loc: tuple[str | int, ...],
    value: Any,
    time: float,
    of_text: Callable[[str, float], float],
    of_number: Callable[[Any], Any],
) -> Any:
    """The value with its formulas replaced by ``of_text``, and its numbers by ``of_number``."""
    if isinstance(value, Mapping):
        return {name: _at((*loc, name), inner, time, of_text, of_number) for name, inner in value.items()}
    if isinstance(value, tuple):
        return tuple(_at((*loc, i), inner, time, of_text, of_number) for i, inner in enumerate(value))
    if not isinstance(value, str):
        return of_number(value)
    try:
        return of_text(value, time)
    except FormulaError as error:
        raise MotionError((loc, f" at t = {time:g}: {error}")) from None


def _value(text: str, time: float) -> float:
    return formula.function_of_time(text)(time)


def _same(number: Any) -> Any:
    return number


def _zero(number: Any) -> float:
    return 0.0


class _Dual(NamedTuple):
    """A value and its time derivative."""

    value: float
    rate: float


def rate(text: str, time: float, **constants: float) -> float:
    """The exact time derivative of a formula in t, and in ``constants``; raises FormulaError where it is not finite."""
    tree = formula.syntax_tree(text.strip(), formula.ALLOWED_IN_TIME)
    found = _RateReader({"t": _Dual(float(time), 1.0), **constants}, formula.ALLOWED_IN_TIME).read(tree)
    return found.rate if isinstance(found, _Dual) else 0.0


def rate_of_arrays(text: str, time: float, **constants: Any) -> Any:
    """``rate`` with constants that are arrays of NumPy; where it has no value, the result is not finite."""
    tree = formula.syntax_tree(text.strip(), formula.ALLOWED_IN_TIME)
    found = _ArrayRateReader({"t": _Dual(np.float64(time), 1.0), **constants}, formula.ALLOWED_IN_TIME).read(tree)
    return found.rate if isinstance(found, _Dual) else 0.0


DERIVATIVES: dict[str, Callable[[Any, Any], Any]] = {
    "sqrt": lambda x, of: 0.5 / of.sqrt(x),
    "exp": lambda x, of: of.exp(x),
    "log": lambda x, of: 1 / x,
    "sin": lambda x, of: of.cos(x),
    "cos": lambda x, of: -of.sin(x),
    "tan": lambda x, of: 1 + of.tan(x) ** 2,
    "sinh": lambda x, of: of.cosh(x),
    "cosh": lambda x, of: of.sinh(x),
    "tanh": lambda x, of: 1 - of.tanh(x) ** 2,
    "atan": lambda x, of: 1 / (1 + x * x),
}
"""Derivatives of ``formula.FUNCTIONS``, with the functions of a module, ``math`` or NumPy."""


class _RateReader(formula.FormulaReader):
    """A reader whose values, except for numbers, carry their time derivatives (forward differentiation)."""

    functions: Any = math

    def negated(self, value: Any) -> Any:
        a, da = _dual(value)
        return _Dual(-a, -da)

    def combined(self, node: ast.BinOp, left: Any, right: Any) -> Any:
        (a, da), (b, db) = _dual(left), _dual(right)
        rules: dict[type[ast.operator], Callable[[], float]] = {
            ast.Add: lambda: da + db,
            ast.Sub: lambda: da - db,
            ast.Mult: lambda: da * b + a * db,
            ast.Div: lambda: (da - a / b * db) / b,
        }
        return self._both(node, lambda: formula.OPERATORS[type(node.op)](a, b), rules[type(node.op)])

    def raised(self, node: ast.BinOp, base: Any, exponent: float) -> Any:
        a, da = _dual(base)
        return self._both(node, lambda: a**exponent, lambda: exponent * a ** (exponent - 1) * da if exponent else 0.0)

    def applied(self, name: str, values: list[Any]) -> Any:
        node = ast.Name(id=name, col_offset=0)
        if name in DERIVATIVES:
            a, da = _dual(values[0])
            return self._both(node, lambda: self._function(name)(a), lambda: DERIVATIVES[name](a, self.functions) * da)
        (a, da), (b, db) = map(_dual, values)
        return self._both(node, lambda: self._function("atan2")(a, b), lambda: (da * b - a * db) / (a * a + b * b))

    def _function(self, name: str) -> Callable[..., Any]:
        return getattr(math, name)

    def _both(self, node: ast.expr, value: Callable[[], Any], rate: Callable[[], Any]) -> _Dual:
        return _Dual(self.finite(node, value), self.finite(node, rate))


class _ArrayRateReader(_RateReader):
    """A reader whose numbers may be arrays of NumPy."""

    functions = np

    def _function(self, name: str) -> Callable[..., Any]:
        return formula.in_numpy(name)

    def _both(self, node: ast.expr, value: Callable[[], Any], rate: Callable[[], Any]) -> _Dual:
        with np.errstate(all="ignore"):
            return _Dual(value(), rate())


def _dual(value: Any) -> _Dual:
    return value if isinstance(value, _Dual) else _Dual(value, 0.0)
