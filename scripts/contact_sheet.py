#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws data with no flag but -o and puts the pictures on one sheet: contact_sheet.py OUT.png INPUT...

Every picture is drawn at the program's own size, on its own background, and reduced four times. A word "--" begins a new row;
files joined by "+" are one input; a .ppm file of that size stands for itself."""
import array
import ast
import os
import struct
import subprocess
import sys
import tempfile
import zlib

OVOID = os.path.join(os.path.dirname(__file__), "..", "build", "release", "bin", "ovoid")
REDUCTION = 4
GAP = 6  # pixels between pictures
BACKGROUND = (0.10, 0.11, 0.13)


def drawn(inputs, folder):
    """Rows of bytes, RGB, of the reduced picture on the program's background."""
    path = os.path.join(folder, "picture.npy")
    subprocess.run([OVOID, "render", *inputs, "-o", path], check=True)
    with open(path, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<H", data, 8)
    height, width, _ = ast.literal_eval(data[10:10 + length].decode("latin-1"))["shape"]
    values = array.array("f", data[10 + length:])
    rows = []
    for y in range(0, height - REDUCTION + 1, REDUCTION):
        row = bytearray()
        for x in range(0, width - REDUCTION + 1, REDUCTION):
            sums = [0.0] * 4
            for dy in range(REDUCTION):
                start = 4 * ((y + dy) * width + x)
                for c in range(4):  # premultiplied, so sums are means
                    sums[c] += sum(values[start + c:start + 4 * REDUCTION:4])
            rest = 1 - sums[3] / REDUCTION ** 2
            row += bytes(min(255, max(0, round(255 * (s / REDUCTION ** 2 + rest * back)))) for s, back in zip(sums, BACKGROUND))
        rows.append(bytes(row))
    return rows


def write_png(path, rows):
    def chunk(kind, content):
        body = kind + content
        return struct.pack(">I", len(content)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)
    # Each row as differences to the one above (filter 2), which deflate likes.
    lines, above = [], bytes(len(rows[0]))
    for row in rows:
        lines.append(b"\x02" + bytes((a - b) & 255 for a, b in zip(row, above)))
        above = row
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
                   chunk(b"IDAT", zlib.compress(b"".join(lines), 9)) + chunk(b"IEND", b""))


def reduced(path):
    """A picture in PPM of the same size, likewise reduced."""
    with open(path, "rb") as file:
        lines = [file.readline()]
        while len(lines) < 3:
            line = file.readline()
            if not line.startswith(b"#"):
                lines.append(line)
        data = file.read()
    assert lines[0] == b"P6\n"
    width, height = map(int, lines[1].split())
    rows = []
    for y in range(0, height - REDUCTION + 1, REDUCTION):
        row = bytearray()
        for x in range(0, width - REDUCTION + 1, REDUCTION):
            for c in range(3):
                starts = [3 * ((y + dy) * width + x) + c for dy in range(REDUCTION)]
                row.append(sum(sum(data[start:start + 3 * REDUCTION:3]) for start in starts) // REDUCTION ** 2)
        rows.append(bytes(row))
    return rows


def sheet(pictures):
    """`pictures`: rows of pictures of one size; a short row ends in white."""
    height, width = len(pictures[0][0]), len(pictures[0][0][0])
    columns = max(map(len, pictures))
    rows = []
    for line in pictures:
        for y in range(height):
            cells = [picture[y] for picture in line] + [b"\xff" * width] * (columns - len(line))
            rows.append((b"\xff" * 3 * GAP).join(cells))
        rows += [b"\xff" * len(rows[0])] * GAP
    return rows[:-GAP]


def main(arguments):
    if len(arguments) < 2:
        sys.exit(__doc__)
    pictures = [[]]
    with tempfile.TemporaryDirectory() as folder:
        for word in arguments[1:]:
            if word == "--":
                pictures.append([])
                continue
            pictures[-1].append(reduced(word) if word.endswith(".ppm") else drawn(word.split("+"), folder))
    write_png(arguments[0], sheet(pictures))


if __name__ == "__main__":
    main(sys.argv[1:])
