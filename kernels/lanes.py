"""Rods side by side in the lanes of vector instructions, with operators that act on each of them alone.

``WIDTH`` rods form a tile. A field of a tile is one value of a type below: one number, pair, or matrix for each rod.
Arrays of fields are [tile, node], and a loop over nodes reads like that of a single rod. Import ``add, div, mul, sub``
where fields are combined: they extend Warp's operators to these types. A rod's bits depend on its own values only.

Nothing in a loop over nodes may branch on values of a field, which differ from rod to rod: take ``where``. What is
done once for a rod and step loops over the lanes of a tile: rod ``tile * WIDTH + lane`` is lane ``lane``. In the last
tile the lanes beyond the last rod repeat it, and are never stored to arrays [rod].
"""

import warp as wp

from warp_rods.kernels.layout import Integers1D, Matrices2D, Scalars1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})

WIDTH = 1 if wp.is_cuda_available() else 8
"""Rods in a tile. A thread of a GPU takes one; vector instructions of CPUs take up to 8."""

Lanes = wp.types.vector(length=WIDTH, dtype=real)
"""A number for each rod."""
Pair = wp.types.matrix(shape=(2, WIDTH), dtype=real)
"""Two components across each rod, or a complex number; ``[0]`` and ``[1]`` are Lanes."""
Vector = wp.types.matrix(shape=(3, WIDTH), dtype=real)
"""Three components for each rod."""
Block = wp.types.matrix(shape=(4, WIDTH), dtype=real)
"""A 2 × 2 matrix for each rod: rows 00, 01, 10, 11."""
Symmetric = wp.types.matrix(shape=(6, WIDTH), dtype=real)
"""A symmetric 3 × 3 matrix for each rod: xx, xy, xz, yy, yz, zz."""
FIELDS = (Lanes, Pair, Vector, Block)
"""The types of fields."""

Lanes1D = wp.array(dtype=Lanes)
Lanes2D = wp.array2d(dtype=Lanes)
Pairs = wp.array2d(dtype=Pair)
Vectors = wp.array2d(dtype=Vector)
Blocks = wp.array2d(dtype=Block)


def each(result: str, body: str) -> str:
    """C++ of a function: ``body`` sets what rod k has in ``r``, a new value of the type ``result``."""
    types = {
        "Lanes": f"wp::vec_t<{WIDTH}, wp::float64>",
        "Pair": f"wp::mat_t<2, {WIDTH}, wp::float64>",
        "Vector": f"wp::mat_t<3, {WIDTH}, wp::float64>",
        "Block": f"wp::mat_t<4, {WIDTH}, wp::float64>",
    }
    return f"{types[result]} r; for (int k = 0; k < {WIDTH}; ++k) {{ {body} }} return r;"


# --- Operators ------------------------------------------------------------------------------------------------------


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] * b.c[k];"))
def mul(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(each("Pair", "r.data[0][k] = a.c[k] * b.data[0][k]; r.data[1][k] = a.c[k] * b.data[1][k];"))
def mul(a: Lanes, b: Pair) -> Pair: ...


@wp.func_native(each("Pair", "r.data[0][k] = a.data[0][k] * b.c[k]; r.data[1][k] = a.data[1][k] * b.c[k];"))
def mul(a: Pair, b: Lanes) -> Pair: ...


@wp.func_native(each("Block", "for (int i = 0; i < 4; ++i) r.data[i][k] = a.c[k] * b.data[i][k];"))
def mul(a: Lanes, b: Block) -> Block: ...


@wp.func_native(each("Block", "for (int i = 0; i < 4; ++i) r.data[i][k] = a.data[i][k] * b.c[k];"))
def mul(a: Block, b: Lanes) -> Block: ...


@wp.func_native(
    each(
        "Pair",
        """r.data[0][k] = a.data[0][k] * b.data[0][k] + a.data[1][k] * b.data[1][k];
    r.data[1][k] = a.data[2][k] * b.data[0][k] + a.data[3][k] * b.data[1][k];""",
    )
)
def mul(a: Block, b: Pair) -> Pair: ...


@wp.func_native(
    each(
        "Block",
        """r.data[0][k] = a.data[0][k] * b.data[0][k] + a.data[1][k] * b.data[2][k];
    r.data[1][k] = a.data[0][k] * b.data[1][k] + a.data[1][k] * b.data[3][k];
    r.data[2][k] = a.data[2][k] * b.data[0][k] + a.data[3][k] * b.data[2][k];
    r.data[3][k] = a.data[2][k] * b.data[1][k] + a.data[3][k] * b.data[3][k];""",
    )
)
def mul(a: Block, b: Block) -> Block: ...


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] / b.c[k];"))
def div(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(each("Lanes", "r.c[k] = a / b.c[k];"))
def div(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(each("Pair", "r.data[0][k] = a.data[0][k] / b.c[k]; r.data[1][k] = a.data[1][k] / b.c[k];"))
def div(a: Pair, b: Lanes) -> Pair: ...


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a.data[i][k] / b.c[k];"))
def div(a: Vector, b: Lanes) -> Vector: ...


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a.c[k] * b.data[i][k];"))
def mul(a: Lanes, b: Vector) -> Vector: ...


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a.data[i][k] * b.c[k];"))
def mul(a: Vector, b: Lanes) -> Vector: ...


@wp.func_native(
    each(
        "Vector",
        """const double x = b.data[0][k], y = b.data[1][k], z = b.data[2][k];
    r.data[0][k] = a.data[0][k] * x + a.data[1][k] * y + a.data[2][k] * z;
    r.data[1][k] = a.data[1][k] * x + a.data[3][k] * y + a.data[4][k] * z;
    r.data[2][k] = a.data[2][k] * x + a.data[4][k] * y + a.data[5][k] * z;""",
    )
)
def mul(a: Symmetric, b: Vector) -> Vector: ...


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a * b.data[i][k];"))
def mul(a: real, b: Vector) -> Vector: ...


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a.data[i][k] + b.data[i][k];"))
def add(a: Vector, b: Vector) -> Vector: ...


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a.data[i][k] - b.data[i][k];"))
def sub(a: Vector, b: Vector) -> Vector: ...


@wp.func_native(each("Lanes", "r.c[k] = a + b.c[k];"))
def add(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] + b.c[k];"))
def add(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] - b.c[k];"))
def sub(a: Lanes, b: Lanes) -> Lanes: ...


@wp.func_native(each("Lanes", "r.c[k] = a - b.c[k];"))
def sub(a: real, b: Lanes) -> Lanes: ...


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] - b;"))
def sub(a: Lanes, b: real) -> Lanes: ...


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] + b;"))
def add(a: Lanes, b: real) -> Lanes: ...


# --- Functions ------------------------------------------------------------------------------------------------------


@wp.func_native(each("Lanes", "r.c[k] = a.data[0][k] * b.data[0][k] + a.data[1][k] * b.data[1][k];"))
def dot(a: Pair, b: Pair) -> Lanes:
    """Re(ā b)."""


@wp.func_native(each("Lanes", "r.c[k] = a.data[0][k] * b.data[1][k] - a.data[1][k] * b.data[0][k];"))
def wedge(a: Pair, b: Pair) -> Lanes:
    """Im(ā b), which is e0·(a × b)."""


@wp.func_native(each("Pair", "r.data[0][k] = -z.data[1][k]; r.data[1][k] = z.data[0][k];"))
def times_i(z: Pair) -> Pair:
    """i z, which is e0 × z."""


@wp.func_native(each("Pair", "r.data[0][k] = x.c[k]; r.data[1][k] = y.c[k];"))
def pair(x: Lanes, y: Lanes) -> Pair:
    """x + iy."""


@wp.func
def pair(x: real, y: real) -> wp.vec2d:
    return wp.vec2d(x, y)


@wp.func_native(
    each("Block", "r.data[0][k] = a.c[k]; r.data[1][k] = b.c[k]; r.data[2][k] = c.c[k]; r.data[3][k] = d.c[k];")
)
def block(a: Lanes, b: Lanes, c: Lanes, d: Lanes) -> Block:
    """The matrix with the rows (a, b) and (c, d)."""


@wp.func_native(each("Vector", "r.data[0][k] = x.c[k]; r.data[1][k] = z.data[0][k]; r.data[2][k] = z.data[1][k];"))
def vector(x: Lanes, z: Pair) -> Vector:
    """The vector with the components x along and z across."""


@wp.func_native(each("Vector", "r.data[0][k] = x.c[k]; r.data[1][k] = y.c[k]; r.data[2][k] = z.c[k];"))
def vector(x: Lanes, y: Lanes, z: Lanes) -> Vector:
    """The vector with these components."""


@wp.func_native(
    each(
        "Lanes",
        "r.c[k] = a.data[0][k] * b.data[0][k] + a.data[1][k] * b.data[1][k] + a.data[2][k] * b.data[2][k];",
    )
)
def dot(a: Vector, b: Vector) -> Lanes:
    """a·b."""


@wp.func_native(
    each(
        "Vector",
        """r.data[0][k] = a.data[1][k] * b.data[2][k] - a.data[2][k] * b.data[1][k];
    r.data[1][k] = a.data[2][k] * b.data[0][k] - a.data[0][k] * b.data[2][k];
    r.data[2][k] = a.data[0][k] * b.data[1][k] - a.data[1][k] * b.data[0][k];""",
    )
)
def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""


@wp.func_native(each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = a.data[i][k] * b.data[i][k];"))
def by_component(a: Vector, b: Vector) -> Vector:
    """The products of the components."""


@wp.func_native(each("Lanes", "r.c[k] = ::sqrt(x.c[k]);"))
def sqrt(x: Lanes) -> Lanes:
    """√x."""


@wp.func_native(each("Lanes", "r.c[k] = x.c[k] * x.c[k];"))
def square(x: Lanes) -> Lanes:
    """x²."""


@wp.func_native(each("Lanes", "r.c[k] = x.c[k] < 0.0 ? -x.c[k] : x.c[k];"))
def magnitude(x: Lanes) -> Lanes:
    """|x|."""


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] < b.c[k] ? b.c[k] : a.c[k];"))
def larger(a: Lanes, b: Lanes) -> Lanes:
    """The larger one; a where b is NaN."""


@wp.func_native(each("Lanes", "r.c[k] = b.c[k] < a.c[k] ? b.c[k] : a.c[k];"))
def smaller(a: Lanes, b: Lanes) -> Lanes:
    """The smaller one; a where b is NaN."""


# --- Conditions -----------------------------------------------------------------------------------------------------


@wp.func_native(each("Lanes", "r.c[k] = m.c[k] != 0.0 ? a.c[k] : b.c[k];"))
def where(m: Lanes, a: Lanes, b: Lanes) -> Lanes:
    """a where m is not zero, b elsewhere."""


@wp.func_native(
    each(
        "Pair",
        """r.data[0][k] = m.c[k] != 0.0 ? a.data[0][k] : b.data[0][k];
    r.data[1][k] = m.c[k] != 0.0 ? a.data[1][k] : b.data[1][k];""",
    )
)
def where(m: Lanes, a: Pair, b: Pair) -> Pair: ...


@wp.func_native(
    each("Vector", "for (int i = 0; i < 3; ++i) r.data[i][k] = m.c[k] != 0.0 ? a.data[i][k] : b.data[i][k];")
)
def where(m: Lanes, a: Vector, b: Vector) -> Vector: ...


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] < b.c[k] ? 1.0 : 0.0;"))
def less(a: Lanes, b: Lanes) -> Lanes:
    """1 where a < b, 0 elsewhere."""


@wp.func_native(each("Lanes", "r.c[k] = a.c[k] < b ? 1.0 : 0.0;"))
def less(a: Lanes, b: real) -> Lanes: ...


@wp.func_native(
    each(
        "Lanes",
        """r.c[k] = 1.0;
    for (int i = 0; i < 3; ++i) if (!(low.c[i] <= x.data[i][k] && x.data[i][k] <= high.c[i])) r.c[k] = 0.0;""",
    )
)
def inside(x: Vector, low: wp.vec3d, high: wp.vec3d) -> Lanes:
    """1 in the box from ``low`` to ``high``, 0 elsewhere."""


@wp.func_native(f"for (int k = 0; k < {WIDTH}; ++k) if (m.c[k] != 0.0) return true; return false;")
def any_of(m: Lanes) -> bool:
    """Whether m is not zero for any rod; NaN is not zero."""


@wp.func_native(f"for (int k = 0; k < {WIDTH}; ++k) if (m.c[k] == 0.0) return false; return true;")
def all_of(m: Lanes) -> bool:
    """Whether m is not zero for all rods."""


# --- Single rods ----------------------------------------------------------------------------------------------------


@wp.func
def rods_in(tile: int, rods: int) -> int:
    """How many of so many rods are in a tile. Loops over it are not unrolled, as loops over ``WIDTH`` would be."""
    return wp.min(WIDTH, rods - tile * WIDTH)


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


@wp.func
def set_pair(field: Pairs, rod: int, node: int, value: wp.vec2d):
    """Set the value of one rod."""
    values = field[rod // WIDTH, node]
    values[0, rod % WIDTH] = value[0]
    values[1, rod % WIDTH] = value[1]
    field[rod // WIDTH, node] = values


@wp.func
def set_block(field: Blocks, rod: int, node: int, value: wp.mat22d):
    """Set the value of one rod."""
    values = field[rod // WIDTH, node]
    for i in range(4):
        values[i, rod % WIDTH] = value[i // 2, i % 2]
    field[rod // WIDTH, node] = values


# --- Arrays of single rods ------------------------------------------------------------------------------------------

ROD = f"int rod = tile * {WIDTH} + k < a.shape[0] ? tile * {WIDTH} + k : a.shape[0] - 1;"
"""C++: the rod of lane k, or the last one where there is none."""


@wp.func_native(each("Lanes", f"{ROD} r.c[k] = *wp::address(a, rod);"))
def load(a: Scalars1D, tile: int) -> Lanes:
    """The values of the rods of a tile; lanes beyond the last rod repeat it."""


@wp.func_native(each("Lanes", f"{ROD} r.c[k] = *wp::address(a, rod);"))
def load(a: Integers1D, tile: int) -> Lanes: ...


@wp.func_native(each("Vector", f"{ROD} for (int i = 0; i < 3; ++i) r.data[i][k] = wp::address(a, rod, node)->c[i];"))
def load(a: Vectors2D, tile: int, node: int) -> Vector: ...


@wp.func_native(
    each(
        "Vector",
        f"""{ROD} const wp::mat_t<3, 3, wp::float64>& m = *wp::address(a, rod, node);
    for (int i = 0; i < 3; ++i)
        r.data[i][k] = m.data[i][0] * v.data[0][k] + m.data[i][1] * v.data[1][k] + m.data[i][2] * v.data[2][k];""",
    )
)
def load_times(a: Matrices2D, tile: int, node: int, v: Vector) -> Vector:
    """The products of the matrices of the rods with v."""


@wp.func_native(
    f"""for (int k = 0; k < {WIDTH} && tile * {WIDTH} + k < a.shape[0]; ++k)
    if (m.c[k] != 0.0) *wp::address(a, tile * {WIDTH} + k) = value.c[k];"""
)
def store(a: Scalars1D, tile: int, m: Lanes, value: Lanes):
    """Store the values of the rods of a tile where m is not zero."""


@wp.func_native(
    f"""for (int k = 0; k < {WIDTH} && tile * {WIDTH} + k < a.shape[0]; ++k)
    if (m.c[k] != 0.0)
        for (int i = 0; i < 3; ++i) wp::address(a, tile * {WIDTH} + k, node)->c[i] = value.data[i][k];"""
)
def store(a: Vectors2D, tile: int, node: int, m: Lanes, value: Vector): ...
