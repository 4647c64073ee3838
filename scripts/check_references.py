#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds what comments and pages point at to what exists: paper keys like [Name 1999b] to docs/references.md, links to files."""
import os
import re
import sys

from sources import ROOT, project_files, read_text

KEY = re.compile(r"\[([A-Z][A-Za-z]+ (?:19|20)\d\d[a-z]?)(?:[,:;][^\]]*)?\](?!\()")
ROW = re.compile(r"^\| ([A-Z][^|]*?) \|", re.MULTILINE)
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")
PAGE = re.compile(r"\b(docs/[a-z_]+\.md|[A-Z]{5,}\.md)\b")


def check_file(path, keys):
    for number, line in enumerate(read_text(path).split("\n"), 1):
        for key in KEY.findall(line):
            if key not in keys:
                yield f"{path}:{number}: [{key}] is not in docs/references.md"
        for page in PAGE.findall(line):
            if not os.path.exists(os.path.join(ROOT, page)):
                yield f"{path}:{number}: there is no {page}"
        if not path.endswith(".md"):
            continue
        for target in LINK.findall(line):
            if "://" not in target and not os.path.exists(os.path.join(ROOT, os.path.dirname(path), target)):
                yield f"{path}:{number}: there is no {target}"


def main():
    keys = set(ROW.findall(read_text("docs/references.md")))
    paths = project_files("*.h", "*.cpp", "*.md", "*.py", "*.sh", "*CMakeLists.txt", "*.cmake")
    findings = [finding for path in paths if path != "scripts/check_references.py" for finding in check_file(path, keys)]
    print("\n".join(findings + [f"{len(keys)} keys, {len(paths)} files"]))
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
