#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Names that only one file should see must be told apart within a part of the program.

Release builds put several sources together, and which ones changes when a file comes or goes. So of functions, types and
constants in the unnamed namespaces of a part's sources, no two may be called the same: functions with the same first line of
parameters, that is. Aliases may, as long as they agree.

Nor may one hide what a header has in a namespace around it, a type, a constant or a function of the same parameters: sources that
come after it in the unit, and mean the header's, would get it instead, without a word.
"""
import collections
import re
import sys

from sources import project_files, read_text

FUNCTION = re.compile(r"(?:template[^>]*> *)?(?:\[\[\w+\]\] )?(?:(?:inline|constexpr|const|static) )*[A-Za-z_][\w:<>,&* ]*?[ &*]+(\w+\([^)]*)")
PARAMETER = re.compile(r"\b\w+(?=,|$)")  # its name alone
TYPE = re.compile(r"(?:struct|class|enum class|enum) (\w+)(?!.*;$)")
CONSTANT = re.compile(r"(?:inline )?(?:constexpr|const) .*?\b(\w+)(?:\[\d*\])? *[={]")
NO_FUNCTION = re.compile(r"(?:return|if|for|while|else|switch|using|namespace|new|delete|throw)\b")
UNNAMED = re.compile(r"^namespace \{\n(.*?)^\}  // namespace\n", re.S | re.M)
NAMESPACE = re.compile(r"^namespace (?:OVOID_API )?([\w:]+) \{$")


def part_of(path):
    folders = path.split("/")
    if path.startswith("src/io/foreign/"):
        return "src/io/foreign"
    if path.startswith("src/render/") and len(folders) > 3 and folders[2] not in ("passes", "light"):
        return "/".join(folders[:3])
    return "/".join(folders[:2])


def names_of(line):
    """What a line declares: at most one name, of functions with the first line of their parameters' types."""
    for kind in (FUNCTION, TYPE, CONSTANT):
        found = kind.match(line)
        if found and not NO_FUNCTION.match(line):
            name, bracket, parameters = found.group(1).partition("(")
            yield name + bracket + PARAMETER.sub("", parameters)
            return


def names_in(text):
    for body in UNNAMED.findall(text):
        for line in body.split("\n"):
            yield from names_of(line)


def as_called(name):
    """The same for functions that a call cannot tell apart."""
    return re.sub(r"\bconst |[ &]", "", name.replace("std::string_view", "std::string"))


def names_in_headers():
    """Each name that a header gives at the level of a namespace, to the namespaces and headers that do."""
    places = collections.defaultdict(set)
    for path in project_files("src/*.h", "include/*.h", "apps/*.h"):
        around = []
        for line in read_text(path).split("\n"):
            opened = NAMESPACE.match(line)
            if opened:
                around.append(opened.group(1))
            elif line.startswith("}  // namespace") and around:
                around.pop()
            for name in names_of(line) if around else ():
                places[as_called(name)].add(("::".join(around), path))
    return places


def namespace_of(text):
    return "::".join(opened.group(1) for opened in map(NAMESPACE.match, text.split("\n")) if opened)


def hidden_names():
    """Names in unnamed namespaces that hide a header's."""
    in_headers = names_in_headers()
    for path in project_files():
        if not path.endswith(".cpp") or not path.startswith(("src/", "apps/")) or path.endswith("_test.cpp"):
            continue
        text = read_text(path)
        own = namespace_of(text)
        for name in sorted(set(names_in(text))):
            for around, header in sorted(in_headers.get(as_called(name), ())):
                if own == around or own.startswith(around + "::"):
                    yield f"{name}: {path} hides that of {header}"


def main():
    places = collections.defaultdict(set)
    for path in project_files():
        if path.endswith(".cpp") and path.startswith(("src/", "apps/", "bench/experiments/")) and not path.endswith("_test.cpp"):
            for name in names_in(read_text(path)):
                places[part_of(path), name].add(path)
    findings = [f"{name}: in {', '.join(sorted(paths))}" for (_, name), paths in sorted(places.items()) if len(paths) > 1]
    findings += hidden_names()
    print("\n".join(findings) or f"{len(places)} names")
    return int(bool(findings))


if __name__ == "__main__":
    sys.exit(main())
