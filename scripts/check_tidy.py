#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy over the project's own translation units, tests aside: check_tidy.py BUILD_FOLDER [FILE...].

A unit that passed is not read again until it, a header of the project, its flags or .clang-tidy change: what passed is remembered by
hash in BUILD_FOLDER/tidy.
"""
import concurrent.futures
import hashlib
import json
import os
import subprocess
import sys

from sources import ROOT, project_files, read_text


def hash_of(*texts):
    digest = hashlib.sha256()
    for text in texts:
        digest.update(text.encode("utf-8", "surrogateescape") + b"\0")
    return digest.hexdigest()


def read_units(build_folder):
    with open(os.path.join(build_folder, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    own = {path for path in project_files("src/*.cpp", "apps/*.cpp", "bench/*.cpp") if not path.endswith("_test.cpp")}
    units = {}
    for entry in entries:
        path = os.path.relpath(os.path.join(entry["directory"], entry["file"]), ROOT)
        if path in own:
            units[path] = entry.get("command") or " ".join(entry["arguments"])
    return units


def run_tidy(build_folder, path):
    # SIMD code is read once, not once per target.
    command = ["clang-tidy", "-p", build_folder, "--quiet", "--extra-arg=-DHWY_COMPILE_ONLY_STATIC", path]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    broken = "Error parsing" in done.stderr  # of .clang-tidy, which clang-tidy does not think worth an exit code
    return done.returncode == 0 and not broken, done.stderr if broken else done.stdout


def main(build_folder, wanted):
    build_folder = os.path.abspath(build_folder)
    units = read_units(build_folder)
    unknown = [path for path in wanted if path not in units]
    if unknown:
        sys.exit(f"not built in {build_folder}: {', '.join(unknown)}")
    memory = os.path.join(build_folder, "tidy")
    os.makedirs(memory, exist_ok=True)
    common = hash_of(read_text(".clang-tidy"), *(read_text(path) for path in project_files("*.h")))
    marks = {path: os.path.join(memory, hash_of(common, read_text(path), units[path])) for path in wanted or units}
    due = [path for path, mark in marks.items() if not os.path.exists(mark)]
    failed = False
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for path, (passed, output) in zip(due, pool.map(lambda unit: run_tidy(build_folder, unit), due)):
            if passed:
                with open(marks[path], "w", encoding="ascii"):
                    pass
            else:
                failed = True
                print(output.strip() or f"{path}: clang-tidy failed without a word")
    print(f"{len(marks)} units, {len(due)} of them read anew")
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2:]))
