#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Damages files and lets the program read them: mutants.py PROGRAM [--count N] [--seed S] [FILE...]

Makes small files of the formats that other people's libraries read, or takes the files that are named
(with all files that they consist of), damages one of the files of each N times, and runs `PROGRAM convert`
on the result. A secret file lies beside every input, a secret variable in the environment, and some of the
damage puts their names where a file's name stood.

Counted as failures: the program ended by a signal or an exit code above 3 (no memory), took more than 10 s, printed a message of more than one
line (notes are lines of their own) or of more than 2000 bytes, or wrote a secret into its output. Prints a
table; exits with 1 if anything failed. The same seed gives the same mutants.
"""
import argparse
import concurrent.futures
import json
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from hdf5_file import Hdf5File

SECRET = b"ovoid-secret-7f3a91"
LONGEST_SECONDS = 10
LONGEST_MESSAGE = 2000
# What the kinds of data are converted to.
ENDINGS = {"lattice": ".vti", "mesh": ".vtu", "particles": ".csv"}

# --- seeds ------------------------------------------------------------------------------------------------


def xml(kind, inner, byte_order="LittleEndian"):
    return f'<VTKFile type="{kind}" version="0.1" byte_order="{byte_order}">{inner}</VTKFile>\n'


def array(values, kind="Float32", name="v", components=1):
    text = " ".join(str(v) for v in values)
    return f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii">{text}</DataArray>'


def grid_points(nx, ny, nz, bend=0.1):
    return [c for k in range(nz) for j in range(ny) for i in range(nx) for c in (i + bend * j, j, k + bend * i)]


def cube_faces(first=0):
    quads = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    return [[first + n for n in quad] for quad in quads]


CUBE = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1]


def vtu():
    points = array(CUBE + [2, 0.5, 0.5], name="Points", components=3)
    cells = (array([0, 1, 2, 3, 4, 5, 6, 7, 1, 2, 6, 8], "Int64", "connectivity") +
             array([8, 12], "Int64", "offsets") + array([12, 10], "UInt8", "types"))
    return xml("UnstructuredGrid", '<UnstructuredGrid><Piece NumberOfPoints="9" NumberOfCells="2">'
               f'<PointData>{array(range(9))}</PointData><CellData>{array([1, 2], name="c")}</CellData>'
               f"<Points>{points}</Points><Cells>{cells}</Cells></Piece></UnstructuredGrid>")


def polyhedra_vtu():
    faces = cube_faces()
    stream = [len(faces)] + [n for face in faces for n in [len(face)] + face]
    cells = (array(range(8), "Int64", "connectivity") + array([8], "Int64", "offsets") +
             array([42], "UInt8", "types") + array(stream, "Int64", "faces") +
             array([len(stream)], "Int64", "faceoffsets"))
    return xml("UnstructuredGrid", '<UnstructuredGrid><Piece NumberOfPoints="8" NumberOfCells="1">'
               f'<PointData>{array(range(8))}</PointData><Points>{array(CUBE, name="Points", components=3)}</Points>'
               f"<Cells>{cells}</Cells></Piece></UnstructuredGrid>")


def legacy(dataset, num_points, binary=False):
    head = f"# vtk DataFile Version 3.0\nseed\n{'BINARY' if binary else 'ASCII'}\n{dataset}"
    return head + f"POINT_DATA {num_points}\nSCALARS v float\nLOOKUP_TABLE default\n" + \
        " ".join(str(i * 0.5) for i in range(num_points)) + "\n"


def polyhedra_legacy():
    faces = cube_faces()
    stream = [len(faces)] + [n for face in faces for n in [len(face)] + face]
    cells = f"CELLS 1 {len(stream) + 1}\n{len(stream)} " + " ".join(map(str, stream)) + "\nCELL_TYPES 1\n42\n"
    return legacy("DATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n" + " ".join(map(str, CUBE)) + "\n" + cells, 8)


def exodus():
    """A classic netCDF file as Exodus lays it out: eight nodes, one hexahedron, two steps of one variable."""

    def name(text):
        data = text.encode()
        return struct.pack(">i", len(data)) + data + b"\0" * (-len(data) % 4)

    dims = [("len_string", 33), ("len_line", 81), ("four", 4), ("time_step", 0), ("num_dim", 3), ("num_nodes", 8),
            ("num_elem", 1), ("num_el_blk", 1), ("num_el_in_blk1", 1), ("num_nod_per_el1", 8), ("num_nod_var", 1)]
    index = {d[0]: i for i, d in enumerate(dims)}
    floats = lambda values: struct.pack(f">{len(values)}d", *values)
    ints = lambda values: struct.pack(f">{len(values)}i", *values)
    char, integer, double = 2, 4, 6
    fixed = [("eb_status", ["num_el_blk"], integer, ints([1]), []),
             ("eb_prop1", ["num_el_blk"], integer, ints([1]), [("name", b"ID")]),
             ("coordx", ["num_nodes"], double, floats(CUBE[0::3]), []),
             ("coordy", ["num_nodes"], double, floats(CUBE[1::3]), []),
             ("coordz", ["num_nodes"], double, floats(CUBE[2::3]), []),
             ("connect1", ["num_el_in_blk1", "num_nod_per_el1"], integer, ints(range(1, 9)),
              [("elem_type", b"HEX8")]),
             ("name_nod_var", ["num_nod_var", "len_string"], char, b"temp".ljust(33, b"\0") + b"\0" * 3, [])]
    records = [("time_whole", ["time_step"], double, [floats([0.0]), floats([1.0])], []),
               ("vals_nod_var1", ["time_step", "num_nodes"], double, [floats(range(8)), floats(range(8, 16))], [])]

    def attributes(pairs):
        if not pairs:
            return struct.pack(">ii", 0, 0)
        out = struct.pack(">ii", 12, len(pairs))
        for key, value in pairs:
            if isinstance(value, bytes):
                out += name(key) + struct.pack(">ii", char, len(value)) + value + b"\0" * (-len(value) % 4)
            elif isinstance(value, float):
                out += name(key) + struct.pack(">iif", 5, 1, value)
            else:
                out += name(key) + struct.pack(">iii", integer, 1, value)
        return out

    def header(begins):
        out = b"CDF\x01" + struct.pack(">i", 2)
        out += struct.pack(">ii", 10, len(dims)) + b"".join(name(n) + struct.pack(">i", s) for n, s in dims)
        out += attributes([("api_version", 4.98), ("version", 4.98), ("floating_point_word_size", 8),
                           ("file_size", 1), ("title", b"seed")])
        variables = fixed + records
        out += struct.pack(">ii", 11, len(variables))
        for (label, axes, kind, data, pairs), begin in zip(variables, begins):
            size = len(data) if isinstance(data, bytes) else len(data[0])
            out += name(label) + struct.pack(">i", len(axes)) + b"".join(struct.pack(">i", index[a]) for a in axes)
            out += attributes(pairs) + struct.pack(">iii", kind, size, begin)
        return out

    at = len(header([0] * (len(fixed) + len(records))))
    begins = []
    for variable in fixed:
        begins.append(at)
        at += len(variable[3])
    for variable in records:
        begins.append(at)
        at += len(variable[3][0])
    body = b"".join(v[3] for v in fixed) + b"".join(v[3][step] for step in range(2) for v in records)
    return header(begins) + body


def vtk_hdf_image(path):
    with Hdf5File(path) as file:
        file.group("VTKHDF")
        file.attribute("VTKHDF", "Version", [1, 0])
        file.attribute("VTKHDF", "Type", b"ImageData")
        file.attribute("VTKHDF", "WholeExtent", [0, 3, 0, 2, 0, 1])
        file.attribute("VTKHDF", "Origin", [0, 0, 0], "f8")
        file.attribute("VTKHDF", "Spacing", [1, 1, 1], "f8")
        file.attribute("VTKHDF", "Direction", [1, 0, 0, 0, 1, 0, 0, 0, 1], "f8")
        file.group("VTKHDF/PointData")
        file.dataset("VTKHDF/PointData/v", "f4", range(24), [2, 3, 4])


def xdmf_hdf5(path):
    with Hdf5File(path) as file:
        file.dataset("v", "f4", range(8), [2, 2, 2])


def vtk_hdf_mesh(path):
    with Hdf5File(path) as file:
        file.group("VTKHDF")
        file.attribute("VTKHDF", "Version", [1, 0])
        file.attribute("VTKHDF", "Type", b"UnstructuredGrid")
        for name, value in (("Points", 9), ("Cells", 2), ("ConnectivityIds", 12)):
            file.dataset(f"VTKHDF/NumberOf{name}", "i8", [value])
        file.dataset("VTKHDF/Points", "f4", CUBE + [2, 0.5, 0.5], [9, 3])
        file.dataset("VTKHDF/Connectivity", "i8", [0, 1, 2, 3, 4, 5, 6, 7, 1, 2, 6, 8])
        file.dataset("VTKHDF/Offsets", "i8", [0, 8, 12])
        file.dataset("VTKHDF/Types", "u1", [12, 10])
        file.group("VTKHDF/PointData")
        file.dataset("VTKHDF/PointData/v", "f4", range(9))


def gltf():
    """The text of a tetrahedron whose numbers are in a.bin, and these."""
    places = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]
    faces = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    text = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
            "nodes": [{"children": [1], "scale": [2, 2, 2]}, {"mesh": 0, "translation": [3, 0, 0]}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
            "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                           "min": [0, 0, 0], "max": [1, 1, 1]},
                          {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
            "buffers": [{"uri": "a.bin", "byteLength": 72}]}
    return json.dumps(text), struct.pack("<12f12H", *places, *faces)


def enzo(folder):
    """A root grid of 4^3 cells and a finer one of 4^3 in its middle, each with three ghost cells on all sides."""

    def grid(number, left, right, pointers):
        return (f"\nGrid = {number}\nGridRank          = 3\nGridDimension     = 10 10 10\n"
                "GridStartIndex    = 3 3 3\nGridEndIndex      = 6 6 6\n"
                f"GridLeftEdge      = {left} {left} {left}\nGridRightEdge     = {right} {right} {right}\n"
                "Time              = 0.5\nSubgridsAreStatic = 0\nNumberOfBaryonFields = 1\nFieldType = 0\n"
                "BaryonFileName = ./a.cpu0000\nNumberOfParticles   = 0\nGravityBoundaryType = 0\n" +
                "".join(f"Pointer: Grid[{number}]->{p}\n" for p in pointers))

    (folder / "a.hierarchy").write_text(
        grid(1, 0, 1, ["NextGridThisLevel = 0", "NextGridNextLevel = 2"]) +
        grid(2, 0.25, 0.75, ["NextGridThisLevel = 0", "NextGridNextLevel = 0"]))
    (folder / "a").write_text("InitialCycleNumber  = 10\nInitialTime         = 0.5\nTopGridRank = 3\n"
                              "TopGridDimensions   = 4 4 4\nDataLabel[0] = Density\n")
    (folder / "a.boundary").write_text("BoundaryRank = 3\n")
    with Hdf5File(folder / "a.cpu0000") as file:
        for number in (1, 2):
            file.group(f"Grid{number:08d}")
            file.dataset(f"Grid{number:08d}/Density", "f8", range(64), [4, 4, 4])


def write(folder, files):
    for name, content in files.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def seeds(folder, program):
    """One folder for each format, with the input's name."""
    made = {}

    def add(kind, first, files):
        place = folder / kind
        place.mkdir()
        write(place, {first: files.pop(first), **files})
        made[kind] = place / first

    image = '<ImageData WholeExtent="0 3 0 2 0 1" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 3 0 2 0 1">' \
            f"<PointData>{array(range(24))}</PointData></Piece></ImageData>"
    add("vti", "a.vti", {"a.vti": xml("ImageData", image)})
    axes = array([0, 1, 3, 4], name="x") + array([0, 1, 2], name="y") + array([0, 1], name="z")
    add("vtr", "a.vtr", {"a.vtr": xml("RectilinearGrid", '<RectilinearGrid WholeExtent="0 3 0 2 0 1">'
        f'<Piece Extent="0 3 0 2 0 1"><PointData>{array(range(24))}</PointData><Coordinates>{axes}</Coordinates>'
        "</Piece></RectilinearGrid>")})
    points = array(grid_points(4, 3, 2), name="Points", components=3)
    add("vts", "a.vts", {"a.vts": xml("StructuredGrid", '<StructuredGrid WholeExtent="0 3 0 2 0 1">'
        f'<Piece Extent="0 3 0 2 0 1"><PointData>{array(range(24))}</PointData><Points>{points}</Points>'
        "</Piece></StructuredGrid>")})
    add("vtu", "a.vtu", {"a.vtu": vtu()})
    verts = array([0, 1, 2, 3], "Int64", "connectivity") + array([1, 2, 3, 4], "Int64", "offsets")
    add("vtp", "a.vtp", {"a.vtp": xml("PolyData", '<PolyData><Piece NumberOfPoints="4" NumberOfVerts="4" '
        'NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="0">'
        f'<PointData>{array(range(4))}</PointData><Points>{array(CUBE[:12], name="Points", components=3)}</Points>'
        f"<Verts>{verts}</Verts></Piece></PolyData>")})
    piece_image = '<ImageData WholeExtent="0 2 0 2 0 2" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 2 0 2 0 2">' \
                  f"<PointData>{array(range(27))}</PointData></Piece></ImageData>"
    add("pvti", "a.pvti", {"a.pvti": xml("PImageData", '<PImageData WholeExtent="0 2 0 2 0 4" GhostLevel="0">'
        '<Piece Extent="0 2 0 2 0 2" Source="p0.vti"/><Piece Extent="0 2 0 2 2 4" Source="p1.vti"/></PImageData>'),
        "p0.vti": xml("ImageData", piece_image),
        "p1.vti": xml("ImageData", piece_image.replace("0 2 0 2 0 2", "0 2 0 2 2 4"))})
    add("pvtu", "a.pvtu", {"a.pvtu": xml("PUnstructuredGrid", '<PUnstructuredGrid GhostLevel="0">'
        '<Piece Source="p0.vtu"/><Piece Source="p1.vtu"/></PUnstructuredGrid>'), "p0.vtu": vtu(), "p1.vtu": vtu()})
    add("vtm", "a.vtm", {"a.vtm": xml("vtkMultiBlockDataSet", '<vtkMultiBlockDataSet><Block index="0" name="b">'
        '<DataSet index="0" name="one" file="p0.vtu"/></Block><DataSet index="1" file="p1.vtu"/>'
        "</vtkMultiBlockDataSet>"), "p0.vtu": vtu(), "p1.vtu": vtu()})
    add("pvd", "a.pvd", {"a.pvd": xml("Collection", '<Collection><DataSet timestep="0" file="p0.vtu"/>'
        '<DataSet timestep="1" file="p1.vtu"/></Collection>'), "p0.vtu": vtu(), "p1.vtu": vtu()})
    cell_image = '<ImageData WholeExtent="0 2 0 2 0 2" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 2 0 2 0 2">' \
                 f"<CellData>{array(range(8))}</CellData></Piece></ImageData>"
    add("vthb", "a.vthb", {"a.vthb": xml("vtkOverlappingAMR", '<vtkOverlappingAMR origin="0 0 0">'
        '<Block level="0" spacing="1 1 1"><DataSet index="0" amr_box="0 1 0 1 0 1" file="g.vti"/></Block>'
        "</vtkOverlappingAMR>"), "g.vti": xml("ImageData", cell_image)})
    text, numbers = gltf()
    add("glTF", "a.gltf", {"a.gltf": text, "a.bin": numbers})
    text = text.replace('"uri": "a.bin", ', "").encode()
    chunks = b"".join(struct.pack("<I4s", len(part), kind) + part
                      for kind, part in ((b"JSON", text + b" " * (-len(text) % 4)), (b"BIN\0", numbers)))
    add("glTF binary", "a.glb", {"a.glb": b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks})
    add("legacy image", "a.vtk", {"a.vtk": legacy("DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 0 0 0\n"
                                                  "SPACING 1 1 1\n", 12)})
    add("legacy rectilinear", "a.vtk", {"a.vtk": legacy("DATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 2\n"
        "X_COORDINATES 3 float\n0 1 3\nY_COORDINATES 2 float\n0 1\nZ_COORDINATES 2 float\n0 1\n", 12)})
    add("legacy structured", "a.vtk", {"a.vtk": legacy("DATASET STRUCTURED_GRID\nDIMENSIONS 3 2 2\nPOINTS 12 float\n" +
        " ".join(map(str, grid_points(3, 2, 2))) + "\n", 12)})
    add("legacy cells", "a.vtk", {"a.vtk": legacy("DATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n" +
        " ".join(map(str, CUBE)) + "\nCELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 0 1 2 5\nCELL_TYPES 2\n12\n10\n", 8)})
    add("legacy polydata", "a.vtk", {"a.vtk": legacy("DATASET POLYDATA\nPOINTS 8 float\n" + " ".join(map(str, CUBE)) +
        "\nVERTICES 2 6\n3 0 1 2\n1 3\nPOLYGONS 1 5\n4 4 5 6 7\n", 8)})
    add("polyhedra vtu", "a.vtu", {"a.vtu": polyhedra_vtu()})
    add("polyhedra vtk", "a.vtk", {"a.vtk": polyhedra_legacy()})
    add("Exodus", "a.e", {"a.e": exodus()})
    coordinates = "\n".join(f"{CUBE[3 * i + axis]:12.5e}" for axis in range(3) for i in range(8))
    add("EnSight", "a.case", {
        "a.case": "FORMAT\ntype: ensight gold\n\nGEOMETRY\nmodel: a.geo\n\nVARIABLE\nscalar per node: v a.v***\n\n"
                  "TIME\ntime set: 1\nnumber of steps: 2\nfilename start number: 0\nfilename increment: 1\n"
                  "time values: 0.0 1.0\n",
        "a.geo": "seed\ngeometry\nnode id assign\nelement id assign\npart\n         1\ncube\ncoordinates\n"
                 f"         8\n{coordinates}\nhexa8\n         1\n" + "".join(f"{n:10d}" for n in range(1, 9)) + "\n",
        "a.v000": "v\npart\n         1\ncoordinates\n" + "\n".join(f"{i:12.5e}" for i in range(8)) + "\n",
        "a.v001": "v\npart\n         1\ncoordinates\n" + "\n".join(f"{i + 8:12.5e}" for i in range(8)) + "\n"})
    for kind, first, make in (("VTKHDF image", "a.vtkhdf", vtk_hdf_image), ("VTKHDF mesh", "a.vtkhdf", vtk_hdf_mesh),
                              ("Enzo", "a.hierarchy", lambda path: enzo(path.parent))):
        add(kind, first, {first: b""})
        make(made[kind])
    for kind in ("inline", "HDF5"):
        item = '<DataItem Dimensions="2 2 2" NumberType="Float" '
        text = " ".join(map(str, range(8))) if kind == "inline" else "a.h5:/v"
        add(f"XDMF {kind}", "a.xdmf", {"a.xdmf":
            '<Xdmf Version="3.0"><Domain><Grid Name="a" GridType="Collection" CollectionType="Temporal"><Grid>'
            '<Topology TopologyType="Hexahedron" NumberOfElements="1"><DataItem Dimensions="1 8" NumberType="Int">'
            '0 1 2 3 4 5 6 7</DataItem></Topology><Geometry GeometryType="XYZ"><DataItem Dimensions="8 3">' +
            " ".join(map(str, CUBE)) + '</DataItem></Geometry><Time Value="1"/><Attribute Name="v" Center="Node">' +
            item + ('Format="HDF">' if kind == "HDF5" else ">") + text +
            "</DataItem></Attribute></Grid></Grid></Domain></Xdmf>\n"})
    xdmf_hdf5(made["XDMF HDF5"].parent / "a.h5")
    make_vdb = Path(program).parent / "make_vdb"  # of the build's tests; without OpenVDB it is not there
    if make_vdb.exists():
        with tempfile.TemporaryDirectory() as place:
            subprocess.run([make_vdb, place], check=True)
            for kind in ("kinds", "points", "zip", "tiles"):
                add(f"OpenVDB {kind}", "a.vdb", {"a.vdb": (Path(place) / f"{kind}.vdb").read_bytes()})
    place = folder / "HDF5 lattice"
    place.mkdir()
    subprocess.run([program, "make", "ball", "-o", place / "a.h5", "--size", "8"], check=True, capture_output=True)
    made["HDF5 lattice"] = place / "a.h5"
    for name in ("fin", "ball"):
        ending = ".vtu" if name == "fin" else ".vti"
        place = folder / f"compressed {ending[1:]}"
        place.mkdir()
        size = ["--count", "60"] if name == "fin" else ["--size", "6"]
        subprocess.run([program, "make", name, "-o", place / f"a{ending}", *size], check=True, capture_output=True)
        made[place.name] = place / f"a{ending}"
    return made


# --- damage -----------------------------------------------------------------------------------------------

ABSURD = [b"-1", b"0", b"1", b"7", b"255", b"65536", b"2147483647", b"2147483648", b"-2147483648", b"4294967296",
          b"99999999999", b"9223372036854775807", b"1e30", b"-1e300", b"nan", b"inf", b"0x10", b"+8", b"1.5", b""]
EXTREME = [0, 1, 2, 7, 42, 127, 255, 256, 32767, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**40, 2**63 - 1,
           2**64 - 1]


def replace_token(data, rng, pattern, choices):
    found = list(re.finditer(pattern, data))
    if not found:
        return data
    token = rng.choice(found)
    return data[:token.start()] + rng.choice(choices) + data[token.end():]


def damage_once(data, rng, secrets):
    how = rng.randrange(10)
    at = rng.randrange(len(data)) if data else 0
    if how == 0:
        return data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1:] if data else data
    if how == 1:
        return data[:at] + bytes([rng.randrange(256)]) + data[at + 1:]
    if how == 2:
        return data[:at]
    if how == 3:
        return replace_token(data, rng, rb"(?<![\w.])[-+]?\d+(\.\d+)?", ABSURD)
    if how == 4:
        size, order = rng.choice((1, 2, 4, 8)), rng.choice(("little", "big"))
        value = (rng.choice(EXTREME) % (1 << (8 * size))).to_bytes(size, order)
        return data[:at] + value + data[at + size:]
    if how == 5:  # a word misspelt
        found = list(re.finditer(rb"[A-Za-z]{4,}", data))
        if not found:
            return data
        word = rng.choice(found)
        cut = rng.randrange(word.start(), word.end())
        return data[:cut] + data[cut + 1:]
    if how == 6:  # a piece twice
        end = min(len(data), at + rng.randrange(1, 200))
        return data[:end] + data[at:end] + data[end:]
    if how == 7:  # a piece gone
        return data[:at] + data[min(len(data), at + rng.randrange(1, 64)):]
    if how == 8:  # two pieces change places
        other, size = rng.randrange(len(data)) if data else 0, rng.randrange(1, 32)
        first, second = sorted((at, other))
        second = max(second, first + size)
        return (data[:first] + data[second:second + size] + data[first + size:second] + data[first:first + size] +
                data[second + size:])
    return replace_token(data, rng, rb"[\w./-]+\.(?:vtu|vti|geo|v\*+|cpu\d+|h5)", secrets)


def damage(data, rng, secrets):
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        data = damage_once(data, rng, secrets)
    return data


# --- runs -------------------------------------------------------------------------------------------------


def consists_of(path):
    """The files of a data set, as the program sees them: all those beside the input that are small."""
    if path.stat().st_size > (16 << 20):
        raise SystemExit(f"{path}: too large to be damaged a thousand times")
    stem = path.name.split(".")[0]
    beside = [f for f in path.parent.iterdir() if f.is_file() and f.name.split(".")[0] == stem]
    return sorted(set(beside + ([] if len(beside) > 1 else [f for f in path.parent.iterdir() if f.is_file()])))


def run_one(program, kind, path, files, ending, number, seed, keep):
    rng = random.Random(f"{seed} {kind} {number}")
    with tempfile.TemporaryDirectory(prefix="ovoid_mutant_") as top:
        place = Path(top) / "data"
        place.mkdir()
        secret_file = Path(top) / "secret.vtu"
        secret_file.write_bytes(SECRET * 50)
        (place / "beside.txt").write_bytes(SECRET * 50)
        secrets = [b"../secret.vtu", str(secret_file).encode(), b"/proc/self/environ", b"/etc/passwd"]
        for file in files:
            shutil.copy(file, place / file.name)
        victim = place / rng.choice(files).name
        os.chmod(victim, 0o600)
        victim.write_bytes(damage(victim.read_bytes(), rng, secrets))
        out = Path(top) / f"out{ending}"
        begin = time.monotonic()
        environment = {**os.environ, "OVOID_TEST_SECRET": SECRET.decode()}
        command = [program, "convert", place / path.name, "-o", out]
        try:
            done = subprocess.run(command, capture_output=True, timeout=30, env=environment)
            code, text = done.returncode, done.stderr
        except subprocess.TimeoutExpired as late:
            code, text = None, late.stderr or b""
        seconds = time.monotonic() - begin
        lines = [line for line in text.split(b"\n") if line and not line.startswith(b"note:")]
        leaked = any(SECRET in f.read_bytes() or b"root:x:0" in f.read_bytes()
                     for f in Path(top).glob("out*")) or SECRET in text
        bad = []
        if code is None or seconds > LONGEST_SECONDS:
            bad.append("hang")
        if code is not None and (code < 0 or code > 3):
            bad.append("crash")
        if len(lines) > (1 if code else 0) or any(len(line) > LONGEST_MESSAGE for line in text.split(b"\n")):
            bad.append("lines")
        if leaked:
            bad.append("leak")
        if bad and keep:
            shutil.copytree(place, Path(keep) / f"{kind.replace(' ', '_')}_{number}", dirs_exist_ok=True)
            print(f"{kind} {number}: {', '.join(bad)}: exit {code}, {seconds:.1f} s: {text[:300]!r}", flush=True)
        stopped = b"its reader stopped" in text or b"its reader is stuck" in text
        return kind, code == 0, stopped, seconds, bad


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", help="folder for what failed")
    parser.add_argument("--only", help="formats to damage, by a regular expression")
    given = parser.parse_args()
    program = str(Path(given.program).resolve())
    with tempfile.TemporaryDirectory(prefix="ovoid_seeds_") as folder:
        kinds = seeds(Path(folder), program) if not given.files else {f.name: f for f in given.files}
        if given.only:
            kinds = {kind: path for kind, path in kinds.items() if re.search(given.only, kind)}
        rows = {kind: dict(mutants=0, read=0, stopped=0, longest=0.0, crash=0, hang=0, lines=0, leak=0)
                for kind in kinds}
        with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
            jobs = []
            for kind, path in kinds.items():
                whole = subprocess.run([program, "info", "--json", path], capture_output=True, timeout=60)
                if whole.returncode != 0:
                    raise SystemExit(f"{kind}: the seed itself is not read: {whole.stderr.decode()}")
                files = consists_of(path)
                ending = ENDINGS.get(json.loads(whole.stdout)["kind"], ".ply")
                jobs += [pool.submit(run_one, program, kind, path, files, ending, n, given.seed, given.keep)
                         for n in range(given.count)]
            for job in concurrent.futures.as_completed(jobs):
                kind, is_read, is_stopped, seconds, bad = job.result()
                row = rows[kind]
                row["mutants"] += 1
                row["read"] += is_read
                row["stopped"] += is_stopped
                row["longest"] = max(row["longest"], seconds)
                for what in bad:
                    row[what] += 1
    print("| format | mutants | read | reader stopped | longest, s | crashes | hangs | over a line | leaks |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for kind, row in rows.items():
        print(f"| {kind} | {row['mutants']} | {row['read']} | {row['stopped']} | {row['longest']:.1f} | {row['crash']} "
              f"| {row['hang']} | {row['lines']} | {row['leak']} |")
    return int(any(row[what] for row in rows.values() for what in ("crash", "hang", "lines", "leak")))


if __name__ == "__main__":
    sys.exit(main())
