"""SE(3) for tiles of rods: screws between frames, their exponentials, and how they change (appendix B).

A screw is (θ, μ), angular part first. With ad of (B.33), log(exp(X) exp δ) = X + J δ and log(exp(−δ) exp X) = X − J' δ,
to first order in δ, where J = ad/(1 − exp(−ad)) and J' = ad/(exp ad − 1). Both have the same blocks::

    J = [A 0; C A],   J' = [Aᵀ 0; Cᵀ Aᵀ],   A = 1 + θ̂/2 + γ θ̂²,   C = μ̂/2 + γ (θ̂μ̂ + μ̂θ̂) + 2γ'(θ·μ) θ̂²

γ(t), t = |θ|², is the coefficient of (B.20), and γ' its derivative: C is the change of A with θ along μ.
"""

import warp as wp

from warp_rods.kernels.cells import coefficients_of, hat_polynomial
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Matrix,
    Pair,
    Screw,
    Vector,
    add,
    cross,
    dot,
    mul,
    rods_in,
    rows,
    sub,
    transposed_times,
)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

PI = float(wp.pi)


# --- Coefficients ---------------------------------------------------------------------------------------------------


def rest_of_zeta(k: int) -> float:
    """ζ(2k) − 1 − 4⁻ᵏ; evaluated on the host."""
    if k < 3:
        return (PI**2 / 6 - 1.25, PI**4 / 90 - 1.0625)[k - 1]
    return sum(float(n) ** (-2 * k) for n in range(2000, 2, -1))


def _polynomial(coefficients: list[float]) -> str:
    text = repr(coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        text = f"({coefficient!r} + t * {text})"
    return text


# γ = Σ_n 2/((2πn)² − t): two poles as they are, the others as a series, whose terms fall by 36 for angles up to π.
_REST = [2 * rest_of_zeta(k) / (2 * PI) ** (2 * k) for k in range(1, 12)]
_POLES = f"""auto t = S[0]; auto p = 1.0 / ({4 * PI**2!r} - t); auto q = 1.0 / ({16 * PI**2!r} - t);
    R[0] = 2.0 * p + 2.0 * q + {_polynomial(_REST)};
    R[1] = 2.0 * p * p + 2.0 * q * q + {_polynomial([k * c for k, c in enumerate(_REST)][1:])};"""


@wp.func_native(rows("Pair", "s", _POLES))
def inverse_coefficients(s: Lanes) -> Pair:
    """γ and γ' from the square of an angle up to π."""


# --- Screws ---------------------------------------------------------------------------------------------------------


@wp.func_native(rows("Screw", "tm", "for (int i = 0; i < 3; ++i) { R[i] = T[i]; R[i + 3] = M[i]; }"))
def screw(t: Vector, m: Vector) -> Screw:
    """The screw with these parts."""


@wp.func_native(rows("Vector", "x", "for (int i = 0; i < 3; ++i) R[i] = X[i];"))
def angular(x: Screw) -> Vector:
    """θ."""


@wp.func_native(rows("Vector", "x", "for (int i = 0; i < 3; ++i) R[i] = X[i + 3];"))
def linear(x: Screw) -> Vector:
    """μ."""


@wp.func_native(rows("Screw", "ab", "for (int i = 0; i < 6; ++i) R[i] = A[i] + B[i];"))
def plus(a: Screw, b: Screw) -> Screw:
    """a + b."""


@wp.func_native(rows("Screw", "ab", "for (int i = 0; i < 6; ++i) R[i] = A[i] - B[i];"))
def minus(a: Screw, b: Screw) -> Screw:
    """a − b."""


@wp.func_native(rows("Screw", "sa", "for (int i = 0; i < 6; ++i) R[i] = S[0] * A[i];"))
def scaled(s: Lanes, a: Screw) -> Screw:
    """s a."""


@wp.func
def bracket(x: Screw, y: Screw) -> Screw:
    """[x, y] (B.33)."""
    theta, phi = angular(x), angular(y)
    return screw(cross(theta, phi), cross(theta, linear(y)) - cross(phi, linear(x)))


# --- Frames ---------------------------------------------------------------------------------------------------------


@wp.func_native(
    rows(
        "Vector",
        "q",
        "R[0] = 0.5 * (Q[7] - Q[5]); R[1] = 0.5 * (Q[2] - Q[6]); R[2] = 0.5 * (Q[3] - Q[1]);",
    )
)
def axis_times_sine(q: Matrix) -> Vector:
    """The axis of a rotation times the sine of its angle."""


@wp.func_native(rows("Lanes", "q", "R[0] = 0.5 * (Q[0] + Q[4] + Q[8] - 1.0);"))
def cosine_of(q: Matrix) -> Lanes:
    """The cosine of the angle of a rotation."""


@wp.func
def rotation_vector(Q: Matrix) -> Vector:
    """θ of a rotation; (π, 0, 0) where an angle of π leaves no axis."""
    theta = axis_times_sine(Q)
    cosine = cosine_of(Q)
    square = dot(theta, theta)
    for lane in range(rods_in(0, WIDTH)):
        sine = wp.sqrt(square[lane])
        if sine > real(0.0):
            ratio = wp.atan2(sine, cosine[lane]) / sine
            theta[0, lane] = ratio * theta[0, lane]
            theta[1, lane] = ratio * theta[1, lane]
            theta[2, lane] = ratio * theta[2, lane]
        elif cosine[lane] < real(0.0):
            theta[0, lane] = real(wp.pi)
    return theta


@wp.func
def screw_between(R: Matrix, r: Vector, Q: Matrix, q: Vector) -> Screw:
    """X with (R, r) exp X = (Q, q), for angles below π (B.17), (B.20)."""
    theta = rotation_vector(transposed_times(R, Q))
    d = transposed_times(R, q - r)
    gamma = inverse_coefficients(dot(theta, theta))
    rotated = cross(theta, d)
    return screw(theta, d - real(0.5) * rotated + gamma[0] * cross(theta, rotated))


@wp.func
def moved_frame(R: Matrix, r: Vector, x: Screw):
    """(R, r) exp x (B.13)."""
    theta, mu = angular(x), linear(x)
    abc = coefficients_of(dot(theta, theta))
    rotated = cross(theta, mu)
    return R * hat_polynomial(theta, abc), r + R * (mu + abc[1] * rotated + abc[2] * cross(theta, rotated))


@wp.func_native(
    rows(
        "Matrix",
        "a",
        """for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j) {
            R[3 * i + j] = 1.5 * A[3 * i + j];
            for (int l = 0; l < 3; ++l)
                R[3 * i + j] -= 0.5 * A[3 * i + l] * (A[l] * A[j] + A[l + 3] * A[j + 3] + A[l + 6] * A[j + 6]);
        }""",
    )
)
def orthonormal(a: Matrix) -> Matrix:
    """The rotation nearest to a matrix that is one up to round-off: R (3 − RᵀR)/2."""


# --- Changes of screws ----------------------------------------------------------------------------------------------


@wp.func_native(
    rows(
        "Matrix",
        "tg",
        """auto x = T[0], y = T[1], z = T[2], f = G[0];
        R[0] = 1.0 - f * (y * y + z * z); R[1] = f * x * y - 0.5 * z; R[2] = f * x * z + 0.5 * y;
        R[3] = f * x * y + 0.5 * z; R[4] = 1.0 - f * (x * x + z * z); R[5] = f * y * z - 0.5 * x;
        R[6] = f * x * z - 0.5 * y; R[7] = f * y * z + 0.5 * x; R[8] = 1.0 - f * (x * x + y * y);""",
    )
)
def change_of_angle(t: Vector, g: Pair) -> Matrix:
    """A of θ, with (γ, γ')."""


@wp.func_native(
    rows(
        "Matrix",
        "tmg",
        """auto x = T[0], y = T[1], z = T[2], a = M[0], b = M[1], c = M[2], f = G[0];
        auto s = x * a + y * b + z * c, h = 2.0 * G[1] * s;
        R[0] = -2.0 * f * (y * b + z * c) - h * (y * y + z * z);
        R[4] = -2.0 * f * (x * a + z * c) - h * (x * x + z * z);
        R[8] = -2.0 * f * (x * a + y * b) - h * (x * x + y * y);
        auto xy = f * (x * b + y * a) + h * x * y, xz = f * (x * c + z * a) + h * x * z;
        auto yz = f * (y * c + z * b) + h * y * z;
        R[1] = xy - 0.5 * c; R[2] = xz + 0.5 * b; R[3] = xy + 0.5 * c;
        R[5] = yz - 0.5 * a; R[6] = xz - 0.5 * b; R[7] = yz + 0.5 * a;""",
    )
)
def change_of_place(t: Vector, m: Vector, g: Pair) -> Matrix:
    """C of (θ, μ), with (γ, γ')."""


def _in_blocks(element: str, lower: bool) -> str:
    """C++ of [A 0; C A] x (``lower``) or [A C; 0 A] x; ``element``: which element of A and C is at (i, j)."""
    first = f"p += A[{element}] * X[j]" + ("" if lower else f" + C[{element}] * X[j + 3]")
    second = f"q += A[{element}] * X[j + 3]" + (f" + C[{element}] * X[j]" if lower else "")
    body = f"for (int j = 0; j < 3; ++j) {{ {first}; {second}; }}"
    return rows(
        "Screw", "acx", f"for (int i = 0; i < 3; ++i) {{ V p = (V)(0.0), q = p; {body} R[i] = p; R[i + 3] = q; }}"
    )


@wp.func_native(_in_blocks("3 * i + j", lower=True))
def changed(a: Matrix, c: Matrix, x: Screw) -> Screw:
    """J x."""


@wp.func_native(_in_blocks("3 * j + i", lower=True))
def changed_before(a: Matrix, c: Matrix, x: Screw) -> Screw:
    """J' x."""


@wp.func_native(_in_blocks("3 * i + j", lower=False))
def carried(a: Matrix, c: Matrix, x: Screw) -> Screw:
    """J'ᵀ x: a stress carried to the node before."""


@wp.func_native(_in_blocks("3 * j + i", lower=False))
def carried_on(a: Matrix, c: Matrix, x: Screw) -> Screw:
    """Jᵀ x: a stress carried to the node after."""
