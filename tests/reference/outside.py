"""What acts from outside, in NumPy: force and couple of a flow on free rods, linear theory of straining flow."""

import numpy as np


def flow_on_rods(velocity, spin, rotation, drag_along, drag_across, rotational_drag, tracked):
    """Force per length in space [rod, node, 3] and couple about the tangent [rod, node] of a flow at the nodes.

    velocity, spin [rod, node, 3]: u∞ and ½∇×u∞; u∞ counts relative to that at the tracked node.
    """
    w = velocity - velocity[:, tracked : tracked + 1]
    tangent = rotation[..., 0]
    along = np.sum(w * tangent, axis=-1, keepdims=True) * tangent
    return drag_along * along + drag_across * (w - along), rotational_drag * np.sum(spin * tangent, axis=-1)


def curl(velocity, x, step=1e-5):
    """∇×u of a function of points [..., 3], by central differences."""
    slopes = [(velocity(x + step * e) - velocity(x - step * e)) / (2 * step) for e in np.eye(3)]
    return np.stack([slopes[j][..., k] - slopes[k][..., j] for j, k in ((1, 2), (2, 0), (0, 1))], axis=-1)


def straining_rates(bend: float, ratio: float = 2.0, modes: int = 30) -> np.ndarray:
    """Growth rates of small deflections h of a free rod along the compression of (x, −y, 0), largest first.

    h_t = h + s h' + ((s² − 1/4) h''/2 − b h'''')/η, h'' = h''' = 0 at the ends; by Chebyshev collocation. Two,
    2 and 1, are turn and shift.
    """
    from numpy.polynomial import chebyshev
    from scipy.linalg import eig

    x = np.cos(np.pi * np.arange(modes + 1) / modes)
    s, basis = x / 2, np.eye(modes + 1)

    def derivative(order):
        return np.array([chebyshev.chebval(x, chebyshev.chebder(row, order)) * 2.0**order for row in basis]).T

    h, first, second, third, fourth = (derivative(order) for order in range(5))
    rates = h + s[:, None] * first + (((s**2 - 0.25) / 2)[:, None] * second - bend * fourth) / ratio
    weight = h.copy()
    for row, condition in ((0, second[0]), (1, third[0]), (modes, second[-1]), (modes - 1, third[-1])):
        rates[row], weight[row] = condition, 0.0
    found = eig(rates, weight)[0]
    found = found[np.isfinite(found) & (np.abs(found) < 1e6)].real
    return np.sort(found)[::-1]
