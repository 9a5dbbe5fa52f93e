"""Stencils along a rod: exact for quadratics, second order, and equal to a NumPy twin."""

from typing import Any

import numpy as np
import pytest
import warp as wp

from warp_rods.kernels import stencils
from warp_rods.kernels.layout import per_node, per_rod, real

wp.set_module_options({"enable_backward": False})

DTYPES = {"number": (real, ()), "pair": (wp.vec2d, (2,)), "vector": (wp.vec3d, (3,))}


@wp.kernel
def at_nodes(
    f: wp.array2d(dtype=Any),
    h: real,
    first: wp.array2d(dtype=Any),
    second: wp.array2d(dtype=Any),
    weight: wp.array2d(dtype=real),
):
    rod, i = wp.tid()
    first[rod, i] = stencils.derivative(f, rod, i, h)
    second[rod, i] = stencils.second_derivative(f, rod, i, h)
    weight[rod, i] = stencils.trapezoid_weight(i, f.shape[1], h)


@wp.kernel
def at_half_nodes(f: wp.array2d(dtype=Any), h: real, difference: wp.array2d(dtype=Any), average: wp.array2d(dtype=Any)):
    rod, i = wp.tid()
    difference[rod, i] = stencils.half_difference(f, rod, i, h)
    average[rod, i] = stencils.half_average(f, rod, i)


@wp.kernel
def at_rods(
    f: wp.array2d(dtype=Any),
    slopes: wp.array2d(dtype=Any),
    h: real,
    ends: wp.array2d(dtype=Any),
    total: wp.array(dtype=Any),
):
    rod = wp.tid()
    ends[rod, 0] = stencils.second_derivative_at_start(f, rod, slopes[rod, 0], h)
    ends[rod, 1] = stencils.second_derivative_at_end(f, rod, slopes[rod, 1], h)
    total[rod] = stencils.integral(f, rod, h)


for _dtype, _ in DTYPES.values():
    _field = wp.array2d(dtype=_dtype)
    wp.overload(at_nodes, {name: _field for name in ("f", "first", "second")})
    wp.overload(at_half_nodes, {name: _field for name in ("f", "difference", "average")})
    _rod_fields = {name: _field for name in ("f", "slopes", "ends")}
    wp.overload(at_rods, _rod_fields | {"total": wp.array(dtype=_dtype)})


def on_device(f: np.ndarray, slopes: np.ndarray, h: float, dtype, device) -> dict[str, np.ndarray]:
    """Every stencil of ``f`` [rod, node, ...] with end slopes [rod, 2, ...]; totals are [rod, ...]."""
    rods, nodes = f.shape[:2]
    fields = {
        name: per_node(rods, nodes - (name in ("difference", "average")), dtype, device)
        for name in ("f", "first", "second", "difference", "average")
    }
    fields["weight"] = per_node(rods, nodes, real, device)
    fields["ends"] = per_node(rods, 2, dtype, device)
    fields["total"] = per_rod(rods, dtype, device)
    fields["f"].assign(f)
    given = per_node(rods, 2, dtype, device)
    given.assign(slopes)
    a, h = fields, real(h)
    wp.launch(at_nodes, (rods, nodes), [a["f"], h, a["first"], a["second"], a["weight"]], device=device)
    wp.launch(at_half_nodes, (rods, nodes - 1), [a["f"], h, a["difference"], a["average"]], device=device)
    wp.launch(at_rods, rods, [a["f"], given, h, a["ends"], a["total"]], device=device)
    return {name: array.numpy() for name, array in fields.items()}


def in_numpy(f: np.ndarray, slopes: np.ndarray, h: float) -> dict[str, np.ndarray]:
    """The same formulas in NumPy, in textbook form."""
    second = np.empty_like(f)
    second[:, 1:-1] = (f[:, 2:] - 2 * f[:, 1:-1] + f[:, :-2]) / h**2
    second[:, 0] = (2 * f[:, 0] - 5 * f[:, 1] + 4 * f[:, 2] - f[:, 3]) / h**2
    second[:, -1] = (2 * f[:, -1] - 5 * f[:, -2] + 4 * f[:, -3] - f[:, -4]) / h**2
    ends = np.stack(
        [
            2 * (f[:, 1] - f[:, 0] - h * slopes[:, 0]) / h**2,
            2 * (f[:, -2] - f[:, -1] + h * slopes[:, 1]) / h**2,
        ],
        axis=1,
    )
    weight = np.full(f.shape[:2], h)
    weight[:, [0, -1]] /= 2
    return {
        "first": np.gradient(f, h, axis=1, edge_order=2),
        "second": second,
        "weight": weight,
        "difference": np.diff(f, axis=1) / h,
        "average": (f[:, 1:] + f[:, :-1]) / 2,
        "ends": ends,
        "total": np.trapezoid(f, dx=h, axis=1),
    }


@pytest.mark.parametrize("kind", DTYPES)
def test_stencils_equal_their_numpy_twin(kind, device):
    dtype, tail = DTYPES[kind]
    rng = np.random.default_rng(1)
    f, slopes, h = rng.normal(size=(3, 11, *tail)), rng.normal(size=(3, 2, *tail)), 0.1
    measured = on_device(f, slopes, h, dtype, device)
    for name, expected in in_numpy(f, slopes, h).items():
        # Round-off of a few operations on numbers of size |f| / h².
        np.testing.assert_allclose(measured[name], expected, rtol=1e-14, atol=1e-14 / h**2, err_msg=name)


@pytest.mark.parametrize("nodes", [4, 9, 33])
def test_stencils_are_exact_for_quadratics(nodes, device, verified):
    h = 1 / (nodes - 1)
    s = np.linspace(0, 1, nodes)
    p = np.array([[2.0, -3.0, 0.7], [0.4, 5.0, -1.1]])  # [rod, power]: p0 + p1 s + p2 s²
    f = p @ [s**0, s, s**2]
    slope = p[:, 1:2] + 2 * p[:, 2:] * s
    middle = s[:-1] + h / 2
    measured = on_device(f, slope[:, [0, -1]], h, real, device)
    exact = {
        "first": slope,
        "second": np.broadcast_to(2 * p[:, 2:], f.shape),
        "difference": p[:, 1:2] + 2 * p[:, 2:] * middle,
        "ends": np.broadcast_to(2 * p[:, 2:], (2, 2)),
    }
    verified.below(
        "exact", f"stencils for quadratics at {nodes} nodes: errors times Δs²",
        measured=[abs(measured[name] - expected).max() * h**2 for name, expected in exact.items()], bound=2e-14,
        reference="exact derivatives",
    )  # fmt: skip


def test_the_derivatives_of_a_constant_are_exactly_zero(device):
    f = np.full((2, 12), 0.1)
    measured = on_device(f, np.zeros((2, 2)), 1 / 11, real, device)
    for name in ("first", "second", "difference", "ends"):
        assert not measured[name].any(), name


def sine_errors(nodes: int, device) -> dict[str, float]:
    """The largest error of each stencil for sin(3 s + 1), s from 0 to 1, separately at ends and at inner nodes."""
    h, s = 1 / (nodes - 1), np.linspace(0, 1, nodes)
    f, slope, second = np.sin(3 * s + 1), 3 * np.cos(3 * s + 1), -9 * np.sin(3 * s + 1)
    middle = 3 * (s[:-1] + h / 2) + 1
    m = on_device(f[None], slope[None, [0, -1]], h, real, device)
    first, twice = abs(m["first"][0] - slope), abs(m["second"][0] - second)
    return {
        "derivative inside": first[1:-1].max(),
        "derivative at ends": first[[0, -1]].max(),
        "second derivative inside": twice[1:-1].max(),
        "second derivative at ends": twice[[0, -1]].max(),
        "half difference": abs(m["difference"][0] - 3 * np.cos(middle)).max(),
        "half average": abs(m["average"][0] - np.sin(middle)).max(),
        "integral": abs(m["total"][0] - (np.cos(1) - np.cos(4)) / 3),
        "mirrored end": abs(m["ends"][0] - second[[0, -1]]).max(),
    }


def test_every_stencil_has_its_order(device, verified):
    sizes = np.array([33, 65, 129, 257])
    errors = [sine_errors(nodes, device) for nodes in sizes]
    slopes = {name: -np.polyfit(np.log(sizes - 1), np.log([e[name] for e in errors]), 1)[0] for name in errors[0]}
    verified.order(
        "stencils: orders of " + ", ".join(slopes), measured=list(slopes.values()),
        expected=[1.0 if name == "mirrored end" else 2.0 for name in slopes], reference="sin(3s + 1), N = 32 to 256",
    )  # fmt: skip
