#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds a portable wheel to what its name promises: check.py WHEEL...

Everything that its ELF files need lies in the wheel, where their RPATH says, or is on the list of what every Linux has; they want no
newer version of a symbol than the platform's tag allows; no RPATH leads out; nothing lies in it that nothing needs; NOTICE names every
library that was bundled, with a licence beside it; and RECORD is right. Prints the findings, and the wheel's size.
"""
import base64
import csv
import glob
import hashlib
import os
import re
import sys
import tempfile
import zipfile

import manylinux
from bundle import LIBRARIES, elf_files
from elf import read_elf

NAME = re.compile(r"(?P<stem>[^-]+-[^-]+)-(?P<tag>cp3(?P<python>\d+)-cp3\d+-manylinux_(?P<major>\d+)_(?P<minor>\d+)_(?P<machine>\w+))\.whl")


def record_findings(root, info):
    record = os.path.join(info, "RECORD")
    with open(os.path.join(root, record), encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    listed = {name: digest for name, digest, _ in rows}
    files = {name for name in glob.glob("**", root_dir=root, recursive=True, include_hidden=True) if os.path.isfile(os.path.join(root, name))}
    for name in sorted(files ^ set(listed)):
        yield f"{name}: is {'not in RECORD' if name in files else 'in RECORD alone'}"
    for name in sorted(files & set(listed) - {record}):
        with open(os.path.join(root, name), "rb") as file:
            digest = base64.urlsafe_b64encode(hashlib.sha256(file.read()).digest()).rstrip(b"=").decode()
        if listed[name] != f"sha256={digest}":
            yield f"{name}: differs from RECORD"


def places_of(rpath, path, root):
    """The folders of the wheel that a file's RPATH means, and those that are none."""
    inside, outside = [], []
    for entry in rpath:
        folder = os.path.normpath(entry.replace("${ORIGIN}", "$ORIGIN").replace("$ORIGIN", os.path.dirname(path)))
        is_inside = entry.startswith(("$ORIGIN", "${ORIGIN}")) and (folder + os.sep).startswith(root + os.sep)
        (inside if is_inside else outside).append(folder if is_inside else entry)
    return inside, outside


def elf_findings(elves, root, match):
    """elves: file to what it says of itself."""
    used = set()
    for path, elf in elves.items():
        name = os.path.relpath(path, root)
        if elf.machine != manylinux.MACHINES.get(match["machine"]):
            yield f"{name}: is for {elf.machine}, not for {match['machine']}"
        inside, outside = places_of(elf.rpath, path, root)
        for entry in outside:
            yield f"{name}: RPATH leads out of the wheel: {entry}"
        for needed in elf.needed:
            if needed in manylinux.LIBRARIES:
                continue
            found = next((os.path.join(place, needed) for place in inside if os.path.join(place, needed) in elves), None)
            if found is None:
                yield f"{name}: needs {needed}, which is neither in the wheel nor in every Linux"
            used.add(found)
        for library, versions in elf.versions.items():
            if library not in manylinux.LIBRARIES:
                continue
            for version in versions:
                finding = manylinux.version_finding(version, (int(match["major"]), int(match["minor"])))
                if finding:
                    yield f"{name}: {finding} ({library})"
    for path, elf in elves.items():
        if os.path.dirname(path) != os.path.join(root, LIBRARIES):
            continue
        if path not in used:
            yield f"{os.path.relpath(path, root)}: nothing needs it"
        if elf.soname != os.path.basename(path):
            yield f"{os.path.relpath(path, root)}: has the SONAME {elf.soname}"


def licence_findings(elves, root, info):
    licences = os.path.join(root, info, "licenses")
    try:
        with open(os.path.join(licences, "NOTICE"), encoding="ascii") as file:
            notice = file.read()
    except FileNotFoundError:
        yield f"{info}/licenses/NOTICE: is missing"
        return
    named = dict(re.findall(r"^(\S+): (\S+) \S+, \S", notice, re.MULTILINE))
    for path in elves:
        name = os.path.basename(path)
        if os.path.dirname(path) != os.path.join(root, LIBRARIES) or name.startswith("libovoid-"):
            continue
        if name not in named:
            yield f"{name}: NOTICE does not name it"
        elif not os.path.isfile(os.path.join(licences, named[name] + ".txt")):
            yield f"{name}: the licence of {named[name]} is missing"


def check_folder(root, match):
    """Findings of an unpacked wheel, and what its ELF files say; `match` is of its name."""
    root = os.path.realpath(root)
    info = f"{match['stem']}.dist-info"
    findings = [f"{name}: has no business in the wheel" for name in os.listdir(root) if name not in ("ovoid", LIBRARIES, info)]
    with open(os.path.join(root, info, "WHEEL"), encoding="ascii") as file:
        if f"Tag: {match['tag']}\n" not in file.read():
            findings.append(f"{info}/WHEEL: has not the tag of the file's name")
    if not glob.glob(os.path.join(root, "ovoid", f"_core.cpython-3{match['python']}-*.so")):
        findings.append(f"ovoid: no extension module for Python 3.{match['python']}")
    elves = {path: read_elf(path) for path in elf_files(root)}
    findings += [*record_findings(root, info), *elf_findings(elves, root, match), *licence_findings(elves, root, info)]
    return findings, elves


def check(wheel):
    """Findings, and a line of what was seen."""
    match = NAME.fullmatch(os.path.basename(wheel))
    if not match:
        return ["the name is not NAME-VERSION-cp3X-cp3X-manylinux_X_Y_MACHINE.whl: it promises to run nowhere else"], ""
    with tempfile.TemporaryDirectory() as root:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(root)
            unpacked = sum(entry.file_size for entry in archive.infolist())
        findings, elves = check_folder(root, match)
    num_bundled = sum(os.path.basename(os.path.dirname(path)) == LIBRARIES for path in elves)
    glibc = ".".join(map(str, manylinux.needed_glibc(elves.values())))
    return findings, (f"{len(elves)} ELF files, {num_bundled} of them bundled; for glibc {glibc} or later; "
                      f"{os.path.getsize(wheel) / 1e6:.1f} MB, unpacked {unpacked / 1e6:.1f} MB")


def main(*wheels):
    failed = False
    for wheel in wheels:
        findings, summary = check(wheel)
        failed = failed or bool(findings)
        print("\n".join(f"{os.path.basename(wheel)}: {line}" for line in findings or [summary]))
    return 1 if failed else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
