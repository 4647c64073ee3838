#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What first pictures are like, in numbers: looks.py [INPUT...]

Draws each input (files joined by "+" are one; without any, every name of `ovoid make`) with no flag but size and output, and prints how
much of the picture is filled, how bright what shows is, and how much of it is nearly black. A pixel counts as shown from an opacity of
1/10 on; its luminance is that of its sRGB numbers (Rec. 709 weights) before the program's own background."""
import argparse
import array
import ast
import os
import struct
import subprocess
import tempfile

from magnification import OVOID

WIDTH, HEIGHT = 512, 384
BACKGROUND = (0.10, 0.11, 0.13)
WEIGHTS = (0.2126, 0.7152, 0.0722)
SHOWN = 0.1
BLACK = 0.08


def drawn(inputs, folder):
    """RGBA, premultiplied, row by row."""
    path = os.path.join(folder, "picture.npy")
    subprocess.run([OVOID, "render", *inputs, "-o", path, "--size", f"{WIDTH}x{HEIGHT}"], check=True, stderr=subprocess.DEVNULL)
    with open(path, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<H", data, 8)
    assert ast.literal_eval(data[10:10 + length].decode("latin-1"))["shape"] == (HEIGHT, WIDTH, 4)
    return array.array("f", data[10 + length:])


def measures(rgba):
    """Shares of width and height that are filled, mean luminance, share that is nearly black."""
    shown = [i for i in range(WIDTH * HEIGHT) if rgba[4 * i + 3] >= SHOWN]
    if not shown:
        return 0, 0, 0, 0
    rows = [i // WIDTH for i in shown]
    columns = [i % WIDTH for i in shown]
    luminances = []
    for i in shown:
        rest = 1 - rgba[4 * i + 3]
        luminances.append(sum(w * (rgba[4 * i + c] + rest * BACKGROUND[c]) for c, w in enumerate(WEIGHTS)))
    return ((max(columns) - min(columns) + 1) / WIDTH, (max(rows) - min(rows) + 1) / HEIGHT, sum(luminances) / len(luminances),
            sum(value < BLACK for value in luminances) / len(luminances))


def made(folder):
    """Files of all names that the program makes."""
    usage = subprocess.run([OVOID, "make", "--help"], check=True, capture_output=True, text=True).stdout
    names = [line.split()[0] for line in usage.split("names:\n", 1)[1].split("\n\n", 1)[0].splitlines() if line.startswith("  ")
             and not line.startswith("   ")]
    for name in names:
        for ending in ("nrrd", "vtu", "npz", "ply"):
            path = os.path.join(folder, f"{name}.{ending}")
            if subprocess.run([OVOID, "make", name, "-o", path], stderr=subprocess.DEVNULL).returncode == 0:
                yield path
                break


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("inputs", nargs="*")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print("| data | width filled | height filled | mean luminance | nearly black |\n|---|---|---|---|---|")
        for word in options.inputs or made(folder):
            across, down, luminance, black = measures(drawn(word.split("+"), folder))
            name = os.path.basename(word.split("+")[0].rstrip("/"))
            print(f"| {name} | {100 * across:.0f} % | {100 * down:.0f} % | {luminance:.2f} | {100 * black:.1f} % |", flush=True)


if __name__ == "__main__":
    main()
