# SPDX-License-Identifier: Apache-2.0
"""VTK's data objects draw as the files that VTK writes of them, their memory is shared, and what is odd is told."""
import gc
from pathlib import Path

import numpy as np
import ovoid
import ovoid._meshes
import pytest
from conftest import FLAGS, SMALL, block, data_of, drawn_by_program, heat_at, pixels, png


@pytest.fixture(name="vtk")
def vtk_package():
    return pytest.importorskip("vtkmodules.all")


def vtk_array(vtk, values, name):
    kinds = {"f4": vtk.vtkFloatArray, "f8": vtk.vtkDoubleArray, "u1": vtk.vtkUnsignedCharArray, "i8": vtk.vtkIdTypeArray}
    array = kinds[np.asarray(values).dtype.str[1:]]()
    array.SetName(name)
    array.SetNumberOfComponents(values.shape[1] if values.ndim == 2 else 1)
    array.SetNumberOfTuples(len(values))
    np.frombuffer(array, values.dtype)[:] = values.ravel()
    return array


def vtk_points(vtk, points):
    made = vtk.vtkPoints()
    made.SetData(vtk_array(vtk, points, "places"))
    return made


def written(vtk, data, path):
    writers = {".vti": vtk.vtkXMLImageDataWriter, ".vtr": vtk.vtkXMLRectilinearGridWriter, ".vts": vtk.vtkXMLStructuredGridWriter,
               ".vtu": vtk.vtkXMLUnstructuredGridWriter, ".vtp": vtk.vtkXMLPolyDataWriter, ".vtm": vtk.vtkXMLMultiBlockDataWriter}
    writer = writers[path.suffix]()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    assert writer.Write()
    return path


def fill(vtk, data, cells=False):
    """Values of a field at its points or in its cells; they are not made active."""
    places = data
    if cells:
        middles = vtk.vtkCellCenters()
        middles.SetInputData(data)
        middles.Update()
        places = middles.GetOutput()
    heat = heat_at(np.array([places.GetPoint(i) for i in range(places.GetNumberOfPoints())]))
    (data.GetCellData() if cells else data.GetPointData()).AddArray(vtk_array(vtk, heat, "of cells" if cells else "heat"))
    return data


def image(vtk, kind=None):
    made = (kind or vtk.vtkImageData)()
    made.SetExtent(2, 12, -1, 9, 0, 7)
    made.SetSpacing(0.08, 0.09, 0.1)
    made.SetOrigin(0.9, -0.2, 0.1)
    made.SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1)
    return fill(vtk, fill(vtk, made), cells=True)


def rectilinear(vtk, power):
    made = vtk.vtkRectilinearGrid()
    made.SetDimensions(8, 9, 1 if power == 0 else 10)
    for letter, count in zip("XYZ", made.GetDimensions()):
        getattr(made, f"Set{letter}Coordinates")(vtk_array(vtk, np.linspace(0.1, 1, count) ** (power or 1), letter))
    return fill(vtk, made)


def structured(vtk):
    points, _, _ = block(7)
    made = vtk.vtkStructuredGrid()
    made.SetDimensions(7, 7, 7)
    made.SetPoints(vtk_points(vtk, points))
    return fill(vtk, fill(vtk, made), cells=True)


def unstructured(vtk, code=12, float_type="f8"):
    points, cells, _ = block()
    made = vtk.vtkUnstructuredGrid()
    made.SetPoints(vtk_points(vtk, points.astype(float_type)))
    made.Allocate(len(cells))
    for cell in cells:
        made.InsertNextCell(code, len(cell), cell[[0, 1, 3, 2, 4, 5, 7, 6]] if code == 11 else cell)
    return fill(vtk, fill(vtk, made), cells=True)


def with_ghosts(vtk):
    made = unstructured(vtk)
    bits = np.resize([0, 0, 0, 1, 32, 8, 0], 125).astype("u1")
    bits[40:] = 0
    made.GetCellData().AddArray(vtk_array(vtk, bits, "vtkGhostType"))
    nodes = np.zeros(216, "u1")
    nodes[[3, 100]] = 2
    made.GetPointData().AddArray(vtk_array(vtk, nodes, "vtkGhostType"))
    return made


def structured_with_ghosts(vtk):
    made = structured(vtk)
    made.GetCellData().AddArray(vtk_array(vtk, np.resize(np.repeat([0, 32], 36), 216).astype("u1"), "vtkGhostType"))
    return made


def sphere(vtk):
    source = vtk.vtkSphereSource()
    source.SetThetaResolution(20)
    source.SetPhiResolution(20)
    source.Update()
    return fill(vtk, source.GetOutput())


def vertices(vtk):
    made = vtk.vtkPolyData()
    points, _, _ = block()
    made.SetPoints(vtk_points(vtk, points))
    cells = vtk.vtkCellArray()
    for i in range(len(points)):
        cells.InsertNextCell(1, [i])
    made.SetVerts(cells)
    return fill(vtk, made, cells=True)


def blocks(vtk):
    made = vtk.vtkMultiBlockDataSet()
    whole = structured(vtk)
    for i, (lo, hi) in enumerate(((0, 4), (4, 6))):
        part = vtk.vtkExtractGrid()
        part.SetInputData(whole)
        part.SetVOI(0, 6, 0, 6, lo, hi)
        part.Update()
        made.SetBlock(i, part.GetOutput())
    inner = vtk.vtkMultiBlockDataSet()
    inner.SetBlock(0, fill(vtk, rectilinear(vtk, 1), cells=True))
    made.SetBlock(2, inner)
    made.SetBlock(3, None)
    return made


def cracked(vtk):
    """Two nodes of one block at the same place stay two; those of different ones become one."""
    made = vtk.vtkMultiBlockDataSet()
    for i, shift in enumerate((0, 0.25)):
        part = unstructured(vtk)
        places = np.frombuffer(part.GetPoints().GetData()).reshape(-1, 3)
        places[:, 2] = np.round(places[:, 2] * 64) / 64 + shift
        places[:, :2] = np.round(places[:, :2] * 64) / 64
        places[1] = places[0]
        made.SetBlock(i, part)
    return made


def blocks_that_share_nothing(vtk):
    made = vtk.vtkMultiBlockDataSet()
    made.SetBlock(0, rectilinear(vtk, 2))
    other = unstructured(vtk)
    other.GetPointData().GetArray("heat").SetName("other")
    for data in (made.GetBlock(0), other):
        data.GetPointData().AddArray(vtk_array(vtk, np.arange(data.GetNumberOfPoints()), "GlobalNodeId"))
    made.SetBlock(1, other)
    return made


def test_kinds_of_cells_are_the_readers(tmp_path, vtk):
    """VTK writes a cell of each kind, and the reader of files tells its kind; written again all are the same."""
    points = np.random.default_rng(2).random((30, 3))
    grid, cells = vtk.vtkUnstructuredGrid(), []
    grid.SetPoints(vtk_points(vtk, points))
    for name, (code, count) in ovoid._meshes._TYPES.items():
        nodes = np.arange(count or 4)
        cells.append((name, [nodes]))
        if name == "polyhedron":
            faces = vtk.vtkIdList()
            for number in [4, 3, 0, 1, 2, 3, 0, 1, 3, 3, 1, 2, 3, 3, 0, 2, 3]:
                faces.InsertNextId(number)
            grid.InsertNextCell(code, faces)
        else:
            grid.InsertNextCell(code, len(nodes), nodes)
    fill(vtk, grid)
    path, again = written(vtk, grid, tmp_path / "kinds.vtu"), [tmp_path / f"{way}.vtu" for way in ("read", "object", "arrays")]
    ovoid.write(again[0], ovoid.read(path))
    ovoid.write(again[1], grid)
    ovoid.write(again[2], ovoid.mesh(points, cells, {"heat": heat_at(points)}))
    assert again[0].read_bytes() == again[1].read_bytes() == again[2].read_bytes()
    for name, other in ovoid._meshes._VTK_NAMES.items():
        assert getattr(vtk, f"VTK_{name.upper()}") == ovoid._meshes._TYPES[other][0]


def test_bookkeeping_is_the_librarys():
    text = (Path(__file__).parents[2] / "src/data/bookkeeping.cpp").read_text(encoding="utf-8")
    assert all(f'"{name}"' in text for name in ovoid._meshes._BOOKKEEPING)


@pytest.mark.parametrize("make, ending, kind", [
    (image, ".vti", "lattice"),
    (lambda vtk: rectilinear(vtk, 1), ".vtr", "lattice"),
    (lambda vtk: rectilinear(vtk, 0), ".vtr", "lattice"),
    (lambda vtk: rectilinear(vtk, 2), ".vtr", "mesh"),
    (structured, ".vts", "mesh"),
    (structured_with_ghosts, ".vts", "mesh"),
    (unstructured, ".vtu", "mesh"),
    (lambda vtk: unstructured(vtk, 11, "f4"), ".vtu", "mesh"),
    (with_ghosts, ".vtu", "mesh"),
    (sphere, ".vtp", "particles"),
    (vertices, ".vtp", "particles"),
    (blocks, ".vtm", "mesh"),
    (blocks_that_share_nothing, ".vtm", "mesh"),
    (cracked, ".vtm", "mesh"),
])
def test_vtk_draws_as_its_files(tmp_path, vtk, make, ending, kind):
    data = make(vtk)
    path = written(vtk, data, tmp_path / f"data{ending}")
    ours, read = data_of(data), ovoid.read(path)
    assert ours.kind == read.kind == kind
    assert list(ours.arrays) == list(read.arrays) and len(ours.notes) == len(read.notes)
    if kind == "lattice":  # pictures look from where the data are
        assert np.allclose(ours.matrix, read.matrix, rtol=0, atol=1e-12)
    else:
        assert (ours.positions == read.positions).all() and (ours._core.connectivity() == read._core.connectivity()).all()
    picture = ovoid.render(data, **SMALL)
    assert picture.numpy().std() > 3 and png(picture) == drawn_by_program(path, *FLAGS)
    for array in ours.arrays:
        if array != "Normals":
            assert (pixels(data, array=array) == pixels(path, array=array)).all()


def test_vtk_memory_is_shared(vtk):
    for data in (image(vtk), structured(vtk), unstructured(vtk, float_type="f4")):
        ours = data_of(data)
        values = np.frombuffer(data.GetPointData().GetArray("heat"))
        assert np.shares_memory(ours.arrays["heat"], values)
        assert np.shares_memory(ours.arrays["of cells"], np.frombuffer(data.GetCellData().GetArray(0)))
        if hasattr(data, "GetPoints"):
            assert np.shares_memory(ours.positions, np.frombuffer(data.GetPoints().GetData(), ours.positions.dtype))


def test_vtk_lives_as_long_as_what_is_made_of_it(vtk):
    expected = pixels(image(vtk))
    scene = ovoid.Scene(image(vtk), **SMALL)
    gc.collect()
    taken = [image(vtk) for _ in range(3)]  # memory that was let go
    for other in taken:
        np.frombuffer(other.GetPointData().GetArray("heat"))[:] = 0.5
    assert (scene.render().numpy() == expected).all()


def test_vtk_cell_arrays_have_shapes(tmp_path, vtk):
    data = image(vtk)
    for ours in (data_of(data), ovoid.read(written(vtk, data, tmp_path / "a.vti"))):
        assert ours.arrays["heat"].shape == (8, 11, 11) and ours.arrays["of cells"].shape == (7, 10, 10)


def test_vtk_active_scalars(vtk):
    data = image(vtk)
    data.GetPointData().AddArray(vtk_array(vtk, np.arange(968.0), "ramp"))
    assert (pixels(data) == pixels(data, array="heat")).all()
    data.GetPointData().SetActiveScalars("ramp")
    assert (pixels(data) == pixels(data, array="ramp")).all() and (pixels(data) != pixels(data, array="heat")).any()
    assert (pixels(data, opacity=[0, 1]) == pixels(data, array="ramp", opacity=[(0, 0), (967, 1)])).all()
    mesh = unstructured(vtk)
    mesh.GetCellData().SetActiveScalars("of cells")
    assert (pixels(mesh) == pixels(mesh, array="of cells")).all()


def test_vtk_hidden_samples_are_missing(vtk):
    data = image(vtk, vtk.vtkUniformGrid)
    values = np.frombuffer(data.GetPointData().GetArray("heat"))
    holes = values.reshape(8, 11, 11).copy()
    holes[:, 5:, :] = np.nan
    data.GetPointData().AddArray(vtk_array(vtk, np.isnan(holes).ravel().astype("u1") * 2, "vtkGhostType"))
    ours = data_of(data)
    assert np.isnan(ours.arrays["heat"]).sum() == np.isnan(holes).sum() and not np.isnan(values).any()
    assert (pixels(data) != pixels(image(vtk))).any()


def test_vtk_subclasses_and_sets(vtk):
    """PyVista's classes are subclasses of VTK's in Python."""
    class ImageData(vtk.vtkImageData):
        points = cells = property(lambda self: 1 / 0)  # made when they are looked at, which is dear

    assert (pixels(image(vtk, ImageData)) == pixels(image(vtk))).all()
    pieces, collection = vtk.vtkPartitionedDataSet(), vtk.vtkPartitionedDataSetCollection()
    for i in range(2):
        pieces.SetPartition(i, blocks(vtk).GetBlock(i))
    collection.SetPartitionedDataSet(0, pieces)
    alike = vtk.vtkMultiBlockDataSet()
    for i in range(2):
        alike.SetBlock(i, pieces.GetPartition(i))
    assert (pixels(collection) == pixels(alike)).all() and (pixels(pieces) == pixels(alike)).all()
    only = vtk.vtkMultiBlockDataSet()
    only.SetBlock(1, image(vtk))
    assert data_of(only).kind == "lattice"


def test_vtk_odd_arrays_are_left_out(vtk):
    data = image(vtk)
    words = vtk.vtkStringArray()
    words.SetName("words")
    words.SetNumberOfTuples(968)
    short = vtk_array(vtk, np.zeros(5), "short")
    bits = vtk.vtkBitArray()
    bits.SetName("bits")
    bits.SetNumberOfTuples(968)
    unnamed = vtk_array(vtk, np.arange(968.0), "")
    for array in (words, short, bits, unnamed):
        data.GetPointData().AddArray(array)
    ours = data_of(data)
    assert set(ours.arrays) == {"heat", "of cells", "points4"}
    assert all(any(f"array '{name}'" in note for note in ours.notes) for name in ("words", "short", "bits"))
    units = vtk_array(vtk, np.arange(968.0), "warm")
    units.GetInformation().Set(vtk.vtkDataArray.UNITS_LABEL(), "K")
    data.GetPointData().AddArray(units)
    assert {array["name"]: array["unit"] for array in ovoid.info(data)["arrays"]}["warm"] == "K"


def broken_structured(vtk):
    made = structured(vtk)
    made.SetDimensions(7, 7, 8)
    return made


def broken_unstructured(vtk, node):
    made = unstructured(vtk)
    np.frombuffer(made.GetCells().GetConnectivityArray(), "i8")[17] = node
    return made


def broken_coordinates(vtk):
    made = rectilinear(vtk, 1)
    made.SetXCoordinates(vtk_array(vtk, np.zeros(3), "x"))
    return made


def bare_image(vtk):
    made = vtk.vtkImageData()
    made.SetDimensions(3, 3, 3)
    return made


def hidden(vtk):
    made = unstructured(vtk)
    made.GetCellData().AddArray(vtk_array(vtk, np.full(125, 32, "u1"), "vtkGhostType"))
    return made


@pytest.mark.parametrize("make, words", [
    (lambda vtk: vtk.vtkImageData(), "vtkImageData: has no points"),
    (lambda vtk: vtk.vtkUnstructuredGrid(), "vtkUnstructuredGrid: has no points"),
    (lambda vtk: vtk.vtkMultiBlockDataSet(), "has no points"),
    (bare_image, "vtkImageData: has no array of numbers"),
    (broken_structured, "has 343 points, dimensions"),
    (lambda vtk: broken_unstructured(vtk, 216), r"connectivity\[17\] = 216: expected the number of a node, 0 to 215"),
    (lambda vtk: broken_unstructured(vtk, -1), r"connectivity\[17\] = -1"),
    (broken_coordinates, "x coordinates: expected 8 numbers"),
    (hidden, "all 125 cells or points are hidden"),
    (lambda vtk: vtk.vtkSphereSource(), "expected what it makes"),
    (lambda vtk: vtk.vtkTable(), "vtkTable: is not drawn"),
    (lambda vtk: vtk.vtkFloatArray(), "vtkFloatArray: is not drawn"),
])
def test_bad_vtk(vtk, make, words):
    with pytest.raises(ovoid.InvalidArgument, match=words):
        ovoid.render(make(vtk))


def test_vtk_adaptive_grids_are_refused_in_words(vtk):
    with pytest.raises(ovoid.Unsupported, match="drawn from files"):
        ovoid.render(vtk.vtkOverlappingAMR())
    with pytest.raises(ovoid.InvalidArgument, match="say themselves where they are"):
        ovoid.render(image(vtk), spacing=(1, 1, 1))
