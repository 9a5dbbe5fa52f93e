"""Archives of arrays (``.npz``) that are read only where every checksum is right."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np


def read_archive(path: Path) -> dict[str, np.ndarray]:
    """The arrays in a file; raises ValueError, which says what is wrong, for one that is damaged or no archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            if broken := archive.testzip():
                raise ValueError(f"the checksum of {broken} is wrong")
        with np.load(path) as stored:
            return dict(stored)
    except Exception as fault:  # damaged archives raise errors of many kinds
        raise ValueError(str(fault)) from None
