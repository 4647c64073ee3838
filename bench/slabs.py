#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Sheets through the middles of slabs against means over them, for meshes and particles: slabs.py [FILE...]

At the default sampling distance, half and a quarter of it: time of a frame, and PSNR against means at a sixteenth. Without files, for
`ovoid make fin` and `galaxy`."""
import array
import json
import math
import os
import struct
import subprocess
import sys
import tempfile

from volumes import array_flags

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")


def picture_of(folder, path, slab, distance, unit):
    picture, profile = os.path.join(folder, "picture.npy"), os.path.join(folder, "profile.json")
    subprocess.run([OVOID, "render", path, *array_flags(path), "--view", "+z", "--fit", "box", "--slab", slab, "--sampling-distance", str(distance), "--unit-distance", str(unit), "--size",
                    "256x256", "--repeat", "3", f"--profile={profile}", "-o", picture], check=True, stderr=subprocess.DEVNULL)
    with open(picture, "rb") as file:
        data = file.read()
    values = array.array("f")
    values.frombytes(data[10 + struct.unpack("<H", data[8:10])[0]:])
    with open(profile, encoding="utf-8") as file:
        return values, json.load(file)["frame_ms"]["median"]


def psnr(values, wanted):
    return -10 * math.log10(sum((a - b) ** 2 for a, b in zip(values, wanted)) / len(values) + 1e-30)


def table(folder, path):
    described = json.loads(subprocess.run([OVOID, "info", "--json", path, *array_flags(path)], check=True, capture_output=True, text=True).stdout)["field"]
    distance = unit = described["default_unit_distance"]
    wanted, _ = picture_of(folder, path, "mean", distance / 16, unit)
    print(f"{os.path.basename(path)}\n\n| slab | distance | frame, ms | PSNR, dB |\n|---|---|---|---|")
    for slab in ("mid", "mean"):
        for parts in (1, 2, 4):
            values, ms = picture_of(folder, path, slab, distance / parts, unit)
            print(f"| {slab} | 1/{parts} | {ms:.0f} | {psnr(values, wanted):.1f} |")
    print()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        files = sys.argv[1:]
        if not files:
            files = [os.path.join(scratch, name) for name in ("fin.vtu", "galaxy.npz")]
            for file in files:
                kind = os.path.basename(file).split(".")[0]
                subprocess.run([OVOID, "make", kind, "--count", "40000", "-o", file], check=True, stderr=subprocess.DEVNULL)
        for file in files:
            table(scratch, file)
