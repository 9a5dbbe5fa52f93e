"""Formulas as text, in x, y, z and parameters, in t or in s: parsed with a whitelist of Python's syntax, not evaluated.

Allowed: numbers, pi, the variables, parameters by name, + − * /, ** to a number, and ``FUNCTIONS``, which are smooth
where they are defined. Lengths, depths, powers and degrees are limited, so that parsing is fast for any text.
``warp_rods.membranes.symbolic`` converts a formula into an expression that can be differentiated.
"""

from __future__ import annotations

import ast
import functools
import keyword
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from warp_rods.documented import Documented

__all__ = [
    "ALLOWED", "FormulaError", "check", "function_of_arc_length", "function_of_arrays", "function_of_time",
    "usable_name", "with_numbers",
]  # fmt: skip

FUNCTIONS: dict[str, Callable[..., float]] = {
    name: getattr(math, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "atan")
}
TWO_ARGUMENTS = {"atan2": math.atan2}
COORDINATES = ("x", "y", "z")

MOST_CHARACTERS = 1000
MOST_PARTS = 300
MOST_DEPTH = 30
LARGEST_POWER = 12
LARGEST_DEGREE = 48
"""Limit for nested powers, which a computer algebra system may expand."""

ALLOWED = "allowed are numbers, pi, x, y, z, the names in parameters, + - * /, ** to a number and " + ", ".join(
    f"{name}()" for name in (*FUNCTIONS, *TWO_ARGUMENTS)
)


def _allowed_in(variables: str) -> str:
    return ALLOWED.replace("x, y, z, the names in parameters", variables)


ALLOWED_IN_TIME = _allowed_in("t")

OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


class FormulaError(ValueError, metaclass=Documented):
    """A text that is not an allowed formula; the message gives the place and what is allowed."""


def usable_name(name: str) -> bool:
    """Whether a parameter may have this name."""
    taken = {*FUNCTIONS, *TWO_ARGUMENTS, *COORDINATES, "pi"}
    return name.isascii() and name.isidentifier() and not keyword.iskeyword(name) and name not in taken


def check(text: str, names: Sequence[str]) -> None:
    """Check a formula in x, y, z and parameters with these names.

    Raises FormulaError for the first part that is not allowed, and for a parameter that does not occur.
    """
    reader = FormulaReader({name: FORM for name in (*COORDINATES, *names)}, ALLOWED)
    reader.read(syntax_tree(text, ALLOWED))
    if unused := [name for name in names if name not in reader.used]:
        raise FormulaError(f"parameters.{unused[0]} does not occur in it")
    if not reader.used & set(COORDINATES):
        raise FormulaError("none of x, y, z occurs in it")


@functools.lru_cache(maxsize=64)
def function_of_time(text: str) -> Callable[[float], float]:
    """The function of time defined by a formula in t; the text is parsed once, with the same whitelist.

    Raises FormulaError for the first part that is not allowed, and where t does not occur. The function raises it at
    a time at which the formula has no value.
    """
    return _function_of("t", text)


@functools.lru_cache(maxsize=64)
def function_of_arc_length(text: str, parameters: tuple[str, ...] = ()) -> Callable[..., float]:
    """The function of arc length defined by a formula in s, from −1/2 to 1/2; otherwise as ``function_of_time``.

    Parameters with these names are given to the function by keyword; its attribute ``names`` are those that occur.
    """
    return _function_of("s", text, parameters)


def _function_of(variable: str, text: str, parameters: tuple[str, ...] = ()) -> Callable[..., float]:
    allowed = _allowed_in(", ".join((variable, *parameters)))
    tree = syntax_tree(text.strip(), allowed)
    reader = FormulaReader(dict.fromkeys((variable, *parameters), FORM), allowed)
    reader.read(tree)
    if not reader.used:
        raise FormulaError(f"{variable} does not occur in it; write a constant without quotes")

    def function(value: float, **numbers: float) -> float:
        return FormulaReader({variable: float(value), **numbers}, allowed).read(tree)

    function.names = frozenset(reader.used)  # type: ignore[attr-defined]
    return function


def with_numbers(text: str, numbers: Mapping[str, float]) -> str:
    """The formula with numbers in place of names; raises FormulaError for a text that cannot be read."""
    tree = syntax_tree(text.strip(), "")
    return ast.unparse(_Numbers(numbers).visit(tree)) if numbers else text


class _Numbers(ast.NodeTransformer):
    """Puts numbers in place of names; negative ones with a sign of their own, before which a power is taken."""

    def __init__(self, numbers: Mapping[str, float]):
        self.numbers = numbers

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id not in self.numbers:
            return node
        value = float(self.numbers[node.id])
        size = ast.Constant(abs(value))
        return ast.UnaryOp(ast.USub(), size) if value < 0 else size


def function_of_arrays(text: str, names: Sequence[str]) -> Callable[..., Any]:
    """The function of arrays defined by a formula in variables with these names, given by keyword; NumPy in and out.

    Its attribute ``names`` are those that occur. Raises FormulaError for the first part that is not allowed.
    """
    allowed = _allowed_in(", ".join(names))
    tree = syntax_tree(text.strip(), allowed)
    reader = FormulaReader(dict.fromkeys(names, FORM), allowed)
    reader.read(tree)

    def function(**values: Any) -> Any:
        return ArrayReader(values, allowed).read(tree)

    function.names = frozenset(reader.used)  # type: ignore[attr-defined]
    return function


def syntax_tree(text: str, allowed: str) -> ast.expr:
    """The syntax tree of a text; raises FormulaError, whose message ends with what is ``allowed``."""
    if len(text) > MOST_CHARACTERS:
        raise FormulaError(f"{len(text)} characters; at most {MOST_CHARACTERS}")
    if "#" in text:
        raise FormulaError(f"column {text.index('#') + 1}: no comments here; {allowed}")
    try:
        # Line breaks in a long TOML string have no meaning.
        return ast.parse(text.replace("\n", " ").replace("\r", " "), mode="eval").body
    except SyntaxError as error:
        raise FormulaError(f"column {error.offset or len(text) + 1}: {error.msg}; {allowed}") from None
    except (ValueError, RecursionError, MemoryError):
        raise FormulaError(f"it cannot be read; {allowed}") from None


FORM = object()
"""Placeholder for variables and for all expressions that contain one, while a formula is only checked."""


class FormulaReader(metaclass=Documented):
    """Traverses the syntax tree of a formula and refuses what is not allowed or too long.

    ``symbols``: the values of variables and parameters, which are numbers to evaluate the formula, or ``FORM`` to check
    it. A subclass with other values overrides ``negated``, ``combined``, ``raised`` and ``applied``.
    """

    def __init__(self, symbols: Mapping[str, Any], allowed: str):
        self.symbols, self.allowed, self.used, self.count = symbols, allowed, set[str](), 0

    def read(self, tree: ast.expr) -> Any:
        """The value of the formula: a float where it is a number, ``FORM`` otherwise."""
        return self.part(tree, 0)[0]

    def negated(self, value: Any) -> Any:
        """−value, for a value that is not a number."""
        return FORM

    def combined(self, node: ast.BinOp, left: Any, right: Any) -> Any:
        """A sum, difference, product or quotient with at least one operand that is not a number."""
        return FORM

    def raised(self, node: ast.BinOp, base: Any, exponent: float) -> Any:
        """A power whose base is not a number."""
        return FORM

    def applied(self, name: str, values: list[Any]) -> Any:
        """A function with at least one argument that is not a number."""
        return FORM

    def part(self, node: ast.expr, depth: int) -> tuple[Any, float]:
        """The value of a part of the formula, and an upper bound of its degree."""
        self.count += 1
        if self.count > MOST_PARTS or depth > MOST_DEPTH:
            raise FormulaError(f"too long: at most {MOST_PARTS} parts, nested at most {MOST_DEPTH} deep")
        match node:
            case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
                return self.finite(node, lambda: float(value)), 0
            case ast.Name(id=name):
                return self._named(node, name)
            case ast.UnaryOp(op=ast.UAdd() | ast.USub() as sign, operand=operand):
                return self._signed(sign, *self.part(operand, depth + 1))
            case ast.BinOp(left=left, op=ast.Pow(), right=right):
                return self._power(node, self.part(left, depth + 1), self.part(right, depth + 1)[0])
            case ast.BinOp(left=left, op=sign, right=right) if type(sign) in OPERATORS:
                return self._joined(node, self.part(left, depth + 1), self.part(right, depth + 1))
            case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
                return self._called(node, name, [self.part(a, depth + 1) for a in arguments])
        raise self.refused(node, _description(node))

    def refused(self, node: ast.expr, what: str) -> FormulaError:
        """The error for a part that is not allowed."""
        return FormulaError(f"column {node.col_offset + 1}: {what}; {self.allowed}")

    def finite(self, node: ast.expr, compute: Callable[[], float]) -> float:
        """The computed number; refuses a result that is not finite or not real."""
        try:
            value = compute()
        except (ArithmeticError, ValueError, TypeError):
            value = math.nan
        if isinstance(value, complex) or not math.isfinite(value):
            raise self.refused(node, "not a finite real number")
        return value

    def _signed(self, sign: ast.unaryop, value: Any, degree: float) -> tuple[Any, float]:
        if isinstance(sign, ast.UAdd):
            return value, degree
        return -value if isinstance(value, float) else self.negated(value), degree

    def _named(self, node: ast.expr, name: str) -> tuple[Any, float]:
        if name == "pi":
            return math.pi, 0
        if name not in self.symbols:
            raise self.refused(node, f"{name} is not known here")
        self.used.add(name)
        return self.symbols[name], 1

    def _joined(self, node: ast.BinOp, left: tuple[Any, float], right: tuple[Any, float]) -> tuple[Any, float]:
        (a, m), (b, n) = left, right
        join = OPERATORS[type(node.op)]
        degree = max(m, n) if isinstance(node.op, (ast.Add, ast.Sub)) else m + n
        if isinstance(a, float) and isinstance(b, float):
            return self.finite(node, lambda: join(a, b)), 0
        if isinstance(node.op, ast.Div) and isinstance(b, float) and b == 0:
            raise self.refused(node, "divides by zero")
        return self.combined(node, a, b), self._degree(node, degree)

    def _power(self, node: ast.BinOp, base: tuple[Any, float], exponent: Any) -> tuple[Any, float]:
        a, degree = base
        if not isinstance(exponent, float) or abs(exponent) > LARGEST_POWER:
            raise self.refused(node, f"the exponent must be a number from −{LARGEST_POWER} to {LARGEST_POWER}")
        if isinstance(a, float):
            return self.finite(node, lambda: a**exponent), 0
        return self.raised(node, a, exponent), self._degree(node, degree * max(abs(exponent), 1.0))

    def _degree(self, node: ast.expr, degree: float) -> float:
        if degree > LARGEST_DEGREE:
            raise self.refused(node, f"its degree is above {LARGEST_DEGREE}")
        return degree

    def _called(self, node: ast.Call, name: str, arguments: list[tuple[Any, float]]) -> tuple[Any, float]:
        wanted = 1 if name in FUNCTIONS else 2 if name in TWO_ARGUMENTS else 0
        if not wanted:
            raise self.refused(node, f"{name}() is not known here")
        if len(arguments) != wanted:
            raise self.refused(node, f"{name}() takes {wanted} argument{'s' if wanted > 1 else ''}")
        values = [value for value, _degree in arguments]
        if all(isinstance(value, float) for value in values):
            return self.finite(node, lambda: (FUNCTIONS | TWO_ARGUMENTS)[name](*values)), 0
        return self.applied(name, values), max(degree for _value, degree in arguments)


class ArrayReader(FormulaReader):
    """Evaluates a formula whose variables are NumPy arrays; where it has no value, the result is not finite."""

    def negated(self, value: Any) -> Any:
        """−value."""
        return -value

    def combined(self, node: ast.BinOp, left: Any, right: Any) -> Any:
        """A sum, difference, product or quotient."""
        with _quiet():
            return OPERATORS[type(node.op)](left, right)

    def raised(self, node: ast.BinOp, base: Any, exponent: float) -> Any:
        """A power."""
        with _quiet():
            return base**exponent

    def applied(self, name: str, values: list[Any]) -> Any:
        """A function."""
        with _quiet():
            return in_numpy(name)(*values)


_IN_NUMPY = {"atan": "arctan", "atan2": "arctan2"}


def in_numpy(name: str) -> Callable[..., Any]:
    """A function of ``FUNCTIONS`` or ``TWO_ARGUMENTS`` of NumPy, for arrays."""
    import numpy as np

    found: Callable[..., Any] = getattr(np, _IN_NUMPY.get(name, name))
    return found


def _quiet() -> Any:
    import numpy as np

    return np.errstate(all="ignore")


def _description(node: ast.expr) -> str:
    """Description of a part that is not allowed."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitXor):
        return "^ is not known here: a power is **"
    words = {ast.Call: "this call", ast.Attribute: "a dot", ast.Subscript: "brackets", ast.Constant: "this value"}
    words |= {ast.Compare: "a comparison: give phi itself, the surface is where it is 0"}
    return f"{words.get(type(node), 'this')} is not allowed"
