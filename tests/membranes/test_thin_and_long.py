"""Membranes much longer or flatter than wide: points uniform in area, from few evaluations of φ."""

import numpy as np
import pytest
from scipy.stats import kstest

from warp_rods.membranes import sampling, surfaces

UNLIKELY = 1e-3


def points_of(kind: str, values: dict, monkeypatch) -> tuple[np.ndarray, int]:
    """A thousand points, and the number of points at which φ was evaluated."""
    evaluated = 0
    sample = surfaces.Surface._sample

    def counted(self, kernel, points, results):
        nonlocal evaluated
        evaluated += np.size(points) // 3
        return sample(self, kernel, points, results)

    surface = surfaces.make(kind, values)
    monkeypatch.setattr(surfaces.Surface, "_sample", counted)
    return sampling.uniform_points(surface, 1000, np.random.default_rng(1)), evaluated


CASES = {
    "thin-box-cylinder": ("cylinder", {"radius": 476.0, "length": 6.0}, 2),
    "flat cylinder": ("cylinder", {"radius": 1e4, "length": 1.0}, 2),
    "thin torus": ("torus", {"major": 1e4, "minor": 0.4}, None),
    "long cylinder": ("cylinder", {"radius": 1.0, "length": 1e5}, 2),
    "long-bridge": ("bridge", {"neck": 0.4, "body": 1.0, "width": 1.0, "length": 3000.0}, 2),
}


@pytest.mark.parametrize("name", CASES)
def test_uniform_around_and_along(name, monkeypatch):
    kind, values, along = CASES[name]
    x, evaluated = points_of(kind, values, monkeypatch)
    assert evaluated < 15e6
    assert kstest(np.arctan2(x[:, 1], x[:, 0]) / (2 * np.pi) + 0.5, "uniform").pvalue > UNLIKELY
    if along is not None:
        assert kstest(x[:, along] / values["length"] + 0.5, "uniform").pvalue > UNLIKELY


def test_a_disc_is_covered_evenly(monkeypatch):
    """The faces of a flat ellipsoid: radius² is uniform."""
    x, _ = points_of("ellipsoid", {"radii": [1.0, 1.0, 1e-3]}, monkeypatch)
    assert kstest(np.sum(x[:, :2] ** 2, axis=-1), "uniform").pvalue > UNLIKELY
    assert abs((x[:, 2] > 0).mean() - 0.5) < 0.07
