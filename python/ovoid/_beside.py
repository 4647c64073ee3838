# SPDX-License-Identifier: Apache-2.0
"""Data in memory where settings name files: label maps, further volumes, surfaces."""
import os

from ._data import Data, data_of, is_path
from ._errors import InvalidArgument

# Of each such setting the ending of a file that holds what it takes, and whether it takes several.
_SETTINGS = {"labels": (".nrrd", False), "over": (".nrrd", True), "add": (".vtu", True), "within": (".vtu", False)}


class Beside:
    """What a scene's settings hold in memory, each made once while it stays the same."""

    def __init__(self, scene_data):
        self._scene_data = scene_data  # None: files
        self._made = {}

    def named(self, settings):
        """The settings with names in the place of data in memory, and the data by these names."""
        settings, found = dict(settings), {}
        for setting, (ending, takes_several) in _SETTINGS.items():
            value = settings.get(setting)
            if value is not None and not takes_several:
                _refuse_several_names(setting, value)
            if value is None or is_path(value):
                continue
            several = list(value) if takes_several and isinstance(value, (list, tuple)) else [value]
            for i, one in enumerate(several):
                _refuse_several_names(f"{setting}[{i}]", one)
            taken = {os.fspath(one) for one in several if is_path(one)}
            names = []
            for i, one in enumerate(several):
                if is_path(one):
                    names.append(one)
                    continue
                names.append(_free_name(setting, ending, taken))
                taken.add(names[-1])
                found[names[-1]] = self._core_of(setting, i, one)
            settings[setting] = names if takes_several else names[0]
        return settings, found

    def _core_of(self, setting, i, value):
        kept = self._made.get((setting, i))
        if kept is None or kept[0] is not value:
            kept = self._made[setting, i] = (value, self._make(setting, value)._core.named(setting))
        return kept[1]

    def _make(self, setting, value):
        if isinstance(value, Data):
            if len(value.steps) > 1:
                raise InvalidArgument(f"{setting}: is a series of {len(value.steps)} steps, expected one, such as series.steps[0]")
            return value
        from . import _arrays, _objects

        found = _objects.data_of_object(value, faces=setting == "add")
        if found is not None:
            return found
        if setting in ("add", "within"):
            raise InvalidArgument(f"{setting} = {type(value).__name__}: expected a file, ovoid.mesh(...)"
                                  f"{', ovoid.particles(...)' if setting == 'add' else ''} or a mesh of another package")
        if _arrays.is_xarray(value):
            if any(axis in value.coords for axis in value.dims):
                return data_of(value)
            value = value.data
        if not hasattr(value, "shape"):
            value = _arrays.numbers_of(value, setting)
        return self._where_the_scene_is(setting, value)

    def _where_the_scene_is(self, setting, array):
        """An array that says nothing of its place: that of the scene's own array of the same shape."""
        own = self._scene_data
        dims = _arrays_dims(array, setting)
        if own is None or own.kind != "lattice":
            what = "files" if own is None else own.kind
            raise InvalidArgument(f"{setting}: is an array without a place, and the data are {what}: expected ovoid.lattice(array, spacing=..., origin=...)")
        if dims != tuple(own._core.dims):
            raise InvalidArgument(f"{setting}: has the shape {tuple(array.shape)}, the data {tuple(reversed(own._core.dims))}: expected the same, "
                                  "or ovoid.lattice(array, spacing=..., origin=...), which has a place of its own")
        space = own.space
        return data_of(array, affine=[*own.matrix, [0, 0, 0, 1]], space=None if space == "none" else space)


def _refuse_several_names(setting, value):
    if isinstance(value, (list, tuple)) and is_path(value):
        raise InvalidArgument(f"{setting}: is a list of names, expected the name of a file or folder, or ovoid.read(names) of the slices of one volume")


def _arrays_dims(array, name):
    from . import _arrays

    return tuple(_arrays.dims_of(array.shape, name))


def _free_name(setting, ending, taken):
    number = 1
    while (name := f"{setting}{'' if number == 1 else f'-{number}'}{ending}") in taken:
        number += 1
    return name
