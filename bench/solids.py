#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kernels of subdivision solids against the solids: solids.py [MESH...]

For each control mesh (without any, the one that `ovoid make solid` has): the kernels of levels 0 to 2, by each basis, beside those of level 4,
which stands for the solid. 512 x 384, one camera and one look: a soft ramp
over the densities, and an isosurface at a quarter of their range. PSNR is that of the pixels which either picture covers."""
import json
import math
import os
import subprocess
import sys
import tempfile
import time

from magnification import OVOID, picture_of

LEVELS, FINE = (0, 1, 2), 4
BASES = ("one", "two", "interpolating")
SIZE = "512x384"


def run(*words):
    return subprocess.run([OVOID, *words], check=True, capture_output=True, text=True).stdout


def described(path):
    return json.loads(run("info", "--json", path))


def camera_of(folder, bounds):
    low, high = bounds
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    distance = 1.7 * math.dist(low, high)
    path = os.path.join(folder, "camera.json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"position": [m + distance * d for m, d in zip(middle, (0.1, -0.62, 0.78))], "focal_point": middle, "view_up": [0, 0, 1]}, file)
    return path


def made(folder, name, control, *flags):
    path = os.path.join(folder, name + ".ply")
    begin = time.perf_counter()
    run("make", "solid", *control, *flags, "-o", path)
    return path, 1000 * (time.perf_counter() - begin)


def drawn(folder, path, flags):
    picture, profile = os.path.join(folder, "picture.npy"), os.path.join(folder, "profile.json")
    run("render", path, "--size", SIZE, "--repeat", "5", f"--profile={profile}", "-o", picture, *flags)
    with open(profile, encoding="utf-8") as file:
        return picture_of(picture), json.load(file)["frame_ms"]["median"]


def decibels(picture, wanted):
    """PSNR of the pixels that either picture covers."""
    squares = []
    for pixel in range(0, len(wanted), 4):
        if max(picture[pixel + 3], wanted[pixel + 3]) > 1 / 255:
            squares += [(a - b) ** 2 for a, b in zip(picture[pixel:pixel + 4], wanted[pixel:pixel + 4])]
    return -10 * math.log10(sum(squares) / len(squares) + 1e-30)


def rows(folder, control):
    fine, _ = made(folder, "fine", control, "--levels", str(FINE))
    facts = described(fine)
    bounds, (low, high), samples = facts["bounds"], facts["field"]["range"], facts["field"]["num_kernels"]
    view = ["--camera", camera_of(folder, bounds), "--sampling-distance", str(math.dist(*bounds) / 300)]

    def at(share):
        return low + share * (high - low)

    looks = (["--opacity", f"{at(0.15)}:0,{at(0.6)}:0.8,{high}:1", "--range", f"{low},{high}", "--unit-distance", str(math.dist(*bounds) / 40)],
             ["--mode", "isosurface", "--iso", str(at(0.25))])
    wanted = [drawn(folder, fine, view + look)[0] for look in looks]
    for level in LEVELS:
        for basis in BASES:
            path, make_ms = made(folder, "level", control, "--levels", str(level), "--basis", basis)
            kernels = described(path)["field"]["num_kernels"]
            pictures = [drawn(folder, path, view + look) for look in looks]
            reached = [f"{decibels(picture, want):.1f}" for (picture, _), want in zip(pictures, wanted)]
            yield (str(level), basis, str(kernels), f"1/{samples / kernels:.0f}", *reached, f"{make_ms:.0f}", f"{pictures[0][1]:.0f}")


def main(meshes):
    for mesh in meshes or [None]:
        print(f"{os.path.basename(mesh) if mesh else 'the star'}\n")
        print("| level | basis | kernels | of the samples | soft, dB | surface, dB | made, ms | frame, ms |\n|---|---|---|---|---|---|---|---|")
        with tempfile.TemporaryDirectory() as folder:
            for row in rows(folder, ["--control", mesh] if mesh else []):
                print("| " + " | ".join(row) + " |", flush=True)
        print()


if __name__ == "__main__":
    main(sys.argv[1:])
