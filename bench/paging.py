#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lattices larger than memory: paging.py [--size XxYxZ] [--runs N] [--format raw|h5]

Draws a volume of 16 bits, as it is or deflated in chunks, within a limit of memory that is a quarter of its samples, and with all samples in
memory; whole processes by turns, medians. The pictures must be the same."""
import argparse
import filecmp
import math
import os
import resource
import statistics
import subprocess
import tempfile
import time

from magnification import OVOID

VIEWS = {"from the front": ["--size", "512x512"], "from the side, nearer": ["--size", "512x512", "--azimuth", "90", "--zoom", "3"],
         "small; in memory by a level": ["--size", "256x256"]}


def draw(path, picture, flags, limit=None):
    """Seconds and the peak of resident memory, MiB."""
    def within():
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    begin = time.monotonic()
    process = subprocess.Popen([OVOID, "render", path, "-o", picture, "--backend", "cpu", "--threads", "2", "--kernel", "catmull-rom",
                                *flags], preexec_fn=within, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"ovoid failed within {limit} bytes")
    return time.monotonic() - begin, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", default="640x640x768")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--format", choices=("raw", "h5"), default="raw")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, f"head_{options.size}_uint16.{options.format}")
        subprocess.run([OVOID, "make", "head", "--size", options.size, "--type", "uint16", "-o", path], check=True)
        limit = 2 * math.prod(map(int, options.size.split("x"))) // 4
        print(f"File {os.path.getsize(path) / 2**20:.0f} MiB, limit {limit / 2**20:.0f} MiB\n")
        print("| view | from the file, s | peak MiB | in memory, s | peak MiB | same picture |\n|---|---|---|---|---|---|")
        for view, flags in VIEWS.items():
            pictures = [os.path.join(folder, name) for name in ("paged.png", "whole.png")]
            runs = [(draw(path, pictures[0], flags, limit), draw(path, pictures[1], flags)) for _ in range(options.runs)]
            cells = [f"{statistics.median(run[way][what] for run in runs):.{1 - what}f}" for way in (0, 1) for what in (0, 1)]
            print(f"| {view} | {' | '.join(cells)} | {'yes' if filecmp.cmp(*pictures, shallow=False) else 'no'} |", flush=True)


if __name__ == "__main__":
    main()
