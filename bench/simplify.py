#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What runs and boxes come to: simplify.py [LATTICE...]

For each input (files joined by "+" are one; without any, what `ovoid make` has), each kind of primitive and each tolerance: the gain, which is
relevant samples per primitive; the file's bytes, and those of zfp's of the same bound (Debian: zfp); PSNR of the samples, and of the
picture with the look that the input has by itself, 512 x 512, to the input's; and the input's frame time over the simplified one's."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

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


def main(inputs):
    print("| " + " | ".join(HEAD) + " |\n" + "|---" * len(HEAD) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for word in inputs or made(("head.nii", "jet.nii"), folder):
            name = os.path.basename(word.split("+")[0].rstrip("/"))
            for row in simplified(word.split("+"), folder):
                print("| " + " | ".join(map(str, (name, *row))) + " |", flush=True)


if __name__ == "__main__":
    if not os.path.exists(OVOID):
        sys.exit(f"{OVOID}: build it first (make build)")
    main(sys.argv[1:])
