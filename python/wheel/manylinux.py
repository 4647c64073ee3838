# SPDX-License-Identifier: Apache-2.0
"""What a wheel may take from the Linux that it is installed on.

PEP 600 promises, of a wheel with the tag ``manylinux_X_Y``, that it runs on every common Linux with glibc X.Y or later. What these
have besides glibc is in the list of the Python Packaging Authority's auditwheel, policies manylinux_2_35 and later. It also allows
X11, OpenGL and GLib, which a server or a container need not have and which nothing here may link.
"""
import re

LIBRARIES = frozenset("""
    ld-linux-x86-64.so.2 ld-linux-aarch64.so.1
    libc.so.6 libm.so.6 libmvec.so.1 libdl.so.2 librt.so.1 libpthread.so.0 libutil.so.1 libanl.so.1 libnsl.so.1 libresolv.so.2
    libgcc_s.so.1 libstdc++.so.6 libatomic.so.1
    libz.so.1 libexpat.so.1
    """.split())

# The highest version of symbols, by the first part of its name; of GLIBC it is the tag's own, which is one of these at least.
LEAST_GLIBC = (2, 35)
VERSIONS = {"GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13), "GCC": (12, 0, 0), "LIBATOMIC": (1, 2), "ZLIB": (1, 2, 9)}
OTHER_VERSIONS = {"CXXABI_FLOAT128", "CXXABI_TM_1", "GLIBC_ABI_DT_RELR"}

MACHINES = {"x86_64": "Advanced Micro Devices X86-64", "aarch64": "AArch64"}  # in a tag, and in the words of readelf


def parse_version(name):
    """``GLIBC_2.34`` as ("GLIBC", (2, 34)); (name, None) if it is no such thing."""
    match = re.fullmatch(r"([A-Z]+)_(\d+(?:\.\d+)*)", name)
    return (match.group(1), tuple(map(int, match.group(2).split(".")))) if match else (name, None)


def needed_glibc(elves):
    """The glibc of the tag that these files can have."""
    wanted = [parse_version(name) for elf in elves for names in elf.versions.values() for name in names]
    return max([LEAST_GLIBC, *(version[:2] for first, version in wanted if first == "GLIBC" and version)])


def version_finding(name, glibc):
    """Why a version of symbols is too much for a wheel of that glibc; None if it is not."""
    first, version = parse_version(name)
    bound = glibc if first == "GLIBC" else VERSIONS.get(first)
    if name in OTHER_VERSIONS or version and bound and version <= bound:
        return None
    return f"wants {name}, and the tag allows {first + '_' + '.'.join(map(str, bound)) if bound else 'none of that name'}"
