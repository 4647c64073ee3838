#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What first pictures are like, in numbers: looks.py [INPUT...]

Draws each input (files joined by "+" are one; without any, every name of `ovoid make`) with no flag but size and output, and prints how
much of the picture is filled, how bright what shows is, and how much of it is nearly black. A pixel counts as shown from an opacity of
1/10 on; its luminance is that of its sRGB numbers (Rec. 709 weights) before the program's own background.

Of lattices, two measures of the default look itself, in CIEDE2000. A value shows if its opacity is at least a twentieth of the look's
greatest.
- A crop: the middle half of the samples along each axis, in a file of its own, so that its default look knows nothing of the rest. How far
  its colours are from the whole's: the mean over its samples, each with the weight of its opacity in the whole's look, and the greatest of
  those that show there.
- Materials: of the values that many samples share (`materials` of `ovoid info --json`) and that show, the least difference of colour between
  two that follow each other."""
import argparse
import array
import ast
import json
import math
import os
import struct
import subprocess
import tempfile

from color_difference import WrittenLook, difference, lab_of
from magnification import OVOID

WIDTH, HEIGHT = 512, 384
BACKGROUND = (0.10, 0.11, 0.13)
WEIGHTS = (0.2126, 0.7152, 0.0722)
SHOWN = 0.1
BLACK = 0.08
SHOWN_VALUE = 1 / 20  # of the look's greatest opacity
MOST_VALUES = 5000  # of a crop, evenly taken
NRRD_TYPES = {"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float": "f", "double": "d"}
NIFTI_TYPES = {2: "B", 4: "h", 8: "i", 16: "f", 64: "d", 256: "b", 512: "H", 768: "I"}


def drawn(inputs, folder, look):
    """RGBA, premultiplied, row by row; the look is written to that file."""
    path = os.path.join(folder, "picture.npy")
    subprocess.run([OVOID, "render", *inputs, "-o", path, "--size", f"{WIDTH}x{HEIGHT}", "--save-look", look], check=True,
                   stderr=subprocess.DEVNULL)
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


def middle_of(data, sizes, item):
    """Bytes of the middle half along each axis, and how many samples that is along each."""
    first, count = [n // 4 for n in sizes], [max(1, n // 2) for n in sizes]
    cut = bytearray()
    for z in range(first[2], first[2] + count[2]):
        for y in range(first[1], first[1] + count[1]):
            start = ((z * sizes[1] + y) * sizes[0] + first[0]) * item
            cut += data[start:start + count[0] * item]
    return bytes(cut), count


def converted(inputs, array_name, path):
    done = subprocess.run([OVOID, "convert", *inputs, "-o", path, "--array", array_name], stderr=subprocess.DEVNULL)
    if done.returncode != 0:
        return None
    with open(path, "rb") as file:
        return file.read()


def nrrd_crop(data, path):
    header, _, data = data.partition(b"\n\n")
    fields = dict(line.split(": ", 1) for line in header.decode().splitlines() if ": " in line)
    sizes = [int(word) for word in fields["sizes"].split()]
    if len(sizes) != 3 or fields["encoding"] != "raw":
        return None
    kind = NRRD_TYPES[fields["type"]]
    cut, count = middle_of(data, sizes, struct.calcsize(kind))
    lines = [f"sizes: {' '.join(map(str, count))}" if line.startswith("sizes: ") else line for line in header.decode().splitlines()]
    with open(path, "wb") as file:
        file.write("\n".join(lines).encode() + b"\n\n" + cut)
    return array.array(kind, cut)


def nifti_crop(data, path):
    sizes = struct.unpack_from("<8h", data, 40)
    kind = NIFTI_TYPES[struct.unpack_from("<h", data, 70)[0]]
    if sizes[0] != 3:
        return None
    offset, slope, intercept = struct.unpack_from("<3f", data, 108)
    cut, count = middle_of(data[int(offset):], sizes[1:4], struct.calcsize(kind))
    header = bytearray(data[:int(offset)])
    struct.pack_into("<3h", header, 42, *count)
    with open(path, "wb") as file:
        file.write(header + cut)
    return [slope * v + intercept for v in array.array(kind, cut)]


def crop_of(inputs, drawn_array, folder):
    """A file of the middle half along each axis, and some of its values; none of what cannot be written as one volume. NRRD keeps units, and
    NIfTI whole numbers that a factor belongs to."""
    ending, crop = ("nii", nifti_crop) if drawn_array.get("value_scale", 1) != 1 else ("nrrd", nrrd_crop)
    data = converted(inputs, drawn_array["name"], os.path.join(folder, f"whole.{ending}"))
    path = os.path.join(folder, f"crop.{ending}")
    values = None if data is None else crop(data, path)
    if values is None:
        return None
    return path, [v for v in values[::max(1, len(values) // MOST_VALUES)] if math.isfinite(v)]


def look_measures(inputs, look_path, folder):
    """Mean and greatest difference of a crop's colours, the least of two materials'; None where there is none."""
    told = subprocess.run([OVOID, "info", *inputs, "--json"], check=True, capture_output=True, text=True).stdout
    described = json.loads(told)
    if described["kind"] != "lattice" or described["field"] is None:
        return None, None, None
    look = WrittenLook(look_path)
    least = SHOWN_VALUE * max(opacity for _, (opacity,) in look.opacities)
    seen = [lab_of(look.color(value)) for value in described["field"]["materials"]["values"] if look.opacity(value) >= least]
    apart = min((difference(a, b) for a, b in zip(seen, seen[1:])), default=None)
    cropped = crop_of(inputs, next(a for a in described["arrays"] if a["name"] == described["field"]["array"]), folder)
    if cropped is None:
        return None, None, apart
    crop_look = os.path.join(folder, "crop.json")
    subprocess.run([OVOID, "render", cropped[0], "-o", os.path.join(folder, "crop.npy"), "--size", "16x12", "--save-look", crop_look],
                   check=True, stderr=subprocess.DEVNULL)
    other = WrittenLook(crop_look)
    known, weights, differences = {}, [], []
    for value in cropped[1]:
        weight = look.opacity(value)
        if weight == 0:
            continue
        if value not in known:
            known[value] = difference(lab_of(look.color(value)), lab_of(other.color(value)))
        weights.append(weight)
        differences.append(known[value])
    if not weights:
        return None, None, apart
    mean = sum(w * d for w, d in zip(weights, differences)) / sum(weights)
    return mean, max((d for w, d in zip(weights, differences) if w >= least), default=None), apart


def text_of(number):
    return "-" if number is None else f"{number:.1f}"


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
        print("| data | width filled | height filled | mean luminance | nearly black | a crop's colours, mean | greatest | materials, least |\n"
              "|---|---|---|---|---|---|---|---|")
        look = os.path.join(folder, "look.json")
        for word in options.inputs or made(folder):
            inputs = word.split("+")
            across, down, luminance, black = measures(drawn(inputs, folder, look))
            of_look = " | ".join(text_of(number) for number in look_measures(inputs, look, folder))
            name = os.path.basename(inputs[0].rstrip("/"))
            print(f"| {name} | {100 * across:.0f} % | {100 * down:.0f} % | {luminance:.2f} | {100 * black:.1f} % | {of_look} |", flush=True)


if __name__ == "__main__":
    main()
