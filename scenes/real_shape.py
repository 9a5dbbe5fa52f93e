"""Writes real_shape.ply: a human red blood cell with the profile measured by Evans and Fung.

E. Evans and Y.-C. Fung, Improved measurements of the erythrocyte geometry, Microvasc. Res. 4 (1972) 335-347, at
300 mosm: thickness 2R √(1 − q) (c0 + c1 q + c2 q²)/2, q = ρ²/R², R = 3.91 µm. Lengths in micrometres.
"""

from pathlib import Path

import numpy as np
import trimesh

RADIUS = 3.91
THICKNESS = (0.207161, 2.002558, -1.122762)
RINGS, SECTORS = 64, 80


def red_blood_cell() -> trimesh.Trimesh:
    """The cell as a closed mesh, its axis along z."""
    angle = np.linspace(0, np.pi, RINGS + 1)  # ρ = R sin(angle): rings are dense near the rim
    rho = RADIUS * np.sin(angle)
    rho[[0, -1]] = 0.0
    q = np.sin(angle) ** 2
    height = RADIUS / 2 * np.cos(angle) * (THICKNESS[0] + THICKNESS[1] * q + THICKNESS[2] * q**2)
    mesh = trimesh.creation.revolve(np.stack([rho, height], axis=-1)[::-1], sections=SECTORS)
    mesh.merge_vertices()
    return mesh


if __name__ == "__main__":
    red_blood_cell().export(Path(__file__).with_suffix(".ply"))
