#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What runs and boxes come to: simplify.py [LATTICE...] [--plot FILE.svg]

For each input (files joined by "+" are one; without any, what `ovoid make` has), each kind of primitive and each tolerance: the gain, which is
relevant samples per primitive; the file's bytes, and those of zfp's of the same bound (Debian: zfp); PSNR of the samples, and of the
picture with the look that the input has by itself, 512 x 512, to the input's; and the input's frame time over the simplified one's.
The plot is of gain over tolerance: boxes solid, ramps dashed."""
import argparse
import json
import os
import re
import shutil
import subprocess
import tempfile

import plots
from fit import floats_of, made, run
from magnification import OVOID, difference, picture_of

TOLERANCES = (0, 0.5, 1, 2, 5)  # % of the range
PRIMITIVES = (("constant", ()), ("ramp", ()), ("ramp", ("--search", "fewest")), ("box", ()))
HEAD = ("data", "primitives", "tolerance", "number", "gain", "bytes", "zfp's bytes", "PSNR, dB", "picture, dB", "frames, times as fast", "time")


def drawn(inputs, look, folder):
    """The picture, and the median of its frames' times, in ms."""
    picture, profile = os.path.join(folder, "picture.npy"), os.path.join(folder, "profile.json")
    run("render", *inputs, "-o", picture, "--tf", look, "--fit", "box", "--size", "512x512", "--repeat", "5", f"--profile={profile}")
    with open(profile, encoding="utf-8") as file:
        return picture_of(picture), json.load(file)["frame_ms"]["median"]


def zfp_bytes(floats, dims, bound):
    """Of zfp's file with the greatest tolerance, a power of two times the bound, whose samples err by no more than that."""
    if shutil.which("zfp") is None or bound == 0:
        return "-"
    size, tolerance = "-", bound
    while True:
        told = subprocess.run(["zfp", "-s", "-f", "-3", *map(str, dims), "-a", str(tolerance), "-i", floats, "-z", os.devnull],
                              check=True, capture_output=True, text=True).stderr
        if float(re.search(r"maxe=([^ ]+)", told).group(1)) > bound:
            return size
        size, tolerance = re.search(r"zfp=([0-9]+)", told).group(1), 2 * tolerance


def simplified(inputs, folder):
    look, boxes, told = (os.path.join(folder, name) for name in ("look.json", "boxes.h5", "told.json"))
    run("render", *inputs, "-o", os.path.join(folder, "first.png"), "--size", "64x64", "--save-look", look)
    picture, _ = drawn(inputs, look, folder)
    floats, dims = floats_of(inputs, (), folder)
    for primitives, more in PRIMITIVES:
        for percent in TOLERANCES:
            run("simplify", *inputs, "-o", boxes, "--primitive", primitives, "--tolerance", f"{percent}%", "--report", told, *more)
            with open(told, encoding="utf-8") as file:
                report = json.load(file)
            ours, frame = drawn([boxes], look, folder)
            _, before = drawn(inputs, look, folder)  # by turns
            decibels, _ = difference(ours, picture)
            yield (" ".join((primitives, *more[1:])), f"{percent} %", report["primitives"],
                   f"{report['relevant'] / max(1, report['primitives']):.2f}", report["bytes"], zfp_bytes(floats, dims, percent / 100 * report["range"]),
                   "-" if report["psnr_db"] is None else f"{report['psnr_db']:.1f}", "same" if decibels > 200 else f"{decibels:.1f}",
                   f"{before / frame:.2f}", f"{report['seconds']:.1f} s")


def plot(rows, path):
    colors = ("#0b5fa5", "#c0392b", "#2e8b57", "#8e44ad", "#d68910")
    names = list(dict.fromkeys(row[0] for row in rows))
    lines = []
    for number, name in enumerate(names):
        for primitives, is_dashed in (("box", False), ("ramp", True)):
            points = [(float(row[2][:-2]), float(row[4])) for row in rows if row[:2] == (name, primitives) and row[2] != "0 %"]
            lines.append(("" if is_dashed else name.split(".")[0], colors[number % len(colors)], is_dashed, points))
    plots.log_plot(path, lines, "relevant samples per primitive, over the tolerance in % of the range",
                   [(0.5, "0.5"), (1, "1"), (2, "2"), (5, "5")], [(2, "2"), (4, "4"), (8, "8"), (16, "16"), (32, "32")])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("inputs", nargs="*")
    parser.add_argument("--plot")
    options = parser.parse_args()
    rows = []
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for word in options.inputs or made(("head.nii", "jet.nii"), folder):
            name = os.path.basename(word.split("+")[0].rstrip("/"))
            for row in simplified(word.split("+"), folder):
                rows.append((name, *row))
                print("| " + " | ".join(map(str, rows[-1])) + " |", flush=True)
    if options.plot:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()
