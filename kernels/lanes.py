"""Rods side by side in the lanes of vector instructions, with operators that act on each of them alone.

``WIDTH`` rods form a tile. A field of a tile is one value of a type below: one number, pair, or matrix for each rod.
Arrays of fields are [tile, node], and a loop over nodes reads like that of a single rod. Import ``add, div, mul, sub``
where fields are combined: they extend Warp's operators to these types. A rod's bits depend on its own values only.

Nothing in a loop over nodes may branch on values of a field, which differ from rod to rod: take ``where``. What is
done once for a rod and step loops over the lanes of a tile: rod ``tile * WIDTH + lane`` is lane ``lane``. Lanes
beyond the last rod may hold anything, NaN included: no result depends on them, and they are never stored in arrays
[rod].
"""

import ctypes
import os
from typing import Any

import warp as wp

from warp_rods.kernels.layout import Integers1D, Matrices2D, Scalars1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})


def has_cuda_driver() -> bool:
    """Whether a CUDA driver is installed. To ask Warp would start it, with its banner."""
    try:
        ctypes.CDLL("nvcuda.dll" if os.name == "nt" else "libcuda.so.1")
    except OSError:
        return False
    return True


WIDTH = 1 if has_cuda_driver() else 8
"""Rods in a tile: a thread of a GPU takes one, vector instructions of CPUs take up to 8. A width of 1 works on both."""

Lanes = wp.types.vector(length=WIDTH, dtype=real)
"""A number for each rod."""
Pair = wp.types.matrix(shape=(2, WIDTH), dtype=real)
"""Two components across each rod, or a complex number; ``[0]`` and ``[1]`` are Lanes."""
Vector = wp.types.matrix(shape=(3, WIDTH), dtype=real)
"""Three components for each rod."""
Block = wp.types.matrix(shape=(4, WIDTH), dtype=real)
"""A 2 × 2 matrix for each rod: rows 00, 01, 10, 11."""
Matrix = wp.types.matrix(shape=(9, WIDTH), dtype=real)
"""A 3 × 3 matrix for each rod, row by row."""
Symmetric = wp.types.matrix(shape=(6, WIDTH), dtype=real)
"""A symmetric 3 × 3 matrix for each rod: xx, xy, xz, yy, yz, zz."""
Screw = wp.types.matrix(shape=(6, WIDTH), dtype=real)
"""An element of se(3) or of its dual for each rod, angular part first."""
Square = wp.types.matrix(shape=(36, WIDTH), dtype=real)
"""A 6 × 6 matrix for each rod, row by row."""
Row = wp.types.matrix(shape=(42, WIDTH), dtype=real)
"""A 6 × 6 matrix and a right-hand side for each rod: six rows of seven."""
FIELDS = (Lanes, Pair, Vector, Block, Matrix, Symmetric, Screw, Square, Row)
"""The types of fields."""

Lanes1D = wp.array(dtype=Lanes)
Lanes2D = wp.array2d(dtype=Lanes)
Pairs = wp.array2d(dtype=Pair)
Vectors = wp.array2d(dtype=Vector)
Blocks = wp.array2d(dtype=Block)
Matrices = wp.array2d(dtype=Matrix)
Screws = wp.array2d(dtype=Screw)
Squares1D = wp.array(dtype=Square)
Rows = wp.array2d(dtype=Row)


_TYPES = {
    "Lanes": f"wp::vec_t<{WIDTH}, wp::float64>",
    "Pair": f"wp::mat_t<2, {WIDTH}, wp::float64>",
    "Vector": f"wp::mat_t<3, {WIDTH}, wp::float64>",
    "Block": f"wp::mat_t<4, {WIDTH}, wp::float64>",
    "Matrix": f"wp::mat_t<9, {WIDTH}, wp::float64>",
    "Screw": f"wp::mat_t<6, {WIDTH}, wp::float64>",
    "Square": f"wp::mat_t<36, {WIDTH}, wp::float64>",
    "Row": f"wp::mat_t<42, {WIDTH}, wp::float64>",
}


def rows(result: str, names: str, body: str) -> str:
    """C++ of a function of fields: ``body`` sets the rows ``R[i]`` of the result from those of its arguments.

    names: the arguments that are fields; the rows of ``a`` are ``A[i]``. What the body says of a row holds for each
    rod. Clang's vectors keep rows in registers, which loops over rods do not; CUDA has no such vectors.
    """
    vectors = "".join(f"const V* {name.upper()} = (const V*)&{name};" for name in names)
    numbers = "".join(f"const Row {name.upper()} = {{(double*)&{name} + k}};" for name in names)
    return f"""{_TYPES[result]} r;
#if defined(__CUDACC__)
    struct Row {{ double* first; double& operator[](int i) const {{ return first[i * {WIDTH}]; }} }};
    typedef double V;
    for (int k = 0; k < {WIDTH}; ++k) {{ {numbers} const Row R = {{(double*)&r + k}}; {body} }}
#else
    typedef double V __attribute__((ext_vector_type({WIDTH}), aligned(8)));
    {vectors} V* R = (V*)&r; {body}
#endif
    return r;"""


# --- Operators ------------------------------------------------------------------------------------------------------


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] + B[0];"))
def add(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] + B[0]; R[1] = A[1] + B[1];"))
def add(a: Pair, b: Pair) -> Pair: ...


@wp.func_native(rows("Vector", "ab", "R[0] = A[0] + B[0]; R[1] = A[1] + B[1]; R[2] = A[2] + B[2];"))
def add(a: Vector, b: Vector) -> Vector: ...


@wp.func_native(rows("Block", "ab", "R[0] = A[0] + B[0]; R[1] = A[1] + B[1]; R[2] = A[2] + B[2]; R[3] = A[3] + B[3];"))
def add(a: Block, b: Block) -> Block: ...


@wp.func_native(rows("Lanes", "b", "R[0] = a + B[0];"))
def add(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] - B[0];"))
def sub(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] - B[0]; R[1] = A[1] - B[1];"))
def sub(a: Pair, b: Pair) -> Pair: ...


@wp.func_native(rows("Vector", "ab", "R[0] = A[0] - B[0]; R[1] = A[1] - B[1]; R[2] = A[2] - B[2];"))
def sub(a: Vector, b: Vector) -> Vector: ...


@wp.func_native(rows("Block", "ab", "R[0] = A[0] - B[0]; R[1] = A[1] - B[1]; R[2] = A[2] - B[2]; R[3] = A[3] - B[3];"))
def sub(a: Block, b: Block) -> Block: ...


@wp.func_native(rows("Lanes", "b", "R[0] = a - B[0];"))
def sub(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Lanes", "a", "R[0] = -A[0];"))
def neg(a: Lanes) -> Lanes: ...


@wp.func_native(rows("Pair", "a", "R[0] = -A[0]; R[1] = -A[1];"))
def neg(a: Pair) -> Pair: ...


@wp.func_native(rows("Vector", "a", "R[0] = -A[0]; R[1] = -A[1]; R[2] = -A[2];"))
def neg(a: Vector) -> Vector: ...


@wp.func_native(rows("Block", "a", "R[0] = -A[0]; R[1] = -A[1]; R[2] = -A[2]; R[3] = -A[3];"))
def neg(a: Block) -> Block: ...


@wp.func_native(rows("Lanes", "b", "R[0] = a * B[0];"))
def mul(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Pair", "b", "R[0] = a * B[0]; R[1] = a * B[1];"))
def mul(a: real, b: Pair) -> Pair: ...


@wp.func_native(rows("Vector", "b", "R[0] = a * B[0]; R[1] = a * B[1]; R[2] = a * B[2];"))
def mul(a: real, b: Vector) -> Vector: ...


@wp.func_native(rows("Block", "b", "R[0] = a * B[0]; R[1] = a * B[1]; R[2] = a * B[2]; R[3] = a * B[3];"))
def mul(a: real, b: Block) -> Block: ...


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] * B[0];"))
def mul(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] * B[0]; R[1] = A[0] * B[1];"))
def mul(a: Lanes, b: Pair) -> Pair: ...


@wp.func_native(rows("Vector", "ab", "R[0] = A[0] * B[0]; R[1] = A[0] * B[1]; R[2] = A[0] * B[2];"))
def mul(a: Lanes, b: Vector) -> Vector: ...


@wp.func_native(rows("Block", "ab", "R[0] = A[0] * B[0]; R[1] = A[0] * B[1]; R[2] = A[0] * B[2]; R[3] = A[0] * B[3];"))
def mul(a: Lanes, b: Block) -> Block: ...


@wp.func_native(rows("Matrix", "ab", "for (int i = 0; i < 9; ++i) R[i] = A[0] * B[i];"))
def mul(a: Lanes, b: Matrix) -> Matrix: ...


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] * B[0]; R[1] = A[1] * B[0];"))
def mul(a: Pair, b: Lanes) -> Pair: ...


@wp.func_native(rows("Block", "ab", "R[0] = A[0] * B[0]; R[1] = A[1] * B[0]; R[2] = A[2] * B[0]; R[3] = A[3] * B[0];"))
def mul(a: Block, b: Lanes) -> Block: ...


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] * B[0] + A[1] * B[1]; R[1] = A[2] * B[0] + A[3] * B[1];"))
def mul(a: Block, b: Pair) -> Pair: ...


@wp.func_native(
    rows(
        "Block",
        "ab",
        """
    R[0] = A[0] * B[0] + A[1] * B[2]; R[1] = A[0] * B[1] + A[1] * B[3];
    R[2] = A[2] * B[0] + A[3] * B[2]; R[3] = A[2] * B[1] + A[3] * B[3];
    """,
    )
)
def mul(a: Block, b: Block) -> Block: ...


@wp.func_native(rows("Lanes", "a", "R[0] = A[0] / b;"))
def div(a: Lanes, b: real) -> Lanes: ...


@wp.func_native(rows("Lanes", "b", "R[0] = a / B[0];"))
def div(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] / B[0];"))
def div(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] / B[0]; R[1] = A[1] / B[0];"))
def div(a: Pair, b: Lanes) -> Pair: ...


@wp.func_native(rows("Vector", "ab", "R[0] = A[0] / B[0]; R[1] = A[1] / B[0]; R[2] = A[2] / B[0];"))
def div(a: Vector, b: Lanes) -> Vector: ...


@wp.func_native(
    rows(
        "Vector",
        "ab",
        "for (int i = 0; i < 3; ++i) R[i] = A[3 * i] * B[0] + A[3 * i + 1] * B[1] + A[3 * i + 2] * B[2];",
    )
)
def mul(a: Matrix, b: Vector) -> Vector: ...


@wp.func_native(
    rows(
        "Matrix",
        "ab",
        """for (int i = 0; i < 9; i += 3) for (int j = 0; j < 3; ++j)
            R[i + j] = A[i] * B[j] + A[i + 1] * B[3 + j] + A[i + 2] * B[6 + j];""",
    )
)
def mul(a: Matrix, b: Matrix) -> Matrix: ...


@wp.func_native(rows("Lanes", "a", "R[0] = A[0] - b;"))
def sub(a: Lanes, b: real) -> Lanes: ...


@wp.func_native(rows("Lanes", "a", "R[0] = A[0] + b;"))
def add(a: Lanes, b: real) -> Lanes: ...


@wp.func_native(rows("Vector", "ab", "R[0] = A[0] * B[0]; R[1] = A[1] * B[0]; R[2] = A[2] * B[0];"))
def mul(a: Vector, b: Lanes) -> Vector: ...


@wp.func_native(
    rows(
        "Vector",
        "ab",
        """R[0] = A[0] * B[0] + A[1] * B[1] + A[2] * B[2]; R[1] = A[1] * B[0] + A[3] * B[1] + A[4] * B[2];
        R[2] = A[2] * B[0] + A[4] * B[1] + A[5] * B[2];""",
    )
)
def mul(a: Symmetric, b: Vector) -> Vector: ...


# --- Functions ------------------------------------------------------------------------------------------------------


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] * B[0] + A[1] * B[1];"))
def dot(a: Pair, b: Pair) -> Lanes:
    """Re(ā b)."""


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] * B[1] - A[1] * B[0];"))
def wedge(a: Pair, b: Pair) -> Lanes:
    """Im(ā b), which is e0·(a × b)."""


@wp.func_native(rows("Pair", "z", "R[0] = -Z[1]; R[1] = Z[0];"))
def times_i(z: Pair) -> Pair:
    """i z, which is e0 × z."""


@wp.func_native(rows("Pair", "ab", "R[0] = A[0] * B[0] - A[1] * B[1]; R[1] = A[0] * B[1] + A[1] * B[0];"))
def times(a: Pair, b: Pair) -> Pair:
    """ab of complex numbers."""


@wp.func
def times(a: Block, b: Block) -> Block:
    return a * b


@wp.func
def times(a: Block, b: Pair) -> Pair:
    return a * b


@wp.func
def none_like(a: Pair) -> Pair:
    """Zeros of the type of a."""
    return Pair()


@wp.func
def none_like(a: Block) -> Block:
    return Block()


@wp.func
def none_like(a: Lanes) -> Lanes:
    return Lanes()


@wp.func_native(rows("Pair", "z", "auto s = 1.0 / (Z[0] * Z[0] + Z[1] * Z[1]); R[0] = s * Z[0]; R[1] = -s * Z[1];"))
def inverse(z: Pair) -> Pair:
    """1/z of complex numbers."""


@wp.func_native(
    rows(
        "Block",
        "a",
        """
    auto s = 1.0 / (A[0] * A[3] - A[1] * A[2]);
    R[0] = s * A[3]; R[1] = -s * A[1]; R[2] = -s * A[2]; R[3] = s * A[0];
    """,
    )
)
def inverse(a: Block) -> Block:
    """a⁻¹."""


@wp.func_native(rows("Pair", "xy", "R[0] = X[0]; R[1] = Y[0];"))
def pair(x: Lanes, y: Lanes) -> Pair:
    """x + iy."""


@wp.func
def pair(x: real, y: real) -> wp.vec2d:
    return wp.vec2d(x, y)


@wp.func_native(rows("Vector", "xz", "R[0] = X[0]; R[1] = Z[0]; R[2] = Z[1];"))
def vector(x: Lanes, z: Pair) -> Vector:
    """The vector with the components x along and z across."""


@wp.func_native(rows("Block", "abcd", "R[0] = A[0]; R[1] = B[0]; R[2] = C[0]; R[3] = D[0];"))
def block(a: Lanes, b: Lanes, c: Lanes, d: Lanes) -> Block:
    """The matrix with the rows (a, b) and (c, d)."""


@wp.func_native(
    rows("Vector", "ab", "for (int i = 0; i < 3; ++i) R[i] = A[i] * B[0] + A[i + 3] * B[1] + A[i + 6] * B[2];")
)
def transposed_times(a: Matrix, b: Vector) -> Vector:
    """aᵀb."""


@wp.func_native(
    rows(
        "Matrix",
        "ab",
        """for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j)
            R[3 * i + j] = A[i] * B[j] + A[i + 3] * B[j + 3] + A[i + 6] * B[j + 6];""",
    )
)
def transposed_times(a: Matrix, b: Matrix) -> Matrix: ...


@wp.func_native(f"{_TYPES['Lanes']} r; for (int k = 0; k < {WIDTH}; ++k) r.c[k] = ::sqrt(x.c[k]); return r;")
def sqrt(x: Lanes) -> Lanes:
    """√x."""


@wp.func_native(rows("Lanes", "x", "R[0] = X[0] < 0.0 ? -X[0] : X[0];"))
def magnitude(x: Lanes) -> Lanes:
    """|x|."""


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] < B[0] ? B[0] : A[0];"))
def larger(a: Lanes, b: Lanes) -> Lanes:
    """The larger one; a where b is NaN."""


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] * B[0] + A[1] * B[1] + A[2] * B[2];"))
def dot(a: Vector, b: Vector) -> Lanes: ...


@wp.func_native(rows("Vector", "xyz", "R[0] = X[0]; R[1] = Y[0]; R[2] = Z[0];"))
def vector(x: Lanes, y: Lanes, z: Lanes) -> Vector:
    """The vector with these components."""


@wp.func_native(
    rows(
        "Vector",
        "ab",
        "R[0] = A[1] * B[2] - A[2] * B[1]; R[1] = A[2] * B[0] - A[0] * B[2]; R[2] = A[0] * B[1] - A[1] * B[0];",
    )
)
def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""


@wp.func_native(rows("Vector", "ab", "R[0] = A[0] * B[0]; R[1] = A[1] * B[1]; R[2] = A[2] * B[2];"))
def by_component(a: Vector, b: Vector) -> Vector:
    """The products of the components."""


@wp.func_native(rows("Lanes", "x", "R[0] = X[0] * X[0];"))
def square(x: Lanes) -> Lanes:
    """x²."""


@wp.func_native(rows("Lanes", "ab", "R[0] = B[0] < A[0] ? B[0] : A[0];"))
def smaller(a: Lanes, b: Lanes) -> Lanes:
    """The smaller one; a where b is NaN."""


# --- Conditions -----------------------------------------------------------------------------------------------------


@wp.func_native(rows("Lanes", "mab", "R[0] = M[0] != 0.0 ? A[0] : B[0];"))
def where(m: Lanes, a: Lanes, b: Lanes) -> Lanes:
    """a where m is not zero, b elsewhere."""


@wp.func_native(rows("Pair", "mab", "R[0] = M[0] != 0.0 ? A[0] : B[0]; R[1] = M[0] != 0.0 ? A[1] : B[1];"))
def where(m: Lanes, a: Pair, b: Pair) -> Pair: ...


@wp.func_native(
    rows(
        "Vector",
        "mab",
        "R[0] = M[0] != 0.0 ? A[0] : B[0]; R[1] = M[0] != 0.0 ? A[1] : B[1]; R[2] = M[0] != 0.0 ? A[2] : B[2];",
    )
)
def where(m: Lanes, a: Vector, b: Vector) -> Vector: ...


@wp.func_native(rows("Block", "mab", "for (int i = 0; i < 4; ++i) R[i] = M[0] != 0.0 ? A[i] : B[i];"))
def where(m: Lanes, a: Block, b: Block) -> Block: ...


@wp.func_native(rows("Lanes", "ab", "R[0] = A[0] < B[0] ? (V)(1.0) : (V)(0.0);"))
def less(a: Lanes, b: Lanes) -> Lanes:
    """1 where a < b, 0 elsewhere and for NaN."""


@wp.func_native(rows("Lanes", "a", "R[0] = A[0] < b ? (V)(1.0) : (V)(0.0);"))
def less(a: Lanes, b: real) -> Lanes: ...


def _each(body: str) -> str:
    """C++ that sets number k of the result ``r``."""
    return f"{_TYPES['Lanes']} r; for (int k = 0; k < {WIDTH}; ++k) {{ {body} }} return r;"


@wp.func_native(
    _each(
        """r.c[k] = 1.0;
    for (int i = 0; i < 3; ++i) if (!(low.c[i] <= x.data[i][k] && x.data[i][k] <= high.c[i])) r.c[k] = 0.0;"""
    )
)
def inside(x: Vector, low: wp.vec3d, high: wp.vec3d) -> Lanes:
    """1 in the box from ``low`` to ``high``, 0 elsewhere and for NaN."""


@wp.func_native(f"for (int k = 0; k < {WIDTH}; ++k) if (m.c[k] != 0.0) return true; return false;")
def any_of(m: Lanes) -> bool:
    """Whether m is not zero for any rod; NaN is not zero."""


@wp.func_native(f"for (int k = 0; k < {WIDTH}; ++k) if (m.c[k] == 0.0) return false; return true;")
def all_of(m: Lanes) -> bool:
    """Whether m is not zero for all rods."""


# --- Arrays of rods -------------------------------------------------------------------------------------------------


def _gather(result: str, count: int, value: str) -> str:
    """C++ that takes ``value``, of the rods' elements ``a``, as row i of the result."""
    return f"""{_TYPES[result]} r;
    for (int k = 0; k < {WIDTH}; ++k) {{
        const int rod = tile * {WIDTH} + k;
        const auto& a = wp::index(array, rod < array.shape[0] ? rod : array.shape[0] - 1, node);
        for (int i = 0; i < {count}; ++i) r.data[i][k] = {value};
    }}
    return r;"""


def _scatter(count: int, value: str) -> str:
    """C++ that sets ``value``, of the rods' elements ``a``, to row i of ``field``."""
    return f"""for (int k = 0; k < {WIDTH}; ++k) {{
        const int rod = tile * {WIDTH} + k;
        if (rod >= array.shape[0]) break;
        auto& a = wp::index(array, rod, node);
        for (int i = 0; i < {count}; ++i) {value} = field.data[i][k];
    }}"""


@wp.func_native(_gather("Vector", 3, "a[i]"))
def load(array: Vectors2D, tile: int, node: int) -> Vector:
    """The values of a tile in an array [rod, node]."""


@wp.func_native(_gather("Matrix", 9, "a.data[i / 3][i % 3]"))
def load(array: Matrices2D, tile: int, node: int) -> Matrix: ...


@wp.func_native(_scatter(3, "a[i]"))
def store(array: Vectors2D, tile: int, node: int, field: Vector):
    """Set the values of a tile in an array [rod, node]."""


@wp.func_native(_scatter(9, "a.data[i / 3][i % 3]"))
def store(array: Matrices2D, tile: int, node: int, field: Matrix): ...


_ROD = f"const int rod = tile * {WIDTH} + k < array.shape[0] ? tile * {WIDTH} + k : array.shape[0] - 1;"
_WHERE = f"for (int k = 0; k < {WIDTH} && tile * {WIDTH} + k < array.shape[0]; ++k) if (m.c[k] != 0.0)"


@wp.func_native(_each(f"{_ROD} r.c[k] = wp::index(array, rod);"))
def load(array: Integers1D, tile: int) -> Lanes:
    """The values of a tile in an array [rod]."""


@wp.func_native(f"{_WHERE} wp::index(array, tile * {WIDTH} + k) = field.c[k];")
def store_where(array: Scalars1D, tile: int, m: Lanes, field: Lanes):
    """Set the values of a tile where m is not zero."""


@wp.func_native(
    f"{_WHERE} for (int i = 0; i < 3; ++i) wp::index(array, tile * {WIDTH} + k, node)[i] = field.data[i][k];"
)
def store_where(array: Vectors2D, tile: int, node: int, m: Lanes, field: Vector): ...


# --- Single rods ----------------------------------------------------------------------------------------------------


@wp.func
def rods_in(tile: int, rods: int) -> int:
    """How many of so many rods are in a tile. Loops over it are not unrolled, as loops over ``WIDTH`` would be."""
    return wp.min(WIDTH, rods - tile * WIDTH)


@wp.func
def copy_of(tile: int, node: int, chosen: Lanes, every: bool, given: Any, field: Any):
    """Set a field at a node to ``given`` there, of the rods where ``chosen`` is not zero.

    every: whether that is so for all rods. A copy of the whole tile is several times cheaper than a choice.
    """
    if every:
        field[tile, node] = given[tile, node]
    else:
        field[tile, node] = where(chosen, given[tile, node], field[tile, node])


@wp.func
def repeat_last(tile: int, rods: int, values: Lanes):
    """``values`` with that of the last rod in the lanes beyond it."""
    repeated = Lanes()
    last = rods_in(tile, rods) - 1
    for lane in range(WIDTH):
        repeated[lane] = values[wp.min(lane, last)]
    return repeated


@wp.func
def number_of(field: Lanes2D, rod: int, node: int) -> real:
    """The value of one rod."""
    return field[rod // WIDTH, node][rod % WIDTH]


@wp.func
def pair_of(field: Pairs, rod: int, node: int) -> wp.vec2d:
    """The value of one rod."""
    values = field[rod // WIDTH, node]
    return wp.vec2d(values[0, rod % WIDTH], values[1, rod % WIDTH])


@wp.func
def vector_of(field: Vectors, rod: int, node: int) -> wp.vec3d:
    """The value of one rod."""
    values = field[rod // WIDTH, node]
    return wp.vec3d(values[0, rod % WIDTH], values[1, rod % WIDTH], values[2, rod % WIDTH])


@wp.func
def set_number(field: Lanes2D, rod: int, node: int, value: real):
    """Set the value of one rod."""
    values = field[rod // WIDTH, node]
    values[rod % WIDTH] = value
    field[rod // WIDTH, node] = values
