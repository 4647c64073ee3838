#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the shared library exports is what symbols.txt lists: symbols.py NM LIBRARY.

Fails if a function of the public headers cannot be called from outside, if one of the library's own can, or if the list was
not changed on purpose: OVOID_UPDATE_SYMBOLS=1 writes it anew, and the difference is looked at like any other."""
import os
import re
import subprocess
import sys

LIST = os.path.join(os.path.dirname(os.path.abspath(__file__)), "symbols.txt")


def main():
    nm, library = sys.argv[1:]
    output = subprocess.run([nm, "--dynamic", "--defined-only", "--demangle", library], check=True, capture_output=True,
                            text=True).stdout
    # "address type name"; constructors and destructors have several entry points each. A header's constant is there or not as the
    # optimiser likes, and nobody misses it.
    exported = sorted({line.split(" ", 2)[2] for line in output.splitlines()})
    exported = [name for name in exported if not re.fullmatch(r"ovoid::k[A-Z]\w*", name)]
    if os.environ.get("OVOID_UPDATE_SYMBOLS"):
        with open(LIST, "w", encoding="ascii") as file:
            file.writelines(name + "\n" for name in exported)
        return 0
    with open(LIST, encoding="ascii") as file:
        listed = file.read().splitlines()
    for name in sorted(set(listed) - set(exported)):
        print(f"no longer exported: {name}")
    for name in sorted(set(exported) - set(listed)):
        print(f"exported, but not in {LIST}: {name}")
    return 0 if listed == exported else 1


if __name__ == "__main__":
    sys.exit(main())
