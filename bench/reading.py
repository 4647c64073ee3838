#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What reading costs: reading.py [INPUT...].

First table: for each INPUT, the time from the start of the process to its end with a picture, and its greatest memory. Second table: a
volume of 400^3 uint16 in every format that is written, the greatest memory of `ovoid info` on it less that of `ovoid --version`, over
its decoded size."""
import os
import statistics
import subprocess
import sys
import tempfile
import time

OVOID = os.path.join(os.path.dirname(__file__), "..", "build", "release", "bin", "ovoid")
RUNS = 9
SIDE = 400


def run(*words):
    """Seconds and greatest resident bytes of one run."""
    start = time.perf_counter()
    process = subprocess.Popen([OVOID, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    if status:
        sys.exit(f"ovoid {' '.join(words)}: ended with status {status}")
    return seconds, usage.ru_maxrss * 1024


def first_pixel(inputs, folder):
    print("| input | start to picture, median of 9, s | least to greatest | greatest memory, MiB |\n|---|---|---|---|")
    for path in inputs:
        runs = [run("render", path, "-o", os.path.join(folder, "picture.png")) for _ in range(RUNS)]
        seconds = sorted(r[0] for r in runs)
        print(f"| {os.path.basename(path.rstrip('/'))} | {statistics.median(seconds):.2f} | {seconds[0]:.2f} to {seconds[-1]:.2f} | "
              f"{max(r[1] for r in runs) / 2 ** 20:.0f} |")
    print()


def memory(folder):
    decoded = 2 * SIDE ** 3
    base = run("--version")[1]
    source = os.path.join(folder, "volume.nrrd")
    run("make", "head", "--size", str(SIDE), "--type", "uint16", "-o", source)
    print(f"| format | memory of reading, times the decoded {decoded / 2 ** 20:.0f} MiB |\n|---|---|")
    for ending in (".nrrd", ".nhdr", ".npy", ".nii", ".nii.gz", ".vti", ".vtk"):
        path = os.path.join(folder, "copy" + ending)
        run("convert", source, "-o", path)
        print(f"| {ending} | {(run('info', path)[1] - base) / decoded:.2f} |")
        for name in os.listdir(folder):
            if name.startswith("copy"):
                os.remove(os.path.join(folder, name))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        if len(sys.argv) > 1:
            first_pixel(sys.argv[1:], scratch)
        memory(scratch)
