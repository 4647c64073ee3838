#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What half sheets lose: unlit pictures with --sheet-precision fp16 against fp32, as a table; lit ones keep floats. half_sheets.py NAME=FILE [NAME=FILE...]

Sample data by formula are added. Needs a Vulkan device; a software driver will do.
"""
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = os.path.join(ROOT, "build", "release", "bin", "ovoid")
COMPARE = os.path.join(ROOT, "bench", "device", "compare.py")
SAMPLES = {"head": ["--size", "64"], "marschner-lobb": ["--size", "40"], "blobs": ["--count", "2000"]}


def run(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def main():
    with tempfile.TemporaryDirectory() as folder:
        data = dict(word.split("=", 1) for word in sys.argv[1:])
        for name, flags in SAMPLES.items():
            data[name] = os.path.join(folder, name + (".ply" if name == "blobs" else ".nrrd"))
            run(PROGRAM, "make", name, "-o", data[name], *flags)
        print("| data | PSNR, greatest difference |\n|---|---|")
        for name, path in data.items():
            pictures = []
            for precision in ("fp32", "fp16"):
                pictures.append(os.path.join(folder, precision + ".npy"))
                run(PROGRAM, "render", path, "--view", "+z", "--fit", "box", "-o", pictures[-1], "--size", "256x256", "--backend", "vulkan", "--post-convolution", "off",
                    "--no-shade", "--sheet-precision", precision)
            print(f"| {name} | {run(sys.executable, COMPARE, *pictures).strip()} |", flush=True)


if __name__ == "__main__":
    main()
