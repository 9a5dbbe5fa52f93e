"""Linear theory of a nearly straight active rod: spectra of (4.36), critical stiffnesses, growth rates.

All quantities are dimensionless (docs/model.md §1.2): arc length s in [−1/2, 1/2], bending stiffness β⊥ = ``bend``,
drag ratio η, activity f(s).
"""

from collections.abc import Callable
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.linalg import eig, eigvals

from warp_rods.rods.modes import beam_mode_derivative
from warp_rods.theory.airy import airy_mode, airy_stiffnesses
from warp_rods.theory.elements import ClampedElements, clamped_elements

__all__ = [
    "ACTIVITIES",
    "airy_mode",
    "airy_stiffnesses",
    "beam_mode_critical_stiffness",
    "beam_mode_growth_rate",
    "critical_stiffness",
    "eigenmodes",
    "eigenvalues",
    "growth_rates",
    "marginal_stiffnesses",
    "physical_critical_stiffness",
]

Activity = str | Callable[[np.ndarray], ArrayLike] | ArrayLike

ACTIVITIES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "tanh": lambda s: -np.tanh(10.0 * s),
    "piecewise": lambda s: -np.sign(s),
    "uniform": np.ones_like,
}
"""Activity f(s) by name: the two compressive profiles of §4.3, and the uniform one."""

CRITICAL_STIFFNESS = 0.0101
"""Critical β⊥ of appendix C.2, where the growth rate of beam mode 0 vanishes."""


def eigenvalues(
    bend: float, activity: Activity = "tanh", drag_ratio: float = 2.0, count: int = 6, intervals: int = 8
) -> np.ndarray:
    """Leading ``count`` eigenvalues μ_n of the linear curvature dynamics (4.36), (4.37) with f held fixed.

    Complex, largest real part first. ``activity``: a name in ACTIVITIES, a function of s, or values at equally spaced
    nodes from −1/2 to 1/2. Accurate to ten digits where f is smooth on each of the equal ``intervals``. Choose their
    number so that jumps of f lie between two of them: an even number for a jump at s = 0. Raises ValueError for an
    unknown name.
    """
    return _spectrum(bend, activity, drag_ratio, count, intervals)[0]


def eigenmodes(
    bend: float,
    s: ArrayLike,
    activity: Activity = "tanh",
    drag_ratio: float = 2.0,
    count: int = 6,
    intervals: int = 8,
) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues [mode], as ``eigenvalues`` gives them, and curvatures of the modes [mode, node] at ``s`` [node].

    Modes are complex with L² norm 1. Their phase makes them real and positive just beyond the middle, as beam modes
    are.
    """
    values, amplitudes, space = _spectrum(bend, activity, drag_ratio, count, intervals)
    samples = amplitudes @ space.value.T
    # Positive here: even modes that are positive at the middle, and odd modes that rise there.
    beside_middle = space.evaluate(amplitudes, np.array([0.01]))[:, 0]
    phase = np.conj(beside_middle) / np.abs(beside_middle)
    scale = phase / np.sqrt(np.abs(samples) ** 2 @ space.weights)
    return values, space.evaluate(amplitudes * scale[:, None], np.asarray(s, dtype=np.float64))


def marginal_stiffnesses(
    count: int = 1, activity: Activity = "tanh", drag_ratio: float = 2.0, intervals: int = 8
) -> np.ndarray:
    """The ``count`` largest stiffnesses β⊥ at which (4.36) has an eigenvalue μ = 0, descending.

    With f = −tanh 10s the first is 1.06153e-2; with the piecewise f they are ``airy_stiffnesses``. Fewer are returned
    where fewer exist. ``drag_ratio`` has an effect only where the mean of f is not zero.
    """
    space = clamped_elements(intervals)
    bending, load = _weak_forms(activity, drag_ratio, space)
    stiffness = eigvals(load, bending)
    negligible = 1e-9 * np.abs(stiffness).max()
    real = stiffness.real[np.abs(stiffness.imag) <= negligible]
    return np.sort(real[real > negligible])[::-1][:count]


def beam_mode_growth_rate(
    bend: float, activity: Activity = "tanh", drag_ratio: float = 2.0, mode: int = 0, intervals: int = 8
) -> float:
    """Initial growth rate σ_k = ⟨φ_k, L φ_k⟩ of beam mode ``mode``, all other modes absent (Fig 4.2b)."""
    bending, load = _beam_mode_forms(activity, drag_ratio, mode, intervals)
    return (load - bend * bending) / drag_ratio


def beam_mode_critical_stiffness(
    activity: Activity = "tanh", drag_ratio: float = 2.0, mode: int = 0, intervals: int = 8
) -> float:
    """Stiffness β⊥ at which ``beam_mode_growth_rate`` is zero: 1.0154e-2 for f = −tanh 10s and mode 0."""
    bending, load = _beam_mode_forms(activity, drag_ratio, mode, intervals)
    return load / bending


@overload
def critical_stiffness(count: int, /) -> np.ndarray: ...


@overload
def critical_stiffness(length: float, diameter: float, viscosity: float, speed: float) -> float: ...


def critical_stiffness(*arguments: Any, **named: Any) -> Any:
    """Critical bending stiffness, dimensionless or of a real cell.

    ``critical_stiffness(10)``: the first ten dimensionless values, as ``airy_stiffnesses(10)``.
    ``critical_stiffness(length, diameter, viscosity, speed)`` in SI units: the value for a real cell in N m², as
    ``physical_critical_stiffness``. Raises TypeError for any other arguments.
    """
    if len(arguments) == 1 and not named:
        return airy_stiffnesses(*arguments)
    return physical_critical_stiffness(*arguments, **named)


def physical_critical_stiffness(length: float, diameter: float, viscosity: float, speed: float) -> float:
    """Critical bending stiffness B⊥ in N m² of a cell that swims at ``speed`` (appendix C.2).

    ``length`` L and ``diameter`` a in m, ``viscosity`` μ in Pa s, ``speed`` u* in m/s. B⊥ = β* f* L³ with
    ζ∥ = 2πμ/ln(L/a) and f* = ζ∥ u*. Raises ValueError unless all are positive and L > a.
    """
    if not (length > diameter > 0 and viscosity > 0 and speed > 0):
        raise ValueError("must be: length > diameter > 0, viscosity > 0 and speed > 0")
    drag = 2.0 * np.pi * viscosity / np.log(length / diameter)
    return float(CRITICAL_STIFFNESS * drag * speed * length**3)


def growth_rates(
    rate: Callable[[np.ndarray], ArrayLike], state: ArrayLike, count: int = 6, step: float = 1e-6
) -> np.ndarray:
    """Leading ``count`` eigenvalues of the linearisation of d/dt state = ``rate(state)`` about ``state``.

    ``state`` [component]. Eigenvalues are complex, largest real part first. The Jacobian is dense and comes from
    central differences of size ``step`` times max(1, |component|), which takes two calls of ``rate`` per component.
    """
    state = np.asarray(state, dtype=np.float64)
    jacobian = np.empty((state.size, state.size))
    for column, size in enumerate(step * np.maximum(1.0, np.abs(state))):
        ahead, behind = state.copy(), state.copy()
        ahead[column] += size
        behind[column] -= size
        change = np.asarray(rate(ahead)) - np.asarray(rate(behind))
        jacobian[:, column] = change / (ahead[column] - behind[column])
    return _leading(eigvals(jacobian), count)


def _leading(values: np.ndarray, count: int) -> np.ndarray:
    return values[np.lexsort((-values.imag, -values.real))][:count]


def _straight_rod(activity: Activity, space: ClampedElements) -> tuple[np.ndarray, float]:
    """Tension (4.35) of the straight rod at the Gauss points, and the mean activity f̄."""
    if isinstance(activity, str):
        if activity not in ACTIVITIES:
            raise ValueError(f"activity = {activity!r}: must be one of {', '.join(ACTIVITIES)}")
        force = ACTIVITIES[activity](space.s)
    elif callable(activity):
        force = np.broadcast_to(np.asarray(activity(space.s), dtype=np.float64), space.s.shape)
    else:
        samples = np.asarray(activity, dtype=np.float64)
        force = CubicSpline(np.linspace(-0.5, 0.5, len(samples)), samples)(space.s)
    mean = float(space.weights @ force)
    return -space.antiderivative(force - mean), mean


def _weak_forms(activity: Activity, drag_ratio: float, space: ClampedElements) -> tuple[np.ndarray, np.ndarray]:
    """Matrices of ∫ψ''κ'' and of the load ∫ψ''λκ + η f̄ ∫ψκ' in the weak form of (4.36)."""
    tension, mean = _straight_rod(activity, space)
    weights = space.weights[:, None]
    bending = space.second.T @ (weights * space.second)
    load = space.second.T @ (weights * tension[:, None] * space.value)
    load += drag_ratio * mean * space.value.T @ (weights * space.slope)
    return bending, load


def _spectrum(
    bend: float, activity: Activity, drag_ratio: float, count: int, intervals: int
) -> tuple[np.ndarray, np.ndarray, ClampedElements]:
    """Leading eigenvalues [mode], their basis amplitudes [mode, function], and the basis."""
    space = clamped_elements(intervals)
    bending, load = _weak_forms(activity, drag_ratio, space)
    mass = space.value.T @ (space.weights[:, None] * space.value)
    values, vectors = eig((load - bend * bending) / drag_ratio, mass)
    order = np.lexsort((-values.imag, -values.real))[:count]
    return values[order], vectors.T[order], space


def _beam_mode_forms(activity: Activity, drag_ratio: float, mode: int, intervals: int) -> tuple[float, float]:
    """The two forms of ``_weak_forms`` for one beam mode."""
    space = clamped_elements(intervals)
    tension, mean = _straight_rod(activity, space)
    value, slope, second = (beam_mode_derivative(mode, space.s, order) for order in range(3))
    load = space.weights @ (second * tension * value + drag_ratio * mean * value * slope)
    return float(space.weights @ second**2), float(load)
