"""A store as version 0.1.0 wrote it: no checksums, many files, the number of complete frames in an array."""

import numpy as np
import zarr

from warp_rods.rods.variables import ARC, TIME
from warp_rods.simulation.trajectory import STORE

GROWTH = 64


def write_earlier(path, groups, attributes, frames, labels: bool) -> None:
    """A store in the folder ``path`` with ``frames``: one dict {group: {variable: values}} each, "time" included.

    labels: whether dimensions have labels; without them strains have the dimension ``axis`` of vectors.
    """
    root = zarr.create_group(path / STORE, attributes={"warp_rods_version": "0.1.0", **attributes})
    count = root.create_array("_complete_frames", shape=(), dtype="int64", dimension_names=())
    for name, spec in groups.items():
        group = root.create_group(name, attributes={"coordinates": "time s"})
        for dim, words in spec.labels().items() if labels else ():
            array = group.create_array(dim, shape=(len(words),), dtype="str", compressors=None, dimension_names=[dim])
            array[...] = np.array(words)
        for label, (variable, values) in {"s": (ARC, np.linspace(-0.5, 0.5, spec.nodes)), **spec.static}.items():
            _array(group, label, variable, spec.shape(variable), spec.shape(variable), labels)[...] = values
        for label, variable in {**spec.variables, "time": TIME}.items():
            shape = spec.shape(variable)
            size = int(np.prod(shape)) * np.dtype(variable.dtype).itemsize
            chunk = next(n for n in (64, 32, 16, 8, 4, 2, 1) if n * size <= 8192 or n == 1)
            array = _array(group, label, variable, (0, *shape), (chunk, *shape), labels)
            array.resize((-(-len(frames) // GROWTH) * GROWTH, *shape))
            for number, frame in enumerate(frames):
                array[number] = frame[name][label]
    count[...] = len(frames)


def _array(group, name, variable, shape, chunks, labels):
    dims = variable.dims if labels else ["axis" if dim == "strain_component" else dim for dim in variable.dims]
    return group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        compressors=None,
        dtype=variable.dtype,
        fill_value=np.nan if variable.dtype.startswith("float") else 0,
        dimension_names=dims,
        attributes=variable.attributes,
    )
