"""Sine and cosine of fields against those of the C library."""

import numpy as np
import pytest
import warp as wp

from warp_rods.kernels.layout import Scalars1D
from warp_rods.kernels.surface.trigonometry import cosine, sine


@wp.kernel
def evaluate(x: Scalars1D, sines: Scalars1D, cosines: Scalars1D):
    i = wp.tid()
    sines[i] = sine(x[i])
    cosines[i] = cosine(x[i])


@pytest.mark.parametrize(("largest", "error"), [(3.0, 2.3e-16), (100.0, 2.3e-16), (1e6, 2.3e-16), (1e12, 1e-4)])
def test_sine_and_cosine(largest, error):
    rng = np.random.default_rng(2)
    x = np.concatenate([rng.uniform(-largest, largest, 20_000), np.arange(-20, 21) * np.pi / 2, [0.0]])
    found = [wp.zeros(len(x), dtype=wp.float64, device="cpu") for _ in range(2)]
    wp.launch(evaluate, len(x), inputs=[wp.array(x, dtype=wp.float64, device="cpu"), *found], device="cpu")
    for ours, exact in zip(found, (np.sin, np.cos), strict=True):
        assert np.abs(ours.numpy() - exact(x)).max() <= error
    assert found[0].numpy()[-1] == 0.0 and found[1].numpy()[-1] == 1.0
    near = np.abs(x) < 1e-3
    np.testing.assert_allclose(found[0].numpy()[near], np.sin(x[near]), rtol=3e-16)
