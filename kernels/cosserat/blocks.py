"""Block tridiagonal systems of 6 × 6 matrices, one for each rod of a tile, by elimination without pivoting.

Row i, lower x[i−1] + diagonal x[i] + upper x[i+1] = rhs, becomes x[i] + c x[i+1] = y; a ``Row`` holds c and y. Blocks
of a row are eliminated before those of the next but one are found, so there is room for two rows (``SLOTS``). What is
done with blocks is done in place, as copies would take longer.
"""

import warp as wp

from warp_rods.kernels.lanes import WIDTH, Matrices, Matrix, Row, Rows, Screw, Screws, Square, Squares1D, rows
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

SLOTS = wp.constant(2)
Squares = wp.array2d(dtype=Square)


@wp.struct
class Blocks:
    """The blocks of a row, [tile, slot], and all rows after elimination, [tile, node]."""

    lower: Squares
    diagonal: Squares
    upper: Squares
    rows: Rows


def in_place(elements: dict[str, str], body: str) -> str:
    """C++ of a function of elements of arrays, or of fields, by name: ``body`` reads and sets their rows ``A[i]``."""
    vectors = "".join(f"V* {name} = (V*)&{element};" for name, element in elements.items())
    numbers = "".join(f"const Row {name} = {{(double*)&{element} + k}};" for name, element in elements.items())
    return f"""
#if defined(__CUDACC__)
    struct Row {{ double* first; double& operator[](int i) const {{ return first[i * {WIDTH}]; }} }};
    typedef double V;
    for (int k = 0; k < {WIDTH}; ++k) {{ {numbers} {body} }}
#else
    typedef double V __attribute__((ext_vector_type({WIDTH}), aligned(8)));
    {vectors} {body}
#endif
    """


@wp.func_native(in_place({"D": "wp::index(diagonal, tile, slot)"}, "for (int i = 0; i < 36; ++i) D[i] = (V)(0.0);"))
def clear(diagonal: Squares, tile: int, slot: int):
    """Zeros."""


@wp.func_native(
    in_place(
        {"D": "wp::index(diagonal, tile, slot)", "A": "drag", "B": "block"},
        """for (int i = 0; i < 6; ++i) D[7 * i] += A[i];
        for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j) D[21 + 6 * i + j] += B[3 * i + j];""",
    )
)
def add_drag(diagonal: Squares, tile: int, slot: int, drag: Screw, block: Matrix):
    """Add ``drag`` on the diagonal, and ``block`` to the part of places."""


# (T)(A, C) = ∓[A C; 0 A] K/Δs + [m̂ n̂; n̂ 0]/2, row by row of 3 × 6; B[·] is K.
_ROWS = """for (int j = 0; j < 6; ++j) for (int i = 0; i < 3; ++i) {{
        V p = (V)(0.0), q = (V)(0.0);
        for (int l = 0; l < 3; ++l) {{
            p += A[{a}] * B[6 * l + j] + C[{a}] * B[18 + 6 * l + j]; q += A[{a}] * B[18 + 6 * l + j];
        }}
        T[6 * i + j] = {sign} p; T[18 + 6 * i + j] = {sign} q;
    }}
    for (int h = 0; h < 2; ++h) {{
        V* G = T + 3 * h; const int o = 3 * h;
        G[1] -= 0.5 * P[2 + o]; G[2] += 0.5 * P[1 + o]; G[6] += 0.5 * P[2 + o];
        G[8] -= 0.5 * P[0 + o]; G[12] -= 0.5 * P[1 + o]; G[13] += 0.5 * P[0 + o];
    }}
    T[19] -= 0.5 * P[5]; T[20] += 0.5 * P[4]; T[24] += 0.5 * P[5];
    T[26] -= 0.5 * P[3]; T[30] -= 0.5 * P[4]; T[31] += 0.5 * P[3];"""
# T [A 0; C A], or with Aᵀ and Cᵀ.
_TIMES = """for (int i = 0; i < 6; ++i) for (int j = 0; j < 3; ++j) {{
        V p = (V)(0.0), q = (V)(0.0);
        for (int l = 0; l < 3; ++l) {{
            p += T[6 * i + l] * A[{a}] + T[6 * i + 3 + l] * C[{a}]; q += T[6 * i + 3 + l] * A[{a}];
        }}
        {target}[6 * i + j] {sign}= p; {target}[6 * i + 3 + j] {sign}= q;
    }}"""
_SEGMENT = f"""V B[36]; V T[36];
    for (int i = 0; i < 36; ++i) {{ B[i] = per_spacing * K[i]; L[i] = (V)(0.0); }}
    {_ROWS.format(a="3 * i + l", sign="-")}
    {_TIMES.format(a="3 * j + l", target="D", sign="-")}
    {_TIMES.format(a="3 * l + j", target="U", sign="")}
    {_ROWS.format(a="3 * l + i", sign="")}
    {_TIMES.format(a="3 * j + l", target="L", sign="-")}
    {_TIMES.format(a="3 * l + j", target="N", sign="")}"""


@wp.func_native(
    in_place(
        {
            "K": "wp::index(stiffness, tile)",
            "A": "wp::index(angle, tile, node)",
            "C": "wp::index(place, tile, node)",
            "P": "wp::index(stress, tile, node)",
            "D": "wp::index(diagonal, tile, slot)",
            "U": "wp::index(upper, tile, slot)",
            "L": "wp::index(lower, tile, next)",
            "N": "wp::index(diagonal, tile, next)",
        },
        _SEGMENT,
    )
)
def add_segment(
    stiffness: Squares1D,
    angle: Matrices,
    place: Matrices,
    stress: Screws,
    lower: Squares,
    diagonal: Squares,
    upper: Squares,
    per_spacing: real,
    tile: int,
    node: int,
    slot: int,
    next: int,
):
    """The part of the segment after a node in its row, and in the next one.

    With J = [A 0; C A] and J' = [Aᵀ 0; Cᵀ Aᵀ] (``screws.py``) and the stress (m, n), each of the rows −J'ᵀK/Δs + G and
    JᵀK/Δs + G is multiplied by −J' and J. G = [m̂ n̂; n̂ 0]/2 is how a stress carried to a node turns with the strain.
    """


@wp.func_native(
    in_place(
        {
            "L": "wp::index(lower, tile, slot)",
            "D": "wp::index(diagonal, tile, slot)",
            "U": "wp::index(upper, tile, slot)",
            "H": "held",
        },
        """for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) {
                L[6 * i + j] = H[i] != 0.0 ? (V)(0.0) : L[6 * i + j];
                U[6 * i + j] = H[i] != 0.0 ? (V)(0.0) : U[6 * i + j];
                D[6 * i + j] = H[i] != 0.0 ? (V)(i == j ? 1.0 : 0.0) : D[6 * i + j];
            }
        }""",
    )
)
def hold(lower: Squares, diagonal: Squares, upper: Squares, tile: int, slot: int, held: Screw):
    """The equations x = 0 where ``held`` is not zero; their right-hand side is that of ``unless_held``."""


@wp.func_native(rows("Screw", "ah", "for (int i = 0; i < 6; ++i) R[i] = H[i] != 0.0 ? (V)(0.0) : A[i];"))
def unless_held(a: Screw, h: Screw) -> Screw:
    """a, and zero where h is not zero."""


@wp.func_native(
    in_place(
        {
            "L": "wp::index(lower, tile, slot)",
            "A": "wp::index(diagonal, tile, slot)",
            "U": "wp::index(upper, tile, slot)",
            "B": "wp::index(rows, tile, node > 0 ? node - 1 : 0)",
            "R": "wp::index(rows, tile, node)",
            "Z": "rhs",
        },
        """V D[36]; V Y[42];
        for (int i = 0; i < 6; ++i) {
            for (int j = 0; j < 6; ++j) { D[6 * i + j] = A[6 * i + j]; Y[7 * i + j] = U[6 * i + j]; }
            Y[7 * i + 6] = Z[i];
        }
        if (node > 0) for (int i = 0; i < 6; ++i) for (int l = 0; l < 6; ++l) {
            const V f = L[6 * i + l];
            for (int j = 0; j < 6; ++j) D[6 * i + j] -= f * B[7 * l + j];
            Y[7 * i + 6] -= f * B[7 * l + 6];
        }
        for (int i = 0; i < 6; ++i) {
            const V s = 1.0 / D[7 * i];
            for (int j = i + 1; j < 6; ++j) D[6 * i + j] *= s;
            for (int j = 0; j < 7; ++j) Y[7 * i + j] *= s;
            for (int l = i + 1; l < 6; ++l) {
                const V f = D[6 * l + i];
                for (int j = i + 1; j < 6; ++j) D[6 * l + j] -= f * D[6 * i + j];
                for (int j = 0; j < 7; ++j) Y[7 * l + j] -= f * Y[7 * i + j];
            }
        }
        for (int i = 4; i >= 0; --i) for (int l = i + 1; l < 6; ++l) for (int j = 0; j < 7; ++j)
            Y[7 * i + j] -= D[6 * i + l] * Y[7 * l + j];
        for (int i = 0; i < 42; ++i) R[i] = Y[i];""",
    )
)
def eliminate_row(
    lower: Squares, diagonal: Squares, upper: Squares, rows: Rows, tile: int, node: int, slot: int, rhs: Screw
):
    """Turn the row of a node into x[i] + c x[i+1] = y."""


@wp.func_native(
    rows(
        "Screw",
        "ax",
        """for (int i = 0; i < 6; ++i) {
            V p = A[7 * i + 6]; for (int j = 0; j < 6; ++j) p -= A[7 * i + j] * X[j]; R[i] = p;
        }""",
    )
)
def substituted(a: Row, x: Screw) -> Screw:
    """y − c x."""


@wp.func_native(
    rows(
        "Screw",
        "ax",
        """for (int i = 0; i < 6; ++i) {
            V p = A[6 * i] * X[0]; for (int j = 1; j < 6; ++j) p += A[6 * i + j] * X[j]; R[i] = p;
        }""",
    )
)
def times(a: Square, x: Screw) -> Screw:
    """a x."""
