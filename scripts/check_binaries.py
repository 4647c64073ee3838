#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What was built looks for libraries in safe places, and has what hardens it: check_binaries.py [--hardened] FOLDER|FILE...

Reads all ELF files in the folders. RPATH and RUNPATH may have absolute entries and those that begin with $ORIGIN. An empty or a relative
entry means the working folder, which may be that of other people's data. --hardened: release builds also have what the distribution
builds its packages with: addresses that the system chooses (PIE), tables that are read-only before main() begins (RELRO, BIND_NOW), no
memory that is written and executed, and functions that check their stack and the memory that they copy to.
"""
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.append(os.path.join(ROOT, "python", "wheel"))
sys.dont_write_bytecode = True
from elf import is_elf, read_elf  # noqa: E402

# Functions of the C library for which there is one that checks where it writes.
COPIES = re.compile(r" UND (?:mem(?:cpy|move|set)|str(?:cpy|cat|ncpy|ncat)|v?snprintf|v?sprintf|read|pread64?|realpath)@")

# Of whose copies the compiler knows that they fit, so that none is checked when they are made.
KNOWN_SIZES = {"libvtkOvoid.so"}


def elf_files(place):
    """A file, or all below a folder but those that are of one source alone."""
    if os.path.isfile(place):
        yield place
    for parent, _, names in os.walk(place):
        for name in sorted(names):
            path = os.path.join(parent, name)
            if not name.endswith((".o", ".a")) and is_elf(path):
                yield path


def runpath_findings(path):
    for entry in read_elf(path).rpath:
        if not entry.startswith(("/", "$ORIGIN", "${ORIGIN}")):
            yield f"RUNPATH has '{entry}': expected absolute folders and those from $ORIGIN"


def hardening_findings(path):
    text = subprocess.run(["readelf", "--wide", "--file-header", "--segments", "--dynamic", "--dyn-syms", path], check=True,
                          capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"}).stdout
    if not re.search(r"Type: +DYN", text):
        yield "is no position independent executable"
    if "GNU_RELRO" not in text:
        yield "has no read-only tables (-z relro)"
    if not re.search(r"\((?:FLAGS|FLAGS_1)\).*\b(?:BIND_)?NOW\b", text):
        yield "binds its symbols late, so that their table stays writable (-z now)"
    stack = re.search(r"GNU_STACK.* (\S+) +0x", text)
    if stack is None or "E" in stack.group(1):
        yield "may execute its stack"
    if "__stack_chk_fail" not in text:
        yield "does not check its stack (-fstack-protector-strong)"
    if os.path.basename(path) not in KNOWN_SIZES and COPIES.search(text) and not re.search(r" __\w+_chk@", text.replace("__stack_chk_fail", "")):
        yield "does not check what it copies to (_FORTIFY_SOURCE)"


def main(places):
    is_hardened = "--hardened" in places
    places = [place for place in places if place != "--hardened"]
    paths = [path for place in places for path in elf_files(place)]
    checks = [runpath_findings, hardening_findings] if is_hardened else [runpath_findings]
    findings = list(dict.fromkeys(f"{path}: {finding}" for path in paths for check in checks for finding in check(path)))
    if not paths:
        findings.append(f"nothing is built in {' '.join(places)}")
    print("\n".join(findings) if findings else f"{len(paths)} programs and libraries")
    return 1 if findings else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
