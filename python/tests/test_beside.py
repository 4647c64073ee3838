# SPDX-License-Identifier: Apache-2.0
"""Data in memory beside what is drawn: labels, further volumes, surfaces; they draw as their files do."""
import shlex
import subprocess

import numpy as np
import ovoid
import ovoid._view
import pytest
from conftest import FLAGS, PROGRAM, SMALL, bumps, drawn_by_program, png
from test_states import stand_in

PLACE = {"spacing": (0.5, 1, 2), "origin": (3, -4, 5)}


@pytest.fixture
def labels(array):
    """Two of them, between boxes of nothing."""
    found = np.zeros(array.shape, "i8")
    found[6:16, 6:18, 4:14] = 3
    found[2:8, 12:22, 18:26] = 7
    return found


@pytest.fixture
def scan_file(tmp_path, array):
    path = tmp_path / "scan.nrrd"
    ovoid.write(path, array, **PLACE)
    return path


def tetrahedron(**values):
    points = np.array([[4, -2, 10], [14, 4, 14], [6, 14, 20], [10, 6, 36]], "f4")
    return ovoid.mesh(points, {"triangle": np.array([[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]], "u4")}, **values)


def test_a_label_array_lies_where_the_scan_lies(tmp_path, array, labels, scan_file):
    ovoid.write(tmp_path / "labels.nrrd", labels.astype("u1"), **PLACE)
    expected = ovoid.render(scan_file, labels=tmp_path / "labels.nrrd", label_opacity="7=0.5", **SMALL)
    picture = ovoid.render(array, **PLACE, labels=labels, label_opacity="7=0.5", **SMALL)
    assert (picture.numpy() == expected.numpy()).all()
    assert (picture.numpy() != ovoid.render(array, **PLACE, **SMALL).numpy()).any()
    assert picture.command == "ovoid render data.nrrd --labels labels.nrrd --label-opacity 7=0.5 --size 96x72 -o picture.png"
    assert (ovoid.render(array, **PLACE, state=picture.state, labels=labels).numpy() == expected.numpy()).all()


def test_a_mask_of_bool(array, labels):
    assert (ovoid.render(array, labels=labels == 3, **SMALL).numpy() == ovoid.render(array, labels=(labels == 3).astype("u1"), **SMALL).numpy()).all()


def test_labels_of_another_grid(tmp_path, scan_file, labels):
    coarse = labels[::2, ::2, ::2]
    place = {"spacing": (1, 2, 4), "origin": (3, -4, 5)}
    ovoid.write(tmp_path / "coarse.nrrd", coarse.astype("u1"), **place)
    expected = ovoid.render(scan_file, labels=tmp_path / "coarse.nrrd", **SMALL)
    assert (ovoid.render(scan_file, labels=ovoid.lattice(coarse, **place), **SMALL).numpy() == expected.numpy()).all()


def test_labels_on_slices_in_colours_of_their_own(tmp_path, array, labels, scan_file):
    ovoid.write(tmp_path / "labels.nrrd", labels.astype("u1"), **PLACE)
    expected = drawn_by_program(scan_file, "--labels", str(tmp_path / "labels.nrrd"), "--slice", "z", "--slice", "1,0,0,9", "--slice-labels", "both", "--flat-labels",
                                "--slice-outline=white", "--label-color", "3=#ff8000,7=lime", "--label-opacity", "3=0.5,others=1", *FLAGS)
    picture = ovoid.render(array, **PLACE, labels=labels, slice=["z", (1, 0, 0, 9)], slice_labels="both", flat_labels=True, slice_outline="white",
                           label_color={3: (1, 0.5, 0), 7: "lime"}, label_opacity={3: 0.5, "others": 1}, **SMALL)
    assert png(picture) == expected
    assert (picture.numpy() != ovoid.render(array, **PLACE, labels=labels, slice=["z", (1, 0, 0, 9)], slice_labels="none", flat_labels=True, **SMALL).numpy()).any()
    drawn = picture.pick(*np.argwhere(np.isfinite(picture.depth))[0][::-1].tolist())
    assert drawn["shows"]


def test_names_in_a_dict(tmp_path, array, labels, scan_file):
    """Mean what a file of them means, and what the program takes as JSON."""
    ovoid.write(tmp_path / "labels.nrrd", labels.astype("u1"), **PLACE)
    (tmp_path / "names.ctbl").write_text("3 Liver 192 80 48 255\n7 spleen 0 0 255 102\n")
    expected = drawn_by_program(scan_file, "--labels", str(tmp_path / "labels.nrrd"), "--label-table", str(tmp_path / "names.ctbl"), "--label-opacity", "liver=0.3", *FLAGS)
    table = {np.int64(3): ("Liver", "#c05030"), 7: ["spleen", (0, 0, 1), 0.4]}
    picture = ovoid.render(array, **PLACE, labels=labels, label_table=table, label_opacity={"liver": 0.3}, **SMALL)
    assert png(picture) == expected
    told = picture.state["flags"]["label-table"]
    assert told == {"3": ["Liver", "#c05030"], "7": ["spleen", "#0000ff", 0.4]}
    assert png(ovoid.render(array, **PLACE, labels=labels, state=picture.state)) == expected
    words = shlex.split(picture.command)
    words[words.index("data.nrrd")], words[words.index("labels.nrrd")] = str(scan_file), str(tmp_path / "labels.nrrd")
    subprocess.run([PROGRAM, *words[1:-1], str(tmp_path / "again.png")], check=True, capture_output=True)
    assert (tmp_path / "again.png").read_bytes() == expected
    named = ovoid.render(array, **PLACE, labels=labels, label_table={3: "liver", 7: ("spleen", "blue")}, **SMALL)
    assert named.state["flags"]["label-table"] == {"3": "liver", "7": ["spleen", "#0000ff"]}
    seen = next(found for x in range(96) if (found := named.pick(x, 36))["shows"] and "label" in found)
    assert seen["label"]["name"] in ("liver", "spleen")


def test_the_scan_within_labels(tmp_path, array, labels, scan_file):
    ovoid.write(tmp_path / "labels.nrrd", labels.astype("u1"), **PLACE)
    expected = drawn_by_program(scan_file, "--labels", str(tmp_path / "labels.nrrd"), "--inside-labels", "3,7", *FLAGS)
    assert png(ovoid.render(array, **PLACE, labels=labels, inside_labels=[3, 7], **SMALL)) == expected


def test_channels_of_an_array(tmp_path):
    """Components, or the fields of a structured array."""
    first, second = bumps(), bumps()[:, ::-1]
    ovoid.write(tmp_path / "both.nrrd", np.stack([first, second], axis=-1))
    expected = drawn_by_program(tmp_path / "both.nrrd", "--channels", "1,0", "--channel-color", "red", "--channel-color", "0,0.5,1", "--channel-range", "20,150", *FLAGS)
    look = {"channel_color": ["red", (0, 0.5, 1)], "channel_range": (20, 150), **SMALL}
    assert png(ovoid.render(np.stack([first, second], axis=-1), channels=[1, 0], **look)) == expected
    named = np.zeros(first.shape, [("nuclei", "u1"), ("membranes", "u1")])
    named["nuclei"], named["membranes"] = first, second
    assert png(ovoid.render(named, channels=["membranes", "nuclei"], **look)) == expected


def test_volumes_over_one_another(tmp_path, array, scan_file):
    first, second = bumps()[::-1].copy(), bumps()[:, ::-1].copy()
    for name, values in (("first", first), ("second", second)):
        ovoid.write(tmp_path / f"{name}.nrrd", values, **PLACE)
    expected = ovoid.render(scan_file, over=[tmp_path / "first.nrrd", tmp_path / "second.nrrd"], over_colormap=["hot", "haline"], **SMALL)
    both = ovoid.render(array, **PLACE, over=[first, second], over_colormap=["hot", "haline"], **SMALL)
    looks = {"over_opacity": [[(60, 0), (150, 0.4)], [(20, 0), (90, 0.2)]], "over_range": [(10, 150), (0, 90)]}
    flags = ("--over-opacity", "60:0,150:0.4", "--over-opacity", "20:0,90:0.2", "--over-range", "10,150", "--over-range", "0,90")
    files = [word for name in ("first", "second") for word in ("--over", str(tmp_path / f"{name}.nrrd"))]
    assert png(ovoid.render(array, **PLACE, over=[first, second], **looks, **SMALL)) == drawn_by_program(scan_file, *files, *flags, *FLAGS)
    one = ovoid.render(array, **PLACE, over=first, over_opacity=[(60, 0), (150, 0.4)], **SMALL)
    assert png(one) == drawn_by_program(scan_file, *files[:2], "--over-opacity", "60:0,150:0.4", *FLAGS)
    mixed = ovoid.render(array, **PLACE, over=(tmp_path / "first.nrrd", second), over_colormap=["hot", "haline"], **SMALL)
    assert (both.numpy() == expected.numpy()).all() and (mixed.numpy() == expected.numpy()).all()
    assert "--over over.nrrd --over over-2.nrrd" in both.command


def test_a_file_with_the_name_of_what_is_in_memory(tmp_path, monkeypatch, array):
    monkeypatch.chdir(tmp_path)
    ovoid.write("over.nrrd", bumps()[::-1].copy())
    expected = ovoid.render(array, over=[bumps()[:, ::-1].copy(), bumps()[::-1].copy()], **SMALL)
    picture = ovoid.render(array, over=[bumps()[:, ::-1].copy(), "over.nrrd"], **SMALL)
    assert (picture.numpy() == expected.numpy()).all() and "--over over-2.nrrd --over over.nrrd" in picture.command


def test_surfaces_of_meshes(tmp_path, array, scan_file):
    mesh = tetrahedron(point_data={"heat": np.arange(4.0)})
    ovoid.write(tmp_path / "mesh.vtu", mesh)
    for settings in ({"add_color": "#4682b4"}, {"add_array": "heat"}):
        expected = ovoid.render(scan_file, add=tmp_path / "mesh.vtu", **settings, **SMALL)
        assert (ovoid.render(array, **PLACE, add=mesh, **settings, **SMALL).numpy() == expected.numpy()).all()


def test_meshes_beside_files(tmp_path, array, scan_file):
    """A list for each of several settings."""
    mesh = tetrahedron()
    ovoid.write(tmp_path / "mesh.vtu", mesh)
    (tmp_path / "lead.obj").write_text("v 4 0 10\nv 14 10 30\nl 1 2\n")
    files = [arg for path in (tmp_path / "mesh.vtu", tmp_path / "lead.obj") for arg in ("--add", str(path))]
    expected = drawn_by_program(scan_file, *files, "--add-opacity", "0.5", "--add-opacity", "0.75", "--add-radius", "1", "--add-radius", "0.5", "--add-color", "red",
                                "--add-color", "0,1,0", *FLAGS)
    picture = ovoid.render(array, **PLACE, add=[mesh, tmp_path / "lead.obj"], add_opacity=[0.5, 0.75], add_radius=np.array([1, 0.5]), add_color=["red", (0, 1, 0)], **SMALL)
    assert png(picture) == expected
    assert (ovoid.render(array, **PLACE, add=[], over=(), **SMALL).numpy() == ovoid.render(array, **PLACE, **SMALL).numpy()).all()


def test_surfaces_of_other_packages(array):
    vtk = pytest.importorskip("vtkmodules.vtkFiltersSources")
    ball = vtk.vtkSphereSource()
    ball.SetCenter(10, 8, 20)
    ball.SetRadius(4)
    ball.Update()
    triangles = ovoid.render(array, **PLACE, add=ball.GetOutput(), add_color="red", **SMALL)
    assert (triangles.numpy() != ovoid.render(array, **PLACE, **SMALL).numpy()).any()
    strips = pytest.importorskip("vtkmodules.vtkFiltersCore").vtkStripper()
    strips.SetInputConnection(ball.GetOutputPort())
    strips.Update()
    assert strips.GetOutput().GetNumberOfStrips() > 0
    assert (ovoid.render(array, **PLACE, add=strips.GetOutput(), add_color="red", **SMALL).numpy() == triangles.numpy()).all()


def test_polygons_are_split():
    """A pentagon and a strip between a line and a triangle; their values go with the pieces."""
    from ovoid._meshes import Part, with_triangles

    cells = np.array([3, 7, 6, 5], "u1"), np.array([0, 2, 7, 11, 14]), np.array([0, 1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 2, 3, 4], "u4")
    part = Part(np.zeros((9, 3)), cells, is_surface=True)
    part.arrays = [("number", np.arange(4.0), "", True)]
    made = with_triangles(part)
    assert made.types.tolist() == [3] + [5] * 6
    assert made.offsets.tolist() == [0, 2, 5, 8, 11, 14, 17, 20]
    assert made.connectivity.tolist() == [0, 1, 0, 1, 2, 0, 2, 3, 0, 3, 4, 5, 6, 7, 7, 6, 8, 2, 3, 4]
    assert made.arrays[0][1].tolist() == [0, 1, 1, 1, 2, 2, 3]


def test_a_mesh_without_values_stands_beside_others_alone(array):
    mesh = tetrahedron()
    assert (ovoid.render(array, **PLACE, add=mesh, **SMALL).numpy() != ovoid.render(array, **PLACE, **SMALL).numpy()).any()
    with pytest.raises(ovoid.InvalidArgument, match="'mesh': has no arrays"):
        ovoid.render(mesh, **SMALL)


@pytest.mark.parametrize("scale", [1e30, 1e100, 1e300])
@pytest.mark.parametrize("setting", ["add", "within"])
def test_corners_out_of_sight(array, setting, scale):
    """So far away that their places in the picture are no numbers: they ended the process."""
    points = np.array([[x, y, z] for z in (0, 19) for y, x in ((0, 0), (0, 27), (23, 27), (23, 0))], "f8")
    points[[7, 5, 1]] *= np.array([[1, -1, 1], [1, 1, -1], [-1, 1, 1]]) * scale
    points[2] *= scale
    try:
        ovoid.render(array, **{setting: ovoid.mesh(points, {"hexahedron": [range(8)]})}, **SMALL)
    except ovoid.Error as error:
        assert str(error)


def test_a_scene_keeps_what_stays(array, labels):
    scene = ovoid.Scene(array, **SMALL)
    first = scene.render(labels=labels)
    assert scene.render(labels=labels, azimuth=10).profile["model_ms"] == 0
    other = scene.render(labels=labels == 7)
    assert (other.numpy() != first.numpy()).any()
    assert (scene.render(labels=labels).numpy() == first.numpy()).all()


@pytest.mark.parametrize("settings, words", [
    ({"labels": np.zeros((2, 3, 4), "u1")}, r"labels: has the shape \(2, 3, 4\), the data \(20, 24, 28\): expected the same, or ovoid\.lattice"),
    ({"labels": np.full((20, 24, 28), 0.5)}, "labels"),
    ({"labels": tetrahedron(point_data={"heat": np.arange(4.0)})}, "--labels: is for lattices"),
    ({"over": tetrahedron(point_data={"heat": np.arange(4.0)})}, "--over: is for lattices"),
    ({"add": np.zeros((20, 24, 28))}, r"add = ndarray: expected a file, ovoid\.mesh"),
    ({"add": ovoid.lattice(np.zeros((20, 24, 28)))}, "holds a lattice, expected a surface"),
    ({"over": [["a.png", "b.png"], "c.nrrd"]}, r"over\[0\]: is a list of names, expected the name of a file or folder, or ovoid\.read\(names\)"),
    ({"labels": ["a.png", "b.png"]}, r"labels: is a list of names"),
    ({"labels": np.zeros((20, 24, 28), "u1"), "label_color": {3: (1, 2, 0)}}, r"\(1, 2, 0\): expected a colour"),
    ({"labels": np.zeros((20, 24, 28), "u1"), "label_color": {3: "reddish"}}, "label-color"),
    ({"label_table": {"liver": 1}}, r"label_table: 'liver' is no label; expected \{number: \"name\"\}"),
    ({"label_table": {1.5: "liver"}}, "label_table: 1.5 is no label"),
    ({"label_table": {1: 2}}, r"label_table: 1: 2: expected \{number"),
    ({"label_table": {1: ("liver", "reddish")}}, "'reddish'"),
    ({"label_table": {1: ("liver", (1, 2, 0))}}, r"\(1, 2, 0\): expected a colour"),
    ({"label_table": {1: ("liver", None, 2)}}, "--label-table: 1.* must be an opacity from 0 to 1"),
    ({"label_table": {}}, "--label-table: has no labels"),
    ({"label_table": 3}, "label_table: is int, expected the name of a file"),
    ({"over": np.zeros((20, 24, 28)), "over_transform": np.eye(4)}, r"over_transform: is ndarray, .*ovoid\.lattice\(array, affine"),
    ({"over": np.zeros((20, 24, 28)), "over_transform": [[1, 0], [0, 1]]}, r"over_transform: is list, expected the name of a file"),
    ({"within": 3}, r"within = int: expected a file, ovoid\.mesh"),
])
def test_what_cannot_stand_beside(array, settings, words):
    with pytest.raises(ovoid.Error, match=words):
        ovoid.render(array, **settings, **SMALL)


def test_an_array_beside_files_has_no_place(scan_file, labels):
    with pytest.raises(ovoid.InvalidArgument, match=r"is an array without a place, and the data are files: expected ovoid\.lattice"):
        ovoid.render(scan_file, labels=labels, **SMALL)


def test_the_window_gets_a_copy(tmp_path, monkeypatch, array, labels):
    stand_in(tmp_path, monkeypatch, "file = words[words.index('--labels') + 1]\nassert open(file, 'rb').read(4) == b'NRRD'\n"
             "json.dump({'ovoid_state': 1, 'inputs': inputs, 'flags': {'labels': file, 'size': '96x72'}}, open(kept, 'w'))")
    state = ovoid.view(array, labels=labels)
    assert state["flags"]["labels"] == "labels.nrrd"
    assert (ovoid.render(array, state=state, labels=labels).numpy() == ovoid.render(array, labels=labels, **SMALL).numpy()).all()
