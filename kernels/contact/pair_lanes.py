"""The sums of ``steric.py`` for CPUs: adjacent nodes of a rod fill the lanes of vector instructions.

Native code, because Warp's own does not fill them. Each lane is a node, and adds its pairs in the order of the list,
one after the other. A neighbour beyond the reach of a lane adds a zero there: bits depend on positions only, not on
when the lists were built or what else they contain. 6 ns a neighbour of a node; one by one they take 35.
"""

import warp as wp

from warp_rods.kernels.contact.neighbour_list import BLOCK, Lists, Points
from warp_rods.kernels.contact.steric import PairSums, Yukawa
from warp_rods.kernels.layout import Integers1D, Integers2D, Matrices1D, Scalars1D, Vectors1D, real

wp.set_module_options({"enable_backward": False})

_SUM = """
    constexpr int LANES = BLOCK_SIZE;
    typedef double V __attribute__((ext_vector_type(LANES)));
    typedef decltype(V() < V()) M;
    V x, y, z, along, close;
    for (int l = 0; l < LANES; ++l) {
        const int i = first + (l < size ? l : size - 1);
        x[l] = positions.data[i][0];
        y[l] = positions.data[i][1];
        z[l] = positions.data[i][2];
        along[l] = arc_length.data[i];
        close[l] = excluded.data[i];
    }
    V fx = 0, fy = 0, fz = 0, energy = 0, Kxx = 0, Kxy = 0, Kxz = 0, Kyy = 0, Kyz = 0, Kzz = 0;
    const int own = rod.data[first];
    const double inverse_range_square = inverse_range * inverse_range;
    const bool periodic = inverse_period[0] + inverse_period[1] + inverse_period[2] > 0;
    const auto separation = [&](const V& here, int j, int axis) -> V {
        const V d = here - positions.data[j][axis];
        return periodic ? d - period[axis] * __builtin_elementwise_rint(d * inverse_period[axis]) : d;
    };
    constexpr int BATCH = 128;
    int batch[BATCH];
    for (int start = 0; start < count; start += BATCH) {
        const int* list = &wp::index(neighbour, block, start);
        const int listed = count - start < BATCH ? count - start : BATCH;
        // Keep what is within reach of a lane.
        int kept = 0;
        for (int n = 0; n < listed; ++n) {
            const V dx = separation(x, list[n], 0), dy = separation(y, list[n], 1), dz = separation(z, list[n], 2);
            batch[kept] = list[n];
            kept += __builtin_reduce_or(dx * dx + dy * dy + dz * dz < cutoff_square * (1.0 + 1e-12)) != 0;
        }
        for (int n = 0; n < kept; ++n) {
            #pragma clang fp contract(fast)
            const int j = batch[n];
            const V dx = separation(x, j, 0), dy = separation(y, j, 1), dz = separation(z, j, 2);
            const V square = dx * dx + dy * dy + dz * dz;
            M within = square < cutoff_square;
            if (rod.data[j] == own)
                within &= __builtin_elementwise_abs(along - arc_length.data[j]) >= close;
            const V w = (V)((M)(V(weights.data[j])) & within);
            const V rho_square = square + core_square, rho = __builtin_elementwise_sqrt(rho_square);
            // One division for 1/ρ² and 1/r², which may be 0/0
            const V some = square + 1e-200;
            const V both = 1.0 / (rho_square * some), inverse_square = both * some, inverse_rho = rho * inverse_square;
            // e^(−ρ/a) = 2^k e^u with |u| ≤ ln 2 / 2, e^u by its series to 2e-16; k is the end of k + 2^52 + 2^51.
            const V t = __builtin_elementwise_max(-rho * inverse_range, V(-708.0));
            const V shifted = t * 1.4426950408889634 + 6755399441055744.0, k = shifted - 6755399441055744.0;
            const V u = (t - k * 0.693147180369123816490) - k * 1.90821492927058770002e-10;
            const V u2 = u * u, u4 = u2 * u2, u8 = u4 * u4;
            const V low = (1.0 + u) + u2 * (0.5 + u * 0.16666666666666666);
            const V middle = (4.1666666666666664e-2 + u * 8.333333333333333e-3)
                + u2 * (1.3888888888888889e-3 + u * 1.984126984126984e-4);
            const V high = (2.48015873015873e-5 + u * 2.755731922398589e-6)
                + u2 * (2.755731922398589e-7 + u * 2.505210838544172e-8);
            const V e = (low + u4 * middle) + u8 * high;
            const V power = (V)(((M)shifted + 1023) << 52);
            // G, −G', P = −G'/ρ, and the part of −∂f/∂d along d, as in steric.py
            const V G = (strength * e) * (power * inverse_rho), F = (inverse_rho + inverse_range) * G;
            const V P = (F - F_cutoff) * inverse_rho;
            const V G2 = inverse_range_square * G + (inverse_rho + inverse_rho) * F;
            const V stiff = (G2 + P) * inverse_square - P * (both * rho_square);
            const V K = w * __builtin_elementwise_max(stiff, V(0.0)), wP = w * P;
            fx += dx * wP;
            fy += dy * wP;
            fz += dz * wP;
            energy += w * (G - G_cutoff + F_cutoff * (rho - rho_cutoff));
            const V Kx = K * dx, Ky = K * dy;
            Kxx += Kx * dx;
            Kxy += Kx * dy;
            Kxz += Kx * dz;
            Kyy += Ky * dy;
            Kyz += Ky * dz;
            Kzz += K * dz * dz;
        }
    }
    for (int l = 0; l < size; ++l) {
        const int i = first + l;
        force.data[i] = wp::vec3d(fx[l], fy[l], fz[l]);
        energies.data[i] = 0.5 * energy[l];
        stiffness.data[i] =
            wp::mat33d(Kxx[l], Kxy[l], Kxz[l], Kxy[l], Kyy[l], Kyz[l], Kxz[l], Kyz[l], Kzz[l]);
    }
""".replace("BLOCK_SIZE", str(BLOCK))


@wp.func_native(_SUM)
def sum_pairs_of(
    block: int,
    first: int,
    size: int,
    count: int,
    neighbour: Integers2D,
    positions: Vectors1D,
    weights: Scalars1D,
    arc_length: Scalars1D,
    excluded: Scalars1D,
    rod: Integers1D,
    period: wp.vec3d,
    inverse_period: wp.vec3d,
    strength: real,
    inverse_range: real,
    core_square: real,
    cutoff_square: real,
    rho_cutoff: real,
    G_cutoff: real,
    F_cutoff: real,
    force: Vectors1D,
    energies: Scalars1D,
    stiffness: Matrices1D,
): ...


@wp.func
def inverse(length: real) -> real:
    """1/x, 0 for 0."""
    if length > real(0.0):
        return real(1.0) / length
    return real(0.0)


@wp.kernel
def sum_pairs(points: Points, lists: Lists, yukawa: Yukawa, first: int, sums: PairSums):
    """Force, energy and stiffness per length at every point of the blocks from ``first`` on."""
    block = first + wp.tid()
    p = points.period
    sum_pairs_of(
        block,
        lists.first[block],
        lists.size[block],
        lists.count[block],
        lists.neighbour,
        points.position,
        points.weight,
        points.arc_length,
        points.excluded,
        points.rod,
        p,
        wp.vec3d(inverse(p[0]), inverse(p[1]), inverse(p[2])),
        yukawa.strength,
        yukawa.inverse_range,
        yukawa.core_square,
        yukawa.cutoff_square,
        yukawa.rho_cutoff,
        yukawa.G_cutoff,
        yukawa.F_cutoff,
        sums.force,
        sums.energy,
        sums.stiffness,
    )
