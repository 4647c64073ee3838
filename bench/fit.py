#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What fewer kernels come to: fit.py [INPUT[@ARRAY]...]

Fits each input (files joined by "+" are one; without any, what `ovoid make` has that is no lattice) with a quarter, a tenth, a thirtieth
and a hundredth of its kernels, and prints the errors that `ovoid fit` tells, beside those of all kernels as they were. Errors of meshes with values at their nodes are
against interpolation in the cells; of everything else, against the field of all kernels."""
import argparse
import json
import os
import subprocess
import tempfile

from magnification import OVOID

SHARES = (4, 10, 30, 100)
MADE = ("fin.vtu", "galaxy.npz", "blobs.ply")


def fitted(inputs, flags, count, folder):
    report = os.path.join(folder, "report.json")
    subprocess.run([OVOID, "fit", *inputs, "-o", os.path.join(folder, "fitted.ply"), "--kernels", str(count), "--report", report, *flags],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(report, encoding="utf-8") as file:
        return json.load(file)


def made(folder):
    for name in MADE:
        path = os.path.join(folder, name)
        subprocess.run([OVOID, "make", name.split(".")[0], "-o", path], check=True, stderr=subprocess.DEVNULL)
        yield path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("inputs", nargs="*")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print("| data | array | kernels | of all | PSNR, dB | all, as they were | greatest error | wrongly empty | wrongly full | time |")
        print("|---|---|---|---|---|---|---|---|---|---|")
        for word in options.inputs or made(folder):
            files, _, array = word.partition("@")
            inputs = files.split("+")
            flags = ["--array", array] if array else []
            all_kernels = fitted(inputs, flags, 1, folder)["source_kernels"]
            for share in SHARES:
                report = fitted(inputs, flags, max(1, all_kernels // share), folder)
                before = report["source_psnr_db"]
                print(f"| {os.path.basename(inputs[0].rstrip('/'))} | {report['array']} | {report['kernels']} | 1/{share} | "
                      f"{report['psnr_db']:.1f} | {'-' if before is None or before > 200 else f'{before:.1f}'} | "
                      f"{100 * report['greatest_error'] / report['range']:.1f} % | {100 * report['wrongly_empty']:.2f} % | "
                      f"{100 * report['wrongly_full']:.1f} % | {report['seconds']:.1f} s |", flush=True)


if __name__ == "__main__":
    main()
