#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Meshes and particles against VTK: kernels.py [OPTION...].

Two meshes of a million tetrahedra (`ovoid make fin`, with thin cells, and a jittered lattice), 512 x 512, shaded by Ovoid and, which is all
they can, unshaded by VTK's mappers for meshes, in one run: prints frame times and how many times as long the fastest of them takes. Then particles (`ovoid make galaxy`): the time from the
start of the process to a written picture, and of the frames after it; how both grow with the number of particles, and what radii of all
sizes cost; and VTK's way, which is to put them on a grid of 256^3 first. Needs `make bench` once, which builds the peers."""
import argparse
import array
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import time

import plots
from volumes import array_flags

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
PEER = os.path.join(ROOT, "build", "bench", "bin", "vtk_peer")
PIXELS = 512
MESH_MAPPERS = ("projected", "raycast", "zsweep")
GRID_FILTERS = {"splat": "vtkGaussianSplatter", "sph": "vtkSPHInterpolator"}  # vtkPointInterpolator takes longer than ten minutes


def ovoid(*words):
    subprocess.run([OVOID, *words], check=True, stderr=subprocess.DEVNULL)


def info(path):
    return json.loads(subprocess.run([OVOID, "info", "--json", path, *array_flags(path)], check=True, capture_output=True, text=True).stdout)


def profile_of(folder, *words):
    """The profile of repeated frames."""
    profile = os.path.join(folder, "profile.json")
    ovoid("render", *words, f"--profile={profile}", "-o", os.path.join(folder, "picture.npy"))
    with open(profile, encoding="utf-8") as file:
        return json.load(file)


def run_peer(mapper, words, frames):
    command = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24", PEER, "--mapper", mapper, *words, "--repeat", str(frames)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def look_and_camera(folder, described):
    """A ramp over the values and a view askew, for both programs."""
    field = described["field"]
    lo, hi = field["range"]
    look = os.path.join(folder, "look.json")
    with open(look, "w", encoding="utf-8") as file:
        json.dump([{"Name": "ramp", "ColorSpace": "RGB", "RGBPoints": [lo, 0.2, 0.3, 0.8, hi, 0.9, 0.5, 0.2],
                    "Points": [lo, 0, 0.5, 0, lo + 0.3 * (hi - lo), 0, 0.5, 0, hi, 0.3, 0.5, 0]}], file)
    low, high = described["bounds"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    size = sum((b - a) ** 2 for a, b in zip(low, high)) ** 0.5
    camera = os.path.join(folder, "camera.json")
    with open(camera, "w", encoding="utf-8") as file:
        json.dump({"position": [m + size * d for m, d in zip(middle, (0.9, 0.7, 1.5))], "focal_point": middle, "view_up": [0, 1, 0],
                   "parallel_projection": False, "view_angle": 30}, file)
    return look, camera, field


def jittered_mesh(folder, edge):
    """Cubes of a lattice whose nodes are moved by up to 0.3 of its spacing, six tetrahedra each; a VTU file."""
    rng = random.Random(9)
    places, values, cells = array.array("f"), array.array("f"), array.array("i")
    for node in range(edge ** 3):
        x, y, z = ((axis + rng.uniform(-0.3, 0.3)) / (edge - 1) for axis in (node % edge, node // edge % edge, node // edge ** 2))
        places.extend((x, y, z))
        values.append(math.sin(7 * x) * math.cos(5 * y) + math.sin(6 * z + 3 * x)
                      + 3 * math.exp(-40 * ((x - 0.5) ** 2 + (y - 0.4) ** 2 + (z - 0.6) ** 2)))
    corners = [i + edge * j + edge * edge * k for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    for node in range((edge - 1) ** 3):
        first = node % (edge - 1) + node // (edge - 1) % (edge - 1) * edge + node // (edge - 1) ** 2 * edge * edge
        for tetrahedron in ((0, 1, 3, 7), (0, 1, 7, 5), (0, 5, 7, 4), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7)):
            cells.append(4)
            cells.extend(first + corners[corner] for corner in tetrahedron)
    count = len(cells) // 5
    types = array.array("i", [10]) * count
    for numbers in (places, values, cells, types):
        numbers.byteswap()
    legacy, mesh = os.path.join(folder, "jittered.vtk"), os.path.join(folder, "jittered.vtu")
    with open(legacy, "wb") as file:
        file.write(b"# vtk DataFile Version 3.0\njittered\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS %d float\n" % edge ** 3)
        places.tofile(file)
        file.write(b"\nCELLS %d %d\n" % (count, 5 * count))
        cells.tofile(file)
        file.write(b"\nCELL_TYPES %d\n" % count)
        types.tofile(file)
        file.write(b"\nPOINT_DATA %d\nSCALARS v float 1\nLOOKUP_TABLE default\n" % edge ** 3)
        values.tofile(file)
    ovoid("convert", legacy, "-o", mesh)
    return mesh


def mesh_table(folder, mesh, frames, skips_slowest):
    described = info(mesh)
    look, camera, field = look_and_camera(folder, described)
    unit = str(field["default_unit_distance"])
    print(f"{described['cells']['count']} cells, {field['num_kernels']} kernels, {PIXELS} x {PIXELS}\n")
    print("| program | shaded | ready to draw after, ms | frame, ms (least) |\n|---|---|---|---|")
    own = profile_of(folder, mesh, "--tf", look, "--light", "headlight", "--occlusion", "0", "--camera", camera, "--size", f"{PIXELS}x{PIXELS}", "--unit-distance", unit,
                     "--repeat", str(frames))
    print(f"| ovoid | yes | {own['load_ms'] + own['model_ms']:.0f} | {own['frame_ms']['median']:.0f} ({own['frame_ms']['min']:.0f}) |")
    peers = {}
    for mapper in MESH_MAPPERS[:2] if skips_slowest else MESH_MAPPERS:
        peer = run_peer(mapper, ["--volume", mesh, "--look", look, "--camera", camera, "--array", field["array"], "--width", str(PIXELS),
                                 "--height", str(PIXELS), "--unit-distance", unit], frames if mapper != "zsweep" else 1)
        peers[mapper] = peer["frame_ms"]["median"]
        print(f"| VTK {peer['vtk']}, {mapper} | no | {peer['prepare_ms']:.0f} | {peers[mapper]:.0f} ({peer['frame_ms']['min']:.0f}) |")
    print(f"\nThe fastest of VTK's takes {min(peers.values()) / own['frame_ms']['median']:.1f} times as long.\n")


def particle_table(folder, most, frames, picture):
    print("| particles | start to picture, s | frame, ms (least) | greatest memory, MiB |\n|---|---|---|---|")
    count, rows = 10_000, []
    while count <= most:
        path = os.path.join(folder, "galaxy.npz")
        ovoid("make", "galaxy", "--count", str(count), "-o", path)
        size = ["--size", f"{PIXELS}x{PIXELS}"]
        begin = time.perf_counter()
        ovoid("render", path, *array_flags(path), *size, "-o", os.path.join(folder, "picture.png"))
        first = time.perf_counter() - begin
        profile = profile_of(folder, path, *array_flags(path), *size, "--repeat", str(frames))
        print(f"| {count} | {first:.2f} | {profile['frame_ms']['median']:.0f} ({profile['frame_ms']['min']:.0f}) | "
              f"{profile['peak_memory_bytes'] / 2 ** 20:.0f} |")
        rows.append((count, first, profile["frame_ms"]["median"] / 1000))
        count *= 10
    print()
    if picture:
        plots.log_plot(picture, [("start to picture", "#0b5fa5", False, [row[:2] for row in rows]),
                                 ("frame", "#c0392b", False, [(row[0], row[2]) for row in rows]),
                                 ("linear", "#888", True, [(1e5, 0.2), (1e7, 20)])], "particles",
                       [(10 ** power, f"1e{power}") for power in range(4, 8)], [(10 ** power, f"{10 ** power:g} s") for power in range(-1, 3)])


def grid_table(folder, count, frames):
    path = os.path.join(folder, "galaxy.npz")
    plain = os.path.join(folder, "galaxy.ply")
    ovoid("make", "galaxy", "--count", str(count), "-o", path)
    ovoid("convert", path, "-o", plain)
    field = info(path)["field"]
    print(f"{count} particles, {PIXELS} x {PIXELS}\n")
    print("| program | shaded | ready to draw after, ms | frame, ms (least) |\n|---|---|---|---|")
    own = profile_of(folder, path, *array_flags(path), "--size", f"{PIXELS}x{PIXELS}", "--repeat", str(frames))
    print(f"| ovoid, no grid | yes | {own['load_ms'] + own['model_ms']:.0f} | {own['frame_ms']['median']:.0f} ({own['frame_ms']['min']:.0f}) |")
    for grid, name in GRID_FILTERS.items():
        peer = run_peer("fixed", ["--volume", plain, "--grid", grid, "--width", str(PIXELS), "--height", str(PIXELS), "--sampling-distance",
                                  str(field["default_unit_distance"]), "--unit-distance", str(field["default_unit_distance"])], frames)
        print(f"| VTK {peer['vtk']}, {name} to 256^3, ray cast | yes | {peer['prepare_ms']:.0f} | {peer['frame_ms']['median']:.0f} "
              f"({peer['frame_ms']['min']:.0f}) |")
    print()


def radius_table(folder, count, frames):
    """Smoothing lengths from 1e-8 to 2e-2 of the domain in one set, evenly by their logarithm, against all of the median's size and of
    the greatest's."""
    print("| smoothing lengths, of the domain | frame, ms (least) |\n|---|---|")
    spread = [10 ** (-8 + 6.3 * i / (count - 1)) for i in range(count)]
    chance = random.Random(1)
    chance.shuffle(spread)
    places = [(chance.random(), chance.random(), chance.random()) for _ in range(count)]
    for name, radii in (("1e-8 to 2e-2", spread), ("all 1.4e-5, their median", [1.4e-5] * count), ("all 2e-2", [2e-2] * count)):
        path = os.path.join(folder, "radii.csv")
        with open(path, "w", encoding="utf-8") as file:
            file.write("x,y,z,value,h\n")
            for (x, y, z), h in zip(places, radii):
                file.write(f"{x!r},{y!r},{z!r},{x:.4f},{h!r}\n")
        own = profile_of(folder, path, "--array", "value", "--radius-array", "h", "--size", f"{PIXELS}x{PIXELS}", "--repeat", str(frames))
        print(f"| {name} | {own['frame_ms']['median']:.0f} ({own['frame_ms']['min']:.0f}) |")
    print()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=180_000)
    parser.add_argument("--particles", type=int, default=10_000_000)
    parser.add_argument("--grid-particles", type=int, default=1_000_000)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--meshes-alone", action="store_true", help="without VTK's slowest mapper, and no particles")
    parser.add_argument("--plot", help="an SVG of the particles' times")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        fin = os.path.join(scratch, "fin.vtu")
        ovoid("make", "fin", "--count", str(options.nodes), "-o", fin)
        mesh_table(scratch, fin, options.frames, options.meshes_alone)
        mesh_table(scratch, jittered_mesh(scratch, 56), options.frames, options.meshes_alone)
        if options.meshes_alone:
            sys.exit()
        particle_table(scratch, options.particles, options.frames, options.plot)
        radius_table(scratch, 100_000, options.frames)
        grid_table(scratch, options.grid_particles, options.frames)
