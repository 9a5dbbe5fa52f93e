"""Cosserat rods against closed forms: decay of small motions, rest shapes, deflection under loads."""

import numpy as np
import pytest
from examples.cosserat import BEND, RATES, SHEAR, STIFFNESS, STRETCH, TWIST, measured_rate, straight
from examples.free import slope
from reference import cosserat as twin

from warp_rods.rods.cosserat.rods import CosseratRods

FORMULAS = {"stretch": "S π²/ζ∥", "twist": "c π²/ζr", "bend": "b k⁴/(1 + …): k tan(k/2) + κ tanh(κ/2) = 0"}


@pytest.mark.parametrize("kind", RATES)
def test_small_motions_decay_at_the_exact_rate(device, kind, verified):
    sizes = np.array([16, 32, 64])
    found = [measured_rate(straight(device, kind, int(n) + 1), RATES[kind], 4e-3) for n in sizes]
    errors = np.abs(np.array(found) / RATES[kind] - 1)
    extrapolated = (4 * found[2] - found[1]) / 3
    verified.order(
        f"Cosserat rod: order in Δs of the slowest {kind}", measured=slope(sizes, errors), reference=FORMULAS[kind]
    )
    verified(
        "exact", f"Cosserat rod: decay of the slowest {kind}, extrapolated from N = 32, 64", measured=extrapolated,
        expected=RATES[kind], relative=2e-5, reference=FORMULAS[kind],
    )  # fmt: skip


def at_rest(device, nodes=33, **parameters) -> CosseratRods:
    return CosseratRods(1, nodes, **({"stiffness": STIFFNESS} | parameters), device=device)


@pytest.mark.parametrize("start", ["natural", "straight"])
def test_a_uniform_natural_strain_gives_the_exact_helix(device, start, verified):
    """To round-off with few nodes: the screw between nodes is the exact one. From straight, after relaxation."""
    natural = (4.0, 5.0, 1.0, 1.1, 0.1, -0.05)
    rods = at_rest(device, 9, natural=natural, shape={"kind": start})
    for dt in (1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0):
        rods.step(dt, 4)
    R, r = rods.rotation[0], rods.position[0]
    S = twin.lay_out(np.tile(natural, (8, 1)), 1 / 8)
    expected = (R[0] @ S[:, :3, 3].T).T + r[0]
    verified.below(
        "exact", f"Cosserat rod: the helix of uniform natural strain, {start} at the start, 9 nodes",
        measured=[abs(r - expected).max(), abs(R - R[0] @ S[:, :3, :3]).max()], bound=1e-12,
        reference="powers of one screw, exp(s ξ0)",
    )  # fmt: skip


LOADS = {
    "clamped, force across": (("clamped", "free"), [0, 1, 0], None, 1 / (8 * BEND) + 1 / (2 * SHEAR), -1, 1),
    "clamped, force along": (("clamped", "free"), [1, 0, 0], None, 1 / (2 * STRETCH), -1, 0),
    "free at the start, force across": (("free", "clamped"), [0, 0, 1], None, 1 / (8 * BEND) + 1 / (2 * SHEAR), 0, 2),
    "hinged": (("hinged", "hinged"), [0, 1, 0], None, 5 / (384 * BEND) + 1 / (8 * SHEAR), 16, 1),
    "clamped at both ends": (("clamped", "clamped"), [0, 0, 1], None, 1 / (384 * BEND) + 1 / (8 * SHEAR), 16, 2),
    "clamped, couple across": (("clamped", "free"), None, [0, 0, 1], 1 / (3 * BEND), -1, 1),
}
"""Ends, force and couple per length, the displacement per load of a node along an axis of a rod on the x axis."""


@pytest.mark.parametrize("case", LOADS)
def test_small_deflections_are_those_of_a_beam_that_shears(device, case, verified):
    ends, force, couple, expected, node, axis = LOADS[case]
    load, found = 1e-4, []
    for nodes in (17, 33):
        rods = at_rest(device, nodes, ends=ends)
        before = rods.position[0]
        rods.force, rods.couple = (np.array(v or [0, 0, 0]) * load for v in (force, couple))
        for dt in (0.01, 0.1, 1.0, 10.0, 1e3):
            rods.step(dt, 3)
        at = node if node in (0, -1) else nodes // 2
        found.append((rods.position[0] - before)[at, axis] / load)
    verified(
        "exact", f"Cosserat rod, {case}: deflection per load, extrapolated from N = 16, 32",
        measured=(4 * found[1] - found[0]) / 3, expected=expected, relative=1e-6, reference="Timoshenko's beam",
    )  # fmt: skip


def test_a_couple_along_twists_a_clamped_rod(device, verified):
    rods = at_rest(device, ends=("clamped", "free"))
    rods.couple = [0.3, 0.0, 0.0]
    for dt in (0.01, 0.1, 1.0, 10.0):
        rods.step(dt, 3)
    R = rods.rotation[0, -1]
    verified(
        "exact", "Cosserat rod: angle of the end under a couple per length", measured=np.arctan2(R[2, 1], R[1, 1]),
        expected=0.3 / (2 * TWIST), relative=1e-9, reference="l/2c",
    )  # fmt: skip


def test_a_rigid_motion_changes_no_energy(device, verified):
    """A rod turned and moved has the same energy, and moves along with it."""
    from scipy.spatial.transform import Rotation

    s = np.linspace(-0.5, 0.5, 33)[:, None]
    shape = np.array([0, 0, 0, 1, 0, 0]) + np.cos(np.pi * s) ** 2 * np.array([3, -2, 4, 0.1, 0.1, 0.1])
    Q, q = Rotation.from_rotvec([0.3, -1.1, 2.0]).as_matrix(), np.array([0.5, -2.0, 1.0])
    one, other = at_rest(device, shape=shape), at_rest(device, shape=shape, rotation=Q, position=q)
    energies = [abs(other.energy[0] / one.energy[0] - 1)]
    for rods in (one, other):
        rods.step(1e-4, 50)
    energies.append(abs(other.energy[0] / one.energy[0] - 1))
    verified.below(
        "symmetry", "Cosserat rod, turned and moved: energy, relative", measured=energies, bound=1e-11,
        reference="the rod itself",
    )  # fmt: skip
    verified.below(
        "symmetry", "Cosserat rod, turned and moved: places after 50 steps",
        measured=abs(other.position - (one.position @ Q.T + q)).max(), bound=1e-11, reference="the rod itself",
    )  # fmt: skip
