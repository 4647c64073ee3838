#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Is the mass in a picture of column densities that of the particles?  column_density.py FILE

An x-ray of the density of particles of equal mass, from the front and large enough for all of them: the sum over its pixels, times their
area, against the number of particles times their mass, for each profile."""
import array
import ast
import json
import os
import struct
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
PIXELS = 300


def ovoid(*words):
    return subprocess.run([OVOID, *words], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout


def first_channel(path):
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack("<H", data[8:10])[0]
    shape = ast.literal_eval(data[10:10 + length].decode())["shape"]
    values = array.array("f")
    values.frombytes(data[10 + length:])
    return values[0::shape[2]]


def main(path):
    described = json.loads(ovoid("info", "--json", path))
    masses = next((a["range"] for a in described["arrays"] if a["name"].lower() in ("mass", "masses", "m")), [1, 1])
    if masses[0] != masses[1]:
        sys.exit("the particles' masses differ")
    mass = described["points"] * masses[0]
    low, high = described["bounds"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    size = sum((b - a) ** 2 for a, b in zip(low, high)) ** 0.5
    print("| profile | mass in the picture / mass - 1 |\n|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        camera, picture = os.path.join(folder, "camera.json"), os.path.join(folder, "picture.npy")
        with open(camera, "w", encoding="utf-8") as file:
            json.dump({"position": [middle[0], middle[1], middle[2] + 2 * size], "focal_point": middle, "view_up": [0, 1, 0],
                       "parallel_projection": True, "parallel_scale": size}, file)
        for profile in ("gaussian", "cubic-spline", "wendland", "epanechnikov"):
            ovoid("render", path, "--quantity", "density", "--mode", "xray", "--profile-kernel", profile, "--camera", camera,
                  "--size", f"{PIXELS}x{PIXELS}", "-o", picture)
            total = sum(first_channel(picture)) * (2 * size / PIXELS) ** 2
            print(f"| {profile} | {total / mass - 1:+.1e} |")


if __name__ == "__main__":
    main(sys.argv[1])
