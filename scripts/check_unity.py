#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Names that only one file should see must be told apart within a part of the program.

Release builds put several sources together, and which ones changes when a file comes or goes. So of functions, types and
constants in the unnamed namespaces of a part's sources, no two may be called the same: functions with the same first line of
parameters, that is. Aliases may, as long as they agree.
"""
import collections
import re
import sys

from sources import project_files, read_text

FUNCTION = re.compile(r"(?:template[^>]*> *)?(?:\[\[\w+\]\] )?(?:(?:inline|constexpr|const|static) )*[A-Za-z_][\w:<>,&* ]*?[ &*]+(\w+\([^)]*)")
PARAMETER = re.compile(r"\b\w+(?=,|$)")  # its name alone
TYPE = re.compile(r"(?:struct|class|enum class|enum) (\w+)(?!.*;$)")
CONSTANT = re.compile(r"(?:constexpr|const) .*?\b(\w+)(?:\[\d*\])? *[={]")
NO_FUNCTION = re.compile(r"(?:return|if|for|while|else|switch|using|namespace|new|delete|throw)\b")
UNNAMED = re.compile(r"^namespace \{\n(.*?)^\}  // namespace\n", re.S | re.M)


def part_of(path):
    folders = path.split("/")
    if path.startswith("src/io/foreign/"):
        return "src/io/foreign"
    if path.startswith("src/render/") and len(folders) > 3:
        return "/".join(folders[:3])
    return "/".join(folders[:2])


def names_in(text):
    for body in UNNAMED.findall(text):
        for line in body.split("\n"):
            for kind in (FUNCTION, TYPE, CONSTANT):
                found = kind.match(line)
                if found and not NO_FUNCTION.match(line):
                    name, bracket, parameters = found.group(1).partition("(")
                    yield name + bracket + PARAMETER.sub("", parameters)
                    break


def main():
    places = collections.defaultdict(set)
    for path in project_files():
        if path.endswith(".cpp") and path.startswith(("src/", "apps/", "bench/experiments/")) and not path.endswith("_test.cpp"):
            for name in names_in(read_text(path)):
                places[part_of(path), name].add(path)
    findings = [f"{name}: in {', '.join(sorted(paths))}" for (_, name), paths in sorted(places.items()) if len(paths) > 1]
    print("\n".join(findings) or f"{len(places)} names")
    return int(bool(findings))


if __name__ == "__main__":
    sys.exit(main())
