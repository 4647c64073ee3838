#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds and tests the parts that changed: quick.py [FOLDER...]

Parts are those of the files that differ from the last commit, or those of the folders that are named ("io", "render/cpu", "apps/ovoid").
The dev preset is built, as far as these parts' tests need it. Of the tests, those that took least the last time are run, as many as fit
into BUDGET; a test that was never run counts as quick. `make test` runs them all.
"""
import concurrent.futures
import glob
import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

from sources import ROOT, changed_since, git

BUDGET = 20.0  # seconds
FOLDER = os.path.join(ROOT, "build", "dev")
TIMES = os.path.join(FOLDER, "quick.json")
UNIT = ("data", "simd", "model", "labels", "fit", "solid", "view", "scene", "annotate", "io", "render")
# The beginning of a path, and the programs that test what is there; the first that fits counts.
PROGRAMS = [
    ("src/io/foreign/", ["readers_tests"]),
    ("src/io/hdf5/", ["io_tests", "readers_tests"]),
    ("src/io/dicom/", ["io_tests", "readers_tests"]),
    ("src/io/vtk/", ["io_tests", "readers_tests"]),
    ("src/io/xdmf/", ["io_tests", "readers_tests"]),
    ("src/render/vulkan/", ["vulkan_tests"]),
    ("src/render/reference/", ["analytic_tests"]),
    ("src/render/", ["render_tests", "golden_tests"]),
    *((f"src/{part}/", [f"{part}_tests"]) for part in UNIT),
    ("include/ovoid/", ["data_tests", "render_tests"]),
    ("apps/reader/", ["readers_tests"]),
    ("apps/viewer/", ["viewer_tests"]),
    ("apps/", ["cli_tests"]),
    *((f"tests/{folder}/", [f"{folder}_tests"]) for folder in ("analytic", "agreement", "golden", "cli", "experiments", "viewer")),
    ("tests/support/", ["analytic_tests"]),
]


def changed_files():
    return changed_since("HEAD") or git("diff", "--name-only", "HEAD~1")


def programs_of(paths):
    programs = []
    for path in paths:
        found = next((names for begin, names in PROGRAMS if path.startswith(begin)), [])
        programs += [name for name in found if name not in programs]
    return programs


def tests_in(program):
    listed = subprocess.run([program, "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout
    names, suite = [], ""
    for line in listed.splitlines():
        name = line.split("  #")[0].rstrip()
        if not line.startswith(" "):
            suite = name
        elif suite:
            names.append(suite + name.strip())
    return names


def run(program, names, number):
    out = os.path.join(FOLDER, "shards", f"quick-{os.path.basename(program)}-{number}.xml")
    environment = {**os.environ, "GTEST_FILTER": ":".join(names), "GTEST_OUTPUT": f"xml:{out}", "GTEST_BRIEF": "1"}
    done = subprocess.run([program], cwd=FOLDER, env=environment, capture_output=True, text=True)
    times, bad = {}, done.returncode != 0
    if os.path.exists(out):
        for case in ElementTree.parse(out).getroot().iter("testcase"):
            times[f"{case.get('classname')}.{case.get('name')}"] = float(case.get("time"))
    return times, bad, done.stdout + done.stderr


def main(folders):
    paths = [f"src/{folder}/" if os.path.isdir(os.path.join(ROOT, "src", folder)) else f"{folder}/" for folder in folders] or changed_files()
    programs = programs_of(paths)
    if not programs:
        print("quick: nothing that changed has tests in C++; `make test` runs all")
        return 0
    print(f"quick: {', '.join(programs)}", flush=True)
    build = subprocess.run([os.path.join(ROOT, "scripts", "build.sh"), "dev", *programs], cwd=ROOT)
    if build.returncode:
        return build.returncode
    for old in glob.glob(os.path.join(FOLDER, "shards", "quick-*.xml")):
        os.remove(old)
    times = {}
    if os.path.exists(TIMES):
        with open(TIMES, encoding="utf-8") as file:
            times = json.load(file)
    jobs = os.cpu_count() or 1
    wanted = sorted((times.get(f"{program}:{name}", 0.0), program, name)
                    for program in programs for name in tests_in(os.path.join(FOLDER, "bin", program)))
    chosen, spent = {}, 0.0
    for cost, program, name in wanted:
        if spent + cost <= BUDGET * jobs:
            spent += cost
            chosen.setdefault(program, []).append(name)
    work = [(os.path.join(FOLDER, "bin", program), names[first::jobs], first)
            for program, names in chosen.items() for first in range(min(jobs, len(names)))]
    failed = False
    ran = 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for (program, _, _), (took, bad, said) in zip(work, pool.map(lambda one: run(*one), work)):
            times.update((f"{os.path.basename(program)}:{name}", seconds) for name, seconds in took.items())
            ran += len(took)
            if bad:
                failed = True
                print(said)
    with open(TIMES, "w", encoding="utf-8") as file:
        json.dump(times, file)
    left = len(wanted) - sum(map(len, chosen.values()))
    print(f"quick: {'FAILED' if failed else 'passed'}, {ran} tests" + (f"; {left} longer ones are left to `make test`" if left else ""))
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
