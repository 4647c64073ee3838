#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `ovoid fit --smooth` takes away of noise that is known: noise.py

Adds normal noise to two fields of 64^3 samples, fits them, and prints how much nearer to the field the fit is than the noisy samples
are, in decibels. Needs NumPy."""
import json
import os
import subprocess
import tempfile

import numpy

from magnification import OVOID

SIDE = 64
DEVIATIONS = (2, 6, 15)


def fields():
    z, y, x = numpy.mgrid[:SIDE, :SIDE, :SIDE].astype(float)

    def ball(at, radius):
        distance = numpy.sqrt((x - at[0]) ** 2 + (y - at[1]) ** 2 + (z - at[2]) ** 2)
        return 1 / (1 + numpy.exp(numpy.minimum(2 * (distance - radius), 50)))

    waves = 10 * numpy.sin(0.2 * x) * numpy.cos(0.15 * y)
    yield "balls with edges a sample wide", 100 * ball((32, 32, 32), 22) + 80 * ball((38, 30, 34), 8) + waves
    yield "waves of 50 samples", 100 + 60 * numpy.sin(0.1 * x + 0.05 * y) * numpy.cos(0.08 * z) + 40 * numpy.sin(0.12 * y)


def decibels(error):
    return 10 * numpy.log10((error**2).mean())


def main():
    random = numpy.random.default_rng(3)
    print("| field, range 200 | deviation | found | kernels | nearer to the noiseless field than the noisy one, dB |\n" + "|---" * 5 + "|")
    with tempfile.TemporaryDirectory() as folder:
        noisy, levels, clean, report = (os.path.join(folder, name) for name in ("noisy.npy", "clean.h5", "clean.npy", "report.json"))
        for name, field in fields():
            for deviation in DEVIATIONS:
                samples = (field + deviation * random.standard_normal(field.shape)).astype(numpy.float32)
                numpy.save(noisy, samples)
                subprocess.run([OVOID, "fit", noisy, "-o", levels, "--smooth", "--report", report], check=True, capture_output=True)
                subprocess.run([OVOID, "convert", levels, "-o", clean], check=True, capture_output=True)
                with open(report, encoding="utf-8") as file:
                    told = json.load(file)
                gain = decibels(samples - field) - decibels(numpy.load(clean).reshape(field.shape) - field)
                print(f"| {name} | {deviation} | {told['noise']:.2f} | {told['kernels']} | {gain:.1f} |", flush=True)


if __name__ == "__main__":
    main()
