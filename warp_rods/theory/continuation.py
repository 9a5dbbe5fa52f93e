"""Branches of fixed shapes followed in a parameter, round folds too, and where along them stability is lost.

Pseudo-arclength continuation: a point is z = (shape, Ω, q), with q = log of a parameter that is positive, or M over
its range. Length along a branch is a relative one, dσ² = |δx|²/|x|² + δq², so that a step means the same everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from warp_rods.errors import SceneError
from warp_rods.rods.free.arrays import PARAMETERS
from warp_rods.theory.steady import AT_REST, FixedShape, at_rest
from warp_rods.theory.steady_equations import DIFFERENCES, Equations, solved

NEARBY = 1e-3
"""Change of q for the fourth-order difference of the rates over it."""
CORRECTIONS = 6
"""Newton steps at one point; more mean that the step along the branch was too long."""
SHORTEST = 1e-5
"""Step along a branch at which following it is given up."""
SHARPEST = 0.97
"""Smallest cosine between the tangents at both ends of a step."""
FOLD = 1e-3
"""dq/dσ below which a real eigenvalue's passage through zero is a fold."""
OSCILLATES = 1e-4
"""|Im μ| above which a passage is a Hopf bifurcation; less is round-off of a double zero."""


@dataclass(frozen=True)
class Bifurcation:
    """Where an eigenvalue crosses the imaginary axis: kind "fold", "Hopf" or "branch point" (pitchforks, too).

    value: of the parameter. frequency: |Im μ| there, radians per ζ∥L/f*; 0 but for Hopf.
    """

    kind: str
    value: float
    frequency: float
    shape: FixedShape


@dataclass(frozen=True)
class Branch:
    """Fixed shapes in order along a branch, with their values of the parameter [point].

    eigenvalues: the leading ones of each, largest real part first [point, eigenvalue].
    """

    parameter: str
    values: np.ndarray
    shapes: tuple[FixedShape, ...]
    eigenvalues: np.ndarray
    bifurcations: tuple[Bifurcation, ...]

    @property
    def stable(self) -> np.ndarray:
        """Whether all perturbations decay [point]."""
        return self.eigenvalues[:, 0].real < 0

    def named(self, kind: str) -> list[Bifurcation]:
        """The bifurcations of one kind, in order."""
        return [found for found in self.bifurcations if found.kind == kind]


@dataclass(frozen=True)
class _Point:
    """A point of a branch: z = (state, Ω, q), its tangent, and the spectrum there."""

    z: np.ndarray
    tangent: np.ndarray
    eigenvalues: np.ndarray

    @property
    def unstable(self) -> int:
        return int(np.sum(self.eigenvalues.real > 0))


class _Curve:
    """The one-dimensional set of fixed shapes of a swimmer over one parameter."""

    def __init__(self, start: FixedShape, parameter: str, span: float):
        self.start, self.parameter, self.span = start, parameter, span
        self.equations = Equations(start.swimmer)
        state = self.equations.state(start.fields)
        self.origin = np.append(state, [start.spin, self.coordinate(start.swimmer.parameters[parameter])])

    def coordinate(self, value: float) -> float:
        return value / self.span if self.parameter == "moment" else float(np.log(value))

    def value(self, q: float) -> float:
        return float(q * self.span if self.parameter == "moment" else np.exp(q))

    def inner(self, at: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
        """Product of two tangents at a point; Ω follows from the shape and does not count."""
        size = max(float(at[:-2] @ at[:-2]), 1.0)
        return float(a[:-2] @ b[:-2] / size + a[-1] * b[-1])

    def shape(self, z: np.ndarray) -> FixedShape:
        swimmer = self.start.swimmer.having(**{self.parameter: self.value(z[-1])})
        return FixedShape(swimmer, self.equations.fields(z[None, :-2])[0], float(z[-2]))

    def linear(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As ``Equations.system`` at a point, with derivatives by q for the last column."""
        nearby = {place: {self.parameter: self.value(z[-1] + place * NEARBY)} for place in DIFFERENCES}
        parameters = {**self.start.swimmer.parameters, self.parameter: self.value(z[-1])}
        residual, system, jacobian = self.equations.system(z[:-2], z[-2], parameters, nearby)
        system[:, -1] /= NEARBY
        return residual, system, jacobian

    def corrected(self, guess: np.ndarray, along: np.ndarray) -> np.ndarray:
        """The point of the curve on the plane through ``guess`` normal to ``along``; ArithmeticError if none."""
        z = guess
        normal = self._dual(guess, along)
        for _ in range(CORRECTIONS):
            residual, system, _ = self.linear(z)
            step = solved(np.vstack([system, normal]), np.append(residual, 0.0))
            z = z - step
            if np.sqrt(np.mean(step**2)) < AT_REST:
                return z
            if not abs(step[-1]) < 1.0:
                break
        raise ArithmeticError("no fixed shape was found next to the last one: take shorter steps")

    def _dual(self, at: np.ndarray, along: np.ndarray) -> np.ndarray:
        size = max(float(at[:-2] @ at[:-2]), 1.0)
        return np.concatenate([along[:-2] / size, [0.0, along[-1]]])

    def point(self, z: np.ndarray, along: np.ndarray) -> _Point:
        """Tangent, in the sense of ``along``, and spectrum of a point of the curve."""
        _, system, jacobian = self.linear(z)
        last = np.zeros(len(z))
        last[-1] = 1.0
        tangent = solved(np.vstack([system, self._dual(z, along)]), last)
        tangent = tangent / np.sqrt(self.inner(z, tangent, tangent))
        return _Point(z, tangent, self.equations.spectrum(jacobian, z[:-2], float(z[-2])))

    def beyond(self, point: _Point, length: float) -> _Point:
        """The point a ``length`` further along."""
        return self.point(self.corrected(point.z + length * point.tangent, point.tangent), point.tangent)


def follow(
    start: FixedShape, parameter: str, low: float, high: float,
    *, upwards: bool = True, step: float = 0.05, longest: float = 0.2, points: int = 400, count: int = 6,
) -> Branch:  # fmt: skip
    """The branch of fixed shapes through ``start``, followed while ``parameter`` stays between ``low`` and ``high``.

    ``parameter``: one of those of ``Swimmer``; it first rises if ``upwards``, and turns at folds. step: length of the
    first step, longest: of any, as relative changes of shape and parameter; points: at most; count: eigenvalues kept
    of each. Folds, Hopf bifurcations and branch points passed are found to round-off in the parameter. A branch ends
    with the shape exactly at ``low`` or ``high``.

    Raises SceneError for an unknown parameter, or a start outside; ArithmeticError where the branch cannot be
    followed: take shorter steps or more nodes.
    """
    if parameter not in PARAMETERS:
        raise SceneError(f"parameter {parameter!r}: known ones are {', '.join(PARAMETERS)}")
    value = start.swimmer.parameters[parameter]
    if not low <= value <= high or not low < high or (parameter != "moment" and low <= 0):
        raise SceneError(f"{parameter} = {value:g}: must start between low = {low:g} and high = {high:g}")
    curve = _Curve(at_rest(start), parameter, high - low)
    ahead = np.zeros(len(curve.origin))
    ahead[-1] = 1.0 if upwards else -1.0
    passed = [curve.point(curve.origin, ahead)]
    found: list[Bifurcation] = []
    ends = [curve.coordinate(value) for value in (low, high)]
    while len(passed) < points:
        here, step = _advance(curve, passed[-1], min(step, longest))
        inside = ends[0] <= here.z[-1] <= ends[1]
        if not inside:
            here = _at_end(curve, passed[-1], here, ends[0] if here.z[-1] < ends[0] else ends[1])
        found += _between(curve, passed[-1], here)
        passed.append(here)
        if not inside:
            break
    return Branch(
        parameter, np.array([curve.value(point.z[-1]) for point in passed]),
        tuple(curve.shape(point.z) for point in passed),
        np.array([point.eigenvalues[:count] for point in passed]), tuple(found),
    )  # fmt: skip


def _advance(curve: _Curve, point: _Point, step: float) -> tuple[_Point, float]:
    """The next point, and a length for the step after: halved until the branch is smooth on its scale."""
    while step > SHORTEST:
        try:
            here = curve.beyond(point, step)
        except ArithmeticError:
            step /= 2
            continue
        if curve.inner(here.z, here.tangent, point.tangent) > SHARPEST * np.sqrt(
            curve.inner(here.z, point.tangent, point.tangent)
        ):
            return here, 1.5 * step
        step /= 2
    raise ArithmeticError(
        f"the branch cannot be followed beyond {curve.parameter} = {curve.value(point.z[-1]):g}: "
        "take shorter steps or more nodes"
    )


def _at_end(curve: _Curve, before: _Point, after: _Point, q: float) -> _Point:
    """The point of the last step at which the parameter is at its bound."""
    share = (q - before.z[-1]) / (after.z[-1] - before.z[-1])
    guess = before.z + share * (after.z - before.z)
    guess[-1] = q
    ahead = np.zeros(len(guess))
    ahead[-1] = 1.0
    return curve.point(curve.corrected(guess, ahead), after.tangent)


def _between(curve: _Curve, before: _Point, after: _Point) -> list[Bifurcation]:
    """Passages of eigenvalues through zero between neighbouring points.

    Sorted real parts are continuous along a branch: where n are unstable at one end and m at the other, those
    numbered n … m − 1 change sign, each exactly where its mode does.
    """
    found: list[tuple[float, Bifurcation]] = []
    length = curve.inner(before.z, after.z - before.z, before.tangent)
    number, high = sorted((before.unstable, after.unstable))
    while number < high:
        along, there = _crossing(curve, before, after, length, number)
        frequency = abs(float(there.eigenvalues[number].imag))
        kind = "Hopf" if frequency > OSCILLATES else "fold" if abs(there.tangent[-1]) < FOLD else "branch point"
        value, shape = curve.value(there.z[-1]), curve.shape(there.z)
        found.append((along, Bifurcation(kind, value, frequency if kind == "Hopf" else 0.0, shape)))
        number += 2 if kind == "Hopf" else 1
    return [bifurcation for _, bifurcation in sorted(found, key=lambda pair: pair[0])]


def _crossing(curve: _Curve, before: _Point, after: _Point, length: float, number: int) -> tuple[float, _Point]:
    """How far from ``before`` the real part of eigenvalue ``number`` vanishes, and the point there."""
    known = {0.0: before, length: after}

    def rate(along: float) -> float:
        if along not in known:
            known[along] = curve.beyond(before, along)
        return float(known[along].eigenvalues[number].real)

    root = float(brentq(rate, 0.0, length, xtol=1e-9, rtol=1e-9))
    rate(root)
    return root, known[root]
