# SPDX-License-Identifier: Apache-2.0
"""What the program's other commands do: fewer kernels, another lattice, values at places."""
import json
import logging
import os
import tempfile
import typing

import numpy as np

from . import _arrays, _core, _settings
from ._data import PLACEMENT, Data, data_of, is_path, path_of, paths_of
from ._errors import InvalidArgument
from ._progress import bar
from ._scene import Scene

_log = logging.getLogger("ovoid")


def _log_notes(notes):
    for note in notes:
        _log.info("%s", note)


def _source(data, settings, command):
    """Data in memory, or None with names of files; and the settings of a command, with what the data have by default."""
    if is_path(data):
        given = [name for name in PLACEMENT[1:] if settings.get(name) is not None]
        if given:
            raise InvalidArgument(f"{given[0]}: is for arrays, files say themselves where they are")
        return None, paths_of(data), settings
    placement = {name: settings[name] for name in PLACEMENT if name in settings}
    found = data_of(data, **placement, memory_limit=settings.get("memory_limit"))
    known = {} if "array" in settings else {name: value for name, value in found._defaults.items() if name in _settings.table(command)}
    return found._core, [], {**known, **{name: value for name, value in settings.items() if name not in PLACEMENT}}


def _written(command, endings, data, path, progress, settings):
    """Data that a command writes, read again, with its report; to a temporary file without a path."""
    core, inputs, settings = _source(data, settings, command)
    for name in ("output", "report"):
        if name in settings:
            raise InvalidArgument(f"{name}: is no setting here; the path is the second argument, and the report the result's")
    words = _settings.words_for(command, settings)
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, command + endings(data, core)) if path is None else path_of(path)
        with bar(progress, command) as on_progress:
            report, notes = getattr(_core, command)(core, inputs, [*words, "--output", output], on_progress)
        _log_notes(notes)
        read, _ = _core.read([output], [], False, None)
    return Data(read.named(command) if path is None else read, report=json.loads(report))


def fit(data, path=None, *, progress=False, **settings):
    """Fewer kernels for the field of a scan, a mesh or particles, with a stated error.

    Parameters
    ----------
    data : Data, array_like, str or path
        What `render` takes.
    path : str or path, optional
        Where the kernels are kept: ``.ply``, of a lattice ``.h5``. Without it they are in memory alone; of a lattice as the samples
        that the file would be read as.
    progress : bool
        Shows a bar.
    **settings
        One goal: `psnr`, `tolerance` (``"1%"`` is a share of the range), `kernels`, `bytes` or `smooth=True`; what else
        ``ovoid fit`` takes: ``ovoid.settings("fit")``; `spacing`, `origin`, ... of an array, as `render` takes them.

    Returns
    -------
    Data
        With `Data.report`: kernels, bytes, PSNR, the greatest error, ...

    Raises
    ------
    InvalidArgument
        For no goal, or several.
    Error
        As `render`, of the data; `FileWrite` where the path cannot be written.

    Examples
    --------
    >>> import numpy, ovoid
    >>> z, y, x = numpy.mgrid[-1:1:24j, -1:1:24j, -1:1:24j]
    >>> fitted = ovoid.fit(numpy.exp(-3 * (x**2 + y**2 + z**2)).astype("f4"), psnr=40)
    >>> fitted.report["kernels"] < 24**3 / 10 and fitted.report["psnr_db"] >= 40
    True
    """

    def ending(data, core):
        if core is None:
            core, _ = _core.read(paths_of(data), [], True, None)
        return ".h5" if core.kind == "lattice" else ".ply"

    return _written("fit", ending, data, path, progress, settings)


def simplify(data, path=None, *, progress=False, **settings):
    """Boxes and runs of a lattice's samples that one primitive stands for, with a bound on every sample's error.

    Parameters
    ----------
    data, path, progress
        As of `fit`; the file is ``.h5``.
    **settings
        `tolerance` (``"1%"`` without it), `primitive`, ...: ``ovoid.settings("simplify")``; `spacing`, `origin`, ... of an array.

    Returns
    -------
    Data
        The samples as the file is read, with `Data.report`: primitives, bytes, PSNR, the greatest error.

    Raises
    ------
    InvalidArgument
        For data that are no lattice.
    Error
        As `render`, of the data; `FileWrite` where the path cannot be written.
    """
    return _written("simplify", lambda *_: ".h5", data, path, progress, settings)


def resample(data, size=None, **settings):
    """A field as a grid, on another lattice, or as the kernels that are drawn.

    Parameters
    ----------
    data : Data, array_like, str or path
        What `render` takes.
    size : int or (x, y, z), optional
        Samples of a grid over the bounds; one number: of cubes, so many along the longest side.
    **settings
        Instead of `size`: `lattice` ("cc" or "bcc", with `lattice_spacing`), or `kernels=True` of meshes and particles; and
        `kernel`, `array`, ...: ``ovoid.settings("convert")``; `spacing`, `origin`, ... of an array.

    Returns
    -------
    Data
        NaN where the field is not defined.

    Raises
    ------
    InvalidArgument
        Where nothing is asked for.
    Error
        As `render`, of the data; `OutOfMemory` where memory does not hold the samples.

    Examples
    --------
    >>> import numpy, ovoid
    >>> cloud = ovoid.particles(numpy.random.default_rng(1).normal(size=(500, 3)))
    >>> list(ovoid.resample(cloud, 16, quantity="density").arrays.values())[0].ndim
    3
    """
    if "output" in settings:
        raise InvalidArgument("output: is no setting here; ovoid.write keeps the result")
    core, inputs, settings = _source(data, settings, "convert")
    if size is not None:
        settings["size"] = size
    if not {"size", "lattice", "kernels"} & set(settings):
        raise InvalidArgument("resample: nothing asked for; expected size=, lattice= or kernels=True")
    made, notes = _core.convert(core, inputs, _settings.words_for("convert", settings))
    _log_notes(notes)
    return Data(made)


class Samples(typing.NamedTuple):
    """A field at places.

    Attributes
    ----------
    value : numpy.ndarray of float64, (...)
        NaN where the field is not defined.
    gradient : numpy.ndarray of float64, (..., 3)
        In values per world unit.
    weight : numpy.ndarray of float64, (...)
        The sum of the kernels, about 1 inside; of a lattice over that of an endless one.
    is_defined : numpy.ndarray of bool, (...)
    """

    value: np.ndarray
    gradient: np.ndarray
    weight: np.ndarray
    is_defined: np.ndarray


def samples_of(scene, points, asked):
    """A scene's field at places (..., 3)."""
    places = _arrays.numbers_of(points, "points")
    if places.shape[-1:] != (3,):
        raise InvalidArgument(f"points: has the shape {places.shape}, expected (..., 3)")
    shape = places.shape[:-1]
    if not places.size:
        return Samples(np.empty(shape), np.empty((*shape, 3)), np.empty(shape), np.empty(shape, bool))
    flat = places.reshape(-1, 3).astype("f8", copy=False)
    if not np.isfinite(flat).all():
        raise InvalidArgument("points: hold NaN or infinite coordinates")
    found, notes = scene.sample(*asked, _core.particles("points", flat, []), None)
    _log_notes(notes)
    arrays = Data(found).arrays
    gradient = np.stack([arrays["gx"], arrays["gy"], arrays["gz"]], axis=-1)
    return Samples(arrays["value"].reshape(shape), gradient.reshape(*shape, 3), arrays["weight"].reshape(shape),
                   arrays["defined"].reshape(shape).astype(bool))


def sample(data, points, **settings):
    """The field, and its gradient, at places.

    Parameters
    ----------
    data : Data, array_like, str or path
        What `render` takes.
    points : array_like, (..., 3)
        Places x, y, z; world units.
    **settings
        `spacing`, `origin`, ... of an array; what chooses array and kernels, as `render` takes it.

    Returns
    -------
    Samples

    Raises
    ------
    InvalidArgument
        For places that are not finite, or not of three numbers.
    Error
        As `render`, of the data.

    Examples
    --------
    >>> import numpy, ovoid
    >>> ramp = numpy.broadcast_to(numpy.arange(16.0), (16, 16, 16))
    >>> found = ovoid.sample(ramp, [(7.5, 8, 8), (99, 0, 0)])
    >>> found.value.round(3), (found.gradient[0].round(3) + 0).tolist()
    (array([7.5, nan]), [1.0, 0.0, 0.0])
    """
    return Scene(data, **settings).sample(points)


class Slice:
    """Values on a plane.

    Attributes
    ----------
    values : numpy.ndarray of float32, (height, width)
        NaN where the field is not defined; row 0 is at `origin`.
    origin : numpy.ndarray, (3,)
        The place of ``values[0, 0]``; world units.
    u, v : numpy.ndarray, (3,)
        From a value to the next in its row, and in its column; world units.
    extent : tuple of float
        Left, right, bottom, top, along u and v: what matplotlib's ``imshow(values, origin="lower", extent=...)`` takes.
    """

    def __init__(self, values, origin, u, v):
        self.values, self.origin, self.u, self.v = values, origin, u, v
        height, width = values.shape
        du, dv = np.linalg.norm(u), np.linalg.norm(v)
        left, bottom = origin @ u / du - du / 2, origin @ v / dv - dv / 2
        self.extent = (left, left + width * du, bottom, bottom + height * dv)

    def __array__(self, dtype=None, copy=None):
        return np.array(self.values, dtype=dtype) if copy else np.asarray(self.values, dtype=dtype)

    def __repr__(self):
        return f"<ovoid.Slice {self.values.shape[1]} x {self.values.shape[0]}>"


_AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def _plane_axes(normal):
    """Two directions in a plane: x and y, x and z, y and z for the axes."""
    normal = normal / np.linalg.norm(normal)
    across = np.eye(3)[np.argmin(abs(normal))] if (abs(normal) < 1 - 1e-12).all() else None
    if across is None:
        axis = int(np.argmax(abs(normal)))
        return tuple(np.eye(3)[other] for other in range(3) if other != axis)
    u = across - normal * (across @ normal)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    return u, v


def slice_of(scene, asked, normal, at, size):
    """A scene's field on a plane."""
    if isinstance(normal, str):
        if normal not in _AXES:
            raise InvalidArgument(f"normal = {normal!r}: expected \"x\", \"y\", \"z\" or three numbers")
        normal = _AXES[normal]
    normal = _arrays.vector(normal, "normal", "\"x\", \"y\", \"z\" or three numbers, not all 0")
    length = np.linalg.norm(normal)
    if not length:
        raise InvalidArgument("normal = (0, 0, 0): expected \"x\", \"y\", \"z\" or three numbers, not all 0")
    if isinstance(size, bool) or not isinstance(size, (int, np.integer)) or not 1 <= size <= 8192:
        raise InvalidArgument(f"size = {size!r}: expected a number of values along the longer side, 1 to 8192")
    normal = normal / length
    lo, hi = (np.array(corner) for corner in scene.bounds(*asked))
    u, v = _plane_axes(normal)
    corners = np.array([[(lo, hi)[(corner >> axis) & 1][axis] for axis in range(3)] for corner in range(8)])
    place = (lo + hi) / 2 @ normal if at is None else _arrays.number(at, "at")
    ends = [(corners @ axis).min() for axis in (u, v)], [(corners @ axis).max() for axis in (u, v)]
    sides = np.maximum(np.subtract(ends[1], ends[0]), 1e-300)
    step = sides.max() / size
    counts = np.maximum(np.ceil(sides / step - 1e-9).astype(int), 1)
    first = [(ends[0][i] + ends[1][i]) / 2 - (counts[i] - 1) / 2 * step for i in range(2)]
    origin = first[0] * u + first[1] * v + place * normal
    matrix = np.column_stack([u * step, v * step, np.cross(u, v) * step, origin])
    found, notes = scene.resample(*asked, (int(counts[0]), int(counts[1]), 1), matrix.tolist(), None)
    _log_notes(notes)
    values = next(iter(Data(found).arrays.values())).reshape(counts[1], counts[0])
    return Slice(values, origin, u * step, v * step)


def slice(data, normal="z", at=None, *, size=512, **settings):
    """The field on a plane, as an array of values.

    Parameters
    ----------
    data : Data, array_like, str or path
        What `render` takes.
    normal : "x", "y", "z" or (x, y, z)
        The plane's normal.
    at : float, optional
        Where the plane is along the normal, of unit length: dot(normal, place); world units. Through the middle without it.
    size : int
        Values along the longer side.
    **settings
        `spacing`, `origin`, ... of an array; what chooses array and kernels, as `render` takes it.

    Returns
    -------
    Slice

    Raises
    ------
    InvalidArgument
        For a normal of length 0, or a size that is not within 1 to 8192.
    Error
        As `render`, of the data.

    Examples
    --------
    >>> import numpy, ovoid
    >>> ramp = numpy.broadcast_to(numpy.arange(16.0), (16, 16, 16))
    >>> middle = ovoid.slice(ramp, "z", size=32)
    >>> places = middle.origin[0] + middle.u[0] * numpy.arange(32)
    >>> middle.values.shape, float(abs(middle.values[16] - places)[8:-8].max()) < 0.001  # a ramp ends at the sides
    ((32, 32), True)
    """
    return Scene(data, **settings).slice(normal, at, size=size)


def histogram(data, *, log=False, **settings):
    """How often values occur, in bins of the library's choice.

    Parameters
    ----------
    data : Data, array_like, str or path
        What `render` takes.
    log : bool
        Bins between logarithms, of the values > 0.
    **settings
        `spacing`, `origin`, ... of an array; what chooses array and kernels, as `render` takes it.

    Returns
    -------
    counts : numpy.ndarray of uint64, (n,)
        Of a lattice's samples, or at a kernel set's centres. Of many millions some are looked at, evenly.
    edges : numpy.ndarray of float64, (n + 1,)
        Between the bins.

    Raises
    ------
    Error
        As `render`, of the data.

    Examples
    --------
    >>> import numpy, ovoid
    >>> counts, edges = ovoid.histogram(numpy.arange(27, dtype="u1").reshape(3, 3, 3))
    >>> counts.tolist() == [1] * 27, edges[[0, -1]].tolist()
    (True, [-0.5, 26.5])
    """
    return Scene(data, **settings).histogram(log=log)


def histogram_of(scene, asked, log):
    """A scene's counts and edges."""
    counts, lo, hi = scene.histogram(*asked, bool(log))
    if not counts.size:
        return counts, np.empty(0)
    edges = np.linspace(lo, hi, counts.size + 1)
    return counts, 10.0**edges if log else edges
