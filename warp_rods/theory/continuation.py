"""Branches of fixed shapes over a parameter, followed around folds, and the bifurcations where stability is lost.

Pseudo-arclength continuation. A point of a branch is z = (shape, Ω, q), where q is the logarithm of a positive
parameter, or M divided by its range. Arc length along a branch is relative, dσ² = |δx|²/|x|² + δq², so that a step has
the same meaning everywhere.
"""

from __future__ import annotations

__all__ = ["Bifurcation", "Branch", "follow"]

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from warp_rods.documented import Documented
from warp_rods.errors import SceneError
from warp_rods.rods.free.arrays import PARAMETERS
from warp_rods.theory.steady import TOLERANCE, FixedShape, at_rest
from warp_rods.theory.steady_equations import DIFFERENCES, Equations, solve

PARAMETER_CHANGE = 1e-3
"""Change of q in the fourth-order difference of the rates."""
MAX_CORRECTIONS = 6
"""Newton steps for one point. Where more are needed the step along the branch is halved."""
SMALLEST_STEP = 1e-5
"""Step along a branch below which the continuation stops."""
SMALLEST_COSINE = 0.97
"""Smallest cosine of the angle between the tangents at both ends of a step."""
FOLD = 1e-3
"""A real eigenvalue that crosses zero where |dq/dσ| is smaller than this marks a fold."""
SMALLEST_FREQUENCY = 1e-4
"""A crossing with |Im μ| above this is a Hopf bifurcation; below, Im μ is round-off of a double zero."""


@dataclass(frozen=True)
class Bifurcation(metaclass=Documented):
    """Where an eigenvalue crosses the imaginary axis.

    kind: "fold", "Hopf" or "branch point" (pitchforks included). value: of the parameter. frequency: |Im μ| there,
    radians per ζ∥L/f*; 0 except at a Hopf bifurcation.
    """

    kind: str
    value: float
    frequency: float
    shape: FixedShape


@dataclass(frozen=True)
class Branch(metaclass=Documented):
    """Fixed shapes in order along a branch, with their values of the parameter [point].

    eigenvalues: the leading ones of each shape, largest real part first [point, eigenvalue].
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

    def of_kind(self, kind: str) -> list[Bifurcation]:
        """The bifurcations of one kind, in order."""
        return [found for found in self.bifurcations if found.kind == kind]


@dataclass(frozen=True)
class _Point:
    """A point of a branch: z = (state, Ω, q), the unit tangent and the eigenvalues there."""

    z: np.ndarray
    tangent: np.ndarray
    eigenvalues: np.ndarray

    @property
    def unstable(self) -> int:
        return int(np.sum(self.eigenvalues.real > 0))


class _Curve:
    """The one-dimensional set of fixed shapes over one parameter; ``coordinate``, ``value``: its q and back."""

    def __init__(self, start: FixedShape, parameter: str, span: float):
        self.start, self.parameter, self.span = start, parameter, span
        self.equations = Equations(start.swimmer)
        state = self.equations.state(start.fields)
        self.origin = np.append(state, [start.spin, self.coordinate(start.swimmer.parameters[parameter])])

    def coordinate(self, value: float) -> float:
        return value / self.span if self.parameter == "moment" else float(np.log(value))

    def value(self, q: float) -> float:
        return float(q * self.span if self.parameter == "moment" else np.exp(q))

    def inner(self, z: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
        """Inner product of two tangents a, b at a point z. Ω follows from the shape and does not count."""
        size = max(float(z[:-2] @ z[:-2]), 1.0)
        return float(a[:-2] @ b[:-2] / size + a[-1] * b[-1])

    def shape(self, z: np.ndarray) -> FixedShape:
        swimmer = self.start.swimmer.with_parameters(**{self.parameter: self.value(z[-1])})
        return FixedShape(swimmer, self.equations.fields(z[None, :-2])[0], float(z[-2]))

    def linearise(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """``Equations.system`` at a point z; the last column has the derivatives with respect to q."""
        nearby = {offset: {self.parameter: self.value(z[-1] + offset * PARAMETER_CHANGE)} for offset in DIFFERENCES}
        parameters = {**self.start.swimmer.parameters, self.parameter: self.value(z[-1])}
        residual, system, jacobian = self.equations.system(z[:-2], z[-2], parameters, nearby)
        system[:, -1] /= PARAMETER_CHANGE
        return residual, system, jacobian

    def corrected(self, guess: np.ndarray, tangent: np.ndarray) -> np.ndarray:
        """The point of the curve in the plane through ``guess`` normal to ``tangent``; ArithmeticError if none."""
        z = guess
        normal = self._normal(guess, tangent)
        for _ in range(MAX_CORRECTIONS):
            residual, system, _ = self.linearise(z)
            step = solve(np.vstack([system, normal]), np.append(residual, 0.0))
            z = z - step
            if np.sqrt(np.mean(step**2)) < TOLERANCE:
                return z
            if not abs(step[-1]) < 1.0:
                break
        raise ArithmeticError("no fixed shape was found next to the last one: take shorter steps")

    def _normal(self, z: np.ndarray, tangent: np.ndarray) -> np.ndarray:
        """The row vector whose product with a vector is its inner product with the tangent."""
        size = max(float(z[:-2] @ z[:-2]), 1.0)
        return np.concatenate([tangent[:-2] / size, [0.0, tangent[-1]]])

    def point(self, z: np.ndarray, direction: np.ndarray) -> _Point:
        """Tangent, oriented along ``direction``, and eigenvalues at a point z of the curve."""
        _, system, jacobian = self.linearise(z)
        last = np.zeros(len(z))
        last[-1] = 1.0
        tangent = solve(np.vstack([system, self._normal(z, direction)]), last)
        tangent = tangent / np.sqrt(self.inner(z, tangent, tangent))
        return _Point(z, tangent, self.equations.spectrum(jacobian, z[:-2], float(z[-2])))

    def after(self, point: _Point, length: float) -> _Point:
        """The point at arc length ``length`` after ``point``."""
        return self.point(self.corrected(point.z + length * point.tangent, point.tangent), point.tangent)


def follow(
    start: FixedShape, parameter: str, low: float, high: float,
    *, upwards: bool = True, step: float = 0.05, longest: float = 0.2, points: int = 400, count: int = 6,
) -> Branch:  # fmt: skip
    """The branch of fixed shapes through ``start``, followed while ``parameter`` stays between ``low`` and ``high``.

    ``parameter``: one of those of ``Swimmer``. It increases at first if ``upwards``, and turns back at folds. step:
    length of the first step, longest: of any step, as relative changes of shape and parameter. points: their largest
    number. count: number of eigenvalues kept for each. Folds, Hopf bifurcations and branch points on the way are
    located to round-off in the parameter. The last shape of a branch that reaches ``low`` or ``high`` is exactly there.

    Raises SceneError for an unknown parameter or a start outside these bounds; ArithmeticError where the branch cannot
    be followed.
    """
    if parameter not in PARAMETERS:
        raise SceneError(f"parameter = {parameter!r}: must be one of {', '.join(PARAMETERS)}")
    value = start.swimmer.parameters[parameter]
    if not low <= value <= high or not low < high or (parameter != "moment" and low <= 0):
        raise SceneError(f"{parameter} = {value:g}: must start between low = {low:g} and high = {high:g}")
    curve = _Curve(at_rest(start), parameter, high - low)
    direction = np.zeros(len(curve.origin))
    direction[-1] = 1.0 if upwards else -1.0
    passed = [curve.point(curve.origin, direction)]
    found: list[Bifurcation] = []
    ends = [curve.coordinate(value) for value in (low, high)]
    while len(passed) < points:
        here, step = _advance(curve, passed[-1], min(step, longest))
        inside = ends[0] <= here.z[-1] <= ends[1]
        if not inside:
            here = _at_bound(curve, passed[-1], here, ends[0] if here.z[-1] < ends[0] else ends[1])
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
    """The next point, and the length of the step after it. The step is halved until the tangent turns little."""
    while step > SMALLEST_STEP:
        try:
            here = curve.after(point, step)
        except ArithmeticError:
            step /= 2
            continue
        if curve.inner(here.z, here.tangent, point.tangent) > SMALLEST_COSINE * np.sqrt(
            curve.inner(here.z, point.tangent, point.tangent)
        ):
            return here, 1.5 * step
        step /= 2
    raise ArithmeticError(
        f"the branch cannot be followed beyond {curve.parameter} = {curve.value(point.z[-1]):g}: "
        "take shorter steps or more nodes"
    )


def _at_bound(curve: _Curve, before: _Point, after: _Point, q: float) -> _Point:
    """The point of the last step at which the parameter is at its bound q."""
    fraction = (q - before.z[-1]) / (after.z[-1] - before.z[-1])
    guess = before.z + fraction * (after.z - before.z)
    guess[-1] = q
    parameter_axis = np.zeros(len(guess))
    parameter_axis[-1] = 1.0
    return curve.point(curve.corrected(guess, parameter_axis), after.tangent)


def _between(curve: _Curve, before: _Point, after: _Point) -> list[Bifurcation]:
    """The bifurcations between two neighbouring points.

    Sorted real parts are continuous along a branch. Where n of them are positive at one point and m at the other, those
    with numbers n … m − 1 change sign, each exactly where its mode does.
    """
    found: list[tuple[float, Bifurcation]] = []
    length = curve.inner(before.z, after.z - before.z, before.tangent)
    number, high = sorted((before.unstable, after.unstable))
    while number < high:
        distance, there = _crossing(curve, before, after, length, number)
        frequency = abs(float(there.eigenvalues[number].imag))
        is_fold = abs(there.tangent[-1]) < FOLD
        kind = "Hopf" if frequency > SMALLEST_FREQUENCY else "fold" if is_fold else "branch point"
        value, shape = curve.value(there.z[-1]), curve.shape(there.z)
        found.append((distance, Bifurcation(kind, value, frequency if kind == "Hopf" else 0.0, shape)))
        number += 2 if kind == "Hopf" else 1
    return [bifurcation for _, bifurcation in sorted(found, key=lambda pair: pair[0])]


def _crossing(curve: _Curve, before: _Point, after: _Point, length: float, number: int) -> tuple[float, _Point]:
    """The distance from ``before`` at which the real part of eigenvalue ``number`` is zero, and the point there."""
    known = {0.0: before, length: after}

    def rate(distance: float) -> float:
        if distance not in known:
            known[distance] = curve.after(before, distance)
        return float(known[distance].eigenvalues[number].real)

    root = float(brentq(rate, 0.0, length, xtol=1e-9, rtol=1e-9))
    rate(root)
    return root, known[root]
