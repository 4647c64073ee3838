#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The ways of post-convolution side by side: sheets_pictures.py OUT.png

The middle of the sample head, 64^3, at 4 pixels per voxel: an x-ray, its differences to `--post-convolution off` times 8, on gray, and the same of
a shaded picture; from left to right off, and the ways of sheets.py."""
import json
import math
import os
import subprocess
import sys
import tempfile

import sheets

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts"))
import contact_sheet  # noqa: E402

PIXELS, MAGNIFICATION, AMPLIFIED = 150, 4, 8
MODES = {"x-ray": ["--mode", "xray"], "shaded": []}


def camera_into(path, volume):
    described = json.loads(subprocess.run([sheets.OVOID, "info", "--json", volume], check=True, capture_output=True, text=True).stdout)
    half = PIXELS / 2 * described["spacing"][0] / MAGNIFICATION
    direction = (0.3, -0.9, 0.32)
    length = math.sqrt(sum(d * d for d in direction))
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"position": [4 * d / length for d in direction], "focal_point": [0, 0, -0.1], "view_up": [0, 0, 1],
                   "parallel_projection": True, "parallel_scale": half}, file)


def rows_of(values, color_of):
    """Rows of RGB bytes; `color_of`: three numbers in [0, 1] of a pixel's RGBA."""
    rows = []
    for y in range(PIXELS):
        row = bytearray()
        for x in range(PIXELS):
            at = 4 * (y * PIXELS + x)
            row += bytes(min(255, max(0, round(255 * c))) for c in color_of(values[at:at + 4]))
        rows.append(bytes(row))
    return rows


def main(output):
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        volume, camera = os.path.join(folder, "head.nrrd"), os.path.join(folder, "camera.json")
        subprocess.run([sheets.OVOID, "make", "head", "--size", "64x64x64", "-o", volume], check=True, stderr=subprocess.DEVNULL)
        camera_into(camera, volume)
        for flags in MODES.values():
            pictures = [sheets.render(volume, camera, PIXELS, [*flags, "--post-convolution", *way], os.path.join(folder, "way.npy"))
                        for way in [["off"], *sheets.WAYS.values()]]
            least = min(pictures[0][0::4]) if flags else 0.0
            span = max(pictures[0][0::4]) - least if flags else 1.0
            lines.append([rows_of(p, lambda c: [(v - least) / span + (0 if flags else 1 - c[3]) for v in c[:3]]) for p in pictures])
            lines.append([rows_of([0.5 + AMPLIFIED * (a - b) / span for a, b in zip(p, pictures[0])], lambda c: c[:3]) for p in pictures])
    contact_sheet.write_png(output, contact_sheet.sheet(lines))


if __name__ == "__main__":
    main(sys.argv[1])
