"""A camera: photons become counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warp_rods.draw.microscope.settings import Microscope

__all__ = ["MOST", "counts"]

MOST = 65535
"""Largest count of 16 bits."""


def counts(expected: np.ndarray, settings: Microscope, stream: tuple[int, ...]) -> np.ndarray:
    """Counts [...] of a camera where so many photons are expected: offset + gain · (Poisson + read noise), rounded.

    Their variance is gain² · (photons + read_noise²) + 1/12. Those beyond 16 bits are saturated. stream: numbers that,
    with the seed, choose the noise: the same ones give the same counts.
    """
    noise = np.random.default_rng([settings.seed, *stream])
    seen = noise.poisson(expected + settings.background) + settings.read_noise * noise.standard_normal(expected.shape)
    return np.clip(np.rint(settings.offset + settings.gain * seen), 0, MOST).astype(np.uint16)
