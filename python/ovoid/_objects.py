# SPDX-License-Identifier: Apache-2.0
"""Objects of other packages as data, by what they can do: none of those packages is imported here."""
import sys

import numpy as np

from . import _arrays, _core
from ._errors import InvalidArgument


def _has(data, *names):
    return all(hasattr(data, name) for name in names)


def is_table(data):
    """Whether it has named columns, as DataFrames of pandas and polars do."""
    return _has(type(data), "columns", "to_numpy", "__getitem__")


def is_yt_grid(data):
    """A covering or arbitrary grid of yt's."""
    return _has(data, "ds", "field_data", "left_edge", "right_edge", "ActiveDimensions", "dds")


def is_yt(data):
    """A data set of yt's, or a part of one (a region, a sphere, all_data())."""
    return _has(data, "ds", "field_data", "get_data") or _has(data, "all_data", "derived_field_list", "field_list")


def _is_meshio(data):
    return _has(data, "points", "cells", "point_data", "cell_data")


def data_of_object(data, faces=False):
    """Data of an object that says itself where it is; None of others. `faces`: of surfaces and lines these, not their points."""
    if isinstance(data, np.ndarray):
        return None
    from . import _data, _meshes, _vtk

    if _vtk.is_vtk(data):
        return _vtk.data_of_vtk(data, faces)
    if is_yt_grid(data):
        return _yt_lattice(data)
    if is_table(data) or is_yt(data):
        return _data.particles(data)
    if _is_meshio(data):
        notes = []
        arrays = [_numbers_alone(data, arrays, notes) for arrays in (data.point_data, data.cell_data)]
        part = _meshes.part_of(data.points, data.cells, *arrays, order=[0, 2, 1, 3, 5, 4])  # wedges stand on their other side there
        return _meshes.data_of_parts(_name_of(data), [_meshes.with_triangles(part) if faces else part], notes, "meshio", faces=faces)
    if _has(data, "dataobj", "affine"):
        return _nibabel_lattice(data)
    if _has(data, "GetSpacing", "GetOrigin", "GetDirection", "GetSize"):
        return _itk_lattice(data)
    return None


def _name_of(data):
    return f"{type(data).__module__.split('.')[0]}.{type(data).__name__}"


def _numbers_alone(data, arrays, notes):
    """Arrays by name, each one or a list of them, without those of text and the like."""
    kept = {}
    for name, values in arrays.items():
        if all(np.asarray(one).dtype.kind in "biuf" for one in (values if isinstance(values, list) else [values])):
            kept[name] = values
        else:
            notes.append(f"{_name_of(data)}: array '{name}' is left out: it holds no numbers")
    return kept


def _lattice(data, values, matrix, space, name="values", scale=1.0, offset=0.0):
    """`values` (z, y, x) or (z, y, x, component)."""
    from ._data import Data

    source = _name_of(data)
    arrays = []
    parts = [(part, values[part]) for part in values.dtype.names] if getattr(values.dtype, "names", None) else [(name, values)]
    for part, one in parts:
        one = _arrays.numbers_of(one, source)
        arrays.append((part, one, "", False, scale, offset))
    return Data(_core.lattice(source, _arrays.dims_of(one.shape, source), matrix.tolist(), arrays).with_facts("", space, []))


def _nibabel_lattice(image):
    """Axes are x, y, z there, the first one fastest as a rule, so that the transposed array is as it is kept here."""
    source = _name_of(image)
    if image.affine is None:
        raise InvalidArgument(f"{source}: has no affine; give its array with spacing= or affine=")
    proxy, scale, offset = image.dataobj, 1.0, 0.0
    if _has(proxy, "get_unscaled", "slope", "inter"):  # as NIfTI files are read: values as they stand, and what they mean
        values, scale, offset = np.asanyarray(proxy.get_unscaled()), proxy.slope, proxy.inter
        if np.ndim(scale) or np.ndim(offset):
            values, scale, offset = np.asanyarray(proxy), 1.0, 0.0
    else:
        values = np.asanyarray(proxy)
    if not 2 <= values.ndim <= 5 or (values.ndim > 3 and values.shape[3] != 1):
        raise InvalidArgument(f"{source}: has the shape {values.shape}, expected one volume (x, y, z), as by image.slicer[..., 0]")
    components = values.shape[4:]
    if values.ndim > 3:
        values = values.reshape(*values.shape[:3], *[n for n in components if n > 1], order="A")
    values = values.transpose(2, 1, 0, 3) if values.ndim == 4 else values.T
    return _lattice(image, values, _arrays.placement(None, None, None, image.affine), "RAS", "values", float(scale), float(offset))


class _Kept:
    """Memory of an array that lives as long as another object."""

    def __init__(self, array, owner):
        self.__array_interface__ = array.__array_interface__
        self.kept = array, owner


def _itk_lattice(image):
    source = _name_of(image)
    package = sys.modules.get(type(image).__module__.split(".")[0])
    if not hasattr(package, "GetArrayViewFromImage"):
        raise InvalidArgument(f"{source}: its samples cannot be seen from here; give numpy's array of it with spacing=, origin=, direction= "
                              "and space='LPS'")
    size = len(image.GetSize())
    if size not in (2, 3):
        raise InvalidArgument(f"{source}: has {size} axes, expected 2 or 3")
    matrix, spacing, origin = np.eye(3), np.ones(3), np.zeros(3)
    matrix[:size, :size] = np.reshape(image.GetDirection(), (size, size))
    spacing[:size], origin[:size] = image.GetSpacing(), image.GetOrigin()
    view = np.asarray(_Kept(package.GetArrayViewFromImage(image), image))  # a view alone does not keep the image
    return _lattice(image, view, _arrays.placement(spacing, origin, matrix), "LPS")


def _yt_field(data, field):
    """Values of a field, and their unit."""
    try:
        values = data[field]
    except Exception as error:  # of any kind: yt's own, and those of the readers below it
        raise InvalidArgument(f"{field}: yt finds no such field: {error}") from error
    return values


def _yt_lattice(grid):
    """The fields that were asked for, or the default one; samples are in the middles of the cells."""
    from ._data import Data

    ds, source = grid.ds, _name_of(grid)
    fields = [field for field in grid.field_data if len(np.shape(grid.field_data[field])) == 3]
    if not fields:
        known = [*ds.field_list, *ds.derived_field_list]
        fields = [field for field in (getattr(ds, "default_field", None), *ds.field_list) if field in known][:1]
    if not fields:
        raise InvalidArgument(f"{source}: has no fields")
    arrays = {}
    for field in fields:
        values = _yt_field(grid, field)
        name = field[-1] if isinstance(field, tuple) else str(field)
        arrays.setdefault(name, (name, _arrays.numbers_of(np.asarray(values).T, name), _arrays.unit_of(values)))
    steps, first = _arrays.in_unit(grid.dds, grid.left_edge), np.asarray(grid.left_edge)
    matrix = np.column_stack([np.diag(steps), first + steps / 2])
    dims = [int(n) for n in grid.ActiveDimensions]
    return Data(_core.lattice(source, dims, matrix.tolist(), list(arrays.values())))


def _names_of(values):
    """Fields or columns: one, or several."""
    if values is None:
        return []
    return [values] if isinstance(values, (str, tuple)) or not hasattr(values, "__iter__") else list(values)


def _yt_columns(data, values):
    """As `columns_of`, of one type of particles."""
    data = data.all_data() if not hasattr(data, "field_data") else data
    ds, source = data.ds, _name_of(data)
    fields = [field if isinstance(field, tuple) else ("all", field) for field in _names_of(values)]
    kinds = list(dict.fromkeys(kind for kind, _ in fields)) or ["all"]
    if not getattr(ds, "particle_types", ()):
        raise InvalidArgument(f"{source}: has no particles; give a lattice of it: ds.covering_grid(...) or ds.arbitrary_grid(...)")
    if len(kinds) > 1:
        raise InvalidArgument(f"{source}: fields of {', '.join(kinds)}, expected those of one type of particles")
    kind = kinds[0]
    if kind == "gas" and getattr(ds, "_sph_ptypes", ()):
        kind = ds._sph_ptypes[0]  # as yt itself finds the particles of a gas
    if kind not in ds.particle_types:
        raise InvalidArgument(f"'{kind}': no type of particles; expected one of {', '.join(ds.particle_types)}")
    xyz = _yt_field(data, (kind, "particle_position"))
    named = {field[1]: _yt_field(data, field) for field in fields}
    known = set(ds.derived_field_list)
    mass = _yt_field(data, (kind, "particle_mass")) if (kind, "particle_mass") in known else None
    h = None
    if (kind, "smoothing_length") in known:
        h = _arrays.in_unit(_yt_field(data, (kind, "smoothing_length")), xyz)
    return xyz, named or None, h, mass, []


def _column(table, name):
    """A column of numbers; None of others."""
    values = table[name].to_numpy()
    if values.dtype.kind == "O":  # pandas' integers that may be missing
        try:
            values = table[name].to_numpy(dtype="f8", na_value=np.nan)
        except (TypeError, ValueError):
            return None
    return values if values.dtype.kind in "biuf" and values.ndim == 1 else None


def _table_columns(table, values):
    source = _name_of(table)
    names = {str(name).lower(): name for name in reversed(list(table.columns))}
    missing = [axis for axis in "xyz" if axis not in names]
    if missing:
        known = ", ".join(map(str, table.columns))
        raise InvalidArgument(f"{source}: has no column {', '.join(missing)}; expected x, y, z. Its columns: {known}")
    axes = [_column(table, names[axis]) for axis in "xyz"]
    for axis, column in zip("xyz", axes):
        if column is None:
            raise InvalidArgument(f"{source}: column '{names[axis]}': expected numbers")
    special = {names[name]: name for name in ("h", "mass") if name in names}
    wanted = [name for name in table.columns if name not in special and name not in [names[axis] for axis in "xyz"]]
    if values is not None:
        wanted = _names_of(values)
        unknown = [name for name in wanted if name not in list(table.columns)]
        if unknown:
            known = [str(name) for name in table.columns]
            raise InvalidArgument(f"{source}: has no column '{unknown[0]}'{_core.did_you_mean(str(unknown[0]), known)}")
    named = {str(name): _column(table, name) for name in wanted}
    others = [name for name, column in named.items() if column is None]
    if values is not None and others:
        raise InvalidArgument(f"{source}: column '{others[0]}': expected numbers")
    notes = [f"{source}: column '{name}' is left out: it holds no numbers" for name in others]
    named = {name: column for name, column in named.items() if column is not None}
    lengths = {kind: _column(table, name) for name, kind in special.items()}
    return np.column_stack(axes), named or None, lengths.get("h"), lengths.get("mass"), notes


def columns_of(data, values):
    """xyz, values, h, mass and notes of a table or of yt's data, of which `values` are names; None of others."""
    if isinstance(data, np.ndarray):
        return None
    if is_table(data):
        return _table_columns(data, values)
    return _yt_columns(data, values) if is_yt(data) else None
