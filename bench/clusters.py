#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Particles as they lie in the sky: clusters.py [--count N] [--frames N] [--against PROGRAM].

Point clouds without any array, of several distributions, each drawn as it comes (the number of particles per volume, default look, 512 x
512): the time from the start of the process to a written picture, the frames after it, and, with levels and merging against every
particle by itself (`--post-convolution off`), how far the pictures are apart and what that saves. `--against` draws with another build,
too. The first three were looked at while the program was tuned, the others not."""
import argparse
import array
import json
import math
import os
import random
import struct
import subprocess
import tempfile
import time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
SIZE = ["--size", "512x512", "--view", "+z", "--fit", "box"]


def direction(rng):
    z, turn = rng.uniform(-1, 1), rng.uniform(0, 2 * math.pi)
    across = math.sqrt(1 - z * z)
    return across * math.cos(turn), across * math.sin(turn), z


def plummer(rng, count):
    for _ in range(count):
        radius = min((max(rng.random(), 1e-6) ** (-2 / 3) - 1 + 1e-9) ** -0.5, 60)
        yield [radius * d for d in direction(rng)]


def clumps(rng, count):
    centers = [([rng.uniform(0, 100) for _ in range(3)], 10 ** rng.uniform(-1.5, 1)) for _ in range(60)]
    for _ in range(count):
        center, width = centers[int(rng.random() ** 3 * len(centers))]
        yield [c + rng.gauss(0, width) for c in center]


def uniform(rng, count):
    for _ in range(count):
        yield rng.random(), rng.random(), rng.random()


def disc(rng, count):
    for _ in range(count):
        radius, turn = rng.expovariate(1), rng.uniform(0, 2 * math.pi)
        turn += 2 * math.log(radius + 0.1)
        yield radius * math.cos(turn), radius * math.sin(turn), rng.gauss(0, 0.03)


def filaments(rng, count):
    nodes = [[rng.uniform(0, 1) for _ in range(3)] for _ in range(24)]
    pairs = [(a, b) for a in range(24) for b in range(a) if math.dist(nodes[a], nodes[b]) < 0.35]
    for _ in range(count):
        a, b = pairs[int(rng.random() * len(pairs))]
        along = rng.betavariate(0.4, 0.4)
        yield [p + along * (q - p) + rng.gauss(0, 0.004) for p, q in zip(nodes[a], nodes[b])]


def shells(rng, count):
    for _ in range(count):
        radius = (1, 2.5, 6)[int(3 * rng.random())] * (1 + 0.01 * rng.gauss(0, 1))
        yield [radius * d for d in direction(rng)]


DISTRIBUTIONS = (plummer, clumps, uniform, disc, filaments, shells)


def write_ply(path, points):
    numbers = array.array("f", [x for point in points for x in point])
    with open(path, "wb") as file:
        file.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % (len(numbers) // 3))
        file.write(b"".join(b"property float %c\n" % axis for axis in b"xyz") + b"end_header\n")
        numbers.tofile(file)


def pixels(path):
    with open(path, "rb") as file:
        data = file.read()
    numbers = array.array("f")
    numbers.frombytes(data[10 + struct.unpack("<H", data[8:10])[0]:])
    return numbers


def psnr(a, b):
    square = sum((x - y) ** 2 for x, y in zip(a, b)) / len(a)
    return min(150.0, -10 * math.log10(square + 1e-30))


def draw(program, folder, path, frames, *words):
    """Seconds to the first picture, milliseconds of the frames after it, and the picture."""
    picture, profile = os.path.join(folder, "picture.npy"), os.path.join(folder, "profile.json")
    begin = time.perf_counter()
    subprocess.run([program, "render", path, *SIZE, *words, "-o", picture], check=True, stderr=subprocess.DEVNULL)
    first = time.perf_counter() - begin
    subprocess.run([program, "render", path, *SIZE, *words, "--repeat", str(frames), f"--profile={profile}", "-o", picture], check=True,
                   stderr=subprocess.DEVNULL)
    with open(profile, encoding="utf-8") as file:
        return first, json.load(file)["frame_ms"]["median"], pixels(picture)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--against", metavar="PROGRAM", help="another build of ovoid")
    options = parser.parse_args()
    print("| distribution | start to picture, s | frame, ms | frame without levels and merging, ms | dB between |"
          + (" other build: start, s | frame, ms |" if options.against else ""))
    print("|---|---|---|---|---|" + ("---|---|" if options.against else ""))
    with tempfile.TemporaryDirectory() as folder:
        for distribution in DISTRIBUTIONS:
            path = os.path.join(folder, "points.ply")
            write_ply(path, distribution(random.Random(7), options.count))
            first, frame, picture = draw(OVOID, folder, path, options.frames)
            _, direct, exact = draw(OVOID, folder, path, options.frames, "--post-convolution", "off")
            row = f"| {distribution.__name__} | {first:.2f} | {frame:.0f} | {direct:.0f} | {psnr(picture, exact):.0f} |"
            if options.against:
                before, other, _ = draw(options.against, folder, path, options.frames)
                row += f" {before:.2f} | {other:.0f} |"
            print(row, flush=True)


if __name__ == "__main__":
    main()
