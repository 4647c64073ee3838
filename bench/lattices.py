#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Body-centred against Cartesian lattices of the same signal: lattices.py [--frames N] [--pictures OUT.png] [VOLUME:THRESHOLD...]

Each volume, and the Marschner-Lobb signal, is limited to a ball of frequencies and put on both lattices. Printed for each: samples, those above the
threshold, bytes of their runs; the least time, on one thread, of reconstruction (gathered: with gradients) and of the frame, ms, scattered and gathered, at one pixel per voxel; and PSNR of the
pictures, three spacings from the faces on, to one of a lattice of half the spacing. The last columns are the body-centred lattice's share of the Cartesian one. --pictures: the same
pictures side by side, a column for each volume: Cartesian, body-centred, and that of half the spacing."""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

from magnification import OVOID, difference, picture_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts"))
import contact_sheet  # noqa: E402

PIXELS = 256
ROUNDS = 3


def ovoid(*words):
    done = subprocess.run([OVOID, *words], check=True, capture_output=True, text=True)
    return done.stdout + done.stderr


def camera_of(path, described):
    low, high = described["bounds"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    half = PIXELS / 2 * min(described["spacing"])
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"position": [m + 1000 * half * d for m, d in zip(middle, (0.46, 0.32, 0.83))], "focal_point": middle, "view_up": [0, 1, 0],
                   "parallel_projection": True, "parallel_scale": half}, file)


def relevant(source, target, threshold, *flags):
    """Samples, relevant ones, and bytes of the runs and of all samples."""
    words = ovoid("convert", source, "-o", target, "--relevant-above", str(threshold), *flags)
    found = re.search(r"(\d+) of (\d+) samples are relevant.*runs: (\d+) bytes, (\d+) dense", words)
    kept, total, runs, dense = (int(word) for word in found.groups())
    return {"samples": total, "relevant": kept, "run bytes": runs, "dense bytes": dense}


def frame(volume, camera, flags, frames, folder):
    picture, profile = os.path.join(folder, "picture.npy"), os.path.join(folder, "profile.json")
    ovoid("render", volume, "--sheets", "image", "--camera", camera, "--size", f"{PIXELS}x{PIXELS}", "-o", picture, *flags, "--repeat", str(frames), f"--profile={profile}")
    with open(profile, encoding="utf-8") as file:
        measured = json.load(file)
    stages = measured["stages_ms"]  # scattered, gradients are gathered all the same
    gathered = 0 if "scatter" in flags else stages["gradient"]
    return {"frame": measured["frame_ms"]["median"], "reconstruct": stages["reconstruct"] + gathered}, picture_of(picture)


def measure(source, threshold, folder, options):
    paths = {kind: os.path.join(folder, f"{kind}.h5") for kind in ("cc", "bcc", "fine")}
    for kind in ("cc", "bcc"):
        ovoid("convert", source, "-o", paths[kind], "--lattice", kind)
    ovoid("convert", paths["cc"], "-o", paths["fine"], "--lattice", "cc", "--lattice-spacing", "0.5", "--no-band-limit")
    described = json.loads(ovoid("info", "--json", paths["cc"]))
    camera = os.path.join(folder, "camera.json")
    camera_of(camera, described)
    high = described["arrays"][0]["range"][1]
    spacing = min(described["spacing"])
    # Lattices end a little apart; what is compared lies within both.
    inside = ",".join(f"{a + 3 * spacing}:{b - 3 * spacing}" for a, b in zip(*described["bounds"]))
    look = ["--crop-world", inside, "--colormap", "viridis", "--range", f"{threshold},{high}", "--opacity", f"{threshold}:0,{high}:0.4", "--unit-distance", str(spacing),
            "--sampling-distance", str(spacing)]
    expected = frame(paths["fine"], camera, [*look, "--prefilter"], 1, folder)[1]
    rows = {kind: relevant(paths[kind], os.path.join(folder, "runs.h5"), threshold) for kind in ("cc", "bcc")}
    pictures = {}
    for way in ("scatter", "gather"):
        taken = {"cc": [], "bcc": []}
        for _ in range(ROUNDS):  # by turns
            for kind, runs in taken.items():
                times, picture = frame(paths[kind], camera, [*look, "--evaluate", way, "--post-convolution", "off", "--threads", "1"],
                                       1 if way == "scatter" else options.frames, folder)
                runs.append(times)
                rows[kind]["dB"] = difference(picture, expected)[0]
                pictures[kind] = picture
        for kind, runs in taken.items():
            rows[kind] |= {f"{way} {stage}": min(times[stage] for times in runs) for stage in ("frame", "reconstruct")}
    return rows, [rows_of(picture) for picture in (pictures["cc"], pictures["bcc"], expected)]


def rows_of(picture):
    """Rows of RGB bytes, on white."""
    lines = []
    for y in range(PIXELS):
        line = bytearray()
        for x in range(PIXELS):
            r, g, b, a = picture[4 * (y * PIXELS + x):4 * (y * PIXELS + x) + 4]
            line += bytes(min(255, max(0, round(255 * (c + 1 - a)))) for c in (r, g, b))
        lines.append(bytes(line))
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("volumes", nargs="*", metavar="VOLUME:THRESHOLD")
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--pictures")
    options = parser.parse_args()
    columns = ["samples", "relevant", "dense bytes", "run bytes", "scatter reconstruct", "scatter frame", "gather reconstruct", "gather frame"]
    print("| data | lattice | " + " | ".join(columns) + " | dB |\n|---|---|" + "---:|" * (len(columns) + 1))
    columns_of_sheet = []
    with tempfile.TemporaryDirectory() as folder:
        signal = os.path.join(folder, "marschner-lobb.nrrd")
        ovoid("make", "marschner-lobb", "--size", "128", "--type", "uint8", "-o", signal)
        for source, threshold in [(signal, 100.0), *((path, float(number)) for path, number in (word.rsplit(":", 1) for word in options.volumes))]:
            rows, pictures = measure(source, threshold, folder, options)
            columns_of_sheet.append(pictures)
            name = os.path.basename(source).split(".")[0]
            for kind, row in rows.items():
                print(f"| {name} | {kind} | " + " | ".join(f"{row[column]:,.0f}" for column in columns) + f" | {row['dB']:.1f} |", flush=True)
            shares = [rows["bcc"][column] / rows["cc"][column] for column in columns]
            print(f"| {name} | bcc / cc | " + " | ".join(f"{share:.3f}" for share in shares) + f" | {rows['bcc']['dB'] - rows['cc']['dB']:+.1f} |", flush=True)
    if options.pictures:
        contact_sheet.write_png(options.pictures, contact_sheet.sheet([list(line) for line in zip(*columns_of_sheet)]))


if __name__ == "__main__":
    main()
