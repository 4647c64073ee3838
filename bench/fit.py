#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What fewer kernels come to: fit.py [INPUT[@ARRAY]...]

Fits each input (files joined by "+" are one; without any, what `ovoid make` has) and prints what `ovoid fit` tells. Meshes, particles and
kernels with a quarter, a tenth, a thirtieth and a hundredth of their kernels, beside the errors of all of them as they were: of meshes
with values at their nodes against interpolation in the cells, of everything else against the field of all kernels; and how many times as
fast as those of all kernels the stage "reconstruct" and the frame are (1024 x 768, the look that the input has, meshes within their surface). Lattices at several
PSNRs, beside the bytes of zfp's file (Debian: zfp) with the least error that is not below it."""
import argparse
import array
import json
import math
import os
import re
import shutil
import subprocess
import tempfile

from magnification import OVOID

SHARES = (4, 10, 30, 100)
PSNRS = (35, 38, 41, 44, 47)
MADE = ("fin.vtu", "galaxy.npz", "blobs.ply", "head.nii", "jet.nii")
HEADS = {
    False: ("data", "array", "kernels", "of all", "PSNR, dB", "all, as they were", "greatest error", "wrongly empty", "wrongly full", "time",
            "reconstruct", "frame"),
    True: ("data", "samples", "PSNR, dB", "kernels", "bytes", "per kernel", "greatest error", "time", "zfp's bytes", "its PSNR"),
}


def run(*words):
    return subprocess.run([OVOID, *words], check=True, capture_output=True, text=True).stdout


def fitted(inputs, flags, goal, ending, folder):
    report = os.path.join(folder, "report.json")
    run("fit", *inputs, "-o", os.path.join(folder, "fitted" + ending), *goal, "--report", report, *flags)
    with open(report, encoding="utf-8") as file:
        return json.load(file)


def made(names, folder):
    for name in names:
        path = os.path.join(folder, name)
        run("make", name.split(".")[0], "-o", path)
        yield path


def stages(words, look, folder):
    """Milliseconds of the least of some frames' reconstruct stage and of the least frame."""
    profile = os.path.join(folder, "profile.json")
    times = []
    for _ in range(3):
        run("render", *words, "-o", os.path.join(folder, "picture.png"), "--tf", look, "--fit", "box", "--repeat", "3", f"--profile={profile}")
        with open(profile, encoding="utf-8") as file:
            told = json.load(file)
        times.append((told["stages_ms"].get("reconstruct", 0), told["frame_ms"]["min"]))
    return [min(column) for column in zip(*times)]


def speed_up(inputs, flags, kind, look, folder):
    is_mesh = kind == "mesh" and len(inputs) == 1
    ours = stages([os.path.join(folder, "fitted.ply"), *(["--within", inputs[0], "--surface=0"] if is_mesh else [])], look, folder)
    theirs = stages([*inputs, *flags, *(["--surface=0"] if is_mesh else [])], look, folder)
    return [f"{before / max(after, 0.01):.1f}" for before, after in zip(theirs, ours)]


def kernels_of_sets(name, inputs, flags, kind, folder):
    look = os.path.join(folder, "look.json")
    run("render", *inputs, *flags, "-o", os.path.join(folder, "first.png"), "--size", "64x64", "--save-look", look)
    all_kernels = fitted(inputs, flags, ("--kernels", "1"), ".ply", folder)["source_kernels"]
    for share in SHARES:
        report = fitted(inputs, flags, ("--kernels", str(max(1, all_kernels // share))), ".ply", folder)
        before = report["source_psnr_db"]
        yield (name, report["array"], report["kernels"], f"1/{share}", f"{report['psnr_db']:.1f}",
               "-" if before is None or before > 200 else f"{before:.1f}", f"{100 * report['greatest_error'] / report['range']:.1f} %",
               f"{100 * report['wrongly_empty']:.2f} %", f"{100 * report['wrongly_full']:.1f} %", f"{report['seconds']:.1f} s",
               *speed_up(inputs, flags, kind, look, folder))


def zfp(raw, dims, psnr, value_range):
    """Bytes and PSNR of zfp's file of floats whose PSNR is at least that: its tolerances are powers of two."""
    if shutil.which("zfp") is None:
        return "-", "-"
    tolerance = value_range
    while True:
        told = subprocess.run(["zfp", "-s", "-f", "-3", *map(str, dims), "-a", str(tolerance), "-i", raw, "-z", os.devnull],
                              check=True, capture_output=True, text=True).stderr
        rmse = float(re.search(r"rmse=([^ ]+)", told).group(1))
        size = int(re.search(r"zfp=([0-9]+)", told).group(1))
        # zfp's own PSNR is against half the range.
        reached = 20 * math.log10(value_range / rmse) if rmse > 0 else float("inf")
        if reached >= psnr:
            return size, f"{reached:.1f}"
        tolerance /= 2


def floats_of(inputs, flags, folder):
    """A raw file of a lattice's samples as floats, and how many there are along each axis."""
    raw = os.path.join(folder, "floats.npy")
    run("convert", *inputs, "-o", raw, *flags)
    with open(raw, "rb") as file:
        head = file.read(10)
        header = file.read(int.from_bytes(head[8:10], "little")).decode("latin-1")
    shape = [int(n) for n in re.search(r"'shape': \(([^)]*)\)", header).group(1).split(",") if n.strip()]
    floats = os.path.join(folder, "floats.raw")
    write_floats(raw, len(head) + len(header), re.search(r"'descr': '([^']*)'", header).group(1), floats)
    return floats, shape[::-1]


def levels_of_lattices(name, inputs, flags, _, folder):
    floats, dims = floats_of(inputs, flags, folder)
    for psnr in PSNRS:
        report = fitted(inputs, flags, ("--psnr", str(psnr)), ".h5", folder)
        size, reached = zfp(floats, dims, psnr, report["range"])
        yield (name, report["source_kernels"], f"{report['psnr_db']:.1f}", report["kernels"], report["bytes"],
               f"{report['bytes'] / max(1, report['kernels']):.2f}", f"{100 * report['greatest_error'] / report['range']:.1f} %",
               f"{report['seconds']:.1f} s", size, reached)


def write_floats(path, begin, descr, to):
    codes = {"|u1": "B", "|i1": "b", "<u2": "H", "<i2": "h", "<u4": "I", "<i4": "i", "<f4": "f", "<f8": "d"}
    with open(path, "rb") as file, open(to, "wb") as out:
        file.seek(begin)
        while chunk := file.read(1 << 24):
            array.array("f", array.array(codes[descr], chunk)).tofile(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("inputs", nargs="*")
    options = parser.parse_args()
    printed = None
    with tempfile.TemporaryDirectory() as folder:
        for word in options.inputs or made(MADE, folder):
            files, _, array_name = word.partition("@")
            inputs = files.split("+")
            flags = ["--array", array_name] if array_name else []
            kind = json.loads(run("info", "--json", *inputs))["kind"]
            is_lattice = kind == "lattice"
            if printed != is_lattice:
                print("\n| " + " | ".join(HEADS[is_lattice]) + " |\n" + "|---" * len(HEADS[is_lattice]) + "|")
                printed = is_lattice
            rows = levels_of_lattices if is_lattice else kernels_of_sets
            for row in rows(os.path.basename(inputs[0].rstrip("/")), inputs, flags, kind, folder):
                print("| " + " | ".join(map(str, row)) + " |", flush=True)


if __name__ == "__main__":
    main()
