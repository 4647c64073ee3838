# SPDX-License-Identifier: Apache-2.0
"""Makes an unpacked wheel run where the libraries that it was built with are not installed.

They go into ``ovoid.libs``, each under a name that is made of its bytes: another package of the same process may have brought another
file of the same name, and the loader takes the first one that it knows by that name. Their licences come along.
"""
import glob
import hashlib
import os
import re
import shutil
import subprocess
import sys

import manylinux
from elf import is_elf, read_elf

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.append(os.path.join(ROOT, "scripts"))
from check_licences import licence_of, package_of, read_list  # noqa: E402

LIBRARIES = "ovoid.libs"
# Packages of headers whose code the compiler puts into ours.
COMPILED_IN = ("libeigen3-dev", "libhwy-dev", "libvulkan-volk-dev", "nlohmann-json3-dev", "pybind11-dev")


def elf_files(folder):
    return sorted(path for path in glob.glob(os.path.join(folder, "**"), recursive=True) if is_elf(path))


def strip(path):
    """Before `patch`: strip breaks what patchelf has moved."""
    subprocess.run(["strip", "--strip-unneeded", path], check=True)


def patch(path, *changes):
    if shutil.which("patchelf") is None:
        raise SystemExit("patchelf is missing, which a wheel is made with: apt install patchelf")
    subprocess.run(["patchelf", *changes, path], check=True)


def loaded_from(path):
    """SONAME to file of all that the loader brings for a file."""
    listing = subprocess.run(["ldd", path], check=True, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"}).stdout
    return dict(re.findall(r"^\s*(\S+) => (/\S+) \(0x", listing, re.MULTILINE))


def libraries_of(originals):
    """The libraries that the built files need and not every Linux has: SONAME to file."""
    found, queue = {}, list(originals)
    places = {name: place for path in originals for name, place in loaded_from(path).items()}
    while queue:
        path = queue.pop()
        for name in read_elf(path).needed:
            if name in manylinux.LIBRARIES or name in found:
                continue
            if name not in places:
                raise SystemExit(f"{path}: needs {name}, which is not found here")
            found[name] = os.path.realpath(places[name])
            queue.append(found[name])
    return found


def own_name(soname, path):
    """libpng16.so.16 as libpng16-0f3c5a12.so.16."""
    with open(path, "rb") as file:
        digest = hashlib.sha256(file.read()).hexdigest()[:8]
    stem, rest = soname.split(".so", 1)
    return f"{stem}-{digest}.so{rest}"


def version_of(package):
    return subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], check=True, capture_output=True, text=True).stdout


def write_notice(bundled, licences):
    """Adds to the wheel's NOTICE what it contains, and copies each package's licence beside it."""
    listed = read_list(os.path.join(ROOT, "scripts", "licences.txt"))
    lines = ["", "This wheel contains these libraries, as Debian and Ubuntu build them, changed in nothing but their names and in where they look for",
             "each other. The licence of each is in the file of its package's name beside this one:", ""]
    owners = [(package_of(path), os.path.basename(copy)) for path, copy in sorted(bundled.items(), key=lambda item: item[1])]
    for package, file in owners + [(package, "compiled in") for package in COMPILED_IN]:
        if package is None:
            raise SystemExit(f"{file}: belongs to no package, so its licence is unknown: a wheel for others is made of the distribution's libraries")
        licence = licence_of(package, listed)
        if licence is None:
            raise SystemExit(f"{package}: not in scripts/licences.txt; read /usr/share/doc/{package}/copyright and add it")
        text = f"/usr/share/doc/{package}/copyright"
        if not os.path.exists(text):
            raise SystemExit(f"{text} is missing: a wheel that contains {package} must show its licence")
        shutil.copyfile(text, os.path.join(licences, package + ".txt"))
        lines.append(f"{file}: {package} {version_of(package)}, {licence}")
    with open(os.path.join(licences, "NOTICE"), "a", encoding="ascii") as notice:
        notice.write("\n".join(lines) + "\n")


def bundle(root, licences, originals, own):
    """Puts the libraries of an unpacked wheel beside it.

    Parameters
    ----------
    root : str
        Folder of the unpacked wheel.
    licences : str
        Folder of licences in it, with a NOTICE.
    originals : list of str
        The ELF files in it where they were built, and the loader finds what they need.
    own : str
        Our library where it was built: it is of no package.

    Returns
    -------
    str
        The platform tag.
    """
    folder = os.path.join(root, LIBRARIES)
    os.makedirs(folder)
    found = libraries_of(originals)
    renamed = {soname: own_name(soname, path) for soname, path in found.items()}
    bundled = {}
    for soname, path in found.items():
        copy = os.path.join(folder, renamed[soname])
        shutil.copyfile(path, copy)
        os.chmod(copy, 0o755)
        if path == os.path.realpath(own):
            strip(copy)
        else:
            bundled[path] = copy
    elves = []
    for path in elf_files(root):
        # One kind of change a call: patchelf 0.14 mixes up the texts of several.
        if os.path.dirname(path) == folder:
            patch(path, "--set-soname", os.path.basename(path))
        replaced = [["--replace-needed", name, renamed[name]] for name in read_elf(path).needed if name in renamed]
        if replaced:
            patch(path, *sum(replaced, []))
        to_libraries = os.path.relpath(folder, os.path.dirname(path))
        patch(path, "--set-rpath", "$ORIGIN" if to_libraries == "." else f"$ORIGIN/{to_libraries}")
        elves.append(read_elf(path))
    write_notice(bundled, licences)
    glibc = manylinux.needed_glibc(elves)
    return f"manylinux_{glibc[0]}_{glibc[1]}_{os.uname().machine}"
