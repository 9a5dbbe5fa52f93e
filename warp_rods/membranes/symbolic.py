"""A formula as a SymPy expression."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from typing import Any

import sympy

from warp_rods.formula import ALLOWED, COORDINATES, OPERATORS, FormulaReader, check, syntax_tree

__all__ = ["expression", "unchecked"]

MOST_FACTORS = 20
"""Largest number of factors, as the second derivatives of a product of n factors have of the order of n³ terms."""
LARGEST_WHOLE = 2.0**53


def expression(text: str, names: Sequence[str]) -> sympy.Expr:
    """The formula in the symbols x0, x1, x2 and, for the parameters in their order, p0, p1, …

    Raises FormulaError as ``formula.check`` does, and for a division by an expression that is identically zero, a power
    of one, and a product with too many factors.
    """
    check(text, names)
    return unchecked(text, names)


def unchecked(text: str, names: Sequence[str]) -> sympy.Expr:
    """As ``expression``, without a check that every name occurs."""
    symbols = {name: sympy.Symbol(f"x{i}") for i, name in enumerate(COORDINATES)}
    symbols |= {name: sympy.Symbol(f"p{i}") for i, name in enumerate(names)}
    return sympy.sympify(_SymPyReader(symbols, ALLOWED).read(syntax_tree(text, ALLOWED)))


class _SymPyReader(FormulaReader):
    """A reader whose values are SymPy expressions, except for numbers."""

    def negated(self, value: Any) -> Any:
        return -value

    def combined(self, node: ast.BinOp, left: Any, right: Any) -> Any:
        if isinstance(node.op, ast.Div) and right == 0:
            raise self.refused(node, "divides by zero")
        value = OPERATORS[type(node.op)](_exact(left), _exact(right))
        if value.is_Mul and len(value.args) > MOST_FACTORS:
            raise self.refused(node, f"more than {MOST_FACTORS} factors")
        return value

    def raised(self, node: ast.BinOp, base: Any, exponent: float) -> Any:
        if base == 0:
            raise self.refused(node, "a power of zero")
        return base ** _exact(exponent)

    def applied(self, name: str, values: list[Any]) -> Any:
        return getattr(sympy, name)(*map(_exact, values))


def _exact(value: Any) -> Any:
    """A float as an integer, half-integer or float of SymPy, so that x**2.0 is x²; an expression unchanged."""
    if not isinstance(value, float):
        return value
    if (2 * value).is_integer() and abs(value) < LARGEST_WHOLE:
        return sympy.Rational(int(2 * value), 2)
    return sympy.Float(value)
