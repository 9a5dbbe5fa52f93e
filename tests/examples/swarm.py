"""Groups of a trajectory for tests of swarms."""

import numpy as np
import xarray as xr


def group(middle, direction=(1.0, 0.0, 0.0), period=None, step=1.0, length=1.0, nodes=5, **other) -> xr.Dataset:
    """Straight rods with these middles [frame, rod, 3] and directions; ``step``: time between frames."""
    middle = np.asarray(middle, float)
    along = np.broadcast_to(np.asarray(direction, float), middle.shape)
    position = middle[:, :, None] + length * np.linspace(-0.5, 0.5, nodes)[:, None] * along[:, :, None]
    data = {
        "position": (("frame", "rod", "node", "axis"), position),
        "length": ("rod", np.full(middle.shape[1], length)),
    }
    if period is not None:
        data["period"] = ("axis", np.array(period, float))
    data |= {name: (("frame", "rod"), values) for name, values in other.items()}
    times = {"units": "time"}
    return xr.Dataset(data, {"time": ("frame", step * np.arange(len(middle)), times)})


def isotropic(rng, *shape, flat=False) -> np.ndarray:
    vectors = rng.normal(size=(*shape, 3)) * [1, 1, not flat]
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def scattered(rng, frames, rods, box) -> np.ndarray:
    return rng.uniform(0, 1, (frames, rods, 3)) * np.asarray(box)


def bent(*bendings) -> xr.Dataset:
    """Swimmers with these bendings k(s) and no twist; positions by integration of the tangent."""
    fine = np.linspace(-0.5, 0.5, 4001)
    s, ds = fine[::50], fine[1] - fine[0]
    k = np.array([np.broadcast_to(bending(fine), fine.shape) + 0j for bending in bendings])
    tangent, one, other = (np.tile(axis, (len(k), 1)) for axis in np.eye(3))
    line = [np.zeros((len(k), 3))]
    for now in ((k[:, 1:] + k[:, :-1]) / 2).T[..., None]:
        turn = ds * (now.real * one + now.imag * other)
        line.append(line[-1] + ds * (tangent + turn / 2))
        tangent = (tangent + turn) / np.linalg.norm(tangent + turn, axis=1, keepdims=True)
        one = one - np.sum(one * tangent, axis=1, keepdims=True) * tangent
        one /= np.linalg.norm(one, axis=1, keepdims=True)
        other = np.cross(tangent, one)
    k = k[:, ::50]
    strain = np.stack([0 * k.real, k.imag, -k.real], axis=-1)
    nodes = ("frame", "rod", "node")
    data = {"position": ((*nodes, "axis"), np.stack(line, axis=1)[None, :, ::50])}
    data["strain"] = ((*nodes, "strain_component"), strain[None])
    data["activity"] = (nodes, np.zeros((1, *k.shape)))
    return xr.Dataset(data, {"time": ("frame", [0.0]), "s": ("node", s)})
