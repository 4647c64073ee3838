#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy over the project's own sources, tests aside: check_tidy.py [FILE...].

Sources of one folder are read together (a unity build that is configured and never built), because most of the time goes into the
headers they share. A unit that passed is not read again until one of its sources, a header of the project, its flags or .clang-tidy
change: what passed is remembered by hash in build/tidy.
"""
import concurrent.futures
import hashlib
import json
import os
import re
import subprocess
import sys

from sources import ROOT, project_files, read_text

FOLDER = os.path.join(ROOT, "build", "tidy")


def hash_of(*texts):
    digest = hashlib.sha256()
    for text in texts:
        digest.update(text.encode("utf-8", "surrogateescape") + b"\0")
    return digest.hexdigest()


def read_units():
    """Path of each unit to its command and the project's sources in it."""
    subprocess.run(["cmake", "--preset", "tidy", "--log-level=ERROR"], cwd=ROOT, check=True, capture_output=True)
    # What sources include that is made of others.
    subprocess.run(["cmake", "--build", FOLDER, "--target", "ovoid_shaders"], cwd=ROOT, check=True, capture_output=True)
    with open(os.path.join(FOLDER, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    own = set(project_files("src/*.cpp", "apps/*.cpp", "bindings/*.cpp", "python/*.cpp", "bench/*.cpp"))
    units = {}
    for entry in entries:
        path = os.path.join(entry["directory"], entry["file"])
        sources = [path]
        if "/Unity/" in path:
            with open(path, encoding="utf-8") as file:
                sources = re.findall(r'#include "(.*)"', file.read())
        sources = [os.path.relpath(source, ROOT) for source in sources]
        sources = [source for source in sources if source in own]
        if sources:
            units[path] = (entry["command"], sources)
    return units


def run_tidy(path):
    # SIMD code is read once, not once per target.
    command = ["clang-tidy", "-p", FOLDER, "--quiet", "--extra-arg=-DHWY_COMPILE_ONLY_STATIC", path]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    broken = "Error parsing" in done.stderr  # of .clang-tidy, which clang-tidy does not think worth an exit code
    return done.returncode == 0 and not broken, done.stderr if broken else done.stdout


def main(wanted):
    units = read_units()
    unknown = set(wanted) - {source for _, sources in units.values() for source in sources}
    if unknown:
        sys.exit(f"not a source that is built: {', '.join(sorted(unknown))}")
    memory = os.path.join(FOLDER, "passed")
    os.makedirs(memory, exist_ok=True)
    common = hash_of(read_text(".clang-tidy"), *(read_text(path) for path in project_files("*.h")))
    due = {}
    for path, (command, sources) in units.items():
        if wanted and not set(wanted) & set(sources):
            continue
        mark = os.path.join(memory, hash_of(common, command, *(read_text(source) for source in sources)))
        if not os.path.exists(mark):
            due[path] = mark
    failed = False
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for (path, mark), (passed, output) in zip(due.items(), pool.map(run_tidy, due)):
            if passed:
                with open(mark, "w", encoding="ascii"):
                    pass
            else:
                failed = True
                print(output.strip() or f"{path}: clang-tidy failed without a word")
    print(f"{sum(len(sources) for _, sources in units.values())} sources, {len(due)} of {len(units)} units read anew")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
