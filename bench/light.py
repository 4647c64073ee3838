#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What light from a coarse volume costs: light.py [--turns N] [FILE...]

For each file the time of a frame without it, with occlusion, and with occlusion, shadows and scattering, by turns; the ratios; and the time
to make the volume, which the first frame takes. Without files, for what `ovoid make` makes of a lattice, a mesh and particles. How near the
volume is to random rays through the field itself is told by `render_tests --gtest_filter=LightVolume.*`."""
import json
import os
import statistics
import subprocess
import sys
import tempfile

from volumes import array_flags

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
LIGHTS = {"without": ["--occlusion", "0"], "occlusion": ["--occlusion", "0.4"], "shadows": ["--occlusion", "0", "--shadows", "0.7"],
          "all three": ["--occlusion", "0.7", "--shadows", "0.7", "--scatter", "0.5"]}


def profile_of(folder, path, light, repeat):
    profile = os.path.join(folder, "profile.json")
    volume = ["--surface=0"] if path.endswith((".vtu", ".vtk", ".ex2", ".e")) else []
    subprocess.run([OVOID, "render", path, "--shade", *volume, *array_flags(path), "--size", "512x512", *repeat, f"--profile={profile}", "-o",
                    os.path.join(folder, "picture.png"), *light], check=True, stderr=subprocess.DEVNULL)
    with open(profile, encoding="utf-8") as file:
        return json.load(file)


def row(folder, path, turns):
    times = {name: [] for name in LIGHTS}
    for _ in range(turns):
        for name, light in LIGHTS.items():
            times[name].append(profile_of(folder, path, light, ["--repeat", "9"])["frame_ms"]["median"])
    cells = [os.path.basename(path), f"{statistics.median(times['without']):.0f}"]
    for name in list(LIGHTS)[1:]:
        ratio = statistics.median(times[name]) / statistics.median(times["without"])
        first = profile_of(folder, path, LIGHTS[name], [])
        cells += [f"{ratio:.2f}", f"{first['stages_ms'].get('light volume', 0):.0f}"]
    print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    arguments = sys.argv[1:]
    rounds = 3
    if arguments[:1] == ["--turns"]:
        rounds, arguments = int(arguments[1]), arguments[2:]
    with tempfile.TemporaryDirectory() as scratch:
        if not arguments:
            arguments = [os.path.join(scratch, name) for name in ("gaussians.nrrd", "fin.vtu", "galaxy.npz")]
            for file in arguments:
                kind = os.path.basename(file).split(".")[0]
                subprocess.run([OVOID, "make", kind, *(["--size", "256"] if file.endswith(".nrrd") else ["--count", "40000"]), "-o", file], check=True,
                               stderr=subprocess.DEVNULL)
        print("| data | frame without, ms | occlusion | its volume, ms | shadows | its volume, ms | all three | its volume, ms |\n|---|---|---|---|---|---|---|---|")
        for file in arguments:
            row(scratch, file, rounds)
