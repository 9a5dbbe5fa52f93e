"""Block tridiagonal systems of 6 × 6 matrices, one for each rod of a tile, by elimination without pivoting.

Row i, [lower x[i−1] + diagonal x[i] + upper x[i+1] = rhs], becomes x[i] + c x[i+1] = y; a ``Row`` holds c and y.
"""

import warp as wp

from warp_rods.kernels.lanes import Lanes, Matrix, Row, Screw, Square, rows

wp.set_module_options({"enable_backward": False})


@wp.func_native(rows("Square", "ab", "for (int i = 0; i < 36; ++i) R[i] = A[i] + B[i];"))
def plus(a: Square, b: Square) -> Square:
    """a + b."""


@wp.func_native(rows("Square", "ab", "for (int i = 0; i < 36; ++i) R[i] = A[i] - B[i];"))
def minus(a: Square, b: Square) -> Square:
    """a − b."""


@wp.func_native(rows("Square", "sa", "for (int i = 0; i < 36; ++i) R[i] = S[0] * A[i];"))
def scaled(s: Lanes, a: Square) -> Square:
    """s a."""


@wp.func_native(
    rows(
        "Screw",
        "ax",
        """for (int i = 0; i < 6; ++i) {
            R[i] = A[6 * i] * X[0]; for (int j = 1; j < 6; ++j) R[i] += A[6 * i + j] * X[j];
        }""",
    )
)
def times(a: Square, x: Screw) -> Screw:
    """a x."""


@wp.func_native(
    rows(
        "Square",
        "acb",
        """for (int i = 0; i < 3; ++i) for (int j = 0; j < 6; ++j) {
            auto p = A[3 * i] * B[j], q = A[3 * i] * B[18 + j];
            for (int l = 1; l < 3; ++l) { p += A[3 * i + l] * B[6 * l + j]; q += A[3 * i + l] * B[18 + 6 * l + j]; }
            for (int l = 0; l < 3; ++l) p += C[3 * i + l] * B[18 + 6 * l + j];
            R[6 * i + j] = p; R[18 + 6 * i + j] = q;
        }""",
    )
)
def carried(a: Matrix, c: Matrix, b: Square) -> Square:
    """[A C; 0 A] b."""


@wp.func_native(
    rows(
        "Square",
        "bac",
        """for (int i = 0; i < 6; ++i) for (int j = 0; j < 3; ++j) {
            auto p = B[6 * i] * A[j], q = B[6 * i + 3] * A[j];
            for (int l = 1; l < 3; ++l) { p += B[6 * i + l] * A[3 * l + j]; q += B[6 * i + 3 + l] * A[3 * l + j]; }
            for (int l = 0; l < 3; ++l) p += B[6 * i + 3 + l] * C[3 * l + j];
            R[6 * i + j] = p; R[6 * i + 3 + j] = q;
        }""",
    )
)
def times_change(b: Square, a: Matrix, c: Matrix) -> Square:
    """b [A 0; C A]."""


@wp.func_native(
    rows(
        "Square",
        "ap",
        """for (int i = 0; i < 36; ++i) R[i] = A[i];
        R[1] -= 0.5 * P[2]; R[2] += 0.5 * P[1]; R[6] += 0.5 * P[2]; R[8] -= 0.5 * P[0]; R[12] -= 0.5 * P[1];
        R[13] += 0.5 * P[0]; R[4] -= 0.5 * P[5]; R[5] += 0.5 * P[4]; R[9] += 0.5 * P[5]; R[11] -= 0.5 * P[3];
        R[15] -= 0.5 * P[4]; R[16] += 0.5 * P[3]; R[19] -= 0.5 * P[5]; R[20] += 0.5 * P[4]; R[24] += 0.5 * P[5];
        R[26] -= 0.5 * P[3]; R[30] -= 0.5 * P[4]; R[31] += 0.5 * P[3];""",
    )
)
def plus_geometric(a: Square, p: Screw) -> Square:
    """a + [m̂ n̂; n̂ 0]/2 with the stress p = (m, n): how a stress carried to a node turns with the strain."""


@wp.func_native(
    rows(
        "Square",
        "adb",
        """for (int i = 0; i < 36; ++i) R[i] = A[i];
        for (int i = 0; i < 6; ++i) R[7 * i] += D[i];
        for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j) R[21 + 6 * i + j] += B[3 * i + j];""",
    )
)
def plus_drag(a: Square, d: Screw, b: Matrix) -> Square:
    """a with d added to its diagonal, and b to the block of places."""


@wp.func_native(
    rows(
        "Row",
        "abc",
        """for (int i = 0; i < 6; ++i) for (int j = 0; j < 7; ++j) {
            auto p = A[6 * i] * C[j]; for (int l = 1; l < 6; ++l) p += A[6 * i + l] * C[7 * l + j];
            R[7 * i + j] = (j < 6 ? B[6 * i + (j < 6 ? j : 0)] : (V)(0.0)) - p;
        }""",
    )
)
def eliminated(a: Square, b: Square, c: Row) -> Row:
    """[b, 0] − a c: the diagonal b less what the row before has of it, and −a y of that row."""


@wp.func_native(
    rows("Row", "ax", "for (int i = 0; i < 42; ++i) R[i] = A[i]; for (int i = 0; i < 6; ++i) R[7 * i + 6] += X[i];")
)
def plus_rhs(a: Row, x: Screw) -> Row:
    """a with x added to its right-hand side."""


@wp.func_native(
    rows(
        "Row",
        "ab",
        """for (int i = 0; i < 42; ++i) R[i] = A[i];
        for (int i = 0; i < 6; ++i) for (int j = 0; j < 6; ++j) R[7 * i + j] -= B[6 * i + j];""",
    )
)
def minus_block(a: Row, b: Square) -> Row:
    """a with b subtracted from its matrix."""


@wp.func_native(
    rows(
        "Row",
        "ab",
        """V D[36]; V Y[42];
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) { D[6 * i + j] = A[7 * i + j]; Y[7 * i + j] = B[6 * i + j]; }
            Y[7 * i + 6] = A[7 * i + 6];
        }
        for (int i = 0; i < 6; ++i) {
            auto s = 1.0 / D[7 * i];
            for (int j = i + 1; j < 6; ++j) D[6 * i + j] *= s;
            for (int j = 0; j < 7; ++j) Y[7 * i + j] *= s;
            for (int l = i + 1; l < 6; ++l) {
                auto f = D[6 * l + i];
                for (int j = i + 1; j < 6; ++j) D[6 * l + j] -= f * D[6 * i + j];
                for (int j = 0; j < 7; ++j) Y[7 * l + j] -= f * Y[7 * i + j];
            }
        }
        for (int i = 4; i >= 0; --i) for (int l = i + 1; l < 6; ++l) for (int j = 0; j < 7; ++j)
            Y[7 * i + j] -= D[6 * i + l] * Y[7 * l + j];
        for (int i = 0; i < 42; ++i) R[i] = Y[i];""",
    )
)
def solved(a: Row, b: Square) -> Row:
    """(D⁻¹ b, D⁻¹ y) of a = (D, y)."""


@wp.func_native(
    rows(
        "Screw",
        "ax",
        """for (int i = 0; i < 6; ++i) {
            R[i] = A[7 * i + 6]; for (int j = 0; j < 6; ++j) R[i] -= A[7 * i + j] * X[j];
        }""",
    )
)
def substituted(a: Row, x: Screw) -> Screw:
    """y − c x."""


@wp.func_native(
    rows(
        "Row",
        "ah",
        """for (int i = 0; i < 6; ++i) for (int j = 0; j < 7; ++j)
            R[7 * i + j] = H[i] != 0.0 ? (V)(i == j ? 1.0 : 0.0) : A[7 * i + j];""",
    )
)
def held(a: Row, h: Screw) -> Row:
    """a with the equations x = 0 where h is not zero."""


@wp.func_native(rows("Square", "ah", "for (int i = 0; i < 36; ++i) R[i] = H[i / 6] != 0.0 ? (V)(0.0) : A[i];"))
def held(a: Square, h: Screw) -> Square:
    """a with zeros in the rows where h is not zero."""
