#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far pictures are from those of ever finer sheets: convergence.py [--size N] [--frames N] [FILE...]

Without files: what `ovoid make` makes, and those of FILES that are in the folder of real data (run.py).

The default classification, refined, and what was the default, sampled, against the converged picture: samples at every pixel, their distance
halved until the picture changes by less than 55 dB tells. Three looks: the default; opaque, from nothing to 0.9 within 5 % of the range; thin, a
peak of 2 %. dB and SSIM [Wang 2004] are of colours over black; `turn` is how much the error changes when the camera turns by half a degree, by how
much the picture does. Times are frames of one run, medians, by turns."""
import argparse
import json
import math
import os
import statistics
import subprocess
import tempfile

from magnification import OVOID, picture_of
from volumes import array_flags, data_folder

ENOUGH = 55.0  # dB between one picture and that of half the distance
FINEST = 128  # sheets per default distance
MADE = {"ball.nrrd": ["ball", "--size", "64"], "head.nrrd": ["head", "--size", "96"], "tornado.nrrd": ["tornado", "--size", "80"],
        "fin.vtu": ["fin"], "galaxy.csv": ["galaxy"]}
FILES = ["bonsai/bonsai.nii.gz", "engine/engine.nii.gz", "fuel/fuel.nii.gz", "headsq/quarter.nhdr", "hydrogen_ironprot/ironProt.vtk",
         "mri_nifti/MR.nii.gz", "can/can.vtu", "disk_out_ref/disk_out_ref.ex2", "limb_tetra/limb_ugrid.vtk", "mug/mug.e",
         "dm_halo/dm_halo.h5py", "phantom_sph/adiabatic_00000.h5", "dicom_ct", "isabel/isabel_30.vti", "mri_nifti/example4d.nii.gz",
         "bluntfin/bluntfinxyz.bin+bluntfin/bluntfinq.bin", "enzo_amr/moving7_0010.hierarchy", "md_water/spce_all_coords.lammpstrj.bz2",
         "zeldovich/zeldovich.csv.gz"]  # "+": one input
PLACE = 0.35  # of the range: where opaque and thin looks lie
WINDOW, STRIDE = 8, 4  # pixels, of SSIM

# The whole box from +z, whatever shows, and the volume of meshes: what the table is about.
SEEN = ["--view", "+z", "--fit", "box", "--light", "headlight",
        "--occlusion", "0"]
MESHES = (".vtu", ".ex2", ".e", "ugrid.vtk", ".bin")


def colors_of(path):
    """Premultiplied, so over black."""
    values = picture_of(path)
    return [values[c::4] for c in range(3)]


def rms(a, b):
    return math.sqrt(sum(sum((x - y) ** 2 for x, y in zip(p, q)) for p, q in zip(a, b)) / (3 * len(a[0])))


def decibels(a, b):
    return min(150.0, -20 * math.log10(rms(a, b) + 1e-30))


def ssim(a, b, width):
    """The mean over square windows of the colours' mean."""
    gray_a, gray_b = ([sum(pixel) / 3 for pixel in zip(*colors)] for colors in (a, b))
    found = []
    for top in range(0, len(gray_a) // width - WINDOW + 1, STRIDE):
        for left in range(0, width - WINDOW + 1, STRIDE):
            places = [(top + j) * width + left + i for j in range(WINDOW) for i in range(WINDOW)]
            x, y = [gray_a[p] for p in places], [gray_b[p] for p in places]
            mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
            var_x = sum((v - mean_x) ** 2 for v in x) / len(x)
            var_y = sum((v - mean_y) ** 2 for v in y) / len(y)
            both = sum((v - mean_x) * (w - mean_y) for v, w in zip(x, y)) / len(x)
            found.append((2 * mean_x * mean_y + 1e-4) * (2 * both + 9e-4) / ((mean_x**2 + mean_y**2 + 1e-4) * (var_x + var_y + 9e-4)))
    return statistics.fmean(found)


class Subject:
    """Pictures of one file by one look."""

    def __init__(self, path, look, size, folder):
        self.path, self.look, self.size, self.folder = path, look, size, folder
        self.seen = [*SEEN, "--surface=0"] if path.endswith(MESHES) else SEEN

    def draw(self, flags, turn=0.0, frames=1):
        """The picture, and the median frame in ms."""
        picture, profile = os.path.join(self.folder, "picture.npy"), os.path.join(self.folder, "profile.json")
        subprocess.run([OVOID, "render", *self.path.split("+"), *array_flags(self.path), "--sheets", "image", "--size", f"{self.size}x{self.size}", *self.seen, "--azimuth", str(30 + turn), "--elevation", "20", *self.look,
                        *flags, "--backend", "cpu", "--repeat", str(frames), f"--profile={profile}", "-o", picture], check=True, stderr=subprocess.DEVNULL)
        with open(profile, encoding="utf-8") as file:
            return colors_of(picture), json.load(file)["frame_ms"]["median"]

    def converged(self, distance, turn=0.0):
        """The picture, and the sheets per default distance that it took."""
        before, sheets = None, 8
        while True:
            flags = ["--classification", "sampled", "--post-convolution", "off", "--sampling-distance", repr(distance / sheets)]
            picture, _ = self.draw(flags, turn)
            if sheets >= FINEST or before and decibels(picture, before) >= ENOUGH:
                return picture, sheets
            before, sheets = picture, 2 * sheets


def looks_of(lo, hi):
    span = hi - lo
    edge = [f"{lo + (PLACE + f) * span!r}" for f in (0, 0.01, 0.02, 0.05)]
    fixed = ["--colormap", "viridis", "--range", f"{lo!r},{hi!r}"]
    return {"default": [], "opaque": [*fixed, f"--opacity={edge[0]}:0,{edge[3]}:0.9"],
            "thin": [*fixed, f"--opacity={edge[0]}:0,{edge[1]}:0.9,{edge[2]}:0"]}


def made_in(folder):
    for name, recipe in MADE.items():
        path = os.path.join(folder, name)
        subprocess.run([OVOID, "make", *recipe, "-o", path], check=True, stderr=subprocess.DEVNULL)
        yield path


def real_files():
    paths = ["+".join(os.path.join(data_folder(), part) for part in name.split("+")) for name in FILES]
    return [path for path in paths if all(map(os.path.exists, path.split("+")))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--frames", type=int, default=5)
    options = parser.parse_args()
    print("| data | look | converged at | sampled, dB | refined, dB | SSIM, sampled | SSIM, refined | turn, sampled | turn, refined | sampled, ms | "
          "refined, ms | refined / sampled |\n|" + "---|" * 12)
    with tempfile.TemporaryDirectory() as folder:
        for path in options.files or [*made_in(folder), *real_files()]:
            field = json.loads(subprocess.run([OVOID, "info", "--json", *path.split("+"), *array_flags(path)], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)["field"]
            for look, flags in looks_of(*field["range"]).items():
                subject = Subject(path, flags, options.size, folder)
                exact, sheets = subject.converged(field["default_unit_distance"])
                turned, _ = subject.converged(field["default_unit_distance"], 0.5)
                cells, times = {}, {}
                for way in ("sampled", "refined"):
                    chosen = ["--classification", way]
                    picture, times[way] = subject.draw(chosen, frames=options.frames)
                    other, _ = subject.draw(chosen, 0.5)
                    errors = [[[x - y for x, y in zip(p, q)] for p, q in zip(a, b)] for a, b in ((picture, exact), (other, turned))]
                    cells[way] = (f"{decibels(picture, exact):.1f}", f"{ssim(picture, exact, options.size):.3f}",
                                  f"{rms(*errors) / max(rms(exact, turned), 1e-9):.2f}")
                pairs = [cell for both in zip(cells["sampled"], cells["refined"]) for cell in both]
                print(f"| {os.path.basename(path).split('.')[0]} | {look} | {sheets} | " + " | ".join(pairs) +
                      f" | {times['sampled']:.0f} | {times['refined']:.0f} | {times['refined'] / times['sampled']:.2f} |", flush=True)


if __name__ == "__main__":
    main()
