# SPDX-License-Identifier: Apache-2.0
"""What an ELF file says that it needs, by binutils' readelf."""
import dataclasses
import os
import re
import subprocess


@dataclasses.dataclass
class Elf:
    """What the dynamic loader reads of a file.

    Attributes
    ----------
    machine : str
        In the words of readelf.
    soname : str
        Empty if it has none.
    needed : list of str
        SONAMEs.
    rpath : list of str
        The folders of RPATH and RUNPATH.
    versions : dict of str to list of str
        The versions of symbols, such as ``GLIBC_2.34``, that it wants of each library.
    """

    machine: str
    soname: str
    needed: list
    rpath: list
    versions: dict


def is_elf(path):
    if os.path.islink(path) or not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def read_elf(path):
    # Written for people, but the same for twenty years; its words are not translated in the C locale.
    text = subprocess.run(["readelf", "--wide", "--file-header", "--dynamic", "--version-info", path], check=True, capture_output=True, text=True,
                          env={**os.environ, "LC_ALL": "C"}).stdout
    sonames = re.findall(r"\(SONAME\) .*\[(.*)\]", text)
    rpaths = re.findall(r"\((?:RPATH|RUNPATH)\) .*\[(.*)\]", text)
    versions = {}
    for library, entries in re.findall(r"Version: \d+  File: (\S+)  Cnt: \d+\n((?:.*Name: .*\n)*)", text):
        versions.setdefault(library, []).extend(re.findall(r"Name: (\S+)", entries))
    return Elf(re.search(r"Machine: +(.*)", text).group(1), sonames[0] if sonames else "", re.findall(r"\(NEEDED\) .*\[(.*)\]", text),
               [folder for rpath in rpaths for folder in rpath.split(":")], versions)
