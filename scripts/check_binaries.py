#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What was built may not look for libraries where it is called: check_binaries.py FOLDER...

Reads all ELF files in the folders. RPATH and RUNPATH may have absolute entries and those that begin with $ORIGIN. An empty or a relative
entry means the working folder, which may be that of other people's data.
"""
import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.append(os.path.join(ROOT, "python", "wheel"))
sys.dont_write_bytecode = True
from elf import is_elf, read_elf  # noqa: E402


def elf_files(folder):
    """All below a folder but those that are of one source alone."""
    for parent, _, names in os.walk(folder):
        for name in sorted(names):
            path = os.path.join(parent, name)
            if not name.endswith((".o", ".a")) and is_elf(path):
                yield path


def findings_of(path):
    for entry in read_elf(path).rpath:
        if not entry.startswith(("/", "$ORIGIN", "${ORIGIN}")):
            yield f"RUNPATH has '{entry}': expected absolute folders and those from $ORIGIN"


def main(folders):
    paths = [path for folder in folders for path in elf_files(folder)]
    findings = [f"{path}: {finding}" for path in paths for finding in findings_of(path)]
    if not paths:
        findings.append(f"nothing is built in {' '.join(folders)}")
    print("\n".join(findings) if findings else f"{len(paths)} programs and libraries")
    return 1 if findings else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
