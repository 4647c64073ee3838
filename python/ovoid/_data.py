# SPDX-License-Identifier: Apache-2.0
"""What is drawn: files, arrays and particles as the library's data sets."""
import json
import os

from . import _core, _settings
from ._errors import InvalidArgument, UnknownSetting


class Data:
    """A lattice, mesh or set of points with its arrays, as `read` and `particles` give it; or several that are steps of time, as `series`
    gives them, whose first is what the properties tell of.

    Its arrays share the memory of what it was made of; they are not to be changed while it is drawn.
    """

    def __init__(self, core, defaults=None, report=None, steps=None):
        self._core = core
        self._defaults = defaults or {}
        self._report = report
        self._steps = steps

    @property
    def kind(self):
        """str: "lattice", "mesh", "boxes", "particles" or "kernels"."""
        return self._core.kind

    @property
    def source(self):
        """str: the file, or what stands for one in messages."""
        return self._core.source

    @property
    def matrix(self):
        """list of list of float: of a lattice, the world from index positions (i, j, k), [3, 4]; world units."""
        return self._core.matrix

    @property
    def space(self):
        """str: the patient's coordinate system that the world is: "LPS", "RAS" or "none"."""
        return self._core.space

    @property
    def notes(self):
        """list of str: what the reader assumed or found odd."""
        return self._core.notes

    @property
    def report(self):
        """dict or None: of what `fit` and `simplify` make, what came of it."""
        return self._report

    @property
    def steps(self):
        """tuple of Data: the steps of a series; of anything else itself."""
        return (self,) if self._steps is None else tuple(self._steps)

    @property
    def times(self):
        """numpy.ndarray of float64 or None: of a series when its steps are, where that is known."""
        times = self._core.times
        if times is None:
            return None
        import numpy as np

        return np.array(times)

    @property
    def positions(self):
        """numpy.ndarray: of all but lattices, the places of nodes or points, (n, 3); world units."""
        return self._core.positions()

    @property
    def arrays(self):
        """dict of str to numpy.ndarray: all arrays, read only; those of lattices (z, y, x) or (z, y, x, component)."""
        found = {}
        for i, name in enumerate(self._core.array_names):
            values = self._core.array(i)
            if values is not None and self.kind == "lattice":
                dims = [max(n - 1, 1) for n in self._core.dims] if self._core.is_cell_data(i) else self._core.dims
                values = values.reshape(*reversed(dims), *values.shape[1:])
            found.setdefault(name, values)
        return found

    def numpy(self, array=None):
        """The values of one array, as `arrays` has them.

        Parameters
        ----------
        array : str, optional
            Its name. Without it the only one there is.

        Returns
        -------
        numpy.ndarray
            Read only; of lattices (z, y, x) or (z, y, x, component), of anything else (n,) or (n, components). Not copied.

        Raises
        ------
        InvalidArgument
            For a name that there is not, for none where there are several, and for values that stay in a file.

        Examples
        --------
        >>> import numpy, ovoid
        >>> ovoid.lattice(numpy.zeros((2, 3, 4))).numpy().shape
        (2, 3, 4)
        """
        arrays = self.arrays
        if array is None and len(arrays) == 1:
            (array,) = arrays
        if array not in arrays:
            has = ", ".join(repr(name) for name in arrays) or "no arrays"
            raise InvalidArgument(f"array = {array!r}: the data have {has}: expected one of them")
        if arrays[array] is None:
            raise InvalidArgument(f"array '{array}': its values stay in their file")
        return arrays[array]

    def __array__(self, dtype=None, copy=None):
        import numpy as np

        values = self.numpy()
        return np.array(values, dtype=dtype) if copy else np.asarray(values, dtype=dtype)

    def __repr__(self):
        size = " x ".join(str(n) for n in self._core.dims) if self.kind == "lattice" else f"{len(self.positions)} points"
        steps = "" if self._core.num_steps == 1 else f", {self._core.num_steps} steps"
        return f"<ovoid.Data {self.kind} '{self.source}', {size}: {', '.join(self._core.array_names) or 'no arrays'}{steps}>"


def is_path(data):
    """Whether it is a name of a file, or several."""
    if isinstance(data, (str, os.PathLike)):
        return True
    return isinstance(data, (list, tuple)) and bool(data) and all(isinstance(one, (str, os.PathLike)) for one in data)


def _kind_of(data):
    (one,) = data if isinstance(data, (list, tuple)) and len(data) == 1 else (data,)
    return type(one).__name__


def paths_of(data):
    """Names of files as text."""
    if not is_path(data):
        several = isinstance(data, (list, tuple)) and len(data) > 1
        raise InvalidArgument(f"path: is {'a list' if several else _kind_of(data)}, expected the name of a file, or a list of names")
    names = [data] if isinstance(data, (str, os.PathLike)) else data
    names = [os.fsdecode(name) for name in names]
    for name in names:
        if "\0" in name:
            raise InvalidArgument(f"path = {name!r}: holds a NUL, which no name of a file does")
    return names


def path_of(path):
    """One name of a file as text."""
    (name,) = paths_of([path])
    return name


# Where an array is, as `render` takes it.
PLACEMENT = ("spacing", "origin", "direction", "affine", "space")


def _check_placement(placement):
    for name in placement:
        if name not in PLACEMENT:
            raise UnknownSetting(f"{name}: unknown setting{_core.did_you_mean(name, PLACEMENT)}")


def _refuse_places(data):
    """A flat picture of three columns is never what is meant."""
    shape, dtype = getattr(data, "shape", ()), getattr(data, "dtype", None)
    if len(shape) == 2 and shape[1] == 3 and shape[0] > 3 and getattr(dtype, "kind", "") == "f":
        raise InvalidArgument(f"data: has the shape {tuple(shape)}, which places x, y, z have: expected ovoid.particles(array); of samples array[None]")


def data_of(data, spacing=None, origin=None, direction=None, affine=None, space=None, memory_limit=None, named=("values", ""), may_stay=True):
    """What is in memory as Data. The others: of arrays, as `render` takes them; `memory_limit`: bytes that one may take which is
    elsewhere, as in a file; `named`: name and unit of its values; `may_stay`: samples that memory does not hold, in a file."""
    is_placed = not (spacing is None and origin is None and direction is None and affine is None)
    from . import _arrays, _objects

    found = data if isinstance(data, Data) else _objects.data_of_object(data)
    if found is not None:
        if is_placed or space is not None:
            raise InvalidArgument("spacing, origin, direction, affine, space: are for arrays, these data say themselves where they are")
        return found
    name, unit = named
    if _arrays.is_xarray(data):
        from . import _series

        if _series.is_in_time(data):
            return _series.series(data, spacing=spacing, origin=origin, direction=direction, affine=affine, space=space)
        if is_placed:
            raise InvalidArgument("spacing, origin, direction, affine: are for arrays without coordinates of their own")
        matrix, name, unit = _arrays.xarray_place(data), str(data.name or name), str(data.attrs.get("units", ""))
        data = data.data
    else:
        matrix = _arrays.placement(spacing, origin, direction, affine)
    limit = _settings.words(_settings.canonical({"memory_limit": memory_limit}))
    from . import _large

    if may_stay and _large.stays_away(data, limit):
        core = _large.lattice_of(data, _arrays.dims_of(data.shape, "data"), matrix.tolist(), name, unit, limit)
        return Data(core if space is None else core.with_facts("", str(space), []))
    names = getattr(getattr(data, "dtype", None), "names", None)
    if not is_placed:
        _refuse_places(data)
    arrays = []
    for part, values in [(part, data[part]) for part in names] if names else [(name, data)]:
        values = _arrays.numbers_of(values, part if names else "data")
        dims = _arrays.dims_of(values.shape, "data")
        arrays.append((part, values, unit))
    core = _core.lattice("array", dims, matrix.tolist(), arrays)
    return Data(core if space is None else core.with_facts("", str(space), []))


def lattice(array, *, spacing=None, origin=None, direction=None, affine=None, space=None):
    """An array with its place in the world, as data for `render` and its settings `labels` and `over`.

    Parameters
    ----------
    array : array_like
        (z, y, x), (z, y, x, component) or (y, x), as `render` takes it. What is an array in memory is not copied, as a rule.
    spacing, origin, direction, affine, space
        As `render` takes them.

    Returns
    -------
    Data

    Raises
    ------
    InvalidArgument
        For what is no array of numbers of such a shape, and for a place that is none.

    Examples
    --------
    >>> import numpy, ovoid
    >>> liver = numpy.zeros((8, 8, 8), "u1")
    >>> liver[2:6, 2:6, 2:6] = 1
    >>> scan = numpy.random.default_rng(1).random((16, 16, 16))
    >>> picture = ovoid.render(scan, labels=ovoid.lattice(liver, spacing=(2, 2, 2)), size=(64, 48))
    """
    return data_of(array, spacing, origin, direction, affine, space)


def particles(xyz, values=None, h=None, mass=None):
    """Points with values as data for `render`.

    Parameters
    ----------
    xyz : array_like, (n, 3)
        Places x, y, z; world units. Floats in C order are not copied. Or a table with columns x, y, z (a DataFrame), of which h, mass
        and all other columns of numbers are taken; or data of yt's, of which mass and smoothing length are.
    values : array_like, (n,) or (n, components), or dict of str to array_like, optional
        What is drawn. Without it, the density of the particles is. Of tables and of yt's data: names of columns or fields.
    h : array_like, (n,), optional
        Smoothing lengths, world units: a particle reaches twice as far. Without it they come from each particle's neighbours.
    mass : array_like, (n,), optional
        Masses, for densities; without it each particle has the mass 1.

    Returns
    -------
    Data

    Raises
    ------
    InvalidArgument
        For shapes that do not fit, what holds no numbers, and columns or fields that there are not.

    Examples
    --------
    >>> import numpy, ovoid
    >>> cloud = ovoid.particles(numpy.random.default_rng(1).normal(size=(500, 3)))
    >>> ovoid.render(cloud, size=(64, 48)).numpy().shape
    (48, 64, 4)
    """
    from . import _arrays, _objects

    columns, notes = _objects.columns_of(xyz, values), []
    if columns is not None:
        xyz, values, own_h, own_mass, notes = columns
        h, mass = own_h if h is None else h, own_mass if mass is None else mass
    xyz = _arrays.numbers_of(xyz, "xyz")
    if xyz.ndim != 2 or xyz.shape[1:] != (3,) or not len(xyz):
        raise InvalidArgument(f"xyz: has the shape {xyz.shape}, expected (n, 3)")
    if xyz.dtype.kind != "f":
        xyz = xyz.astype("f8")
    named = dict(values) if isinstance(values, dict) else {} if values is None else {"values": values}
    for name, array in (("h", h), ("mass", mass)):
        if array is not None:
            named[name] = array
    arrays = []
    for name, array in named.items():
        unit = _arrays.unit_of(array)
        array = _arrays.numbers_of(array, name)
        if array.ndim not in (1, 2) or len(array) != len(xyz) or 0 in array.shape:
            raise InvalidArgument(f"{name}: has the shape {array.shape}, expected one or more for each of {len(xyz)} particles")
        arrays.append((name, array, unit))
    core = _core.particles("particles", xyz, arrays)
    return Data(core.with_facts("", "none", notes) if notes else core, {"quantity": "density"} if values is None else None)


def read(path, **settings):
    """Reads files of any format that the library knows.

    Parameters
    ----------
    path : str or path, or list of them
        A file or a folder of DICOM files; several are the slices or time steps of one data set.
    **settings
        What ``ovoid render`` takes of data: `step`, `time`, `block`, `dims`, `type`, `spacing` of raw files, ...

    Returns
    -------
    Data

    Raises
    ------
    NotFound
        Where there is no such file.
    FileFormat
        Where it is not what its header says.
    Unsupported
        For formats, or parts of them, that this build does not read.
    InvalidArgument
        For settings that do not suit the file.
    """
    core, _ = _core.read(paths_of(path), _settings.words(_settings.canonical(settings)), False, None)
    return Data(core)


def write(path, data, **placement):
    """Writes data to a file; the ending of its name says the format.

    Parameters
    ----------
    path : str or path
        ``.nrrd``, ``.nii.gz``, ``.npy``, ``.vtu``, ``.ply``, ...: what ``ovoid convert`` writes for this kind of data. Of a series
        ``.pvd``: times, and the names of files beside it that hold the steps.
    data : Data or array_like
        What `render` takes, but paths.
    **placement
        `spacing`, `origin`, `direction`, `affine`, `space` of an array.

    Raises
    ------
    Unsupported
        For an ending that names no format which holds such data.
    FileWrite
        Where the file cannot be written; nothing is left behind.
    InvalidArgument
        As `lattice`, of an array.
    """
    name = path_of(path)
    _check_placement(placement)
    found = data_of(data, **placement)
    if found._core.num_steps > 1 or name.endswith(".pvd"):
        from . import _series

        _series.write(name, found)
    else:
        found._core.write(name)


def info(data, **placement):
    """What is in data, and how it would be drawn: the members of ``ovoid info --json``.

    Parameters
    ----------
    data : Data, array_like, str or path
        What `render` takes.
    **placement
        `spacing`, `origin`, `direction`, `affine`, `space` of an array.

    Returns
    -------
    dict

    Raises
    ------
    Error
        As `read` of a path, as `lattice` of an array.
    """
    if not is_path(data):
        _check_placement(placement)
    found = read(data, **placement) if is_path(data) else data_of(data, **placement)
    return json.loads(found._core.info())
