# SPDX-License-Identifier: Apache-2.0
"""Drawing: once, or data that are kept between frames."""
import logging
import os

from . import _core, _settings, _state
from ._beside import Beside
from ._data import data_of, is_path, path_of, paths_of
from ._errors import InvalidArgument, Unsupported
from ._picture import Picture
from ._progress import bar

_log = logging.getLogger("ovoid")


class Scene:
    """Data that are read and modelled once, and drawn many times.

    Parameters
    ----------
    data, spacing, origin, direction, affine, space, state
        As `render` takes them. Arrays are not to be changed while the scene lives.
    **settings
        Settings of all its pictures.

    Examples
    --------
    >>> import numpy, ovoid
    >>> scene = ovoid.Scene(numpy.arange(27.0).reshape(3, 3, 3), size=(64, 48))
    >>> front, side = scene.render(view="front"), scene.render(view="right")
    >>> side.profile["model_ms"]
    0.0
    """

    def __init__(self, data=None, *, spacing=None, origin=None, direction=None, affine=None, space=None, state=None, **settings):
        self._defaults = {}
        inputs, settings = _state.merged(state, settings)
        if data is None:
            if not inputs:
                raise InvalidArgument("data: none given, and no state that names files")
            data = inputs
        if is_path(data):
            if not (origin is None and direction is None and affine is None and space is None):
                raise InvalidArgument("origin, direction, affine, space: are for arrays, files say themselves where they are")
            if spacing is not None:
                settings["spacing"] = spacing  # of raw files, which the program refuses of others
            self._data = None
            self._files = paths_of(data)
            self._core = _core.Scene(None, self._files)
        else:
            self._data = data_of(data, spacing, origin, direction, affine, space, settings.get("memory_limit"))
            self._core = _core.Scene(self._data._core, [])
            self._defaults = self._data._defaults
        self._spans = {}
        self._beside = Beside(self._data)
        self.settings = settings
        self._asked(settings)  # names that there are not are found now

    def _range(self, array):
        """The range of the values called `array`; None where they are not one array of numbers in memory."""
        if self._data is None or not isinstance(array, (str, type(None))):
            return None
        array = array or self._defaults.get("array")
        if array not in self._spans:
            spans = [_span_of(step, array) for step in self._data.steps]
            known = [end for span in spans if span is not None for end in span]
            self._spans[array] = (min(known), max(known)) if known else None
        return self._spans[array]

    def _asked(self, settings):
        """The program's words, and the data in memory that they name."""
        settings, beside = self._beside.named(settings)
        chosen = _settings.canonical(settings, self._range)
        for name, value in self._defaults.items():
            if name not in chosen and "array" not in chosen:
                chosen[name] = value
        return _settings.words(chosen), beside

    def render(self, *, progress=False, profile=False, **settings):
        """Draws a frame by the scene's settings and those given here, which win.

        Parameters
        ----------
        progress : bool
            Shows a bar while it draws, by tqdm if that is installed.
        profile : bool
            Measures the stages, for `Picture.profile`.
        **settings
            As `ovoid.render` takes them.

        Returns
        -------
        Picture
        """
        with bar(progress) as on_progress:
            picture = self._draw({**self.settings, **settings}, bool(profile), on_progress)
        why_empty = picture._why_empty
        for note in picture.notes:
            _log.log(logging.WARNING if note == why_empty else logging.INFO, "%s", note)
        return picture

    def _draw(self, settings, profile, on_progress, coarseness=0):
        return Picture(self._core.draw(*self._asked(settings), profile, on_progress, coarseness))

    def view(self, **settings):
        """How the scene is looked at, with settings that are kept.

        Parameters
        ----------
        **settings
            As `ovoid.render` takes them; they win over those of the scene.

        Returns
        -------
        View

        Raises
        ------
        UnknownSetting
            For names that there are not. Values are looked at when it draws.
        """
        return View(self, settings)

    def sample(self, points):
        """The field, and its gradient, at places.

        Parameters
        ----------
        points : array_like, (..., 3)
            Places x, y, z; world units.

        Returns
        -------
        Samples

        Raises
        ------
        InvalidArgument
            For places that are not finite, or not of three numbers.
        """
        from . import _functions

        return _functions.samples_of(self._core, points, self._asked(self.settings))

    def slice(self, normal="z", at=None, *, size=512):
        """The field on a plane, as an array of values.

        Parameters
        ----------
        normal, at, size
            As of `ovoid.slice`.

        Returns
        -------
        Slice
        """
        from . import _functions

        return _functions.slice_of(self._core, self._asked(self.settings), normal, at, size)

    def histogram(self, *, log=False):
        """How often values occur.

        Parameters
        ----------
        log : bool
            Bins between logarithms, of the values > 0.

        Returns
        -------
        counts : numpy.ndarray of uint64, (n,)
        edges : numpy.ndarray of float64, (n + 1,)
        """
        from . import _functions

        return _functions.histogram_of(self._core, self._asked(self.settings), log)


    def __repr__(self):
        return f"<ovoid.Scene of {', '.join(self._files) if self._data is None else repr(self._data)}{_told(self.settings)}>"


def _told(settings):
    """Names of settings, for what stands for an object."""
    return f" with {', '.join(settings)}" if settings else ""


def _span_of(data, array):
    """The least and the greatest of the values called `array`, or of the only one; None where they are not one array of numbers."""
    arrays = data.arrays
    values = arrays.get(array) if array else next(iter(arrays.values())) if len(arrays) == 1 else None
    if values is None or values.ndim != (3 if data.kind == "lattice" else 1):
        return None
    finite = values[abs(values) < float("inf")] if values.dtype.kind == "f" else values
    if not finite.size:
        return None
    scale, offset = data._core.value_scale(data._core.array_names.index(array) if array else 0)
    ends = finite.min(), finite.max()
    return ends if (scale, offset) == (1, 0) else tuple(sorted(end * scale + offset for end in ends))


class View:
    """How a scene is looked at: settings that are kept from picture to picture.

    Attributes
    ----------
    scene : Scene
        What is looked at.
    settings : dict
        What `update` has set.
    """

    def __init__(self, scene, settings):
        self.scene = scene
        self.settings = {}
        self.update(**settings)

    def update(self, **settings):
        """Sets settings.

        Parameters
        ----------
        **settings
            As `ovoid.render` takes them; None takes one away.

        Returns
        -------
        View
            This one.

        Raises
        ------
        UnknownSetting
            For names that there are not. Values are looked at when it draws.
        """
        merged = {**self.settings, **settings}
        merged = {name: value for name, value in merged.items() if value is not None}
        self.scene._asked({**self.scene.settings, **merged})
        self.settings = merged
        return self

    def render(self, **settings):
        """Draws a frame.

        Parameters
        ----------
        **settings
            For this picture alone, as `Scene.render` takes them.

        Returns
        -------
        Picture
        """
        return self.scene.render(**{**self.settings, **settings})

    def frames(self, **series):
        """Pictures one after the other, for settings that change.

        Parameters
        ----------
        **series : iterable
            For each setting its values, one for each picture; as many of each.

        Yields
        ------
        Picture

        Raises
        ------
        InvalidArgument
            For settings that have not as many values each.

        Examples
        --------
        >>> import numpy, ovoid
        >>> view = ovoid.Scene(numpy.arange(27.0).reshape(3, 3, 3)).view(size=(32, 24))
        >>> [picture.width for picture in view.frames(azimuth=range(0, 360, 120))]
        [32, 32, 32]
        """
        values = [list(each) for each in series.values()]
        if len({len(each) for each in values}) != 1:
            raise InvalidArgument("frames: expected settings with as many values each")
        for chosen in zip(*values):
            yield self.render(**dict(zip(series, chosen)))

    def along(self, camera_path, frames=None):
        """Pictures one after the other, along a camera's path.

        Parameters
        ----------
        camera_path : list of dict, str or path
            Keys, each a dict with a `frame`, and any of a camera's words (`Picture.camera`) and of azimuth, elevation, roll and zoom; or
            a file of them. `ovoid animate --camera-path` takes the same.
        frames : int, optional
            So many pictures, not up to the last key.

        Yields
        ------
        Picture

        Raises
        ------
        InvalidArgument
            For keys that are none, in words that name the key.

        Examples
        --------
        >>> import numpy, ovoid
        >>> view = ovoid.Scene(numpy.arange(27.0).reshape(3, 3, 3)).view(size=(32, 24))
        >>> keys = [{"frame": 0}, {"frame": 4, "azimuth": 90, "zoom": 2}]
        >>> len(list(view.along(keys)))
        5
        """
        if frames is not None and (isinstance(frames, bool) or not hasattr(frames, "__index__") or not 1 <= frames.__index__() <= 1000000):
            raise InvalidArgument(f"frames = {frames!r}: expected a whole number from 1 to 1000000")
        # What the keys do not say is of the picture without them.
        first = self.render()
        cameras = first._core.cameras_along(_settings.camera_path_text(camera_path), 0 if frames is None else frames.__index__())
        from_where = dict.fromkeys(("azimuth", "elevation", "roll", "zoom", "view", "cpos", "fit", "projection", "parallel_projection", "view_angle"))
        for camera in cameras:
            yield self.render(**from_where, camera=camera)

    def _repr_png_(self):
        return self.render()._repr_png_()

    def __repr__(self):
        return f"<ovoid.View of {self.scene!r}{_told(self.settings)}>"


def render(data=None, *, spacing=None, origin=None, direction=None, affine=None, space=None, state=None, progress=False, profile=False, **settings):
    """Draws data to a picture.

    Parameters
    ----------
    data : array_like, str, path, Data or an object of another package, optional
        An array (z, y, x), (z, y, x, component) or (y, x), in any order of memory; masked values and NaN are missing. What has
        ``__array__`` or ``__dlpack__``, or ``shape``, ``dtype`` and ``__getitem__``, is taken as an array. A path is read by the
        library. Of other packages: arrays of xarray; meshes of meshio; images, grids, meshes and points of VTK and PyVista;
        DataFrames and yt's data, as `particles` takes them; yt's covering grids; images of nibabel and SimpleITK.
    spacing : (x, y, z) or float, optional
        Distance of an array's samples along its axes, world units; one number: along all of them. 1 without it.
    origin : (x, y, z), optional
        The place of the first sample, world units.
    direction : (3, 3) array_like, optional
        Its columns are the directions of the axes x, y, z, as VTK and ITK have them.
    affine : (4, 4) array_like, optional
        Instead of the three: world from (i, j, k, 1), i along the axis x, as nibabel has it.
    space : str, optional
        "LPS" or "RAS": the world is a patient's, which views are named by.
    state : dict, str or path, optional
        What to begin with: `Picture.state`, what `view` gave back, or a state file, whose inputs are drawn without `data`. Settings
        that are given beat it.
    progress : bool
        Shows a bar while it draws, by tqdm if that is installed.
    profile : bool
        Measures the stages, for `Picture.profile`.
    **settings
        The flags of ``ovoid render`` with underscores (`settings` tells them all), or PyVista's words for them: `cmap`, `clim`,
        `opacity`, `background`, `window_size`, `cpos`, ... `cmap` also takes a list of colours, and a colour map of matplotlib's.

    Returns
    -------
    Picture

    Raises
    ------
    Error
        In the program's words; `InvalidArgument` is also a ValueError, `NotFound` a FileNotFoundError, ...

    Examples
    --------
    >>> import numpy, ovoid
    >>> z, y, x = numpy.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
    >>> ovoid.render(numpy.exp(-4 * (x**2 + y**2 + z**2)), size=(64, 48))
    <ovoid.Picture 64 x 48>
    """
    scene = Scene(data, spacing=spacing, origin=origin, direction=direction, affine=affine, space=space, state=state, **settings)
    return scene.render(progress=progress, profile=profile)


def animate(pictures, path, fps=25, *, camera_path=None, frames=None, **settings):
    """Makes a film of pictures, or of data along a camera's path.

    Parameters
    ----------
    pictures : iterable of Picture
        Of one size, such as `View.frames` yields; each is written before the next is asked for. With `camera_path` a `View`, a `Scene`
        or what `render` takes.
    path : str or path
        ``.gif``, or ``.mp4`` or ``.webm``, which ffmpeg makes.
    fps : float
        Pictures a second.
    camera_path : list of dict, str or path, optional
        Keys of a camera that moves, as `View.along` takes them.
    frames : int, optional
        With a camera path: so many pictures, not up to the last key.
    **settings
        With a camera path: settings of all pictures.

    Raises
    ------
    InvalidArgument
        For no pictures, of several sizes, or a path without the ending of a film.
    Unsupported
        Where ffmpeg is not installed, which is looked for first.
    FileWrite
        Where the film cannot be written.

    Examples
    --------
    >>> import numpy, ovoid
    >>> data = numpy.arange(27.0).reshape(3, 3, 3)
    >>> keys = [{"frame": 0}, {"frame": 3, "azimuth": 90, "zoom": 2}]
    >>> ovoid.animate(data, "turn.gif", camera_path=keys, size=(64, 48))
    """
    import shutil  # not above: it loads the system's libbz2 before the package its own
    import tempfile

    try:
        fps = float(fps)
    except (TypeError, ValueError, OverflowError):
        raise InvalidArgument(f"fps = {fps!r}: expected a number") from None
    path = os.path.abspath(path_of(path))
    if not path.endswith((".gif", ".mp4", ".webm")):
        raise InvalidArgument(f"'{path}': expected a film: .gif, .mp4 or .webm")
    if not path.endswith(".gif") and shutil.which("ffmpeg") is None:  # else told when all is drawn
        raise Unsupported(f"'{path}': such films are made by the program ffmpeg, which is not on PATH: install it (apt install ffmpeg), "
                          "or write a .gif, which needs none")
    if camera_path is not None:
        pictures = _view_of(pictures, settings).along(camera_path, frames)
    elif frames is not None or settings:
        raise InvalidArgument(f"{next(iter(settings), 'frames')}: is for films along a camera_path, pictures are drawn already")
    with tempfile.TemporaryDirectory() as folder:
        pattern = os.path.join(folder, "frame_%06d.png")
        count = 0
        for count, picture in enumerate(_each(pictures), 1):
            picture.save(pattern % (count - 1))
        if not count:
            raise InvalidArgument("animate: no pictures")
        _core.make_film(pattern, count, path, fps)


def _view_of(data, settings):
    if isinstance(data, View):
        return data.scene.view(**{**data.settings, **settings})
    scene = data if isinstance(data, Scene) else Scene(data, **settings)
    return scene.view(**settings) if scene is data else scene.view()


def _each(pictures):
    """Pictures one after the other; an error for anything else."""
    if isinstance(pictures, Picture) or not hasattr(pictures, "__iter__"):
        raise InvalidArgument(f"pictures: is one {type(pictures).__name__}, expected several pictures, or a camera_path along which it is drawn")
    size = None
    for number, picture in enumerate(pictures):
        if not isinstance(picture, Picture):
            raise InvalidArgument(f"pictures[{number}]: is {type(picture).__name__}, expected a Picture, which render() gives")
        size = size or (picture.width, picture.height)
        if size != (picture.width, picture.height):
            raise InvalidArgument(f"pictures[{number}]: is {picture.width} x {picture.height}, expected {size[0]} x {size[1]}, as the first is")
        yield picture
