#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy over the project's own sources, tests aside: check_tidy.py [FILE...].

Sources of one folder are read together (a unity build that is configured and never built), because most of the time goes into the
headers they share. A unit that passed is not read again until one of its sources, a header that these include, its flags or .clang-tidy
change: what passed is remembered by hash in build/tidy.

Nor is what has not changed since everything passed: the commit of which that is true is recorded in .ci/tidy-base (`make nightly` says
when it can be moved), so a fresh clone reads what differs from it, and what includes what differs. Everything is read where the commit
is not there, as in a shallow clone, where what decides over all differs (ALL), and with OVOID_TIDY_BASE=none.
"""
import concurrent.futures
import hashlib
import json
import os
import re
import subprocess
import sys

from sources import ROOT, changed_since, git, project_files, read_text

FOLDER = os.path.join(ROOT, "build", "tidy")
BASE = ".ci/tidy-base"
ALL = (".clang-tidy", "scripts/check_tidy.py")
PRESETS = "CMakePresets.json"
INCLUDE = re.compile(r'^\s*#\s*include [<"]([^>"]+)[>"]', re.M)


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
    command = ["clang-tidy", "-p", FOLDER, "--quiet", path]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    broken = "Error parsing" in done.stderr  # of .clang-tidy, which clang-tidy does not think worth an exit code
    return done.returncode == 0 and not broken, done.stderr if broken else done.stdout


def included_by(paths):
    """Each of the project's files to those that it includes, directly or not, and itself."""
    known = set(paths)
    direct = {}
    for path in paths:
        names = INCLUDE.findall(read_text(path))
        places = [[os.path.join(root, name) for root in ("include", "src", os.path.dirname(path), "apps/ovoid", "apps/viewer", "bench")]
                  for name in names]
        direct[path] = {next((os.path.normpath(p) for p in found if os.path.normpath(p) in known), None) for found in places} - {None}
    reached = {}
    for path in paths:
        seen, todo = set(), [path]
        while todo:
            one = todo.pop()
            if one not in seen:
                seen.add(one)
                todo += direct[one]
        reached[path] = seen
    return reached


def flags_in(presets):
    """What the text of the presets says of tidy's."""
    named = {preset["name"]: preset for preset in json.loads(presets)["configurePresets"]}
    chain, name = [], "tidy"
    while name:
        chain.append(named[name])
        name = named[name].get("inherits")
    return chain


def changed_since_base():
    """Files that differ from the recorded commit, and its name; None where everything is to be read."""
    base = os.environ.get("OVOID_TIDY_BASE") or (read_text(BASE).strip() if os.path.exists(os.path.join(ROOT, BASE)) else "none")
    if subprocess.run(["git", "merge-base", "--is-ancestor", base, "HEAD"], cwd=ROOT, capture_output=True).returncode:
        return None, base
    changed = set(changed_since(base))
    reads_all = changed & set(ALL) or PRESETS in changed and flags_in("\n".join(git("show", f"{base}:{PRESETS}"))) != flags_in(read_text(PRESETS))
    return (None if reads_all else changed), base


def main(wanted):
    units = read_units()
    unknown = set(wanted) - {source for _, sources in units.values() for source in sources}
    if unknown:
        sys.exit(f"not a source that is built: {', '.join(sorted(unknown))}")
    memory = os.path.join(FOLDER, "passed")
    os.makedirs(memory, exist_ok=True)
    reached = included_by(project_files("*.h", "*.cpp"))
    changed, base = (None, "none") if wanted else changed_since_base()
    due = {}
    for path, (command, sources) in units.items():
        files = sorted(set().union(*(reached[source] for source in sources)))
        if wanted and not set(wanted) & set(sources) or changed is not None and not changed & set(files):
            continue
        mark = os.path.join(memory, hash_of(read_text(".clang-tidy"), command, *(read_text(file) for file in files)))
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
    print(f"{sum(len(sources) for _, sources in units.values())} sources, {len(due)} of {len(units)} units read anew"
          + ("" if changed is None else f", of what differs from {base[:12]}"))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
