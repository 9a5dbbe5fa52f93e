"""Operators and functions of fields act on each rod alone, as NumPy does on arrays [row, rod]."""

import numpy as np
import warp as wp

from warp_rods.kernels import lanes
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Block,
    Lanes,
    Pair,
    Vector,
    add,
    block,
    div,
    dot,
    inverse,
    larger,
    magnitude,
    mul,
    neg,
    pair,
    sqrt,
    sub,
    times,
    times_i,
    vector,
    wedge,
    where,
)
from warp_rods.kernels.layout import real

ROUND_OFF = 4e-15


@wp.kernel
def find_numbers(x: Lanes, y: Lanes, z: Pair, w: Pair, r: real, out: wp.array(dtype=Lanes)):
    out[0] = x + y
    out[1] = x - y
    out[2] = -x
    out[3] = x * y
    out[4] = x / y
    out[5] = r + x
    out[6] = r - x
    out[7] = r * x
    out[8] = r / x
    out[9] = x / r
    out[10] = dot(z, w)
    out[11] = wedge(z, w)
    out[12] = sqrt(magnitude(x))
    out[13] = larger(x, y)
    out[14] = where(x, y, z[0])


@wp.kernel
def find_pairs(x: Lanes, z: Pair, w: Pair, A: Block, r: real, out: wp.array(dtype=Pair)):
    out[0] = z + w
    out[1] = z - w
    out[2] = -z
    out[3] = x * z
    out[4] = z * x
    out[5] = z / x
    out[6] = r * z
    out[7] = times_i(z)
    out[8] = times(z, w)
    out[9] = inverse(z)
    out[10] = A * z
    out[11] = pair(x, z[1])
    out[12] = where(x, z, w)


@wp.kernel
def find_others(
    x: Lanes,
    z: Pair,
    u: Vector,
    v: Vector,
    A: Block,
    B: Block,
    r: real,
    out: wp.array(dtype=Vector),
    blocks: wp.array(dtype=Block),
):
    out[0] = u + v
    out[1] = u - v
    out[2] = -u
    out[3] = x * u
    out[4] = u / x
    out[5] = r * u
    out[6] = vector(x, z)
    out[7] = where(x, u, v)
    blocks[0] = A + B
    blocks[1] = A - B
    blocks[2] = -A
    blocks[3] = x * A
    blocks[4] = A * x
    blocks[5] = r * A
    blocks[6] = A * B
    blocks[7] = inverse(A)
    blocks[8] = block(x, z[0], z[1], x)
    blocks[9] = where(x, A, B)


def number(z: np.ndarray) -> np.ndarray:
    """Complex numbers of a pair."""
    return z[0] + 1j * z[1]


def parts(z: np.ndarray) -> np.ndarray:
    """The pair of complex numbers."""
    return np.stack([z.real, z.imag])


def matrices(rows: np.ndarray) -> np.ndarray:
    """The matrices [rod, 2, 2] of a block."""
    return rows.T.reshape(-1, 2, 2)


def rows(values: np.ndarray) -> np.ndarray:
    """The block of matrices [rod, 2, 2]."""
    return values.reshape(-1, 4).T


def fields(count: int, seed: int) -> list[np.ndarray]:
    """Random fields of so many rows; the first rod of the first one is 0."""
    values = np.random.default_rng(seed).normal(size=(2, count, WIDTH))
    return [values[0], values[1]]


def close(found: wp.array, expected: list[np.ndarray]) -> None:
    for i, (one, other) in enumerate(zip(found.numpy(), expected, strict=True)):
        np.testing.assert_allclose(one, np.squeeze(other), rtol=ROUND_OFF, atol=ROUND_OFF, err_msg=f"number {i}")


def test_operators_of_numbers():
    (x, y), (z, w), r = fields(1, 1), fields(2, 2), 0.7
    out = wp.zeros(15, dtype=Lanes)
    wp.launch(find_numbers, 1, [Lanes(x[0]), Lanes(y[0]), Pair(z), Pair(w), r, out])
    product = number(z).conj() * number(w)
    sums = [x + y, x - y, -x, x * y, x / y, r + x, r - x, r * x, r / x, x / r]
    close(out, [*sums, product.real, product.imag, np.sqrt(np.abs(x)), np.maximum(x, y), y])


def test_operators_of_pairs():
    (x, _), (z, w), (A, _), r = fields(1, 1), fields(2, 2), fields(4, 3), 0.7
    x[0, 0] = 2.0
    out = wp.zeros(13, dtype=Pair)
    wp.launch(find_pairs, 1, [Lanes(x[0]), Pair(z), Pair(w), Block(A), r, out])
    sums = [z + w, z - w, -z, x * z, z * x, z / x, r * z]
    products = [parts(1j * number(z)), parts(number(z) * number(w)), parts(1 / number(z))]
    close(out, [*sums, *products, np.einsum("kij,jk->ik", matrices(A), z), np.stack([x[0], z[1]]), z])


def test_operators_of_vectors_and_blocks():
    (x, _), (z, _), (u, v), (A, B), r = fields(1, 1), fields(2, 2), fields(3, 4), fields(4, 3), 0.7
    out, blocks = wp.zeros(8, dtype=Vector), wp.zeros(10, dtype=Block)
    wp.launch(find_others, 1, [Lanes(x[0]), Pair(z), Vector(u), Vector(v), Block(A), Block(B), r, out, blocks])
    close(out, [u + v, u - v, -u, x * u, u / x, r * u, np.concatenate([x, z]), u])
    products = [rows(matrices(A) @ matrices(B)), rows(np.linalg.inv(matrices(A)))]
    close(blocks, [A + B, A - B, -A, x * A, A * x, r * A, *products, np.concatenate([x, z, x]), A])


@wp.kernel
def choose(m: Lanes, x: Lanes, y: Lanes, out: wp.array(dtype=Lanes), answers: wp.array(dtype=wp.int32)):
    out[0] = where(m, x, y)
    out[1] = larger(x, m)
    answers[0] = wp.where(lanes.any_of(m), 1, 0)
    answers[1] = wp.where(lanes.all_of(m), 1, 0)


def test_conditions_take_each_rod_alone_and_nan_as_not_zero():
    m = np.zeros(WIDTH)
    x, y = np.arange(WIDTH) + 1.0, -np.arange(WIDTH) - 1.0
    out, answers = wp.zeros(2, dtype=Lanes), wp.zeros(2, dtype=wp.int32)
    for nonzero, any_of, all_of in (
        (slice(0, 0), 0, int(WIDTH == 0)),
        (slice(1, 2), int(WIDTH > 1), 0),
        (slice(None), 1, 1),
    ):
        m[nonzero] = np.nan
        wp.launch(choose, 1, [Lanes(m), Lanes(x), Lanes(y), out, answers])
        np.testing.assert_array_equal(out.numpy()[0], np.where(m != 0, x, y))
        np.testing.assert_array_equal(out.numpy()[1], np.fmax(x, m))
        np.testing.assert_array_equal(answers.numpy(), [any_of, all_of])
