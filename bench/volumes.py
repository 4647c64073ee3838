# SPDX-License-Identifier: Apache-2.0
"""The volumes of the scenes as VTI files, which Ovoid and its peers both read, and cameras on them."""
import gzip
import json
import math
import os
import struct
import subprocess

HEADER = """<?xml version="1.0"?>
<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{spacing}">
<Piece Extent="{extent}"><PointData Scalars="value">
<DataArray type="UInt8" Name="value" format="appended" offset="0"/>
</PointData></Piece></ImageData>
<AppendedData encoding="raw">
_"""


def data_folder():
    candidates = [os.environ.get("OVOID_DATA", ""), os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "shared", "data")]
    return next((path for path in candidates if path and os.path.isdir(path)), "")


def array_flags(path):
    """Of `ovoid make galaxy` the tables are about an array's mean."""
    return ["--array", "age"] if os.path.basename(path).startswith("galaxy") else []


def read_nifti(path):
    """Dims, spacing and bytes of an 8-bit NIfTI-1 volume; the rest of the header does not matter to a benchmark."""
    with gzip.open(path) as file:
        data = file.read()
    size, = struct.unpack_from("<i", data, 0)
    dims = struct.unpack_from("<8h", data, 40)
    datatype, = struct.unpack_from("<h", data, 70)
    spacing = struct.unpack_from("<8f", data, 76)[1:4]
    offset = int(struct.unpack_from("<f", data, 108)[0])
    count = dims[1] * dims[2] * dims[3]
    if size != 348 or datatype != 2 or len(data) < offset + count:
        raise ValueError(f"{path}: expected a whole little-endian NIfTI-1 volume of 8-bit samples")
    return dims[1:4], spacing, data[offset:offset + count]


def write_vti(path, dims, spacing, samples):
    extent = " ".join(f"0 {count - 1}" for count in dims)
    header = HEADER.format(extent=extent, spacing=" ".join(f"{value:g}" for value in spacing))
    with open(path + ".part", "wb") as file:
        file.write(header.encode("ascii") + struct.pack("<Q", len(samples)) + samples)
        file.write(b"\n</AppendedData></VTKFile>\n")
    os.replace(path + ".part", path)


def prepare(name, recipe, ovoid, folder, data_folder):
    """The volume's VTI file, made if it is not there; None if its data is not on this machine."""
    path = os.path.join(folder, name + ".vti")
    if os.path.exists(path):
        return path
    os.makedirs(folder, exist_ok=True)
    if "nifti" in recipe:
        source = os.path.join(data_folder, recipe["nifti"]) if data_folder else ""
        if not os.path.exists(source):
            return None
        write_vti(path, *read_nifti(source))
    else:
        subprocess.run([ovoid, "make", *recipe["make"], "--type", recipe.get("type", "uint8"), "-o", path], check=True)
    return path


def describe(path, ovoid):
    """Dims and world box of the samples, as `ovoid info` reads them."""
    text = subprocess.run([ovoid, "info", path, "--json"], check=True, capture_output=True, text=True).stdout
    info = json.loads(text)
    return info["dims"], info["spacing"], info["bounds"]


def write_camera(path, view, dims, spacing, bounds, zoom):
    """Half the picture's height is half the volume's longest side over `zoom`: a picture of so many pixels has `zoom` per voxel."""
    length = math.hypot(*view["direction"])
    direction = [component / length for component in view["direction"]]
    centre = [(lo + hi) / 2 for lo, hi in zip(bounds[0], bounds[1])]
    half = max(count * step for count, step in zip(dims, spacing)) / 2 / zoom
    angle = 30
    distance = half / math.tan(math.radians(angle / 2)) if not view["parallel"] else 4 * half * zoom
    camera = {"position": [c + d * distance for c, d in zip(centre, direction)], "focal_point": centre,
              "view_up": [0, 1, 0], "parallel_projection": view["parallel"], "parallel_scale": half, "view_angle": angle}
    with open(path, "w", encoding="ascii") as file:
        json.dump(camera, file)
