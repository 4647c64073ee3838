# SPDX-License-Identifier: Apache-2.0
"""Finished pictures."""
import json
import operator

from . import _core
from ._data import path_of
from ._errors import InvalidArgument


class Picture:
    """A finished picture.

    numpy, and what takes DLPack, take it as an array of 8 bits; notebooks show it, `save` writes it.
    """

    def __init__(self, core):
        self._core = core
        self._pixels = None

    @property
    def width(self):
        """int: pixels."""
        return self._core.width

    @property
    def height(self):
        """int: pixels."""
        return self._core.height

    def numpy(self):
        """The pixels of the PNG.

        Returns
        -------
        numpy.ndarray of uint8, (height, width, 4)
            Red, green, blue and straight opacity, row 0 at the top, on the background.
        """
        if self._pixels is None:
            self._pixels = self._core.rgba8()
        return self._pixels

    @property
    def __array_interface__(self):
        return self.numpy().__array_interface__

    def __dlpack__(self, **options):
        return self.numpy().__dlpack__(**options)

    def __dlpack_device__(self):
        return self.numpy().__dlpack_device__()

    @property
    def rgba(self):
        """numpy.ndarray of float32, (height, width, 4): premultiplied, without background and marks; of x-rays the integrals."""
        return self._core.rgba()

    @property
    def depth(self):
        """numpy.ndarray of float32, (height, width): from the camera's plane to where opacity reaches 1/2, world units; inf: nowhere."""
        return self._core.depth()

    @property
    def profile(self):
        """dict: where the time went, as ``ovoid render --profile=FILE.json`` writes it; `stages_ms` with ``profile=True`` alone."""
        found = json.loads(self._core.profile)
        found["command"] = self.command
        return found

    @property
    def notes(self):
        """list of str: what the program would have told."""
        return self._core.notes

    @property
    def _why_empty(self):
        """The note that nothing shows and why, or an empty text."""
        return next((note for note in self.notes if note.startswith("nothing shows")), "")

    @property
    def camera(self):
        """dict: the camera of the picture, which the setting `camera` takes."""
        return json.loads(self._core.camera)

    @property
    def look(self):
        """dict: the look of the picture, which the setting `tf` takes: ParaView's JSON with values that are absolute."""
        return json.loads(self._core.look)[0]

    @property
    def state(self):
        """dict: inputs and flags, as in a state file of ``ovoid render --state``; the setting `state` takes it."""
        return {"ovoid_state": 1, "program": _core.version, "inputs": self._core.inputs, "flags": json.loads(self._core.flags)}

    @property
    def command(self):
        """str: the command that draws the same bytes; of data in memory with the name ``data.nrrd``, or ``data.pvd`` of a series, for a file
        that `write` makes."""
        inputs = self._core.inputs or ["data.pvd" if self._core.is_series else "data.nrrd"]
        return _core.quoted(["ovoid", "render", *inputs, *self._core.words, "-o", "picture.png"])

    def pick(self, x, y):
        """What the picture shows at a pixel, whatever is drawn afterwards: the picture keeps the data that it shows.

        Parameters
        ----------
        x, y : int
            The pixel: column, and row with row 0 at the top.

        Returns
        -------
        dict
            `pixel` [x, y]; `shows`, False where its opacity is less than 1/255, and then no place follows; `opacity`. The place is
            where the opacity reaches 1/2, or what adds most to the pixel: `position` [x, y, z], world units; `depth` from the
            camera's plane, world units; `index` [i, j, k] of arrays and other lattices, samples at whole numbers; the field's
            `value` and `gradient` [x, y, z] there, value per world unit, None where it is not defined; `color_value` of an array of
            its own; `label` {`value`, `name`} of labels; `integral` of x-rays, value times length. `unit` of the value and
            `length_unit`, empty where the data say none.

        Raises
        ------
        InvalidArgument
            A pixel outside of the picture.

        Examples
        --------
        >>> import numpy, ovoid
        >>> z, y, x = numpy.mgrid[-1:1:32j, -1:1:32j, -1:1:32j]
        >>> picture = ovoid.render(1 - numpy.sqrt(x**2 + y**2 + z**2), size=(64, 48), mode="isosurface", iso=0.5)
        >>> round(picture.pick(32, 24)["value"], 3), picture.pick(0, 0)["shows"]
        (0.5, False)
        """
        return json.loads(self._core.pick(operator.index(x), operator.index(y)))

    def save(self, path):
        """Writes the picture.

        Parameters
        ----------
        path : str or path
            ``.png``, ``.jpg``, ``.exr`` (floats, depths, normals) or ``.npy`` (float32, premultiplied).

        Raises
        ------
        InvalidArgument
            For another ending; of a JPEG for a background that is transparent.
        FileWrite
            Where the file cannot be written; nothing is left behind.
        """
        self._core.save(path_of(path))

    def encode(self, ending=".png", quality=92):
        """The bytes of the file that `save` writes, without a file.

        Parameters
        ----------
        ending : str
            ``.png``, or ``.jpg``.
        quality : int
            Of a JPEG, 1 to 100.

        Returns
        -------
        bytes

        Raises
        ------
        InvalidArgument
            As `save`, and for a quality outside of its range.
        """
        try:
            quality_number = operator.index(quality)
        except TypeError:
            quality_number = 0
        if not 1 <= quality_number <= 100:
            raise InvalidArgument(f"quality = {quality!r}: expected a whole number from 1 to 100")
        return self._core.encode(str(ending), quality_number)

    def _repr_png_(self):
        return self.encode()

    def _repr_mimebundle_(self, include=None, exclude=None):
        makers = {"text/plain": self.__repr__, "image/png": self._repr_png_}
        wanted = [kind for kind in makers if (include is None or kind in include) and (exclude is None or kind not in exclude)]
        return {kind: makers[kind]() for kind in wanted}

    def __repr__(self):
        return f"<ovoid.Picture {self.width} x {self.height}>"
