#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How near pictures on lattice sheets and on image sheets are to finer ones:
lattice_sheets.py [--size N] [--projection parallel|perspective] [--magnified] [FILE...]

Without files: bonsai, engine, headsq and MR of the folder of real data (run.py). Three looks: the default; opaque, from nothing to 0.9 within 5 % of
the range; soft, to 0.06 over the whole range. Two views. Held against the mean of 4 x 4 rays per pixel whose sheets are an eighth as far from each
other; dB of colours over black. `turn`: how much the picture on lattice sheets changes where its main axis does, and by a turn of half a degree.

--magnified: instead, how near magnified pictures from few samples are to those of all samples, and how many were reconstructed."""
import argparse
import json
import math
import os
import subprocess
import tempfile

from magnification import OVOID, picture_of
from volumes import data_folder

FILES = ["bonsai/bonsai.nii.gz", "engine/engine.nii.gz", "headsq/quarter.nhdr", "mri_nifti/MR.nii.gz"]
VIEWS = [(17, -33), (-62, 9)]
FINER = 8
PLACE = 0.35  # of the range: where the opaque look begins


def colors_of(path):
    """Premultiplied, so over black."""
    values = picture_of(path)
    return [values[c::4] for c in range(3)]


def averaged(colors, width):
    """Means of 4 x 4 pixels of a picture `width` pixels wide."""
    means = []
    for values in colors:
        rows = [values[i:i + width] for i in range(0, len(values), width)]
        strips = [[sum(column) for column in zip(*rows[y:y + 4])] for y in range(0, len(rows), 4)]
        means.append([sum(strip[x:x + 4]) / 16 for strip in strips for x in range(0, width, 4)])
    return means


def decibels(a, b):
    squared = sum(sum((x - y) ** 2 for x, y in zip(p, q)) for p, q in zip(a, b)) / (3 * len(a[0]))
    return -10 * math.log10(squared + 1e-30)


def described(path):
    return json.loads(subprocess.run([OVOID, "info", path, "--json"], check=True, capture_output=True, text=True).stdout)


def looks_of(description):
    low, high = description["arrays"][0]["range"]
    step, span = low + PLACE * (high - low), high - low
    colors = [low, 0.1, 0.2, 0.9, high, 1, 0.9, 0.6]

    def look(points):
        return ["--tf", json.dumps([{"RGBPoints": colors, "Points": points}])]

    return {"default": [], "opaque": look([low, 0, 0.5, 0, step, 0, 0.5, 0, step + 0.05 * span, 0.9, 0.5, 0, high, 0.9, 0.5, 0]),
            "soft": look([low, 0, 0.5, 0, high, 0.06, 0.5, 0])}


class Subject:
    def __init__(self, path, look, options, folder):
        self.words = [OVOID, "render", path, *look, "--backend", "cpu", "--projection", options.projection, "--view", "+z", "--fit",
                      "box", "--light", "headlight",
        "--occlusion", "0"]
        self.size, self.folder = options.size, folder

    def draw(self, view, *flags, times=1):
        picture = os.path.join(self.folder, "picture.npy")
        subprocess.run([*self.words, "--size", f"{times * self.size}x{times * self.size}", "--azimuth", str(view[0]), "--elevation", str(view[1]),
                        *flags, "-o", picture], check=True, stderr=subprocess.DEVNULL)
        return colors_of(picture)


def print_magnified(subjects):
    """Of (name, look's name, subject): pictures as by default, and with every sample drawn."""
    print("| file | look | zoom | few samples against all, dB | samples, few / all |\n|---|---|---:|---:|---:|")
    for file, look, subject in subjects:
        for zoom in (5, 10, 20):
            pictures, samples = [], []
            for how in ("auto", "off"):
                profile = os.path.join(subject.folder, "profile.json")
                pictures.append(subject.draw(VIEWS[0], "--zoom", str(zoom), "--sheets", "lattice", "--post-convolution", how, f"--profile={profile}"))
                with open(profile, encoding="utf-8") as opened:
                    samples.append(json.load(opened)["samples"]["reconstructed"])
            print(f"| {file} | {look} | {zoom} | {min(decibels(*pictures), 99.9):.1f} | {samples[0] / samples[1]:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=200)
    parser.add_argument("--projection", default="parallel")
    parser.add_argument("--magnified", action="store_true")
    parser.add_argument("files", nargs="*")
    options = parser.parse_args()
    files = options.files or [os.path.join(data_folder(), file) for file in FILES]
    if options.magnified:
        with tempfile.TemporaryDirectory() as folder:
            print_magnified((os.path.basename(path), name, Subject(path, look, options, folder)) for path in files
                            for name, look in looks_of(described(path)).items())
        return
    print("| file | look | view | image sheets, dB | lattice sheets, dB | main axis changes, dB | turn by half a degree, dB |\n|---|---|---|---:|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for path in files:
            finest = 0.5 * min(described(path)["spacing"]) / FINER
            for name, look in looks_of(described(path)).items():
                subject = Subject(path, look, options, folder)
                before = subject.draw((44.999, 10), "--sheets", "lattice")
                step = decibels(before, subject.draw((45.001, 10), "--sheets", "lattice"))
                turn = decibels(before, subject.draw((44.5, 10), "--sheets", "lattice"))
                for view in VIEWS:
                    fine = averaged(subject.draw(view, "--sheets", "image", "--post-convolution", "off", "--sampling-distance", str(finest), times=4),
                                    4 * subject.size)
                    image, lattice = (decibels(subject.draw(view, "--sheets", sheets), fine) for sheets in ("image", "lattice"))
                    print(f"| {os.path.basename(path)} | {name} | {view[0]}, {view[1]} | {image:.1f} | {lattice:.1f} | {step:.1f} | {turn:.1f} |", flush=True)


if __name__ == "__main__":
    main()
