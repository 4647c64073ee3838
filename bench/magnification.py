#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Frames of a magnified volume: magnification.py VOLUME [--plot FILE.svg] [--frames N].

512 x 512, shaded by the default look, from 1 to 16 pixels per voxel, by turns: with post-convolution and without; scattered with the published
cubic way and without at some, one frame each; PSNR and greatest difference in 8 bits of the first to the second; and what shading and compositing alone take of a visible
sample's time."""
import argparse
import array
import json
import math
import os
import struct
import subprocess
import tempfile

import plots

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
PIXELS = 512
MAGNIFICATIONS = (1, 1.5, 2, 3, 4, 6, 8, 12, 16)
SCATTERED = (2, 4, 8)
OFF, SCATTER = ["--post-convolution", "off"], ["--evaluate", "scatter"]
WAYS = {"auto": [], "off": OFF, "scattered, cubic": SCATTER + ["--post-convolution", "cubic"], "scattered, off": SCATTER + OFF}


def camera_of(path, described, magnification):
    low, high = described["bounds"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    half = PIXELS / 2 * min(described["spacing"]) / magnification
    distance = half / math.tan(math.radians(15))
    direction = (0.46, 0.32, 0.83)
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"position": [m + distance * d for m, d in zip(middle, direction)], "focal_point": middle, "view_up": [0, 1, 0],
                   "parallel_projection": True, "parallel_scale": half}, file)


def picture_of(path):
    with open(path, "rb") as file:
        data = file.read()
    values = array.array("f")
    values.frombytes(data[10 + struct.unpack("<H", data[8:10])[0]:])
    return values


def difference(a, b):
    """PSNR in dB and the greatest difference in 8 bits."""
    square = sum((x - y) ** 2 for x, y in zip(a, b)) / len(a)
    return -10 * math.log10(square + 1e-30), 255 * max(abs(x - y) for x, y in zip(a, b))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("volume")
    parser.add_argument("--plot")
    parser.add_argument("--frames", type=int, default=5)
    options = parser.parse_args()
    described = json.loads(subprocess.run([OVOID, "info", "--json", options.volume], check=True, capture_output=True, text=True).stdout)
    lines = {way: [] for way in WAYS}
    print("| pixels per voxel | auto, ms | off, ms | off / auto | scattered: cubic, ms | off, ms | off / auto | dB | 8 bits | ns per visible sample | "
          "shade and composite |\n|---|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        camera, profile = os.path.join(folder, "camera.json"), os.path.join(folder, "profile.json")
        for magnification in MAGNIFICATIONS:
            camera_of(camera, described, magnification)
            frames, pictures, profiles = {}, {}, {}
            for way, flags in WAYS.items():
                is_scattered = flags[:2] == SCATTER
                if is_scattered and magnification not in SCATTERED:
                    continue
                picture = os.path.join(folder, f"{way}.npy")
                subprocess.run([OVOID, "render", options.volume, "--sheets", "image", "--camera", camera, "--size", f"{PIXELS}x{PIXELS}", *flags, "--repeat",
                                str(1 if is_scattered else options.frames), f"--profile={profile}", "-o", picture], check=True, stderr=subprocess.DEVNULL)
                with open(profile, encoding="utf-8") as file:
                    profiles[way] = json.load(file)
                frames[way] = profiles[way]["frame_ms"]["median"]
                pictures[way] = picture_of(picture)
                lines[way].append((magnification, frames[way]))
            psnr, greatest = difference(pictures["auto"], pictures["off"])
            stages, shaded = profiles["auto"]["stages_ms"], profiles["auto"]["samples"]["shaded"]
            visible = sum(stages[name] for name in ("shade", "composite")) * 1e6 / shaded
            everything = sum(ms for name, ms in stages.items() if name != "plan") * 1e6 / shaded
            scattered = "| | |"
            if magnification in SCATTERED:
                nodes, every = frames["scattered, cubic"], frames["scattered, off"]
                scattered = f"{nodes:.0f} | {every:.0f} | {every / nodes:.2f} |"
            print(f"| {magnification} | {frames['auto']:.0f} | {frames['off']:.0f} | {frames['off'] / frames['auto']:.2f} | {scattered} "
                  f"{'same' if psnr > 150 else f'{psnr:.1f}'} | {greatest:.0f} | {everything:.1f} | {visible:.1f} |", flush=True)
    if options.plot:
        plots.log_plot(options.plot, [("with nodes", "#0b5fa5", False, lines["auto"]), ("every pixel", "#c0392b", False, lines["off"]),
                                      ("scattered, every pixel", "#888", False, lines["scattered, off"]),
                                      ("scattered, cubic", "#bbb", False, lines["scattered, cubic"])], "pixels per voxel",
                       [(m, f"{m:g}") for m in (1, 2, 4, 8, 16)], [(ms, f"{ms:g} ms") for ms in (100, 200, 500, 1000, 2000, 5000, 10000, 20000)])


if __name__ == "__main__":
    main()
