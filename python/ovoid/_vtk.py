# SPDX-License-Identifier: Apache-2.0
"""Data objects of VTK, and of what stands on it (PyVista), by their methods alone: no module of VTK is imported.

Each kind becomes what the readers of VTK's files make of it (docs/formats.md); the memory of its arrays is shared.
"""
import numpy as np

from . import _arrays, _core, _meshes
from ._data import Data
from ._errors import InvalidArgument, Unsupported

# VTK's type numbers, in the order of VTK's header: what kind of number they are; their sizes are asked for.
_KINDS = {2: "i", 15: "i", 3: "u", 4: "i", 5: "u", 6: "i", 7: "u", 8: "i", 9: "u", 10: "f", 11: "f", 12: "i", 16: "i", 17: "u"}
_HIDDEN_POINT, _HIDDEN_CELL = 2, 32


def is_vtk(data):
    """Whether it is an object of VTK's."""
    return all(callable(getattr(type(data), name, None)) for name in ("GetClassName", "IsA"))


def _numbers(array):
    """(tuples,) or (tuples, components), the memory of a vtkDataArray, which lives as long; None of bits and text."""
    kind = _KINDS.get(array.GetDataType())
    if kind is None or not array.IsA("vtkDataArray"):
        return None
    dtype = np.dtype(f"{kind}{array.GetDataTypeSize()}")
    num_tuples, num_components = array.GetNumberOfTuples(), array.GetNumberOfComponents()
    values = np.frombuffer(array, dtype, num_tuples * num_components) if num_tuples * num_components else np.empty(0, dtype)
    return values.reshape(num_tuples, num_components) if num_components != 1 else values


def _unit(array):
    information = array.GetInformation() if array.HasInformation() else None
    has_unit = information is not None and information.Has(array.UNITS_LABEL())
    return information.Get(array.UNITS_LABEL()) if has_unit else ""


def _arrays_of(attributes, num_expected, is_cell_data, source, notes):
    """All arrays of points or cells that hold numbers, one tuple for each."""
    found = []
    for i in range(attributes.GetNumberOfArrays() if num_expected else 0):
        array = attributes.GetAbstractArray(i)
        name = array.GetName() or f"{'cells' if is_cell_data else 'points'}{i}"
        values = _numbers(array)
        if values is not None and len(values) == num_expected and values.size:
            found.append((name, values, _unit(array), is_cell_data))
        else:
            kind = f"{array.GetNumberOfTuples()} tuples of {array.GetNumberOfComponents()} {array.GetDataTypeAsString()}"
            notes.append(f"{source}: array '{name}' ({kind}) is left out: expected {num_expected} tuples of numbers")
    return found


def _arrays_of_both(data, num_points, num_cells, source, notes):
    of_points = _arrays_of(data.GetPointData(), num_points, False, source, notes)
    return of_points + _arrays_of(data.GetCellData(), num_cells, True, source, notes)


def _active(data):
    """The name of the active scalars, of points before those of cells; None without."""
    for attributes in (data.GetPointData(), data.GetCellData()):
        scalars = attributes.GetScalars()
        if scalars is not None and scalars.GetName() and not scalars.GetName().startswith("vtk"):
            return scalars.GetName()
    return None


def _image_place(image):
    """World from (i, j, k), with index 0 at the first sample whatever the extent."""
    direction = image.GetDirectionMatrix()
    linear = np.array([[direction.GetElement(row, axis) for axis in range(3)] for row in range(3)]) * image.GetSpacing()
    return np.column_stack([linear, np.array(image.GetOrigin()) + linear @ image.GetExtent()[::2]])


def _axes(grid, source):
    axes = []
    coordinates = grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates()
    for letter, array, count in zip("xyz", coordinates, grid.GetDimensions()):
        values = None if array is None else _numbers(array)
        if values is None or values.shape != (count,):
            raise InvalidArgument(f"{source}: {letter} coordinates: expected {count} numbers")
        if not np.isfinite(values).all():
            raise InvalidArgument(f"{source}: {letter} coordinates: expected finite numbers")
        axes.append(values)
    return axes


def _even_place(axes):
    """World from (i, j, k) of coordinates that are even, as of files (docs/formats.md, "VTR"); None of others."""
    steps = np.zeros(3)
    for i, values in enumerate(axes):
        rounding = 1.5 * np.finfo(values.dtype if values.dtype.kind == "f" else "f8").eps * abs(values).max()
        values = values.astype("f8")
        if len(values) == 1:
            continue
        steps[i] = (values[-1] - values[0]) / (len(values) - 1)
        even = values[0] + steps[i] * np.arange(len(values))
        if not steps[i] or (abs(values - even) > 1e-4 * abs(steps[i]) + rounding).any():
            return None
    known = abs(steps[steps != 0])
    steps[steps == 0] = known.min() if known.size else 1
    return np.column_stack([np.diag(steps), [float(values[0]) for values in axes]])


def _without_hidden(arrays):
    """What is hidden is missing, in floats of its own."""
    shown = []
    for name, values, unit, is_cell_data in arrays:
        flags = _meshes.flags_of(arrays, is_cell_data)
        is_hidden = None if flags is None else flags & (_HIDDEN_CELL if is_cell_data else _HIDDEN_POINT) != 0
        if is_hidden is not None and is_hidden.any() and name != _meshes.GHOSTS:
            values = values.astype(_arrays.floats_for(values.dtype))
            values[is_hidden] = np.nan
        shown.append((name, values, unit, is_cell_data))
    return shown


def _lattice(data, place, source):
    notes = []
    arrays = _without_hidden(_arrays_of_both(data, data.GetNumberOfPoints(), data.GetNumberOfCells(), source, notes))
    if not arrays:
        raise InvalidArgument(f"{source}: has no array of numbers at its points or cells")
    core = _core.lattice(source, data.GetDimensions(), place.tolist(), arrays).with_facts("VTK", "none", notes)
    active = _active(data)
    return Data(core, {"array": active} if active in core.array_names and len(core.array_names) > 1 else None)


def _grid_points(axes):
    z, y, x = np.meshgrid(*(axis.astype("f8") for axis in reversed(axes)), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()])


def _cells(array):
    """Offsets and connectivity of a vtkCellArray."""
    if array is None or not array.GetNumberOfCells():
        return np.zeros(1, "i8"), np.empty(0, "i8")
    return _numbers(array.GetOffsetsArray()), _numbers(array.GetConnectivityArray())


def _poly_cells(data):
    types, counts, connectivity = [], [], []
    for array, code in ((data.GetVerts(), 2), (data.GetLines(), 4), (data.GetPolys(), 7), (data.GetStrips(), 6)):
        offsets, nodes = _cells(array)
        types.append(np.full(len(offsets) - 1, code, "u1"))
        counts.append(np.diff(offsets))
        connectivity.append(nodes)
    offsets = np.concatenate([[0], np.cumsum(np.concatenate(counts))])
    return np.concatenate(types), offsets, np.concatenate(connectivity)


def _part(data, notes):
    """A mesh, points or, as a piece of several, a lattice as a structured mesh."""
    source = data.GetClassName()
    num_points = data.GetNumberOfPoints()
    if not num_points:
        return _meshes.Part(np.empty((0, 3)))
    if data.IsA("vtkImageData"):
        place, axes = _image_place(data), [np.arange(n) for n in data.GetDimensions()]
        part = _meshes.Part(_grid_points(axes) @ place[:, :3].T + place[:, 3], dims=tuple(data.GetDimensions()))
    elif data.IsA("vtkRectilinearGrid"):
        part = _meshes.Part(_grid_points(_axes(data, source)), dims=tuple(data.GetDimensions()))
    elif not data.IsA("vtkPointSet"):
        raise Unsupported(f"{source}: is not drawn; expected an image, a grid, a mesh or points")
    else:
        points = _meshes.places_of(_numbers(data.GetPoints().GetData()), f"{source}: points")
        if data.IsA("vtkStructuredGrid"):
            part = _meshes.Part(points, dims=tuple(data.GetDimensions()))
            if np.prod(part.dims) != len(points):
                raise InvalidArgument(f"{source}: has {len(points)} points, dimensions {part.dims} need another number")
        elif data.IsA("vtkUnstructuredGrid"):
            offsets, nodes = _cells(data.GetCells())
            types = data.GetCellTypesArray()
            types = np.empty(0, "u1") if len(offsets) == 1 or types is None else _numbers(types)
            part = _meshes.Part(points, _meshes.cells_of_vtk(types, offsets, nodes, num_points, f"{source}: cells"))
        elif data.IsA("vtkPolyData"):
            cells = _meshes.cells_of_vtk(*_poly_cells(data), num_points, f"{source}: cells")
            is_surface = data.GetNumberOfLines() + data.GetNumberOfPolys() + data.GetNumberOfStrips() > 0
            part = _meshes.Part(points, cells, is_surface=is_surface)
        elif data.GetNumberOfCells():
            raise Unsupported(f"{source}: its cells are not drawn; make it a vtkUnstructuredGrid first")
        else:
            part = _meshes.Part(points)
    part.arrays = _arrays_of_both(data, num_points, part.num_cells, source, notes)
    return part


def _block_name(data, i):
    information = data.GetMetaData(i) if data.HasMetaData(i) else None
    name = information.Get(data.NAME()) if information is not None and information.Has(data.NAME()) else None
    return name or str(i)


def _leaves(data, block=""):
    """Data sets of a tree of blocks, with the blocks' names, below others "outer/inner"; pieces of a block share its name."""
    if data is None:
        return
    if data.IsA("vtkDataSet"):
        if data.GetNumberOfPoints():
            yield block, data
    elif data.IsA("vtkPartitionedDataSet"):  # vtkMultiPieceDataSet is one
        for i in range(data.GetNumberOfPartitions()):
            yield from _leaves(data.GetPartitionAsDataObject(i), block)
    elif data.IsA("vtkPartitionedDataSetCollection"):
        for i in range(data.GetNumberOfPartitionedDataSets()):
            yield from _leaves(data.GetPartitionedDataSet(i), f"{block}/{_block_name(data, i)}" if block else _block_name(data, i))
    elif data.IsA("vtkMultiBlockDataSet"):
        for i in range(data.GetNumberOfBlocks()):
            yield from _leaves(data.GetBlock(i), f"{block}/{_block_name(data, i)}" if block else _block_name(data, i))
    elif not data.IsA("vtkTable"):
        raise Unsupported(f"{data.GetClassName()}: is not drawn as an object; write it to a file and draw that")


def data_of_vtk(data, faces=False):
    """A data object as Data; `faces`: of surfaces and lines these, not their points."""
    source = data.GetClassName()
    if data.IsA("vtkAlgorithm"):
        raise InvalidArgument(f"{source}: makes data; expected what it makes: Update(), then GetOutput()")
    if data.IsA("vtkUniformGridAMR"):
        raise Unsupported(f"{source}: adaptive grids are drawn from files; write it by vtkXMLUniformGridAMRWriter and draw that")
    if data.IsA("vtkDataSet"):
        leaves = [("", data)]
    elif data.IsA("vtkCompositeDataSet"):
        leaves = list(_leaves(data))
    else:
        raise InvalidArgument(f"{source}: is not drawn; expected an image, a grid, a mesh, points or blocks of these")
    if not leaves or not leaves[0][1].GetNumberOfPoints():
        raise InvalidArgument(f"{source}: has no points")
    only = leaves[0][1]
    if len(leaves) == 1 and only.IsA("vtkImageData"):
        return _lattice(only, _image_place(only), source)
    if len(leaves) == 1 and only.IsA("vtkRectilinearGrid"):
        place = _even_place(_axes(only, source))
        if place is not None:
            return _lattice(only, place, source)
    notes, parts = [], []
    for block, leaf in leaves:
        parts.append(_part(leaf, notes))
        parts[-1].block = block
    if faces:
        parts = [_meshes.with_triangles(part) for part in parts]
    return _meshes.data_of_parts(source, parts, notes, "VTK", _active(only), faces)
