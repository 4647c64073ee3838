#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How long the program takes to start, and to a first small picture: start.py [PROGRAM...]

Without PROGRAM: build/release/bin/ovoid. Programs run by turns; the least and the median of 25 wall-clock times. Beside them,
what the system itself takes to start a process (`true`).
"""
import os
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
ROUNDS = 25


def seconds_of(command):
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - begin


def main(programs):
    with tempfile.TemporaryDirectory() as folder:
        mesh, scan, picture = (os.path.join(folder, name) for name in ("small.vtu", "small.nrrd", "picture.png"))
        subprocess.run([programs[0], "make", "fin", "-o", mesh, "--count", "200"], check=True, capture_output=True)
        subprocess.run([programs[0], "make", "ball", "-o", scan, "--size", "16"], check=True, capture_output=True)
        jobs = [("true", ["true"])]
        for program in programs:
            for what, words in (("--version", ["--version"]), ("a scan of 16^3", ["render", scan]),
                                ("a mesh of 200 points (.vtu)", ["render", mesh])):
                drawn = [] if what == "--version" else ["-o", picture, "--size", "64x64"]
                jobs.append((f"{os.path.relpath(program)}, {what}", [program, *words, *drawn]))
        taken = [[seconds_of(command) for _, command in jobs] for _ in range(ROUNDS)]
    print("| what | least, ms | median, ms |")
    print("|---|---:|---:|")
    for (what, _), seconds in zip(jobs, zip(*taken)):
        print(f"| {what} | {1000 * min(seconds):.1f} | {1000 * statistics.median(seconds):.1f} |")


if __name__ == "__main__":
    main(sys.argv[1:] or [os.path.join(ROOT, "build", "release", "bin", "ovoid")])
