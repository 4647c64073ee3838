#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures Ovoid, and VTK's mappers beside it, on the scenes of bench/scenes.json; prints the tables in Markdown and stores them.

  bench/run.py [TABLE...]     the named tables, or all
  --rounds N --frames N       each program is run in N rounds, by turns, each of one warm-up and N timed frames
  --quick                     one round of three frames: to try the benchmark, not to publish

Everything goes to bench/results/: DATE-COMMIT.json with every number, the same with .md, and the pictures. Scans are used where
OVOID_DATA, or ../shared/data beside the sources, has them; their rows are left out elsewhere.
"""
import argparse
import datetime
import itertools
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys

import pictures
import tables
import volumes

BENCH = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(BENCH)
RESULTS = os.path.join(BENCH, "results")
WORK = os.path.join(ROOT, "build", "bench")
OVOID = os.path.join(ROOT, "build", "release", "bin", "ovoid")
PEER = os.path.join(WORK, "bin", "vtk_peer")


def output_of(command):
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()


def describe_machine():
    with open("/proc/cpuinfo", encoding="ascii", errors="replace") as file:
        cpu = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), platform.machine())
    changed = output_of(["git", "status", "--porcelain", "--untracked-files=no"])
    return {"commit": output_of(["git", "rev-parse", "--short", "HEAD"]) + ("+" if changed else ""),
            "date": datetime.datetime.now().astimezone().isoformat(timespec="seconds"),
            "cpu": cpu, "hardware_threads": os.cpu_count(), "system": platform.platform(),
            "compiler": output_of(["c++", "--version"]).splitlines()[0],
            "command": " ".join(["python3", "bench/run.py", *sys.argv[1:]])}


def rows_of(table, defaults):
    """Every combination of the table's `vary`; an entry that is an object sets several keys at once."""
    keys = list(table["vary"])
    for choice in itertools.product(*table["vary"].values()):
        row = {**defaults, **table.get("with", {})}
        for key, value in zip(keys, choice):
            row.update(value if isinstance(value, dict) else {key: value})
        yield row


class Scene:
    """One row made concrete: files, picture size, sampling distance."""

    def __init__(self, row, config, name):
        self.row, self.name = row, name
        volume = volumes.prepare(row["volume"], config["volumes"][row["volume"]], OVOID, os.path.join(WORK, "volumes"),
                                 volumes.data_folder())
        self.is_here = volume is not None
        if not self.is_here:
            return
        self.volume = volume
        self.look = os.path.join(BENCH, "looks", row["look"] + ".json")
        dims, spacing, bounds = volumes.describe(volume, OVOID)
        self.pixels = row["pixels"] or max(dims)
        self.sampling_distance = min(spacing)
        os.makedirs(os.path.join(RESULTS, "pictures"), exist_ok=True)
        self.camera = os.path.join(WORK, "camera.json")
        zoom = row["magnification"] * max(dims) / self.pixels if row["magnification"] else 1
        volumes.write_camera(self.camera, config["views"][row["view"]], dims, spacing, bounds, zoom)

    def picture(self, program, ending):
        return os.path.join(RESULTS, "pictures", f"{self.name}-{program}.{ending}")

    def run_ovoid(self, frames):
        profile = os.path.join(WORK, "profile.json")
        as_peers = [] if self.row["refined"] else ["--sampling-distance", str(self.sampling_distance), "--classification", "sampled"]
        subprocess.run([OVOID, "render", self.volume, "--tf", self.look, "--light", "headlight", "--occlusion", "0", "--camera", self.camera,
                        "--size", f"{self.pixels}x{self.pixels}", *as_peers, "--unit-distance", str(self.sampling_distance), "--threads",
                        str(self.row["threads"]), *self.row["flags"], "--repeat", str(frames), f"--profile={profile}",
                        "-o", self.picture("ovoid", "npy")], check=True)
        with open(profile, encoding="utf-8") as file:
            return json.load(file)

    def run_peer(self, mapper, frames):
        command = [PEER, "--mapper", mapper, "--volume", self.volume, "--look", self.look, "--camera", self.camera,
                   "--width", str(self.pixels), "--height", str(self.pixels),
                   "--sampling-distance", str(self.sampling_distance), "--unit-distance", str(self.sampling_distance),
                   "--threads", str(self.row["threads"]), "--repeat", str(frames), "-o", self.picture(mapper, "ppm")]
        environment = {**os.environ, "LP_NUM_THREADS": str(self.row["threads"])}  # of Mesa's software driver
        done = subprocess.run(["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24", *command], check=True,
                              capture_output=True, text=True, env=environment)
        return json.loads(done.stdout)


def merge(runs):
    """Several rounds as one: the median of medians, the least and the greatest frame, and the rest of the last round."""
    times = [run["frame_ms"] for run in runs]
    merged = {"median": statistics.median(time["median"] for time in times),
              "min": min(time["min"] for time in times), "max": max(time["max"] for time in times)}
    return {**runs[-1], "frame_ms": merged}


def measure(scene, rounds, frames):
    programs = ["ovoid", *scene.row["peers"]]
    runs = {program: [] for program in programs}
    for _ in range(rounds):  # by turns, so that a machine that slows down slows all of them
        for program in programs:
            if program == "gpu":  # the software driver takes seconds a frame, and varies little
                if not runs[program]:
                    runs[program].append(scene.run_peer(program, min(frames, 3)))
                continue
            runs[program].append(scene.run_ovoid(frames) if program == "ovoid" else scene.run_peer(program, frames))
    result = {"row": scene.row, "pixels": scene.pixels, **{program: merge(runs[program]) for program in programs}}
    result["psnr"] = {program: pictures.psnr(scene.picture("ovoid", "npy"), scene.picture(program, "ppm"))
                      for program in scene.row["peers"]}
    return result


def run_table(name, config, options):
    results = []
    for number, row in enumerate(rows_of(config["tables"][name], config["defaults"])):
        scene = Scene(row, config, f"{name}-{number}")
        if not scene.is_here:
            print(f"{name}: no data for '{row['volume']}' here, row left out", file=sys.stderr)
            continue
        print(f"{name}: {tables.label(row, config['tables'][name])}", file=sys.stderr)
        results.append(measure(scene, options.rounds, options.frames))
    return results


def parse_arguments(config):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", nargs="*", help=", ".join(config["tables"]))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    unknown = [name for name in options.table if name not in config["tables"]]
    if unknown:
        parser.error(f"no table is called {', '.join(unknown)}; there are {', '.join(config['tables'])}")
    if options.quick:
        options.rounds, options.frames = 1, 3
    return options


def main():
    with open(os.path.join(BENCH, "scenes.json"), encoding="ascii") as file:
        config = json.load(file)
    options = parse_arguments(config)
    for program in (OVOID, PEER, shutil.which("xvfb-run") or "xvfb-run"):
        if not os.path.exists(program):
            sys.exit(f"{program} is missing: `make bench` builds and installs what is needed")
    os.makedirs(RESULTS, exist_ok=True)
    record = {"machine": describe_machine(), "tables": {}}
    for name in options.table or config["tables"]:
        record["tables"][name] = run_table(name, config, options)
    text = tables.to_markdown(record, config)
    print(text)
    stem = os.path.join(RESULTS, record["machine"]["date"][:19].replace(":", "") + "-" + record["machine"]["commit"])
    with open(stem + ".json", "w", encoding="ascii") as file:
        json.dump(record, file, indent=1)
    with open(stem + ".md", "w", encoding="ascii") as file:
        file.write(text + "\n")
    print(f"stored: {stem}.json and .md", file=sys.stderr)


if __name__ == "__main__":
    main()
