#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds what the programs are linked with to a list of licences: check_licences.py PROGRAM... LIST.

Each line of LIST is a pattern of package names and an SPDX expression. Every shared library that a program loads must come from
a listed package whose licence may be linked into an Apache-2.0 program and shipped with it.
"""
import fnmatch
import os
import re
import subprocess
import sys

# The copyleft licences that do not reach over dynamic linking (LGPL), nor beyond their own files (MPL), or that say so for this very
# use (the GCC exception).
ACCEPTED = {"Apache-2.0", "MIT", "BSD-2-Clause", "BSD-3-Clause", "Zlib", "libpng-2.0", "bzip2-1.0.6", "0BSD", "public-domain",
            "BSL-1.0", "IJG", "curl", "ISC", "Unicode-DFS-2016", "OLDAP-2.8", "BSD-3-Clause-Attribution", "LGPL-2.1-or-later", "LGPL-3.0-or-later", "MPL-2.0",
            "GPL-3.0-or-later WITH GCC-exception-3.1"}


def read_list(path):
    with open(path, encoding="ascii") as file:
        lines = [line.split("#")[0].split(None, 1) for line in file]
    return [(line[0], line[1].strip()) for line in lines if len(line) == 2]


def licence_of(package, licences):
    """What a list says of a package; None if it says nothing."""
    return next((text for pattern, text in licences if fnmatch.fnmatch(package, pattern)), None)


def loaded_libraries(program):
    listing = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    missing = re.findall(r"^\s*(\S+) => not found", listing, re.MULTILINE)
    if missing:
        raise SystemExit(f"{program}: not found: {', '.join(missing)}")
    own = os.path.dirname(os.path.realpath(program))  # libovoid lies beside it
    return sorted(path for path in set(re.findall(r"(/\S+) \(0x", listing)) if os.path.dirname(os.path.realpath(path)) != own)


def package_of(library):
    """The Debian package that owns a library. /lib and /usr/lib are one folder, and the package database knows either name."""
    real = os.path.realpath(library)
    for name in (real, real.removeprefix("/usr"), library):
        found = subprocess.run(["dpkg-query", "-S", name], capture_output=True, text=True)
        if found.returncode == 0:
            return found.stdout.split(":")[0]
    return None


def main(*arguments):
    *programs, list_path = arguments
    licences = read_list(list_path)
    packages, findings = {}, []
    for library in sorted({library for program in programs for library in loaded_libraries(program)}):
        package = package_of(library)
        if package is None:
            findings.append(f"{library}: belongs to no package, so its licence is unknown")
        else:
            packages.setdefault(package, []).append(os.path.basename(library))
    for package, libraries in sorted(packages.items()):
        licence = licence_of(package, licences)
        if licence is None:
            findings.append(f"{package} ({', '.join(libraries)}): not in {list_path}; "
                            f"read /usr/share/doc/{package}/copyright and add it")
            continue
        for term in re.split(r"\s+(?:AND|OR)\s+", licence):
            if term not in ACCEPTED:
                findings.append(f"{package}: {term} must not be linked")
    print("\n".join(findings + [f"{sum(map(len, packages.values()))} libraries of {len(packages)} packages"]))
    return 1 if findings else 0


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
