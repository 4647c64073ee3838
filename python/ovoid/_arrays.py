# SPDX-License-Identifier: Apache-2.0
"""Arrays of any kind as what the library takes: C order, the machine's byte order, its types; with NaN where values are masked."""
import numbers

import numpy as np

from ._errors import InvalidArgument

_TYPES = {"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"}


def _library_type(dtype, name):
    """The library's type that holds all values of another."""
    if dtype.kind == "b":
        return np.dtype("u1")
    if dtype.kind == "f" and dtype.itemsize == 2:
        return np.dtype("f4")
    if dtype.kind == "f" and dtype.itemsize > 8:
        return np.dtype("f8")
    if f"{dtype.kind}{dtype.itemsize}" in _TYPES:
        return dtype.newbyteorder("=")
    raise InvalidArgument(f"{name}: holds {dtype}, expected numbers: integers or floats")


def floats_for(dtype):
    """The float that holds all values of a type, NaN beside them."""
    return np.dtype("f4" if dtype.itemsize <= (4 if dtype.kind == "f" else 2) else "f8")


def unit_of(values):
    """What units say that come with values, as unyt's and pint's do."""
    unit = str(getattr(values, "units", ""))
    return "" if unit == "dimensionless" else unit


def in_unit(values, other):
    """Values in the unit of others, as plain numbers."""
    return np.asarray(values.to(other.units) if hasattr(values, "to") and hasattr(other, "units") else values)


# DLPack's numbers of what numpy can see into, and its names of others.
_HOSTS = (1, 3, 11, 13)
_DEVICES = {2: "CUDA", 4: "OpenCL", 7: "Vulkan", 8: "Metal", 10: "ROCm", 14: "oneAPI"}


def _on_host(data, name):
    """What has DLPack's methods as an array of numpy, without a copy."""
    kind, number = data.__dlpack_device__() if hasattr(data, "__dlpack_device__") else (1, 0)
    if int(kind) not in _HOSTS:
        device = f"{_DEVICES.get(int(kind), f'device {int(kind)}')}:{number}"
        raise InvalidArgument(f"{name}: lies in the memory of {device}; copy it to the host's first, as by .cpu() or .get()")
    if hasattr(data, "__array__"):
        return data
    try:
        return np.from_dlpack(data)
    except (BufferError, RuntimeError, TypeError, ValueError) as error:
        raise InvalidArgument(f"{name}: cannot be taken by DLPack: {error}") from None


def numbers_of(data, name="data"):
    """An array as the library takes it; the memory of `data` itself wherever that is so already.

    Masked values become NaN, of types that have none in the float that holds the others.
    """
    if hasattr(data, "__dlpack__") and not isinstance(data, np.ndarray):
        data = _on_host(data, name)
    if not hasattr(data, "dtype") and hasattr(data, "keys"):
        names = [repr(key) for key in data.keys()]
        raise InvalidArgument(f"{name}: is a {type(data).__name__} of {', '.join(names[:9]) or 'nothing'}, expected an array, such as one of these")
    if not hasattr(data, "dtype") or not hasattr(data, "shape") or (hasattr(data, "__array__") and not isinstance(data, np.ndarray)):
        try:
            data = np.asanyarray(data)
        except (RuntimeError, TypeError, ValueError) as error:
            raise InvalidArgument(f"{name}: {error}") from None
    elif not isinstance(data, np.ndarray):
        shape, data = tuple(data.shape), np.asanyarray(data[...])
        if data.shape != shape:
            raise InvalidArgument(f"{name}: has the shape {shape}, but what is read of it {data.shape}")
    target = _library_type(data.dtype, name)
    if isinstance(data, np.ma.MaskedArray):
        mask = np.ma.getmaskarray(data)
        if mask.any():
            with np.errstate(all="ignore"):  # what does not fit is infinite, and missing too
                filled = np.array(data.data, dtype=floats_for(target), order="C")
            filled[mask] = np.nan
            return filled
        data = data.data
    with np.errstate(all="ignore"):  # likewise
        return np.asarray(np.asarray(data), dtype=target, order="C")


def vector(value, name, expected):
    """Three finite numbers."""
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        numbers = np.empty(0)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise InvalidArgument(f"{name} = {value!r}: expected {expected}")
    return numbers


def number(value, name):
    """A finite number."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = np.nan
    if not np.isfinite(found):
        raise InvalidArgument(f"{name} = {value!r}: expected a finite number")
    return found


def _direction(value):
    try:
        matrix = np.array(value, dtype=float).reshape(3, 3)
    except (TypeError, ValueError, OverflowError):
        matrix = np.zeros((3, 3))
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-12:
        raise InvalidArgument(f"direction = {value!r}: expected 3 x 3 numbers, whose columns are the axes x, y, z, no two along a line")
    return matrix


def _affine(value):
    """The first three rows of a matrix (4, 4), world from (i, j, k, 1), or these alone."""
    try:
        matrix = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        matrix = np.empty(0)
    is_affine = matrix.shape == (3, 4) or (matrix.shape == (4, 4) and (matrix[3] == (0, 0, 0, 1)).all())
    if not is_affine or not np.isfinite(matrix).all() or not abs(np.linalg.det(matrix[:3, :3])) > 0:
        raise InvalidArgument(f"affine = {value!r}: expected 4 x 4 numbers, world from (i, j, k, 1): the columns are the steps along "
                              "x, y, z, no two along a line, and the first sample's place; the last row is 0, 0, 0, 1")
    return matrix[:3]


def _spacing(value):
    """Three numbers > 0, which may be one for all axes."""
    expected = "a number > 0, or three along x, y, z"
    is_one = isinstance(value, numbers.Real) and not isinstance(value, bool)
    spacing = vector([value] * 3 if is_one else value, "spacing", expected)
    if not (spacing > 0).all():
        raise InvalidArgument(f"spacing = {value if is_one else tuple(spacing.tolist())}: expected {expected}")
    return spacing


def placement(spacing, origin, direction, affine=None):
    """world_from_index by rows, [3, 4]: from VTK's three words, each (x, y, z), or from a matrix of all."""
    if affine is not None:
        if not (spacing is None and origin is None and direction is None):
            raise InvalidArgument("affine: says what spacing, origin and direction say; give one of them")
        return _affine(affine)
    spacing = np.ones(3) if spacing is None else _spacing(spacing)
    origin = np.zeros(3) if origin is None else vector(origin, "origin", "the place x, y, z of the first sample")
    matrix = np.eye(3) if direction is None else _direction(direction)
    return np.column_stack([matrix * spacing, origin])


# As the reader of NPY has them: vectors, colours, tensors. Any other last axis of four is one of samples.
_COMPONENTS = (1, 2, 3, 4, 6, 9)


def dims_of(shape, name):
    """Samples along x, y, z of the shape (y, x), (z, y, x) or (z, y, x, component)."""
    if 0 in shape:
        raise InvalidArgument(f"{name}: has the shape {tuple(shape)}, expected at least one value")
    if len(shape) == 2:
        return shape[1], shape[0], 1
    if len(shape) == 4 and shape[3] not in _COMPONENTS:
        raise InvalidArgument(
            f"{name}: has the shape {tuple(shape)}, whose last axis is not that of 1 to 4, 6 or 9 components: "
            "expected (z, y, x) of one time step or channel, such as array[0], all steps by ovoid.series(array), or channels last, by "
            "numpy.moveaxis(array, 0, -1)"
        )
    if len(shape) in (3, 4):
        return shape[2], shape[1], shape[0]
    raise InvalidArgument(f"{name}: has the shape {tuple(shape)}, expected (z, y, x), (z, y, x, component) or (y, x)")


def is_xarray(data):
    """Whether it has named axes with coordinates, as xarray.DataArray does."""
    return all(hasattr(data, name) for name in ("dims", "coords", "data", "attrs"))


def _evenly(coordinates, axis):
    """The first of some coordinates, and their distance."""
    places = np.asarray(coordinates)
    if places.dtype.kind not in "iuf" or places.ndim != 1:
        raise InvalidArgument(f"coordinate '{axis}': holds {places.dtype}, expected numbers along one axis")
    places = places.astype(float)
    if len(places) == 1:
        return places[0], 1.0
    step = (places[-1] - places[0]) / (len(places) - 1)
    even = places[0] + step * np.arange(len(places))
    if not step or not np.allclose(places, even, rtol=0, atol=1e-3 * abs(step)):
        raise InvalidArgument(f"coordinate '{axis}': is not evenly spaced; resample the data first, as by .interp()")
    return places[0], step


def xarray_place(data, first=0):
    """world_from_index of what xarray's coordinates say, of z, y, x from its axis `first` on; an axis without any has spacing 1 from 0.
    A coordinate that falls makes an axis that points the other way."""
    matrix = np.zeros((3, 4))
    matrix[:, :3] = np.eye(3)
    for column, axis in enumerate(reversed(data.dims[first:first + 3])):
        if axis in data.coords:
            matrix[column, 3], matrix[column, column] = _evenly(data.coords[axis].values, axis)
    return matrix
