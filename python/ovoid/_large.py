# SPDX-License-Identifier: Apache-2.0
"""Arrays that memory does not hold: their samples stay in a file.

Memory maps stay in their own. What is read block by block (zarr, dask, h5py, anything with `shape`, `dtype` and `__getitem__`) is
read once, each of its chunks once, into a temporary file.
"""
import mmap
import os

import numpy as np

from . import _core
from ._errors import InvalidArgument, OutOfMemory

_SHOWN = {"u1", "i1", "u2", "i2", "f4"}
_BLOCK = 16 << 20  # bytes that are read at a time, of what has no chunks
_NAMES = {"u1": "uint8", "i1": "int8", "u2": "uint16", "i2": "int16", "f4": "float"}


def _type(dtype):
    """The type that stays in a file for another one: itself, or float32; None of what is no number."""
    key = f"{dtype.kind}{dtype.itemsize}"
    if dtype.kind == "b":
        return np.dtype("u1")
    if key in _SHOWN:
        return dtype.newbyteorder("=")
    return np.dtype("f4") if dtype.kind in "iuf" else None


def stays_away(data, words):
    """Whether an array is not to be read into memory: one (z, y, x) of numbers that lie elsewhere, for which there is too little.
    `words`: --memory-limit."""
    dtype, shape = getattr(data, "dtype", None), getattr(data, "shape", None)
    if not isinstance(dtype, np.dtype) or dtype.names or shape is None or len(shape) != 3 or 0 in shape:
        return False
    is_elsewhere = isinstance(data, np.memmap) or not isinstance(data, np.ndarray) and hasattr(data, "__getitem__")
    target = _type(dtype)
    return bool(is_elsewhere and target is not None and _core.would_stay_in_file(target.name, int(np.prod(shape, dtype="i8")), words))


def _place_in_map(data):
    """The file of a memory map and the byte where its first value lies; None where the file does not hold the values as they are."""
    if not isinstance(data, np.memmap) or not data.flags.c_contiguous or data.mode == "c" or data.filename is None:
        return None
    if f"{data.dtype.kind}{data.dtype.itemsize}" not in _SHOWN or not isinstance(data._mmap, mmap.mmap):
        return None
    start = np.frombuffer(data._mmap, "u1", 1).__array_interface__["data"][0]
    begin = data.offset - data.offset % mmap.ALLOCATIONGRANULARITY  # of the map in its file
    name = os.path.abspath(os.fspath(data.filename))
    if not isinstance(name, str) or any(sign in name for sign in "\n\r"):  # which a header cannot name
        return None
    return name, begin + data.__array_interface__["data"][0] - start


def _header(folder, target, shape, order, file, skip):
    """A header of NRRD for samples in another file."""
    path = os.path.join(folder, "array.nhdr")
    with open(path, "w", encoding="utf-8") as header:
        header.write(f"NRRD0004\ntype: {_NAMES[f'{target.kind}{target.itemsize}']}\ndimension: 3\n"
                     f"sizes: {shape[2]} {shape[1]} {shape[0]}\nendian: {order}\nencoding: raw\nbyte skip: {skip}\ndata file: {file}\n")
    return path


def _steps(data):
    """Where blocks begin along z, y, x: the chunks of the array, or layers of some size."""
    chunks = getattr(data, "chunks", None)
    shape = data.shape
    if chunks is not None and len(chunks) == 3:
        if all(isinstance(chunk, (int, np.integer)) and chunk > 0 for chunk in chunks):
            return [list(range(0, size, int(chunk))) + [size] for size, chunk in zip(shape, chunks)]
        if all(isinstance(chunk, tuple) and sum(chunk) == size for size, chunk in zip(shape, chunks)):  # dask's
            return [np.cumsum((0, *chunk)).tolist() for chunk in chunks]
    row = shape[2] * data.dtype.itemsize
    rows = max(1, min(shape[1], _BLOCK // row))
    layers = max(1, _BLOCK // (row * shape[1]))
    return [list(range(0, shape[0], layers)) + [shape[0]], list(range(0, shape[1], rows)) + [shape[1]], [0, shape[2]]]


def _blocks(data):
    """Slices of all blocks; small chunks along x are read together."""
    z_steps, y_steps, x_steps = _steps(data)
    for z0, z1 in zip(z_steps, z_steps[1:]):
        for y0, y1 in zip(y_steps, y_steps[1:]):
            row = (z1 - z0) * (y1 - y0) * data.dtype.itemsize
            x0 = 0
            for x1, further in zip(x_steps[1:], [*x_steps[2:], None]):
                if further is not None and row * (further - x0) <= _BLOCK:
                    continue
                yield slice(z0, z1), slice(y0, y1), slice(x0, x1)
                x0 = x1


def _copy(data, target, file):
    """Writes an array to a file, block by block."""
    total = int(np.prod(data.shape, dtype="i8"))
    disk = os.statvfs(os.path.dirname(file))
    free = disk.f_bavail * disk.f_frsize
    if total * target.itemsize > free:
        raise OutOfMemory(f"data: memory does not hold their {total} values, and {os.path.dirname(os.path.dirname(file))} has {free} bytes "
                          f"for {total * target.itemsize}: set TMPDIR to a folder with more")
    kept = np.memmap(file, target, "w+", shape=data.shape)
    for block in _blocks(data):
        values = np.asanyarray(data[block])
        if isinstance(values, np.ma.MaskedArray):
            if target.kind != "f" and np.ma.getmaskarray(values).any():
                raise OutOfMemory("data: memory does not hold them, and masked values of integers cannot stay in a file: give them as float32")
            values = values.astype(target).filled(np.nan) if target.kind == "f" else values.data
        expected = tuple(part.stop - part.start for part in block)
        if values.shape != expected:
            raise InvalidArgument(f"data: the block {block} has the shape {values.shape}, expected {expected}")
        kept[block] = values
        kept._mmap.madvise(mmap.MADV_DONTNEED)  # written, and no longer in memory
    kept.flush()


def lattice_of(data, dims, matrix, name, unit, words):
    """Samples that stay in a file as a lattice of the library."""
    import tempfile

    place = _place_in_map(data)
    with tempfile.TemporaryDirectory(prefix="ovoid-") as folder:
        if place:
            target, (file, skip) = data.dtype, place
            order = "big" if data.dtype.newbyteorder("=") != data.dtype else "little"
        else:
            target, file, skip, order = _type(data.dtype), os.path.join(folder, "array.raw"), 0, "little"
            _copy(data, target, file)
        header = _header(folder, target, data.shape, order, file, skip)
        words = [*words, "--data-folder", os.path.dirname(os.path.abspath(file))]
        read, _ = _core.read([header], words, True, None)
    return _core.lattice_of(read, "array", dims, matrix, name, unit)
