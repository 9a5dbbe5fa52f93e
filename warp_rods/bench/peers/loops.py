"""Kernels as plain loops compiled by Numba."""

from __future__ import annotations

import numpy as np

from warp_rods.bench.peers.optional import compiled


@compiled
def pentadiagonal(rows, right, first, second, solution):
    """Solve each rod's system; ``rows`` [5, rod, node]: from the lowest diagonal to the highest, as ours."""
    nodes = right.shape[1]
    for rod in range(right.shape[0]):
        c1 = c2 = e1 = e2 = y1 = y2 = 0.0
        for i in range(nodes):
            b = rows[0, rod, i] if i > 1 else 0.0
            a = (rows[1, rod, i] if i > 0 else 0.0) - b * c2
            scale = 1.0 / (rows[2, rod, i] - b * e2 - a * c1)
            y = (right[rod, i] - b * y2 - a * y1) * scale
            c2, e2, y2 = c1, e1, y1
            c1, e1, y1 = (rows[3, rod, i] - a * e2) * scale, rows[4, rod, i] * scale, y
            first[i], second[i], solution[rod, i] = c1, e1, y
        y1 = y2 = 0.0
        for i in range(nodes - 1, -1, -1):
            y = solution[rod, i] - first[i] * y1 - second[i] * y2
            y1, y2 = y, y1
            solution[rod, i] = y


@compiled
def tridiagonal(rows, right, first, _second, solution):
    """The same for three diagonals."""
    nodes = right.shape[1]
    for rod in range(right.shape[0]):
        c = y = 0.0
        for i in range(nodes):
            a = rows[0, rod, i] if i > 0 else 0.0
            scale = 1.0 / (rows[1, rod, i] - a * c)
            c, y = rows[2, rod, i] * scale, (right[rod, i] - a * y) * scale
            first[i], solution[rod, i] = c, y
        for i in range(nodes - 2, -1, -1):
            y = solution[rod, i] - first[i] * y
            solution[rod, i] = y


@compiled
def frames(strain, spacing, rotation, position):
    """Frames [rod, node] from the one of node 0 by exponentials of the mean strains, in closed form (B.14), (D.77)."""
    for rod in range(strain.shape[0]):
        for i in range(strain.shape[1] - 1):
            x = spacing * (strain[rod, i, 0] + strain[rod, i + 1, 0]) / 2
            y = spacing * (strain[rod, i, 1] + strain[rod, i + 1, 1]) / 2
            z = spacing * (strain[rod, i, 2] + strain[rod, i + 1, 2]) / 2
            t = x * x + y * y + z * z
            angle = np.sqrt(t)
            if t > 1e-12:
                a, b = np.sin(angle) / angle, (1 - np.cos(angle)) / t
                c = (1 - a) / t
            else:
                a, b, c = 1.0, 0.5, 1.0 / 6
            turn = (
                (1 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y),
                (b * x * y + a * z, 1 - b * (x * x + z * z), b * y * z - a * x),
                (b * x * z - a * y, b * y * z + a * x, 1 - b * (x * x + y * y)),
            )
            step = (1 - c * (y * y + z * z), c * x * y + b * z, c * x * z - b * y)
            for row in range(3):
                for column in range(3):
                    total = 0.0
                    for k in range(3):
                        total += rotation[rod, i, row, k] * turn[k][column]
                    rotation[rod, i + 1, row, column] = total
                total = position[rod, i, row]
                for k in range(3):
                    total += spacing * rotation[rod, i, row, k] * step[k]
                position[rod, i + 1, row] = total


@compiled
def pair_forces(position, pairs, strength, reach, core, force):
    """Add the forces −∇G of G(ρ) = g0 e^(−ρ/a)/4πρ, ρ² = r² + ε², to both nodes of each pair (5.39)."""
    for p in range(len(pairs)):
        i, j = pairs[p]
        x = position[i, 0] - position[j, 0]
        y = position[i, 1] - position[j, 1]
        z = position[i, 2] - position[j, 2]
        rho = np.sqrt(x * x + y * y + z * z + core * core)
        push = strength / (4 * np.pi) * np.exp(-rho / reach) / rho * (1 / rho + 1 / reach) / rho
        force[i, 0] += push * x
        force[i, 1] += push * y
        force[i, 2] += push * z
        force[j, 0] -= push * x
        force[j, 1] -= push * y
        force[j, 2] -= push * z
