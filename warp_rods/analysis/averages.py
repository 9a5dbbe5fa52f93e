"""Averages of values that may be numbers or words, and may be missing at some places."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from warp_rods.analysis.registry import FAILED

__all__ = ["MISSING", "commonest", "mean_or_commonest"]

MISSING = ("", FAILED)
"""Words where nothing was measured, as NaN is such a number."""


def mean_or_commonest(values: np.ndarray) -> np.ndarray:
    """The mean of numbers [..., k] over k, or the commonest word, of those that were measured; NaN or "" of none."""
    if values.dtype.kind in "UO":
        flat = [commonest(row) for row in values.reshape(-1, values.shape[-1])]
        return np.array(flat, dtype=object).reshape(values.shape[:-1])
    measured = np.isfinite(values)
    count = measured.sum(axis=-1)
    total = np.where(measured, values, 0.0).sum(axis=-1)
    return np.divide(total, count, out=np.full(count.shape, np.nan), where=count > 0)


def commonest(words: Iterable[str]) -> str:
    """The word that occurs most often, of those as often the first in the alphabet; "" where nothing was measured."""
    names, counts = np.unique([str(word) for word in words if word not in MISSING], return_counts=True)
    return str(names[counts.argmax()]) if len(names) else ""
