#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""D4* against Cartesian lattices in space and time: series.py [--size N] [--steps T] [NAME:THRESHOLD... | FILE...:THRESHOLD]

Series by formula (tornado, jet), sampled on both lattices; or series of files, resampled to both (the files of one separated by commas). Printed for each: samples of all steps, those above the threshold, bytes of their
runs, and of a step cut out at times between steps: seconds from the page cache, its samples, those above the threshold. The last row is D4*'s share."""
import argparse
import os
import re
import subprocess
import tempfile
import time

from lattices import ovoid, relevant
from magnification import OVOID

CUTS = 7


def write(source, kind, target, options):
    if source in ("tornado", "jet"):
        ovoid("make", source, "-o", target, "--lattice", kind, "--size", str(options.size), "--steps", str(options.steps), "--type", "uint8")
    else:
        ovoid("convert", *source.split(","), "-o", target, "--lattice", kind)


def cut(path, moment, target):
    start = time.perf_counter()
    subprocess.run([OVOID, "convert", path, "--time", str(moment), "-o", target], check=True, capture_output=True)
    return time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("series", nargs="*", metavar="NAME:THRESHOLD", default=["tornado:100", "jet:25"])
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--steps", type=int, default=64)
    options = parser.parse_args()
    columns = ["steps", "samples", "relevant", "share", "run bytes", "slice samples", "slice relevant", "cut s"]
    print("| data | lattice | " + " | ".join(columns) + " |\n|---|---|" + "---:|" * len(columns))
    with tempfile.TemporaryDirectory() as folder:
        for word in options.series:
            source, number = word.rsplit(":", 1)
            rows = {}
            for kind in ("cc4", "d4star"):
                path, target = os.path.join(folder, f"{kind}.h5"), os.path.join(folder, "cut.h5")
                write(source, kind, path, options)
                steps = int(re.search(r'"steps": *(\d+)', ovoid("info", "--json", path)).group(1))
                row = {"steps": steps, "samples": 0, "relevant": 0, "run bytes": 0}
                for step in range(steps):
                    one = os.path.join(folder, "one.h5")
                    found = relevant(path, one, float(number), "--step", str(step))
                    for column in ("samples", "relevant", "run bytes"):
                        row[column] += found[column]
                row["share"] = row["relevant"] / row["samples"]
                last = float(re.search(r'"times": *\[[^\]]*?([-+.e\d]+)\s*\]', ovoid("info", "--json", path)).group(1))
                seconds = sorted(cut(path, last * (0.11 + 0.8 * i / CUTS), target) for i in range(CUTS))
                row["cut s"] = seconds[CUTS // 2]
                found = relevant(target, os.path.join(folder, "one.h5"), float(number))
                row["slice samples"], row["slice relevant"] = found["samples"], found["relevant"]
                rows[kind] = row
                name = source.split(",")[0]
                print(f"| {os.path.basename(name)} | {kind} | " + " | ".join(f"{row[c]:,.3f}" if c in ("share", "cut s") else f"{row[c]:,}" for c in columns) + " |", flush=True)
            print("| | d4star / cc4 | " + " | ".join(f"{rows['d4star'][c] / rows['cc4'][c]:.3f}" for c in columns) + " |", flush=True)


if __name__ == "__main__":
    main()
