"""Exact solutions, and reference numbers where there is no closed form, for all tests."""

import numpy as np
from scipy.optimize import brentq

AIRY_STIFFNESSES = np.array(
    [
        *(1.13286e-2, 4.08868e-3, 1.82794e-3, 1.15663e-3, 7.49294e-4),
        *(5.44780e-4, 4.00084e-4, 3.15892e-4, 2.49965e-4, 2.06206e-4),
    ]
)
"""Roots of (4.45) and (4.47), alternating, to six digits."""

CRITICAL_BEND_TANH = 1.06153e-2
"""First critical stiffness of the linear operator with f = −tanh 10s (straight_rod.py)."""

CRITICAL_BEND_BEAM_MODE = 1.0154e-2
"""Stiffness at which beam mode 0 neither grows nor decays under f = −tanh 10s (straight_rod.py)."""

STEADY_U = {5e-3: (3.022, 0.4885), 1e-3: (3.936, 0.6406)}
"""β⊥ → (a₀, |U|) of the steady U-swimmer (steady_u.py)."""

SADDLE_NODE = 8.876e-3
"""β⊥ at which the U branch ends (steady_u.py)."""

HOPF = 1.456e-4
"""β⊥ at which the U becomes unstable to waving (waving.py)."""

BRIDGE_BUCKLING_LENGTH = 0.849
"""Length at which a filament clamped along the waist of ρ = 0.4 + 0.6(1 − exp −z²) becomes unstable.

B = (1, 1, 0.1), σ = (0, 1, 0)."""


def beam_roots(count: int) -> np.ndarray:
    """First ``count`` positive roots of cos x = 1/cosh x: 4.73004, 7.85320, …"""

    def condition(x: float) -> float:
        return np.cos(x) - 1 / np.cosh(x)

    guesses = (np.arange(count) + 1.5) * np.pi
    return np.array([brentq(condition, guess - 0.5, guess + 0.5, xtol=1e-13) for guess in guesses])


def beam_decay_rates(stiffness: float, drag: float, length: float, count: int) -> np.ndarray:
    """Decay rates (B/ζ⊥)(x_k/L)⁴ of small bending: a free planar rod, or a filament on a plane (B3, ζ2)."""
    return stiffness / drag * (beam_roots(count) / length) ** 4


def twist_decay_rates(stiffness: float, rotational_drag: float, length: float, count: int) -> np.ndarray:
    """Decay rates (B∥/ζr)(kπ/L)², k = 1, 2, …, of the twist of a straight free rod."""
    return stiffness / rotational_drag * (np.arange(1, count + 1) * np.pi / length) ** 2


def sphere_decay_rates(
    stiffness: float, drag: float, rotational_drag: float, radius: float, length: float, count: int
) -> np.ndarray:
    """Decay rates of geodesic curvature on a sphere: (B3/(ζ2 + ζr/R²))(∂² + 1/R²)², Ω = Ω' = 0 at the ends.

    The eigenvalues are ν², where ν = p² + 1/R² = q² − 1/R² solves p sinh pa cos qa + q cosh pa sin qa = 0
    (even) or q sinh pa cos qa = p cosh pa sin qa (odd), a = L/2; p may be imaginary.
    """
    a, k2 = length / 2, radius**-2

    def conditions(nu: float) -> tuple[float, float]:
        p, q = np.emath.sqrt(nu - k2 + 0j), np.sqrt(nu + k2)
        even = p * np.sinh(p * a) * np.cos(q * a) + q * np.cosh(p * a) * np.sin(q * a)
        odd = q * np.sinh(p * a) / p * np.cos(q * a) - np.cosh(p * a) * np.sin(q * a)
        return even.real, odd.real

    top = ((count + 2.5) * np.pi / length) ** 2
    grid = np.linspace(1e-4, 1.0, 4001) ** 2 * top
    values = np.array([conditions(nu) for nu in grid])
    roots = []
    for parity in range(2):
        for i in np.flatnonzero(values[1:, parity] * values[:-1, parity] < 0):
            roots.append(brentq(lambda nu, b=parity: conditions(nu)[b], grid[i], grid[i + 1], rtol=1e-13))
    return stiffness / (drag + rotational_drag * k2) * np.sort(roots)[:count] ** 2


def cylinder_energy(angle, stiffness, intrinsic, radius: float) -> np.ndarray:
    """Energy per length of a geodesic filament at ``angle`` α from the circumference of a cylinder.

    ½B1(sin 2α/2R − σ1)² + ½B2(cos² α/R − σ2)²; ``stiffness``, ``intrinsic``: (twist, normal bending, …).
    """
    twist = np.sin(2 * np.asarray(angle)) / (2 * radius) - intrinsic[0]
    bending = np.cos(angle) ** 2 / radius - intrinsic[1]
    return 0.5 * stiffness[0] * twist**2 + 0.5 * stiffness[1] * bending**2


def cylinder_angles(stiffness, intrinsic, radius: float) -> np.ndarray:
    """Angles α in (−π/2, π/2] of the local minima of ``cylinder_energy``, the lowest first.

    dE/dα = 0 is a quartic in exp(2iα). Two-fold degenerate at σ1 = 0 where B2 > B1.
    """
    B1, B2 = stiffness[:2]
    σ1, σ2 = intrinsic[:2]
    A, C = (B1 - B2) / (2 * radius), B2 * (1 / (2 * radius) - σ2)
    roots = np.roots([A, -2j * B1 * σ1 - 2 * C, 0.0, -2j * B1 * σ1 + 2 * C, -A])
    angles = 0.5 * np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-6])

    def slope(α):
        return A * np.sin(2 * α) * np.cos(2 * α) - B1 * σ1 * np.cos(2 * α) - C * np.sin(2 * α)

    def curvature(α):
        return 2 * (A * np.cos(4 * α) + B1 * σ1 * np.sin(2 * α) - C * np.cos(2 * α))

    minima = angles[curvature(angles) > 0]
    for _ in range(3):
        minima = minima - slope(minima) / curvature(minima)
    minima = np.where(minima <= -np.pi / 2 + 1e-12, minima + np.pi, minima)
    return minima[np.argsort(cylinder_energy(minima, stiffness, intrinsic, radius), kind="stable")]


def hoop_buckling_length(neck: float, bend: float, stiffness, normal_curvature: float) -> float:
    """Length at which a filament clamped along the waist of a neck ρ(z) = neck + ½ bend z² + … becomes unstable.

    w(s) is the distance from the waist, w' the angle to it: to second order K12 = c w', Ω = w'' + 𝒦w and
    −K11 = 1/ρ − ½a w² − c w'², with c = ρ'' + 1/ρ, 𝒦 = −ρ''/ρ, a = ρ''/ρ² + ρ''²/ρ. With B = ``stiffness`` and
    σ = (0, ``normal_curvature``, 0) the energy is ½∫ B3 (w'' + 𝒦w)² + P w'² − Q w² ds, P = B1 c² − 2tc, Q = ta,
    t = B2(1/ρ − σ2). The length is the smallest root of the determinant of its Euler–Lagrange equation with w = w' = 0
    at the clamp, Ω = 0 and P w' = B3 Ω' at the tip. For Q > 𝒦²B3 one wavenumber is real and one imaginary.
    """
    c, K, a = bend + 1 / neck, -bend / neck, bend / neck**2 + bend**2 / neck
    t = stiffness[1] * (1 / neck - normal_curvature)
    P, Q, B3 = stiffness[0] * c * c - 2 * t * c, t * a, stiffness[2]
    x = np.sort(np.roots([B3, 2 * K * B3 - P, K * K * B3 - Q]))
    q, p = np.sqrt(-x[0]), np.sqrt(x[1])

    def modes(s: float, order: int, length: float) -> np.ndarray:
        """Derivatives of exp(−ps), exp(p(s − L)), cos qs, sin qs."""
        turn = q * s + order * np.pi / 2
        decaying = (-p) ** order * np.exp(-p * s), p**order * np.exp(p * (s - length))
        return np.array([*decaying, q**order * np.cos(turn), q**order * np.sin(turn)])

    def determinant(length: float) -> float:
        w = [modes(length, order, length) for order in range(4)]
        force = P * w[1] - B3 * (w[3] + K * w[1])
        return np.linalg.det([modes(0, 0, length), modes(0, 1, length), w[2] + K * w[0], force])

    lengths = np.linspace(1e-2, 5.0, 1000)
    values = np.array([determinant(length) for length in lengths])
    first = np.flatnonzero(values[1:] * values[:-1] < 0)[0]
    return brentq(determinant, lengths[first], lengths[first + 1], xtol=1e-12)
