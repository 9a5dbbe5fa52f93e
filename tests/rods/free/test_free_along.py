"""Free rods with natural shapes, graded properties and held ends: the energy law of the equations discretised in s."""

import itertools

import numpy as np
import pytest

from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_node
from warp_rods.rods.tiles import Tiled

N, H = 65, 1 / 64
S = np.linspace(-0.5, 0.5, N)
KINDS = ("free", "hinged", "clamped")


TIMES = np.linspace(-0.5, 1.0, 7)
TABLE = {"times": TIMES, "points": np.stack([0.3 * np.sin(TIMES), -0.2 * TIMES, 0.4 * TIMES**2], axis=1)}


def rods_of_any_kind(ends, device, natural=True, motion=("0.3*t", "-0.2*t", "0.4*t")):
    """Two rough rods whose properties and natural shape change along them, with loads or turns at the ends."""
    rng = np.random.default_rng(3)
    strain = 3 * rng.normal(size=(2, N, 3)) * (0.2 + np.cos(3 * S)[:, None] ** 2)
    tables = []
    for kind in ends:
        table = {"kind": kind}
        if kind == "free":
            table |= {"thrust": [3e-2, -2e-2]}
        if kind != "free":
            table |= {"motion": motion}
        if kind == "clamped":
            table |= {"rotation": ["0.7*t", "-0.4*t", "0.2*t"]}
        table |= {"turning": [0.3, 1.0]} if kind == "clamped" else {"torque": [2e-3, -3e-3]}
        tables.append(table)
    shape = {"natural_bend": {"second": "2*sin(5*s)", "third": "1 + 3*cos(4*s)"}, "natural_twist": "2 - 3*s"}
    return FreeRods(
        2, N, bend="2e-3*(1 + s)", twist="1e-3*(1 - s**2)", moment=[5e-3, -2e-3], drag_ratio="1.8 + s",
        drag_along="1 + 0.5*s", rotational_drag="4e-3*(1 - s)", shape=strain, ends=tables, device=device,
        **(shape if natural else {}),
    )  # fmt: skip


def rate_of_energy(rods):
    """dE/dt [rod] from the rates of k, τ and ϑ, and E, both from docs/model.md §2.7."""
    found = rods.rates()
    k, tau, f = found["bending"], found["twist"], found["activity"]
    b, c = 2e-3 * (1 + S), 1e-3 * (1 - S**2)
    weight = H * np.where((np.arange(N) == 0) | (np.arange(N) == N - 1), 0.5, 1.0)
    tracked = rods._arrays.rods.tracked
    angle = rods._arrays.shown_midpoint.angle.numpy()[:, None] + from_node(tau, tracked)
    rest = (rods.natural_bend[..., 0] + 1j * rods.natural_bend[..., 1]) * np.exp(1j * angle)
    m, m0 = b * (k - rest), c * (tau - rods.natural_twist)
    energy = np.sum(weight * (np.abs(k - rest) ** 2 * b + (tau - rods.natural_twist) ** 2 * c) / 2, axis=1)

    def mid(x):
        return (x[:, 1:] + x[:, :-1]) / 2

    drag = mid((4e-3 * (1 - S))[None])
    roll = (np.diff(m0, axis=1) / H + mid((k.conj() * m).imag) + rods.moment[:, None] * mid(f)) / drag
    spin = (mid(k).conj() * found["angular_velocity"]).imag
    hinged = roll[:, 0] + H / 2 * spin[:, 0] if tracked == 0 else roll[:, -1] - H / 2 * spin[:, -1]
    held = rods._arrays.rods.first if tracked == 0 else rods._arrays.rods.last
    at = {"clamped": Tiled(held.angular_velocity, 2).numpy()[:, 0], "hinged": hinged}
    kind = rods.ends[0].kind if tracked == 0 else rods.ends[1].kind
    at_tracked = at[kind] if tracked in (0, N - 1) else (roll[:, tracked] + roll[:, tracked - 1]) / 2
    turn = at_tracked[:, None] + from_node(found["twist_rate"], tracked)
    rate = np.sum(
        weight * ((m.conj() * (found["bending_rate"] - 1j * turn * rest)).real + m0 * found["twist_rate"]), axis=1
    )
    return energy, rate


@pytest.mark.parametrize("ends", [*itertools.product(KINDS, KINDS), ("clamped", "hinged", "table")], ids="-".join)
def test_energy_law_of_rods_of_any_kind(device, ends, verified):
    """The last pair is moved along a table."""
    *ends, moved = ends if len(ends) == 3 else (*ends, "")
    rods = rods_of_any_kind(ends, device, **({"motion": TABLE} if moved else {}))
    rods.force = np.random.default_rng(5).normal(size=(2, N, 3))
    energy, rate = rate_of_energy(rods)
    np.testing.assert_allclose(rods.energy, energy, rtol=1e-12)
    expected = rods.power - rods.dissipation
    verified.below(
        "conservation",
        f"free rods, graded, natural shape, ends {ends[0]}, {ends[1]} {moved}: dE/dt = power − dissipation",
        measured=abs(rate - expected) / rods.dissipation, bound=1e-10, reference="chain rule in NumPy",
    )  # fmt: skip
