# SPDX-License-Identifier: Apache-2.0
"""How near two programs' pictures are: informative, as each has its own interpolation, light and rounding."""
import array
import ast
import math
import re
import struct


def read_npy_rgb(path):
    """Colours in 0..255 of a float32 (H, W, 4) NPY file over black; it is premultiplied, so black adds nothing."""
    with open(path, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<H", data, 8)
    header = ast.literal_eval(data[10:10 + length].decode("latin-1"))
    values = array.array("f", data[10 + length:])
    height, width, channels = header["shape"]
    if header["descr"] != "<f4" or channels != 4 or len(values) != width * height * 4:
        raise ValueError(f"{path}: expected little-endian float32 of shape (H, W, 4)")
    return width, height, [255.0 * values[4 * i + c] for i in range(width * height) for c in range(3)]


def read_ppm_rgb(path):
    with open(path, "rb") as file:
        data = file.read()
    header = re.match(rb"P6\s+(?:#[^\n]*\n\s*)*(\d+)\s+(\d+)\s+255\s", data)
    width, height = int(header[1]), int(header[2])
    return width, height, data[header.end():]


def psnr(npy_path, ppm_path):
    """Peak signal-to-noise ratio in dB over the pixels that either picture covers."""
    width, height, ours = read_npy_rgb(npy_path)
    if (width, height) != read_ppm_rgb(ppm_path)[:2]:
        raise ValueError(f"{npy_path} and {ppm_path} differ in size")
    theirs = read_ppm_rgb(ppm_path)[2]
    total, count = 0.0, 0
    for pixel in range(0, 3 * width * height, 3):
        a, b = ours[pixel:pixel + 3], theirs[pixel:pixel + 3]
        if any(value >= 0.5 for value in a) or any(b):
            total += sum((x - y) ** 2 for x, y in zip(a, b))
            count += 3
    if not total:
        return math.inf
    return 10 * math.log10(255.0 ** 2 * count / total)
