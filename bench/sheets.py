#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What ways of post-convolution lose: sheets.py [VOLUME...]

Pictures of each way against `--post-convolution off`, PSNR in dB over the range of the latter, from 1.5 to 8 pixels per voxel: the middle sheets
of a volume that is a slice of random waves up to a frequency, the same all along z, seen along z and turned by 27 degrees; and volumes from
files, shaded by their default look from no axis' direction."""
import array
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile

from magnification import OVOID, camera_of, difference, picture_of

EDGE, DEPTH, SHOWN = 128, 48, 64  # samples of the volume, and of the picture's height
WAYS = {"bilinear": ["bilinear"], "gaussian": ["gaussian"], "cubic": ["cubic"], "spread, bilinear": ["bilinear", "--spread", "bilinear"],
        "spread, gaussian": ["gaussian", "--spread", "bilinear"], "auto": ["auto"]}
MAGNIFICATIONS = (1.5, 2, 3, 4, 8)


def write_npy(path, shape, values):
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (63 - (len(header) + 10) % 64) + b"\n"
    with open(path, "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
        values.tofile(file)


def waves(limit):
    """A slice of random waves up to `limit` cycles per spacing, in about [0, 1]."""
    draw = random.Random(3)
    found = []
    while len(found) < 200:
        u, v = draw.uniform(-limit, limit), draw.uniform(-limit, limit)
        if math.hypot(u, v) <= limit:
            found.append((2 * math.pi * u, 2 * math.pi * v, 2 * math.pi * draw.random()))
    across = [[(math.cos(u * i + phase), math.sin(u * i + phase)) for i in range(EDGE)] for u, _, phase in found]
    samples = array.array("f")
    for j in range(EDGE):
        down = [(math.cos(v * j), math.sin(v * j)) for _, v, _ in found]
        for i in range(EDGE):
            samples.append(0.5 + 0.016 * sum(a[i][1] * c + a[i][0] * s for a, (c, s) in zip(across, down)))
    return samples


def render(volume, camera, size, flags, output):
    subprocess.run([OVOID, "render", volume, "--sheets", "image", "--camera", camera, "--size", f"{size}x{size}", "-o", output, *flags], check=True,
                   stderr=subprocess.DEVNULL)
    return picture_of(output)


def losses(volume, camera, size, flags, folder):
    exact = render(volume, camera, size, [*flags, "--post-convolution", "off"], os.path.join(folder, "off.npy"))
    span = max(exact[0::4]) - min(exact[0::4]) if "--mode" in flags else 1.0
    for way in WAYS.values():
        picture = render(volume, camera, size, [*flags, "--post-convolution", *way], os.path.join(folder, "way.npy"))
        yield min(150.0, difference(picture[0::4], exact[0::4])[0] + 20 * math.log10(span))


def print_row(name, magnification, values):
    print(f"| {name} | {magnification} | " + " | ".join("same" if value >= 150 else f"{value:.1f}" for value in values) + " |", flush=True)


def main():
    print("| data | pixels per voxel | " + " | ".join(WAYS) + " |\n|" + "---|" * (len(WAYS) + 2))
    with tempfile.TemporaryDirectory() as folder:
        camera, volume = os.path.join(folder, "camera.json"), os.path.join(folder, "waves.npy")
        roll = math.radians(27)
        for limit in (0.15, 0.30, 0.45):
            write_npy(volume, (DEPTH, EDGE, EDGE), waves(limit) * DEPTH)
            for magnification in MAGNIFICATIONS:
                middle = [(EDGE - 1) / 2, (EDGE - 1) / 2, (DEPTH - 1) / 2]
                with open(camera, "w", encoding="utf-8") as file:
                    json.dump({"position": [middle[0], middle[1], middle[2] + 100], "focal_point": middle,
                               "view_up": [math.sin(roll), math.cos(roll), 0], "parallel_projection": True, "parallel_scale": SHOWN / 2}, file)
                flags = ["--mode", "xray", "--clip", f"0,0,1,{middle[2] - 3}", "--clip", f"0,0,-1,{-middle[2] - 3}"]
                print_row(f"waves up to {limit:.2f}", magnification, losses(volume, camera, int(SHOWN * magnification), flags, folder))
        for path in sys.argv[1:]:
            described = json.loads(subprocess.run([OVOID, "info", "--json", path], check=True, capture_output=True, text=True).stdout)
            for magnification in MAGNIFICATIONS:
                camera_of(camera, described, magnification)
                print_row(os.path.basename(path).split(".")[0], magnification, losses(path, camera, 512, [], folder))


if __name__ == "__main__":
    main()
