"""Cosserat rods: second order in space and time, and the limit in which they neither stretch nor shear."""

from itertools import pairwise

import numpy as np
import pytest
from examples.cosserat import in_space
from examples.free import slope

from warp_rods.rods.cosserat.rods import CosseratRods
from warp_rods.rods.free.rods import FreeRods

READINGS = ("position", "rotation", "strain", "stretch", "internal_moment", "internal_force")
END = 0.01


def loaded(device, nodes, ends):
    rods, s = in_space(device, nodes, ends=ends), np.linspace(-0.5, 0.5, nodes)
    rods.force = np.stack([3 * s, 5 + 0 * s, 2 * np.cos(3 * s)], axis=-1)[None]
    rods.couple = np.stack([0 * s + 0.5, s, 0 * s], axis=-1)[None]
    return rods


def orders(sizes, runs):
    """Orders of the readings, from differences of neighbouring runs."""
    return [slope(sizes[:-1], [abs(b[name] - a[name]).max() for a, b in pairwise(runs)]) for name in READINGS]


def test_second_order_in_time(device, verified):
    steps, runs = np.array([40, 80, 160, 320]), []
    for count in steps:
        rods = loaded(device, 17, ("clamped", "free"))
        rods.step(END / count, int(count))
        runs.append({name: rods.reading(name) for name in READINGS})
    verified.order(
        f"Cosserat rod under loads: order in Δt of {', '.join(READINGS)}", measured=orders(steps, runs),
        reference="successive differences, Δt = 2.5e-4 to 3.1e-5",
    )  # fmt: skip


@pytest.mark.parametrize("ends", [("free", "free"), ("clamped", "hinged")])
def test_second_order_in_space(device, ends, verified):
    sizes, runs = np.array([16, 32, 64, 128]), []
    for size in sizes:
        rods = loaded(device, int(size) + 1, ends)
        rods.step(END / 50, 50)
        runs.append({name: rods.reading(name)[:, :: size // 16] for name in READINGS})
    verified.order(
        f"Cosserat rod under loads, ends {ends}: order in Δs of {', '.join(READINGS)}", measured=orders(sizes, runs),
        reference="successive differences, N = 16 to 128",
    )  # fmt: skip


# --- the stiff limit --------------------------------------------------------------------------------------------------

SOFT, TWIST = 1e-2, 5e-3
OVER_BENDING = np.array([1e3, 1e4, 1e5, 1e6])


def bent(nodes):
    """Strains of a twisted rod in space [node, 3]."""
    s = np.linspace(-0.5, 0.5, nodes)
    return (np.cos(np.pi * s) ** 2)[:, None] * np.stack([3 * np.sin(2 * s), 4 + 0 * s, 3 * np.sin(5 * s)], axis=-1)


def stiff(device, nodes, over_bending=OVER_BENDING) -> CosseratRods:
    count = len(over_bending)
    stiffness = np.repeat([[TWIST, SOFT, SOFT, SOFT, SOFT, SOFT]], count, axis=0)
    stiffness[:, 3:] *= over_bending[:, None]
    shape = np.concatenate([bent(nodes), np.tile([1.0, 0.0, 0.0], (nodes, 1))], axis=1)
    return CosseratRods(count, nodes, stiffness=stiffness, shape=shape, device=device)


def extrapolated(run):
    """Places at 33 nodes from 64 and 128 cells, to fourth order in Δs."""
    return (4 * run(129)[:, ::4] - run(65)[:, ::2]) / 3


def test_stiff_rods_move_as_kirchhoff_rods(device, verified):
    """The difference falls as 1/S; equal steps that resolve bending carry S = 1e6 b as well as S = 1e3 b."""
    end, steps = 0.05, 50

    def kirchhoff(nodes):
        rods = FreeRods(1, nodes, bend=SOFT, twist=TWIST, flagella=None, shape=bent(nodes), device=device)
        rods.step(end / steps, steps)
        return rods.position

    def cosserat(nodes):
        rods = stiff(device, nodes)
        rods.step(end / steps, steps)
        return rods.position

    apart = np.abs(extrapolated(cosserat) - extrapolated(kirchhoff)).max(axis=(1, 2))
    verified(
        "orders", "Cosserat rods towards Kirchhoff rods: exponent in the stretching and shearing stiffness",
        measured=-slope(OVER_BENDING[:3], apart[:3]), expected=-1.0, within=0.1,
        reference="S/b = 1e3 to 1e5, both extrapolated from N = 64, 128",
    )  # fmt: skip
    verified.below(
        "independent", "Cosserat rod of S = 1e6 b: places beside those of the Kirchhoff rod", measured=apart[3],
        bound=1e-5, reference="free passive rods, the same steps",
    )  # fmt: skip


def test_long_steps_of_stiff_rods_are_stable(device):
    """Steps of a fifth of the time of bending, 1e8 of that of stretching between nodes: the energy only falls."""
    rods, energies = stiff(device, 65, np.array([1e2, 1e6, 1e8])), []
    for _ in range(60):
        rods.step(rods.natural_time / 5)
        energies.append(rods.energy)
    assert not rods.status.any() and (np.diff(energies, axis=0) < 1e-12).all()
    assert (energies[-1] < 1e-6 * np.array(energies[0])).all()
