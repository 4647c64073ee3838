#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rules that can be read off the text of a file: licence line, ASCII, length, words and calls that do not belong."""
import os
import re
import sys

from sources import project_files, read_text

SPDX = "SPDX-License-Identifier: Apache-2.0"
CODE = (".h", ".cpp", ".py", ".sh", ".cmake", ".comp", ".glsl")
BINARY = (".png", ".gif", ".npy", ".exr", ".gz", ".bin", ".raw", ".vti", ".vtk", ".nrrd", ".nhdr", ".tif", ".pdf")
FIXTURES = ("tests/data/", "tests/golden/", "tests/fuzz/")  # inputs as they are, whatever they hold
MAX_LINES = 1000  # a longer file is refused, one over SOFT_LINES is named
SOFT_LINES = 600
UNFINISHED = re.compile(r"\b(TODO|FIXME|XXX)\b")
# The library reports by exceptions and call-backs alone; main() and the tests may print.
LIBRARY = ("include/", "src/")
LOUD = re.compile(r"std::(cout|cerr|clog|exit|abort|terminate)\b|\b(printf|fprintf|puts|fputs|perror)\s*\(|fmt::print\b"
                  r"|#include <iostream>")
# Results must not depend on the machine that compiled: SIMD targets are chosen at run time.
FLAGS = re.compile(r"-march=|-mtune=|-ffast-math|-Ofast")


def is_code(path):
    return path.endswith(CODE) or os.path.basename(path) in ("CMakeLists.txt", "Makefile") or path == ".ci/run"


def check_file(path, warnings):
    text = read_text(path)
    lines = text.split("\n")
    code = is_code(path)
    if code and SPDX not in "\n".join(lines[:2]):
        yield 1, f"the line '{SPDX}' is missing at the top"
    if text and not text.endswith("\n"):
        yield len(lines), "no newline at the end of the file"
    if path.endswith(".h") and "#pragma once" not in text and not path.endswith("-inl.h"):
        yield 1, "no #pragma once"
    if code and len(lines) - 1 > MAX_LINES:
        yield len(lines), f"{len(lines) - 1} lines: at most {MAX_LINES}"
    elif code and len(lines) - 1 > SOFT_LINES:
        warnings.append(f"{path}: {len(lines) - 1} lines, over {SOFT_LINES}: can it be divided?")
    library = path.startswith(LIBRARY) and not path.endswith("_test.cpp")
    for number, line in enumerate(lines, 1):
        if not line.isascii():
            yield number, "not ASCII"
        if line != line.rstrip():
            yield number, "blanks at the end of the line"
        if path != "scripts/check_text.py":
            if UNFINISHED.search(line):
                yield number, "an unfinished-work marker"
            if code and FLAGS.search(line):
                yield number, "a flag that ties results to the compiling machine"
        if library and not line.lstrip().startswith("//") and LOUD.search(line):
            yield number, "the library neither prints nor exits"
        if path.endswith((".h", ".cpp")) and "\t" in line:
            yield number, "a tab"


def main():
    findings, warnings, count = [], [], 0
    for path in project_files():
        if path.endswith(BINARY) or path.startswith(FIXTURES) and not path.endswith(CODE):
            continue
        if path in ("LICENSE",):
            continue
        count += 1
        findings += [f"{path}:{number}: {message}" for number, message in check_file(path, warnings)]
    print("\n".join(warnings + findings + [f"{count} files" + (f", {len(warnings)} long" if warnings else "")]))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
