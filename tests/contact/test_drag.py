"""Contact as drag: stable for every stiffness and ratio of steps, and no burden to rods that move along together."""

import numpy as np
import pytest
import warp as wp
from examples.contact_steps import take_steps
from examples.free import slope
from reference import free as twin
from reference.contact_drag import ContactFormula

from warp_rods.kernels.contact_drag import Alternating, drag_in_plane, principal, share_foretold
from warp_rods.kernels.lanes import Lanes, Lanes1D, Vector
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.tiles import Tiled, tiled

wp.set_module_options({"enable_backward": False})


def growth_in_a_step(kappa: float, felt: float, ratio: float) -> float:
    """|z| of the fastest growing places, in units of a step, for ζ = 1 and a mode of stiffness ``felt`` ≤ κ.

    ζ dr/dt = −felt r* − a D (r − r**), in steps each ``ratio`` times as long as the one before, the last of length 1.
    """
    t = 1.0
    times = list(t - np.cumsum([1.0, 1 / ratio, 1 / ratio**2]))
    f = ContactFormula(times, t)
    share = f.share(kappa, 1.0)
    s = f.rate * f.drag(kappa, 1.0, share)
    foretold = np.array([*twin.lagrange(times[:2], t)[0], 0.0])
    slope = np.array([*twin.lagrange([t, *times[:2]], t)[1], 0.0])
    lag = np.array([1.0, *np.negative(twin.lagrange(times[1:], times[0])[0])])
    held = np.append(1.0, -foretold - share * f.ratio * lag)
    return float(np.abs(np.roots(slope + felt * np.append(0.0, foretold) + s * held)).max())


@pytest.mark.parametrize("kappa", [0.5, 1.3, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 30.0, 1e3])
def test_every_mode_of_a_stiff_contact_is_stable(kappa, verified):
    """κΔt/ζ from soft to stiff; explicit contact is stable below 4/3. Steps of equal length, growing, and shrinking."""
    for share in (1e-3, 0.1, 0.25, 0.5, 0.75, 1.0):
        for ratio in (0.8, 1.0, 1.1, 1.2):
            assert growth_in_a_step(kappa, share * kappa, ratio) < max(ratio, 1.0)
    damped = max(growth_in_a_step(kappa, share * kappa, 1.0) for share in (0.5, 0.75, 1.0))
    verified.below(
        "constraint", f"contact as drag at κΔt/ζ = {kappa:g}: growth of a place in a step", measured=damped, bound=0.9,
        reference="roots of the characteristic polynomial, for ½κ to κ",
    )  # fmt: skip


@wp.kernel
def evaluate(K: wp.array(dtype=Vector), own: Lanes, terms: Alternating, drag: wp.array(dtype=Vector), share: Lanes1D):
    tile = wp.tid()
    kappa = principal(K[tile])
    share[tile] = share_foretold(kappa[0] + kappa[1], own, terms)
    drag[tile] = drag_in_plane(K[tile], own, share[tile], terms)


def test_the_drag_has_the_principal_directions_of_the_stiffness(verified):
    """Soft, stiff, isotropic and without a stiffness in one direction, in steps of unequal length."""
    rng = np.random.default_rng(2)
    A = rng.normal(size=(40, 2, 2)) * 10.0 ** rng.uniform(-1, 1.5, (40, 1, 1))
    K = A @ np.swapaxes(A, 1, 2)
    K[:4] = np.eye(2), 30 * np.eye(2), np.diag([20.0, 0.0]), np.zeros((2, 2))
    f = ContactFormula([0.0, -0.7, -1.9], 1.1)
    terms = Alternating()
    terms.foretold, terms.slope, terms.rate = Lanes(f.foretold), Lanes(-f.slope), Lanes(f.rate)
    terms.ratio, terms.lag = Lanes(f.ratio), Lanes(f.ratio * f.lag)
    given = tiled(np.stack([K[:, 0, 0], K[:, 0, 1], K[:, 1, 1]], axis=-1), Vector, "cpu")
    drag, shares = tiled(np.zeros((len(K), 3)), Vector, "cpu"), tiled(np.zeros(len(K)), Lanes, "cpu")
    wp.launch(evaluate, dim=len(given), inputs=[given, Lanes(2.0), terms, drag, shares], device="cpu")
    found = np.column_stack([Tiled(drag, len(K)).numpy(), Tiled(shares, len(K)).numpy()])
    share = f.share(2 * np.linalg.eigvalsh(K)[:, -1], 2.0)
    D = f.drag_of_matrix(K, 2.0, share)
    assert (share < 1).any() and (share == 1).any() and (D == 0).all(axis=(1, 2)).any()
    verified(
        "independent", "drag of contact: components and θ", measured=found,
        expected=np.stack([D[:, 0, 0], D[:, 0, 1], D[:, 1, 1], share], axis=-1), within=1e-12,
        reference="NumPy, by eigenvectors",
    )  # fmt: skip


def swimmer() -> FreeRods:
    return FreeRods(1, 33, bend=5e-3, twist=1e-3, flagella=None, shape={"kind": "straight"}, device="cpu")


def filament() -> BoundRods:
    return BoundRods(surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], nodes=17, drag=(1.0, 2.0, 0.1))


@pytest.mark.parametrize("make", [swimmer, filament])
def test_rods_that_move_along_together_hardly_feel_a_contact_of_moderate_stiffness(make, verified):
    """Neighbours that move along leave no force, only the stiffness. D grows as 1/Δt where κΔt is given."""

    def force(t, r):
        return np.array([1.0, 0.8, 0.0]) * np.sin(6 * t) + 0 * r

    def place(count: int, in_a_step: float) -> np.ndarray:
        rods, dt = make(), 0.3 / count
        take_steps(rods, dt, count, force, lambda r: in_a_step / (2 * dt) * np.eye(3))
        return rods.position

    counts = np.array([20, 40, 80, 160])
    alone = [place(count, 0.0) for count in counts]
    np.testing.assert_array_equal(place(20, 0.6), alone[0])
    apart = {
        in_a_step: [np.abs(place(count, in_a_step) - x).max() for count, x in zip(counts, alone, strict=True)]
        for in_a_step in (2.5, 20.0)
    }
    assert np.all(apart[2.5] < np.divide(apart[20.0], 20))
    verified.order(
        f"{make.__name__} among neighbours that move along: order in Δt", measured=slope(counts, apart[2.5]),
        reference="the same force without contact, κΔt/ζ = 2.5",
    )  # fmt: skip
