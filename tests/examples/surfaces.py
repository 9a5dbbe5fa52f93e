"""An example of every surface of the table: values of its parameters, and φ with these values."""

import sympy as sp
from reference.surface import X, Y, Z

RHO = sp.sqrt(X**2 + Y**2)
R2 = X**2 + Y**2 + Z**2

SURFACES = {
    "plane": ({"size": 4.0}, Z),
    "sphere": ({"radius": 1.3}, (R2 - 1.3**2) / 2.6),
    "ellipsoid": ({"radii": [1.0, 1.5, 0.7]}, ((X / 1.0) ** 2 + (Y / 1.5) ** 2 + (Z / 0.7) ** 2 - 1) / 2),
    "cylinder": ({"radius": 0.6, "length": 3.0}, (X**2 + Y**2 - 0.6**2) / 1.2),
    "torus": ({"major": 1.1, "minor": 0.4}, ((RHO - 1.1) ** 2 + Z**2 - 0.4**2) / 0.8),
    "cassini": ({"a": 1.0, "b": 1.1}, (RHO**2 + Z**2 + 1) ** 2 - 4 * Z**2 - sp.Float(1.1) ** 4),
    "bridge": (
        {"neck": 0.4, "body": 1.0, "width": 0.8, "length": 5.0},
        (RHO**2 - (0.4 + 0.6 * (1 - sp.exp(-(Z**2) / 0.64))) ** 2) / 2,
    ),
    "undulated": (
        {"radius": 1.0, "amplitude": 0.16, "wavenumber": 5.0},
        R2 - 1 + 0.16 * (sp.cos(5 * X) + sp.cos(5 * Y) + sp.cos(5 * Z)),
    ),
}
"""Kind: values, and φ with these values as documented for the scene and the field. A new kind gets a row here."""

INSIDE = {"plane": (0, 0, -1), "torus": (1.1, 0, 0)}
"""A point inside, where it is not the origin."""
