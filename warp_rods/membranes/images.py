"""Stacks of voxels from .npy, TIFF and NIfTI files, with their voxel sizes where the file has them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warp_rods.membranes.files import ARRAYS, FileError

__all__ = ["Header", "read_header", "read_stack"]

ORDERS = {".npy": "xyz", ".tif": "zyx", ".tiff": "zyx", ".nii": "xyz", ".nii.gz": "xyz"}
"""Ending of a file → the order of the axes of its array, where the scene gives none."""
METRES = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "Å": 1e-10}
NAMES = {"µm": "um", "μm": "um", "micron": "um", "microns": "um", "micrometer": "um", "meter": "m", "\\u00B5m": "um"}
"""Names of units in files → ours."""


class Header(NamedTuple):
    """What a file says of its array without reading it."""

    shape: tuple[int, ...]
    """In the order x, y, z."""
    spacing: tuple[float, float, float] | None
    """The size of a voxel along x, y, z, where the file has it."""
    unit: str
    """Its unit; empty where the file has none."""
    axes: str

    @property
    def metres(self) -> float | None:
        """One unit in metres."""
        return METRES.get(self.unit)


def ending(path: Path) -> str:
    """The ending of a file, in lower case; two parts for .nii.gz."""
    return ".nii.gz" if path.name.lower().endswith(".nii.gz") else path.suffix.lower()


def read_header(path: Path, axes: str | None = None) -> Header:
    """Shape and voxel size; raises FileError for a file that cannot be read as one stack."""
    return _read(path, axes)[0]


def read_stack(path: Path, axes: str | None = None) -> tuple[np.ndarray, Header]:
    """The array [x, y, z] of a file, and its header; raises FileError."""
    header, values = _read(path, axes, whole=True)
    if values.dtype.kind not in "biuf":
        raise FileError(f"has {values.dtype} values: must be floats (φ, negative inside), or a mask, or labels")
    return values, header


def _read(path: Path, axes: str | None, whole: bool = False) -> tuple[Header, Any]:
    kind = ending(path)
    axes = axes or ORDERS[kind]
    reader = _npy if kind in ARRAYS else _nifti if kind.startswith(".nii") else _tiff
    try:
        values, spacing, unit = reader(path, whole)
    except (FileError, OSError):
        raise
    except Exception as error:  # each reader raises its own
        raise FileError(f"cannot be read as an array: {error}") from None
    shape = tuple(values.shape)
    if len(shape) != 3:
        raise FileError(f"has shape {shape} of {values.dtype}: must have three axes, {axes[0]}, {axes[1]}, {axes[2]}")
    if 0 in shape:
        raise FileError(f"has shape {shape}: it is empty")
    if axes == "zyx":
        shape, values = shape[::-1], values.transpose() if whole else values
    return Header(shape, spacing, NAMES.get(unit, unit), axes), values


def _npy(path: Path, whole: bool) -> tuple[Any, None, str]:
    return np.load(path, mmap_mode="r", allow_pickle=False), None, ""


def _needed(package: str) -> Any:
    import importlib

    try:
        return importlib.import_module(package)
    except ImportError:
        raise FileError(f"is read with {package}, which is not installed: pip install -e '.[images]'") from None


def _nifti(path: Path, whole: bool) -> tuple[Any, tuple[float, float, float] | None, str]:
    """Axes are turned such that x, y, z increase to the right, the front and the top, whatever their order on disk."""
    nibabel = _needed("nibabel")
    image = nibabel.squeeze_image(nibabel.as_closest_canonical(nibabel.load(path)))
    x, y, z = (float(f"{size:.6g}") for size in image.header.get_zooms()[:3])  # stored in single precision
    unit = image.header.get_xyzt_units()[0]
    values = np.asanyarray(image.dataobj) if whole else image.dataobj
    return values, (x, y, z), "" if unit == "unknown" else unit


def _tiff(path: Path, whole: bool) -> tuple[Any, tuple[float, float, float] | None, str]:
    tifffile = _needed("tifffile")
    with tifffile.TiffFile(path) as file:
        series = file.series[0]
        if len(series.shape) != 3 or not series.axes.endswith("YX"):
            raise FileError(
                f"has axes {series.axes} of lengths {series.shape}: must be a stack of slices, ZYX; save one channel "
                f"at one time"
            )
        spacing, unit = _ome_spacing(file, tifffile) if file.is_ome else _imagej_spacing(file)
        return series.asarray() if whole else series, spacing, unit


def _ome_spacing(file: Any, tifffile: Any) -> tuple[tuple[float, float, float] | None, str]:
    image = tifffile.xml2dict(file.ome_metadata)["OME"]["Image"]
    pixels = (image[0] if isinstance(image, list) else image)["Pixels"]
    if any(f"PhysicalSize{axis}" not in pixels for axis in "XYZ"):
        return None, ""
    units = [str(pixels.get(f"PhysicalSize{axis}Unit", "µm")) for axis in "XYZ"]
    factors = [METRES.get(NAMES.get(unit, unit), 1.0) for unit in units]
    x, y, z = (float(pixels[f"PhysicalSize{a}"]) * f / factors[0] for a, f in zip("XYZ", factors, strict=True))
    return (x, y, z), units[0]


def _imagej_spacing(file: Any) -> tuple[tuple[float, float, float] | None, str]:
    about, tags = file.imagej_metadata or {}, file.pages[0].tags
    if "spacing" not in about or "XResolution" not in tags or "YResolution" not in tags:
        return None, ""
    x, y = (below / above for above, below in (tags[f"{axis}Resolution"].value for axis in "XY"))
    return (x, y, abs(float(about["spacing"]))), str(about.get("unit", ""))
