"""From formulas to source with symbolic derivatives: φ, ∇φ, ∇∇φ, ∂tφ, ∇∂tφ, where φ is singular; flows, forces.

SymPy takes most of a second to import: this module is imported where a formula is new (``formula_fields.py``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import sympy

from warp_rods.formula import FormulaError

__all__ = ["field_source", "flow_source", "force_source", "rate_source", "singular_arguments", "singular_source"]

MOST_LINES = 2000

X = sympy.symbols("x:3")

CALLS = ("exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "atan", "atan2")


def field_source(phi: Any) -> str:
    """Source of ``field(x, p)`` for an expression in x0, x1, x2 and p0, p1, …; the same text in every process.

    Raises FormulaError where the expression is not real, or its derivatives are too long.
    """
    gradient = [sympy.diff(phi, a) for a in X]
    hessian = [sympy.diff(gradient[i], X[j]) for i in range(3) for j in range(i, 3)]
    body, (value, gx, gy, gz, xx, xy, xz, yy, yz, zz) = _written([phi, *gradient, *hessian])
    return (
        f"def field(x: wp.vec3d, p: Parameters):\n{body}\n"
        f"    return {value}, wp.vec3d({gx}, {gy}, {gz}), "
        f"wp.mat33d({xx}, {xy}, {xz}, {xy}, {yy}, {yz}, {xz}, {yz}, {zz})\n"
    )


def rate_source(phi: Any, count: int) -> str:
    """Source of ``rate(x, p, rates)``, ∂tφ = Σ ∂φ/∂p dp/dt and its gradient, for an expression in ``count`` p.

    Raises FormulaError as ``field_source`` does.
    """
    changes = [sympy.diff(phi, p) * q for p, q in zip(sympy.symbols("p:8"), sympy.symbols("q:8"), strict=True)]
    phi_t = sympy.Add(*changes[:count])
    body, (value, gx, gy, gz) = _written([phi_t, *(sympy.diff(phi_t, a) for a in X)])
    start = "def rate(x: wp.vec3d, p: Parameters, rates: Parameters):\n"
    return f"{start}{body}\n    return {value}, wp.vec3d({gx}, {gy}, {gz})\n"


def singular_arguments(phi: Any) -> list[Any]:
    """Expressions that are zero where φ is not smooth: arguments of roots, logarithms, negative powers, tan, atan2."""
    found: dict[Any, None] = {}
    for part in sympy.preorder_traversal(phi):
        if part.is_number:
            continue
        if part.is_Pow and not (part.exp.is_Integer and part.exp.is_positive):
            base = part.base
            found[base.base if base.is_Pow and base.exp.is_Integer and base.exp.is_positive else base] = None
        elif isinstance(part, sympy.log):
            found[part.args[0]] = None
        elif isinstance(part, sympy.tan):
            found[sympy.cos(part.args[0])] = None
        elif isinstance(part, sympy.atan2):
            found[part.args[0]] = None
            found[part.args[0] ** 2 + part.args[1] ** 2] = None
    return [argument for argument in found if argument.free_symbols & set(X)]


def singular_source(phi: Any) -> str:
    """Source of ``singular(x, p)``: value and derivatives along x, y, z of each of the ``singular_arguments``."""
    parts = [part for a in singular_arguments(phi) for part in (a, *(sympy.diff(a, b) for b in X))]
    body, names = _written(parts)
    rows = "".join(f"({', '.join(names[i : i + 4])}), " for i in range(0, len(names), 4))
    return f"def singular(x: wp.vec3d, p: Parameters):\n{body}\n    return [{rows}]\n"


def flow_source(velocity: Sequence[Any]) -> str:
    """Source of ``flow(x, t, p)`` -> u, ½∇×u for three expressions in x0, x1, x2 and p0, the time."""
    u, v, w = velocity
    x, y, z = X
    slopes = ((w, y, v, z), (u, z, w, x), (v, x, u, y))
    curl = [sympy.diff(a, b) - sympy.diff(c, d) for a, b, c, d in slopes]
    body, names = _written([*velocity, *(part / 2 for part in curl)], {"p0": "t"})
    start = "def flow(x: wp.vec3d, t: wp.float64, p: Profile):\n"
    return f"{start}{body}\n    return {_vector(names[:3])}, {_vector(names[3:])}\n"


def force_source(parts: Sequence[Any]) -> str:
    """Source of ``force(x, s, t)`` -> force, couple for six expressions in x0, x1, x2 and p0, p1, which are s and t."""
    body, names = _written(list(parts), {"p0": "s", "p1": "t"})
    start = "def force(x: wp.vec3d, s: wp.float64, t: wp.float64):\n"
    return f"{start}{body}\n    return {_vector(names[:3])}, {_vector(names[3:])}\n"


def _vector(names: list[str]) -> str:
    return f"wp.vec3d({', '.join(names)})"


def _written(parts: list[Any], named: Mapping[str, str] | None = None) -> tuple[str, list[str]]:
    """Indented lines that evaluate these expressions, and the names of their values.

    named: symbol → its name in the source, where it is not a coordinate or a parameter.
    """
    shared, wanted = sympy.cse(parts, symbols=sympy.numbered_symbols("t"), order="canonical")
    lines = _Lines()
    lines.names |= {sympy.Symbol(symbol): name for symbol, name in (named or {}).items()}
    for symbol, part in shared:
        lines.names[symbol] = lines.name(part)
    names = [lines.name(part) for part in wanted]
    return "\n".join(f"    {line}" for line in lines.lines), names


class _Lines:
    """Lines of source, one for each operation; equal operations are written once."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.names: dict[Any, str] = {sympy.Symbol(f"x{i}"): f"x[{i}]" for i in range(3)}
        self.names |= {sympy.Symbol(f"p{i}"): f"p.v[{i}]" for i in range(8)}
        self.names |= {sympy.Symbol(f"q{i}"): f"rates.v[{i}]" for i in range(8)}
        self.written: dict[str, str] = {}

    def name(self, part: Any) -> str:
        """The name of the variable with the value of this part; its lines are written first where necessary."""
        if part not in self.names:
            self.names[part] = _literal(part) if part.is_number else self._operation(part)
        return self.names[part]

    def line(self, text: str) -> str:
        if text not in self.written:
            self.written[text] = f"v{len(self.lines)}"
            self.lines.append(f"{self.written[text]} = {text}")
            if len(self.lines) > MOST_LINES:
                raise FormulaError(f"too long: with its derivatives it has more than {MOST_LINES} operations")
        return self.written[text]

    def _operation(self, part: Any) -> str:
        if part.is_Add:
            return self._chain(" + ", [self.name(term) for term in part.as_ordered_terms()])
        if part.is_Pow and part.exp.is_number:
            return self._power(part.base, part.exp)
        if part.is_Mul:
            return self._product(part)
        kind = type(part).__name__
        if kind not in CALLS:
            raise FormulaError(f"it contains {kind}, which has no meaning for real numbers here")
        return self.line(f"wp.{kind}({', '.join(self.name(a) for a in part.args)})")

    def _chain(self, sign: str, names: list[str]) -> str:
        total = names[0]
        for name in names[1:]:
            total = self.line(f"{total}{sign}{name}")
        return total

    def _product(self, part: Any) -> str:
        """A product with one division, by the product of the denominators."""
        factors = part.as_ordered_factors()
        below = [f for f in factors if f.is_Pow and f.exp.is_number and f.exp.is_negative]
        above = [f for f in factors if f not in below and f != -1]
        top = self._chain(" * ", [self.name(f) for f in above]) if above else "wp.float64(1.0)"
        if below:
            top = self.line(f"{top} / {self._chain(' * ', [self._power(f.base, -f.exp) for f in below])}")
        return self.line(f"-{top}") if -1 in factors else top

    def _power(self, base: Any, exponent: Any) -> str:
        b = self.name(base)
        if exponent.is_negative:
            return self.line(f"wp.float64(1.0) / {self._power(base, -exponent)}")
        if exponent.is_Integer:
            return self._whole_power(b, int(exponent))
        if (2 * exponent).is_Integer:
            root = self.line(f"wp.sqrt({b})")
            return self.line(f"{self._whole_power(b, int(exponent))} * {root}") if exponent > 1 else root
        return self.line(f"wp.pow({b}, {_literal(exponent)})")

    def _whole_power(self, name: str, n: int) -> str:
        """An integer power by squaring, as wp.pow is much slower."""
        if n == 1:
            return name
        if n % 2:
            return self.line(f"{self._whole_power(name, n - 1)} * {name}")
        half = self._whole_power(name, n // 2)
        return self.line(f"{half} * {half}")


def _literal(number: Any) -> str:
    """A number as one float64 literal, as Warp evaluates quotients of literals in float32."""
    try:
        value = float(number)
    except (TypeError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise FormulaError(f"it contains {str(number)[:40]}, which is not a finite real number")
    return f"wp.float64({value!r})"
