# SPDX-License-Identifier: Apache-2.0
"""Meshes of plain arrays and of meshio draw as the files that hold the same; node numbers that are out of range are found before."""
import gc

import numpy as np
import ovoid
import pytest
from conftest import FLAGS, SMALL, block, data_of, drawn_by_program, pixels, png


def wedges_of(cells):
    return np.concatenate([cells[:, [0, 1, 3, 4, 5, 7]], cells[:, [1, 2, 3, 5, 6, 7]]])


@pytest.mark.parametrize("kind", ["hexahedron", "tetra", "wedge", "mixed", "polyhedron", "quad"])
def test_meshes_draw_as_their_files(tmp_path, kind):
    points, cells, heat = block()
    tetra = np.concatenate([cells[:, corners] for corners in ([0, 1, 3, 4], [1, 2, 3, 6], [1, 3, 4, 6], [3, 4, 6, 7], [1, 4, 5, 6])])
    given = {"hexahedron": {"hexahedron": cells}, "tetra": {"VTK_TETRA": tetra}, "wedge": {13: wedges_of(cells)},
             "mixed": [("hexahedron", cells[:60]), ("wedge", wedges_of(cells[60:])), ("vertex", [[0]])],
             "polyhedron": {"polyhedron": [[cell[[0, 1, 2, 3]], cell[[4, 5, 6, 7]], cell[[0, 1, 5, 4, 0]]] for cell in cells]},
             "quad": {"quad": cells[:25, :4]}}[kind]
    mesh = ovoid.mesh(points, given, {"heat": heat, "place": points})
    ovoid.write(tmp_path / "mesh.vtu", mesh)
    assert mesh.kind == "mesh" and pixels(mesh).std() > 3
    assert png(ovoid.render(mesh, **SMALL)) == drawn_by_program(tmp_path / "mesh.vtu", *FLAGS)


def test_mesh_memory_is_shared():
    points, cells, heat = block()
    for nodes in (cells.astype("u4"), cells.astype("i4")):
        mesh = ovoid.mesh(points, {"hexahedron": nodes}, {"heat": heat})
        assert np.shares_memory(mesh._core.connectivity(), nodes)
        assert np.shares_memory(mesh.positions, points) and np.shares_memory(mesh.arrays["heat"], heat)
    copied = ovoid.mesh(points, {"hexahedron": cells}, {"heat": heat})._core.connectivity()
    assert not np.shares_memory(copied, cells) and (copied == cells.ravel()).all()


def test_mesh_lives_as_long_as_what_is_made_of_it():
    points, cells, heat = block()
    expected = pixels(ovoid.mesh(points, {"hexahedron": cells}, {"heat": heat}))
    scene = ovoid.Scene(ovoid.mesh(points.copy(), {"hexahedron": cells.astype("u4")}, {"heat": heat.copy()}), **SMALL)
    gc.collect()
    _ = [np.full(points.shape, 7.0), np.full(cells.shape, 9, "u4"), np.full(heat.shape, 5.0)]  # take memory that was let go
    assert (scene.render().numpy() == expected).all()


def test_cell_data_of_each_kind():
    points, cells, _ = block()
    kinds = {"hexahedron": cells[:60], "wedge": wedges_of(cells[60:])}
    values = [np.arange(60.0), np.arange(130.0)]
    expected = pixels(ovoid.mesh(points, kinds, cell_data={"c": np.concatenate(values)}))
    for given in (values, dict(zip(kinds, values))):
        assert (pixels(ovoid.mesh(points, kinds, cell_data={"c": given})) == expected).all()
    assert (pixels(ovoid.mesh(points, kinds, cell_data={"c": np.zeros(190)})) != expected).any()


def test_plane_points():
    points, cells, heat = block()
    flat = ovoid.mesh(points[:36, :2], {"quad": cells[:25, :4]}, {"heat": heat[:36]})
    assert (flat.positions == np.column_stack([points[:36, :2], np.zeros(36)])).all()
    assert (pixels(flat) == pixels(ovoid.mesh(flat.positions, {"quad": cells[:25, :4]}, {"heat": heat[:36]}))).all()


TETRA = {"tetra": [[0, 1, 2, 3]]}
HEAT = {"heat": [1.0, 2, 3, 4]}


@pytest.mark.parametrize("points, cells, point_data, cell_data, words", [
    (4, {"tetra": [[0, 1, 2, 4]]}, HEAT, None, r"cells\['tetra'\]\[0, 3\] = 4: expected the number of a node, 0 to 3"),
    (4, {"tetra": [[0, 1, -2, 3]]}, HEAT, None, r"\[0, 2\] = -2: expected"),
    (4, {"tetra": np.array([[0, 1, 2, 2**63 + 1]], "u8")}, HEAT, None, "expected the number of a node"),
    (4, {"tetra": np.array([[0, 1, 2, 2**31 + 1]], "u4")}, HEAT, None, "expected the number of a node"),
    (4, {"tetra": [[0, 1, 2]]}, HEAT, None, r"shape \(1, 3\), expected \(n, 4\)"),
    (4, {"tetra": [0, 1, 2, 3]}, HEAT, None, r"shape \(4,\), expected \(n, 4\)"),
    (4, {"tetra": [[0, 1, 2, 3.5]]}, HEAT, None, "expected numbers of nodes: integers"),
    (4, {"tetra": [[0, 1, 2, 3], [0, 1]]}, HEAT, None, r"cells\['tetra'\]: .*inhomogeneous"),
    (4, {"polygon": [[0, 1, 2], [0, 9]]}, HEAT, None, "= 9: expected the number of a node"),
    (4, {"polygon": [1, 2]}, HEAT, None, "expected the nodes of a cell"),
    (4, {"polyhedron": [[[0, 1, 2], [0, 1.5]]]}, HEAT, None, "expected numbers of nodes: integers"),
    (4, {"tetrra": [[0, 1, 2, 3]]}, HEAT, None, "'tetrra': unknown kind of cells; did you mean tetra"),
    (4, {None: [[0, 1, 2, 3]]}, HEAT, None, "expected the name of a kind of cells"),
    (4, {300: [[0, 1, 2, 3]]}, HEAT, None, "expected VTK's number"),
    (4, {}, HEAT, None, "cells: there are none; points alone are drawn by ovoid.particles"),
    (4, {"tetra": np.zeros((0, 4), int)}, HEAT, None, "cells: there are none"),
    (4, 5, HEAT, None, "cells: is a int, expected a dict"),
    (4, [[[0, 1, 2, 3]]], HEAT, None, "cells: is a list, expected a dict"),
    (4, TETRA, {"heat": [1.0, 2]}, None, r"heat: has the shape \(2,\), expected one or more for each of 4 points"),
    (4, TETRA, {"heat": list("abcd")}, None, "heat: holds <U1, expected numbers"),
    (4, TETRA, 5, None, "point_data: is a int, expected a dict"),
    (4, TETRA, None, {"c": [1.0, 2]}, "for each of 1 cells"),
    (4, TETRA, None, {"c": {"wedge": [1.0]}}, "c: expected values for each kind of cells: tetra"),
    (4, TETRA, None, {"c": [[1.0, 2]]}, "c: has .* values, expected"),
    (0, TETRA, HEAT, None, r"points: has the shape \(0, 3\)"),
    (np.zeros((4, 4)), TETRA, HEAT, None, r"points: has the shape \(4, 4\), expected \(n, 3\) or \(n, 2\)"),
    (np.full((4, 3), np.inf), TETRA, HEAT, None, r"points\[0, 0\] = inf: expected a finite number"),
    ("abc", TETRA, HEAT, None, "points: holds <U3"),
])
def test_bad_meshes(points, cells, point_data, cell_data, words):
    points = np.eye(4, 3)[:points] if isinstance(points, int) else points
    with pytest.raises(ovoid.InvalidArgument, match=words):
        ovoid.mesh(points, cells, point_data, cell_data)


class Block:
    def __init__(self, type, data):
        self.type, self.data = type, data


class Mesh:
    """What meshio.Mesh has."""

    def __init__(self, points, cells, point_data=None, cell_data=None):
        self.points, self.cells = points, [Block(*pair) for pair in cells]
        self.point_data, self.cell_data = point_data or {}, cell_data or {}


def test_meshio(tmp_path):
    """The package itself where it is; its files then hold the same as its objects."""
    points, cells, heat = block()
    wedges = wedges_of(cells[60:])
    blocks = [("hexahedron", cells[:60]), ("wedge", wedges[:, [0, 2, 1, 3, 5, 4]])]  # as meshio has them
    arrays = {"heat": heat}, {"c": [np.arange(60.0), np.arange(130.0)]}
    mesh = Mesh(points, blocks, *arrays)
    expected = ovoid.mesh(points, {"hexahedron": cells[:60], "wedge": wedges}, *arrays)
    assert (data_of(mesh)._core.connectivity() == expected._core.connectivity()).all()
    assert np.shares_memory(data_of(mesh).positions, points)
    mesh.point_data["words"] = np.array(["a"] * len(points))
    assert "array 'words' is left out" in data_of(mesh).notes[0] and data_of(mesh).notes[0] in ovoid.render(mesh, **SMALL).notes
    for array in ("heat", "c"):
        assert (pixels(mesh, array=array) == pixels(expected, array=array)).all()
    mesh.cells[1].data[0, 0] = 999
    with pytest.raises(ovoid.InvalidArgument, match=r"cells\['wedge'\]\[0, 0\] = 999"):
        ovoid.render(mesh)
    meshio = pytest.importorskip("meshio")
    del arrays[0]["words"]
    real = meshio.Mesh(points, [("hexahedron", cells[:60]), ("wedge", wedges[:, [0, 2, 1, 3, 5, 4]])], *arrays)
    real.write(tmp_path / "mesh.vtu")
    assert png(ovoid.render(real, **SMALL)) == drawn_by_program(tmp_path / "mesh.vtu", *FLAGS)
    assert (data_of(real)._core.connectivity() == ovoid.read(tmp_path / "mesh.vtu")._core.connectivity()).all()


def test_vertices_alone_are_particles():
    points, _, heat = block()
    for cells in ([], [("vertex", np.arange(len(points))[:, np.newaxis])]):
        data = data_of(Mesh(points, cells, {"heat": heat}))
        assert data.kind == "particles" and (pixels(data) == pixels(ovoid.particles(points, {"heat": heat}))).all()
