#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""PSNR (peak 1) and greatest 8-bit difference of two NPY pictures, over pixels covered in either: compare.py A B [LEAST_DB].

Exits 1 if the PSNR is less than LEAST_DB.
"""
import array
import ast
import math
import struct
import sys


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    size = struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:10 + size].decode("ascii"))
    numbers = array.array("f")
    numbers.frombytes(data[10 + size:])
    return header["shape"], numbers


def main():
    (shape, a), (other, b) = read(sys.argv[1]), read(sys.argv[2])
    if shape != other:
        raise SystemExit(f"sizes differ: {shape} and {other}")
    covered = squares = greatest = 0
    for i in range(0, len(a), 4):
        if a[i + 3] == 0 and b[i + 3] == 0:
            continue
        covered += 1
        for c in range(4):
            difference = a[i + c] - b[i + c]
            squares += difference * difference
            greatest = max(greatest, abs(difference))
    psnr = 10 * math.log10(4 * covered / squares) if squares else math.inf
    print(f"{psnr:.1f} dB, {greatest * 255:.2f} / 255 at most, {covered} pixels")
    return 1 if not covered or len(sys.argv) > 3 and psnr < float(sys.argv[3]) else 0


if __name__ == "__main__":
    sys.exit(main())
