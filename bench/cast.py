#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What it costs that surfaces cast: cast.py [--turns N]

A head of 256^3 samples alone, over a floor, and within balls of ever more triangles. For each the times to make the light volume, with occlusion alone and with shadows
alone, which a scene's first frame takes, and to draw the surfaces, which every frame takes; medians, by turns. That light is right is told by
`render_tests --gtest_filter=SurfaceExtinction.*`."""
import json
import math
import os
import statistics
import struct
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
LIGHTS = {"occlusion": ["--occlusion", "0.4"], "shadows": ["--occlusion", "0", "--shadows", "0.7"]}


def write_ball(path, radius, rings):
    def place(i, j):
        polar, turn = math.pi * i / rings, math.pi * j / rings
        return radius * math.sin(polar) * math.cos(turn), radius * math.sin(polar) * math.sin(turn), radius * math.cos(polar)

    count = 0
    with open(path, "wb") as file:
        file.write(bytes(84))
        for i in range(rings):
            for j in range(2 * rings):
                corners = place(i, j), place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)
                for triangle in ((0, 1, 2), (0, 2, 3)):
                    numbers = [number for corner in triangle for number in corners[corner]]
                    file.write(struct.pack("<12fH", 0, 0, 0, *numbers, 0))
                    count += 1
        file.seek(80)
        file.write(struct.pack("<I", count))
    return count


def stages_of(folder, data, more):
    profile = os.path.join(folder, "profile.json")
    subprocess.run([OVOID, "render", data, "--shade", "--size", "512x512", f"--profile={profile}", "-o", os.path.join(folder, "picture.png"), *more],
                   check=True, stderr=subprocess.DEVNULL)
    with open(profile, encoding="utf-8") as file:
        return json.load(file)["stages_ms"]


if __name__ == "__main__":
    turns = int(sys.argv[2]) if sys.argv[1:2] == ["--turns"] else 5
    with tempfile.TemporaryDirectory() as scratch:
        head = os.path.join(scratch, "head.nrrd")
        subprocess.run([OVOID, "make", "head", "--size", "256", "-o", head], check=True, stderr=subprocess.DEVNULL)
        floor = os.path.join(scratch, "floor.obj")
        with open(floor, "w", encoding="ascii") as out:
            out.write("v -3 -3 -1.1\nv 3 -3 -1.1\nv 3 3 -1.1\nv -3 3 -1.1\nf 1 2 3 4\n")
        scenes = {"0": [], "2, a floor three times as wide": ["--add", floor]}
        for wanted in (158, 500):
            ball = os.path.join(scratch, f"ball{wanted}.stl")
            scenes[str(write_ball(ball, 0.95, wanted))] = ["--add", ball]
        times = {(number, light): [] for number in scenes for light in LIGHTS}
        for _ in range(turns):
            for number, added in scenes.items():
                for light, flags in LIGHTS.items():
                    times[number, light].append(stages_of(scratch, head, [*added, *flags]))
        print("| triangles | volume with occlusion, ms | with shadows, ms | the surfaces' drawing, ms |\n|---:|---:|---:|---:|")
        for number in scenes:
            medians = [statistics.median(stages["light volume"] for stages in times[number, light]) for light in LIGHTS]
            drawing = statistics.median(stages.get("scenery", 0) for light in LIGHTS for stages in times[number, light])
            print(f"| {number} | {medians[0]:.0f} | {medians[1]:.0f} | {drawing:.0f} |")
