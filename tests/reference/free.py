"""The staggered Bishop-frame scheme of free rods in NumPy and SciPy (docs/model.md §2).

Bending is complex, ``k = Ω[1] + i Ω[2]`` in the twist-free frame. Arrays are ``[rod, node]``; an array at half nodes
has one entry fewer.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded


@dataclass
class Parameters:
    """One number per rod (or one for all), dimensionless, with the names of the ensemble."""

    bend: float = 5e-3
    twist: float = 1e-3
    moment: float = 0.0
    drag_ratio: float = 2.0
    rotational_drag: float = 3e-3
    relaxation: float = 1e-2
    diffusion: float = 1e-3


@dataclass
class Shape:
    """The strains and the flagellar field: the unknowns of the shape equations."""

    bending: np.ndarray
    twist: np.ndarray
    activity: np.ndarray

    def fields(self):
        return self.bending, self.twist, self.activity

    def combined(self, weight, other, other_weight):
        return Shape(*(weight * a + other_weight * b for a, b in zip(self.fields(), other.fields(), strict=True)))


@dataclass
class Load:
    """What acts on rods from outside, in the Bishop frame: forces, and the drag that contact adds to their own."""

    axial: np.ndarray | float = 0.0  # half nodes
    transverse: np.ndarray | complex = 0.0  # nodes, complex
    axial_drag: np.ndarray | float = 0.0  # half nodes
    transverse_drag: np.ndarray | float = 0.0  # nodes, 2 × 2 matrices


NOTHING = Load()


def load_of(force):
    """The load of an external force at nodes [rod, node, 3] in the Bishop frame."""
    return Load(middle(force[..., 0]), force[..., 1] + 1j * force[..., 2])


def across(p, load, force):
    """u⊥ from (η + D⊥) u⊥ = force, with D⊥ a 2 × 2 matrix at each node."""
    pair = np.stack([force.real, force.imag], axis=-1)
    drag = np.reshape(p.drag_ratio, (-1, 1, 1, 1)) * np.eye(2) + load.transverse_drag
    velocity = np.linalg.solve(np.broadcast_to(drag, (*force.shape, 2, 2)), pair[..., None])[..., 0]
    return velocity[..., 0] + 1j * velocity[..., 1]


def middle(x):
    """Values at half nodes."""
    return (x[:, 1:] + x[:, :-1]) / 2


def slope(x, h):
    """Difference quotient: from nodes to half nodes, or from half nodes to interior nodes."""
    return np.diff(x, axis=1) / h


def odd_slope(x, h):
    """From half nodes to all nodes, with x odd beyond the ends."""
    return slope(np.concatenate([-x[:, :1], x, -x[:, -1:]], axis=1), h)


def even_mean(x):
    """From half nodes to all nodes, with x even beyond the ends."""
    return middle(np.concatenate([x[:, :1], x, x[:, -1:]], axis=1))


def pinned(interior):
    """Interior values with zeros at both ends."""
    return np.pad(interior, ((0, 0), (1, 1)))


def solve_rows(bands, right):
    """Solve the banded system of each rod; ``bands[offset]`` is ``[rod, row]``, the entry at column row + offset."""
    reach = max(bands)
    result = np.empty_like(right)
    for rod in range(len(right)):
        n = right.shape[1]
        stored = np.zeros((2 * reach + 1, n))
        for offset, band in bands.items():
            rows = np.arange(max(0, -offset), n - max(0, offset))
            stored[reach - offset, rows + offset] = band[rod, rows]
        result[rod] = solve_banded((reach, reach), stored, right[rod])
    return result


@dataclass
class Rates:
    """The result of the balance of forces and moments for one shape; see ``evaluate``."""

    tension: np.ndarray  # nodes
    axial: np.ndarray  # u0, half nodes
    transverse: np.ndarray  # u⊥, nodes, complex
    spin: np.ndarray  # ω⊥, half nodes, complex
    bishop_spin: np.ndarray  # ω0 of the Bishop frame, nodes, 0 at the midpoint
    roll: np.ndarray  # ω0 of the material, half nodes
    bending: np.ndarray  # dk/dt, nodes
    twist: np.ndarray  # dτ/dt, nodes
    activity: np.ndarray  # df/dt, nodes


def internal_force(bending, twist, p, h):
    """Λ⊥ = i b k' + c τ k at half nodes."""
    return 1j * p.bend * slope(bending, h) + p.twist * middle(twist) * middle(bending)


def transverse_velocity(bending, twist, tension, p, h, load):
    """u⊥ at nodes from (η + D⊥) u⊥ = Λ⊥' − i λ k + f_ext⊥."""
    pull = odd_slope(internal_force(bending, twist, p, h), h)
    return across(p, load, pull - 1j * tension * bending + load.transverse)


def solve_tension(shape, p, h, load):
    """λ from (∂s u + Ω×u)·e0 = 0, which is linear in λ: u0' + Im(k̄ u⊥) with and without it."""
    k = shape.bending
    loose = transverse_velocity(k, shape.twist, 0.0, p, h, load)
    right = -slope(axial_velocity(shape, np.zeros_like(shape.twist), p, h, load), h)
    right -= (k.conj() * loose).imag[:, 1:-1]
    ease = np.broadcast_to(1 / (1 + load.axial_drag), middle(shape.twist).shape) / h**2
    held = (k.conj() * across(p, Load(transverse_drag=load.transverse_drag), 1j * k)).imag[:, 1:-1]
    return pinned(solve_rows({-1: ease[:, :-1], 0: -ease[:, :-1] - ease[:, 1:] - held, 1: ease[:, 1:]}, right))


def spin_of(transverse, axial, bending, h):
    """ω⊥ = i u⊥' + u0 k at half nodes."""
    return 1j * slope(transverse, h) + axial * middle(bending)


def axial_velocity(shape, tension, p, h, load):
    """(1 + D0) u0 = λ' + (b/2)(|k|²)' + f + f_ext0 at half nodes."""
    push = p.bend / 2 * slope(np.abs(shape.bending) ** 2, h) + middle(shape.activity) + load.axial
    return (slope(tension, h) + push) / (1 + load.axial_drag)


def twist_from_bending(bending, spin):
    """Im(k̄ ω⊥) at half nodes: the rate of twist due to the motion of the bent rod."""
    return (middle(bending).conj() * spin).imag


def from_midpoint(density, h):
    """Integral of half-node values from the middle node to every node."""
    total = np.pad(np.cumsum(density, axis=1), ((0, 0), (1, 0))) * h
    return total - total[:, total.shape[1] // 2, None]


def evaluate(shape, p, h, load=NOTHING):
    """Tension, velocities and the time derivative of a shape."""
    k = shape.bending
    tension = solve_tension(shape, p, h, load)
    axial = axial_velocity(shape, tension, p, h, load)
    transverse = transverse_velocity(k, shape.twist, tension, p, h, load)
    spin = spin_of(transverse, axial, k, h)
    converted = twist_from_bending(k, spin)
    bishop_spin = -from_midpoint(converted, h)
    roll = (p.twist * slope(shape.twist, h) + p.moment * middle(shape.activity)) / p.rotational_drag
    f = shape.activity
    spread = p.diffusion * odd_slope(slope(f, h), h)
    return Rates(
        tension,
        axial,
        transverse,
        spin,
        bishop_spin,
        roll,
        bending=pinned(slope(spin, h)) - 1j * bishop_spin * k,
        twist=pinned(slope(roll, h) + middle(converted)),
        activity=((1 - f**2) * even_mean(axial) + spread) / p.relaxation,
    )


def linear_bending_rate(z, shape, rates, p, h, load):
    """∂k/∂t of an increment z [rod, node] of the bending, zero at the ends; λ, u0, τ and ω0 of the shape are kept."""
    pull = odd_slope(internal_force(z, shape.twist, p, h), h)
    transverse = across(p, load, pull - 1j * rates.tension * z)
    return pinned(slope(spin_of(transverse, rates.axial, z, h), h) - 1j * (rates.bishop_spin * z)[:, 1:-1])


def bending_increment(shape, rates, p, h, rate, right, load):
    """δk from (rate − J) δk = right [rod, inner node], with J assembled column by column; it is linear over reals."""
    rods, inner = right.shape
    matrix = np.zeros((rods, 2 * inner, 2 * inner))
    for column in range(2 * inner):
        unit = np.zeros((rods, inner + 2), complex)
        unit[:, column % inner + 1] = 1 if column < inner else 1j
        image = -linear_bending_rate(unit, shape, rates, p, h, load)[:, 1:-1]
        matrix[:, :, column] = np.concatenate([image.real, image.imag], axis=1)
        matrix[:, column, column] += rate
    found = np.linalg.solve(matrix, np.concatenate([right.real, right.imag], axis=1)[..., None])[..., 0]
    return pinned(found[:, :inner] + 1j * found[:, inner:])


def linear_twist_rate(z, bending, p, h, load):
    """∂τ/∂t of an increment z [rod, node] of the twist, zero at the ends: by roll, and by the motion across."""
    pull = odd_slope(p.twist * middle(z) * middle(bending), h)
    spin = spin_of(across(p, load, pull), 0.0, bending, h)
    return slope(p.twist * slope(z, h) / p.rotational_drag, h) + middle(twist_from_bending(bending, spin))


def twist_increment(bending, p, h, rate, right, load):
    """δτ from (rate − J) δτ = right [rod, inner node], with J assembled column by column."""
    rods, inner = right.shape
    matrix = np.zeros((rods, inner, inner))
    for column in range(inner):
        unit = np.zeros((rods, inner + 2))
        unit[:, column + 1] = 1
        matrix[:, :, column] = -linear_twist_rate(unit, bending, p, h, load)
        matrix[:, column, column] += rate
    return pinned(np.linalg.solve(matrix, right[..., None])[..., 0])


def lagrange(times, t):
    """Values and slopes at t of the Lagrange polynomials of these times."""
    values, slopes = [], []
    for own in times:
        others = [x for x in times if x != own]
        basis = np.poly1d(np.subtract(others, t), r=True) / np.prod(np.subtract(own, others))
        values.append(basis(0.0))
        slopes.append(basis.deriv()(0.0))
    return values, slopes


def combined(weights, shapes):
    """Σ w_j x_j."""
    fields = zip(*(shape.fields() for shape in shapes), strict=True)
    return Shape(*(sum(w * x for w, x in zip(weights, levels, strict=True)) for levels in fields))


def step(shapes, times, t, p, h, load=NOTHING):
    """One linearly implicit step to t from levels at these times, newest first; as many levels as the order.

    Returns the shape, u0 and u⊥ at its end.
    """
    values, _ = lagrange(times, t)
    _, slopes = lagrange([t, *times], t)
    rate = slopes[0]
    star = combined(values, shapes)
    past = combined(slopes[1:], shapes)  # dx/dt = rate x + past
    now = evaluate(star, p, h, load)

    right = now.bending - past.bending - rate * star.bending
    bending = star.bending + bending_increment(star, now, p, h, rate, right[:, 1:-1], load)

    ends = np.zeros_like(star.activity)
    ends[:, [0, -1]] = 1
    spread = p.diffusion / h**2
    flow = even_mean(now.axial)
    activity = solve_rows(
        {
            -1: -spread * (1 + ends),
            0: p.relaxation * rate + star.activity * flow + 2 * spread,
            1: -spread * (1 + ends),
        },
        -p.relaxation * past.activity + flow,
    )

    transverse = transverse_velocity(bending, star.twist, now.tension, p, h, load)
    converted = twist_from_bending(bending, spin_of(transverse, now.axial, bending, h))
    roll = (p.twist * slope(star.twist, h) + p.moment * middle(activity)) / p.rotational_drag
    right = slope(roll, h) + middle(converted) - past.twist[:, 1:-1] - rate * star.twist[:, 1:-1]
    twist = star.twist + twist_increment(bending, p, h, rate, right, load)
    return Shape(bending, twist, activity), now.axial, transverse


def energy(shape, p, h):
    """E = ½ ∫ b|k|² + c τ² ds."""
    return h / 2 * np.sum(p.bend * np.abs(shape.bending) ** 2 + p.twist * shape.twist**2, axis=1)


def energy_rate(shape, rates, p, h):
    """dE/dt along the rates."""
    bend = p.bend * (shape.bending.conj() * rates.bending).real
    return h * np.sum(bend + p.twist * shape.twist * rates.twist, axis=1)


def trapezoid(values, h):
    """Integral over a rod of values at nodes."""
    return h * (values.sum(axis=1) - (values[:, 0] + values[:, -1]) / 2)


def dissipation(rates, p, h):
    """∫ u0² + η|u⊥|² + ηr ω0² ds."""
    at_half = h * np.sum(rates.axial**2 + p.rotational_drag * rates.roll**2, axis=1)
    return at_half + trapezoid(p.drag_ratio * np.abs(rates.transverse) ** 2, h)


def power(shape, rates, p, h, load=NOTHING):
    """∫ f u0 + M f ω0 + f_ext·u ds: the power of the flagella and the external force."""
    pushed = ((middle(shape.activity) + load.axial) * rates.axial).sum(axis=1)
    turned = (p.moment * middle(shape.activity) * rates.roll).sum(axis=1)
    return h * (pushed + turned) + trapezoid((np.conj(load.transverse) * rates.transverse).real, h)
