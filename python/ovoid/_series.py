# SPDX-License-Identifier: Apache-2.0
"""Steps of time in memory as one thing to draw."""
import os

import numpy as np

from . import _arrays, _core
from ._data import Data, data_of, is_path, read
from ._errors import InvalidArgument

_NAMES = ("t", "time")


def _is_time_axis(name, coordinate):
    """Whether an axis is time, by its name or by what stands along it."""
    if str(name).lower() in _NAMES:
        return True
    places = np.asarray(coordinate)
    return places.dtype.kind in "mM" or (places.dtype.kind == "O" and places.size > 0 and all(hasattr(one, "year") for one in places.flat))


def is_in_time(data):
    """Whether an array of xarray is steps of time: of four axes or more, the first of which is time."""
    if len(data.dims) < 4:
        return False
    first = data.dims[0]
    return _is_time_axis(first, data.coords[first].values if first in data.coords else ())


def _seconds(times):
    """Times as numbers, and their unit where it is known: dates are seconds from the first, differences seconds."""
    found = np.asarray(times)
    if found.ndim == 1 and found.dtype.kind == "M":
        found = found - found[:1]
    elif found.ndim == 1 and found.dtype.kind == "O":
        try:
            found = np.array([getattr(one, "total_seconds", (one - found[0]).total_seconds if hasattr(one, "year") else None)() for one in found], float)
        except (TypeError, ValueError, AttributeError, OverflowError):
            raise InvalidArgument(f"times = {times!r}: expected a number or a date for each step") from None
        return found, "s"
    if found.ndim == 1 and found.dtype.kind == "m":
        return np.where(np.isnat(found), np.nan, found / np.timedelta64(1, "s")), "s"
    if found.ndim != 1 or found.dtype.kind not in "iuf":
        raise InvalidArgument(f"times = {times!r}: expected a number or a date for each step")
    return found.astype(float), ""


def _slices(array):
    """The parts of an array along its first axis, each in the memory of the whole."""
    if getattr(getattr(array, "dtype", None), "names", None) is None:
        array = _arrays.numbers_of(array, "steps")  # masked values make floats of all steps
    return [array[i] for i in range(array.shape[0])]


def _of_xarray(data, times, time_unit, space):
    """Steps along the first axis, whose coordinate tells their times."""
    axis = data.dims[0]
    if times is None and axis in data.coords:
        coordinate = data.coords[axis]
        values = np.asarray(coordinate.values)
        times, unit = _seconds(values)
        time_unit = time_unit or unit or str(getattr(coordinate, "attrs", {}).get("units", ""))
    matrix, name, unit = _arrays.xarray_place(data, first=1), str(data.name or "values"), str(data.attrs.get("units", ""))
    affine = np.vstack([matrix, [0, 0, 0, 1]])
    steps = [data_of(values, affine=affine, space=space, named=(name, unit), may_stay=False) for values in _slices(data.data)]
    return _made(steps, times, time_unit)


def _made(steps, times, time_unit):
    numbers, unit = ([], "") if times is None else _seconds(times)
    if times is not None and len(numbers) != len(steps):
        raise InvalidArgument(f"times: {len(numbers)} of {len(steps)} steps: expected one each")
    core = _core.series("series", [step._core for step in steps], list(numbers), str(time_unit or unit))
    return Data(core, steps[0]._defaults, steps=steps)


def series(steps, times=None, *, time_unit="", spacing=None, origin=None, direction=None, affine=None, space=None):
    """Steps of time in memory, as data for `render`, whose settings `step`, `time`, `motion_blur` and `hyperslice` choose of them.

    Parameters
    ----------
    steps : sequence of what `render` takes, or array_like
        Arrays, `particles`, `mesh`, `lattice`, objects of other packages, or names of files, which are read: one for each step, all of
        one kind, with the same arrays; lattices also of one size and place. Or an array whose first axis is time, (t, z, y, x) as a
        rule; of `xarray.DataArray` the coordinate of that axis tells the times. Memory of arrays is shared as by `render`, and all
        steps are in memory.
    times : array_like, (number of steps,), optional
        When the steps are: numbers that rise, in any unit; or dates, which become seconds from the first. Without it what the steps
        say themselves, as those that were read may do, else their numbers 0, 1, 2, ...
    time_unit : str, optional
        The unit of the times.
    spacing, origin, direction, affine, space
        Of all arrays, as `render` takes them.

    Returns
    -------
    Data
        Its arrays are those of the first step; `Data.steps` are all, and `Data.times` when they are.

    Raises
    ------
    InvalidArgument
        For no steps, steps that are not alike, or times that are not one for each and rising.

    Examples
    --------
    >>> import numpy, ovoid
    >>> z, y, x = numpy.mgrid[-1:1:16j, -1:1:16j, -1:1:16j]
    >>> steps = [numpy.exp(-9 * ((x - at) ** 2 + y**2 + z**2)) for at in (-0.5, 0, 0.5)]
    >>> blob = ovoid.series(steps, times=[0, 0.2, 0.4], time_unit="s")
    >>> picture = ovoid.render(blob, time=0.3, motion_blur=0.2, size=(64, 48))
    >>> film = list(ovoid.Scene(blob, size=(64, 48), clim=(0, 1)).view().frames(time=numpy.linspace(0, 0.4, 5)))
    """
    placement = {"spacing": spacing, "origin": origin, "direction": direction, "affine": affine}
    if _arrays.is_xarray(steps):
        if any(value is not None for value in placement.values()):
            raise InvalidArgument("spacing, origin, direction, affine: are for arrays without coordinates of their own")
        return _of_xarray(steps, times, time_unit, space)
    placement["space"] = space
    is_array = not isinstance(steps, (list, tuple)) and len(getattr(steps, "shape", ())) >= 3 and hasattr(steps, "dtype")
    if is_array:
        several = _slices(steps)
    elif isinstance(steps, (str, bytes, dict, os.PathLike, Data)) or not hasattr(steps, "__iter__") or hasattr(steps, "dtype") or hasattr(steps, "columns"):
        raise InvalidArgument(f"steps: is one {type(steps).__name__}, expected a list of steps, or an array (t, z, y, x)")
    else:
        several = list(steps)
    if not several:
        raise InvalidArgument("steps: is empty, expected at least one")
    return _made([_step(one, number, placement) for number, one in enumerate(several)], times, time_unit)


def _step(one, number, placement):
    """A step as data, placed if it is an array."""
    if is_path(one):
        return read(one)
    try:
        found = data_of(one, **placement, may_stay=False)
    except InvalidArgument as error:
        raise InvalidArgument(f"steps[{number}]: {error}") from None
    if len(found.steps) > 1:
        raise InvalidArgument(f"steps[{number}]: is a series of {len(found.steps)} steps itself, expected one")
    return found


# Of each kind the ending of VTK's files that hold it.
_ENDINGS = {"lattice": ".vti", "mesh": ".vtu", "particles": ".vtu"}


def _as_vtk(data, path):
    """What VTK's files hold of a step; points are cells there."""
    core = data._core
    if core.kind == "lattice" and not _is_orthogonal(core):
        raise InvalidArgument(f"'{path}': holds steps as .vti, which have no lattices whose axes are askew; expected another file for each step")
    if core.kind != "particles":
        return core
    count = len(data.positions)
    arrays = [(name, core.array(i), core.array_unit(i), False, *core.value_scale(i)) for i, name in enumerate(core.array_names)]
    cells = np.ones(count, "u1"), np.arange(count + 1), np.arange(count, dtype="u4")
    return _core.mesh(core.source, data.positions, *cells, (0, 0, 0), arrays)


def _is_orthogonal(core):
    axes = np.array(core.matrix)[:, :3]
    lengths = np.linalg.norm(axes, axis=0)
    return core.is_cartesian and np.allclose(axes.T @ axes, np.diag(lengths**2), rtol=0, atol=1e-9 * lengths.max() ** 2)


def write(path, data):
    """Writes a series as ParaView's collection: a file that names times, and beside it a file for each step."""
    if not path.endswith(".pvd"):
        raise InvalidArgument(f"'{path}': holds one step, the data are a series of {len(data.steps)}: expected .pvd, or one of data.steps")
    ending = _ENDINGS.get(data.kind)
    if ending is None:
        raise InvalidArgument(f"'{path}': holds lattices, meshes and particles, the data are {data.kind}")
    if len({step._core.space for step in data.steps}) > 1:
        raise InvalidArgument(f"'{path}': holds steps in one patient space, the data's differ")
    stem = path[: -len(".pvd")]
    times = range(len(data.steps)) if data.times is None else data.times.tolist()
    digits = len(str(len(data.steps) - 1))
    lines = []
    for number, (step, time) in enumerate(zip(data.steps, times)):
        file = f"{stem}-{number:0{digits}d}{ending}"
        _as_vtk(step, path).write(file)
        lines.append(f'    <DataSet timestep="{time!r}" file="{_escaped(os.path.basename(file))}"/>\n')
    # Words of Ovoid's, which other programs pass over.
    words = {"TimeUnit": data._core.time_unit, "Space": data.steps[0]._core.space}
    said = "".join(f' {name}="{_escaped(value)}"' for name, value in words.items() if value not in ("", "none"))
    partial = path + ".part"
    with open(partial, "w", encoding="utf-8", errors="surrogateescape") as file:
        file.writelines(['<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n', f"  <Collection{said}>\n", *lines, "  </Collection>\n</VTKFile>\n"])
    os.replace(partial, path)


def _escaped(text):
    for sign, name in (("&", "&amp;"), ("<", "&lt;"), ('"', "&quot;")):
        text = text.replace(sign, name)
    return text
