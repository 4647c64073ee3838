#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the wheel of the Python package: the back end that pyproject.toml names to pip (PEP 517), and a program.

  back_end.py [--portable] [--build-dir FOLDER] OUT_FOLDER

Without --build-dir, CMake's preset `wheel` is built in build/wheel: the package for the Python that runs this, the library, and the
readers' process, of what is found. With it, what was built in that folder is taken as it is. The wheel runs on this machine, with
this machine's libraries; with --portable it brings them, leaves out the readers' process and the window, which need VTK and the
machine's graphics, and runs elsewhere. pip takes the same by --config-settings portable=1 and build-dir=FOLDER.
"""
import argparse
import base64
import glob
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import time
import tomllib
import zipfile

import bundle
from elf import is_elf, read_elf

ROOT = bundle.ROOT
GENERATOR = "ovoid python/wheel/back_end.py"
# Of a build folder; the first also of the sources.
PACKAGE, LIBRARY = "python/ovoid", "bin/libovoid.so"
READERS = ("bin/ovoid-read", "bin/ovoid-read-vdb")
NOT_PORTABLE = ("_window",)  # extension modules that link the machine's graphics


def project_table():
    with open(os.path.join(ROOT, "pyproject.toml"), "rb") as file:
        return tomllib.load(file)["project"]


def version():
    with open(os.path.join(ROOT, "include", "ovoid", "version.h"), encoding="ascii") as file:
        return ".".join(re.findall(r"^#define OVOID_VERSION_\w+ (\d+)", file.read(), re.MULTILINE))


def stem():
    return f"{project_table()['name']}-{version()}"


def metadata():
    """The text of METADATA and PKG-INFO."""
    project = project_table()
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {version()}", f"Summary: {project['description']}",
             f"License: {project['license']['text']}", f"Requires-Python: {project['requires-python']}"]
    lines += [f"Classifier: {classifier}" for classifier in project["classifiers"]]
    lines += [f"Requires-Dist: {dependency}" for dependency in project["dependencies"]]
    with open(os.path.join(ROOT, project["readme"]), encoding="utf-8") as file:
        return "\n".join([*lines, "Description-Content-Type: text/markdown", "", file.read()])


def cached(folder, name):
    """A variable of a build folder's cache; empty if it has none."""
    try:
        with open(os.path.join(folder, "CMakeCache.txt"), encoding="utf-8") as file:
            return next((line.rstrip("\n").split("=", 1)[1] for line in file if line.startswith(name + ":")), "")
    except FileNotFoundError:
        return ""


def build():
    """Configures and builds the preset, and returns its folder."""
    for program in ("cmake", "ninja", "c++"):
        if shutil.which(program) is None:
            raise SystemExit(f"{program} is missing, which the package is built with: scripts/setup.sh build installs what is needed")
    folder = os.path.join(ROOT, "build", "wheel")
    python = os.path.realpath(sys.executable)  # of a virtual environment that whose it is
    fresh = ["--fresh"] if cached(folder, "OVOID_PYTHON_PROGRAM") not in ("", python) else []
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    subprocess.run(["cmake", *fresh, "--preset", "wheel", f"-DOVOID_PYTHON_PROGRAM={python}", *launcher, *os.environ.get("CMAKE_ARGS", "").split()],
                   cwd=ROOT, check=True)
    shutil.rmtree(os.path.join(folder, PACKAGE), ignore_errors=True)  # may be another Python's, or have files that are no more
    subprocess.run([os.path.join(ROOT, "scripts", "build.sh"), "wheel", "ovoid_package"], check=True)
    return folder


def extension(folder):
    """The extension module of a build folder, and the wheel's tag for its Python."""
    modules = glob.glob(os.path.join(folder, PACKAGE, "_core.*.so"))
    match = re.search(r"\.cpython-3(\d+)-", modules[0]) if len(modules) == 1 else None
    if not match:
        raise SystemExit(f"{folder} has {len(modules) or 'no'} extension module{'s' * (len(modules) != 1)} of CPython: expected one, which pybind11-dev"
                         " and python3-dev are needed for")
    return modules[0], f"cp3{match.group(1)}"


def stage(folder, root, is_portable):
    """Lays the wheel's files out in a folder. Returns those of them that are ELF, where they were built, and the library there."""
    package = os.path.join(root, "ovoid")
    os.makedirs(package)
    originals = []
    for path in sorted(glob.glob(os.path.join(folder, PACKAGE, "*"))):
        name = os.path.basename(path)
        if is_elf(path):
            if is_portable and name.split(".")[0] in NOT_PORTABLE:
                continue
            originals.append(path)
        elif not os.path.isfile(os.path.join(ROOT, PACKAGE, name)):
            continue  # nothing of the package's, or no longer
        shutil.copy(path, package)
    library = os.path.join(folder, LIBRARY)
    if not is_portable:
        shutil.copy(library, os.path.join(package, read_elf(library).soname))
        for reader in READERS:
            if os.path.exists(os.path.join(folder, reader)):
                shutil.copy(os.path.join(folder, reader), package)
    for path in bundle.elf_files(package):
        bundle.strip(path)
    return originals, library


def stay_here(root, folder):
    """The files of an unpacked wheel find each other, and this machine's libraries where the build found them."""
    for path in bundle.elf_files(root):
        elsewhere = [place for place in read_elf(path).rpath if not place.startswith(("$ORIGIN", os.path.realpath(folder), ROOT))]
        bundle.patch(path, "--set-rpath", ":".join(["$ORIGIN", *elsewhere]))
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


def write_info(root, tag):
    folder = os.path.join(root, f"{stem()}.dist-info")
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "METADATA"), "w", encoding="utf-8") as file:
        file.write(metadata())
    with open(os.path.join(folder, "WHEEL"), "w", encoding="ascii") as file:
        file.write(f"Wheel-Version: 1.0\nGenerator: {GENERATOR}\nRoot-Is-Purelib: false\nTag: {tag}\n")
    return os.path.basename(folder)


def write_wheel(root, path):
    """Zips an unpacked wheel. The same files give the same bytes."""
    record_name = f"{stem()}.dist-info/RECORD"
    record = []
    files = sorted(name for name in glob.glob("**", root_dir=root, recursive=True) if os.path.isfile(os.path.join(root, name)))
    date = time.gmtime(max(int(os.environ.get("SOURCE_DATE_EPOCH", 0)), 315532800))[:6]  # zip begins in 1980
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:

        def add(name, data, mode):
            entry = zipfile.ZipInfo(name, date)
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)

        for name in files:
            with open(os.path.join(root, name), "rb") as file:
                data = file.read()
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{name},sha256={digest},{len(data)}")
            add(name, data, 0o755 if os.access(os.path.join(root, name), os.X_OK) else 0o644)
        add(record_name, "\n".join([*record, f"{record_name},,", ""]), 0o644)


def make_wheel(out, folder, is_portable):
    """Makes a wheel of what was built in a folder. Returns its name."""
    module, python_tag = extension(folder)
    with tempfile.TemporaryDirectory() as root:
        info = f"{stem()}.dist-info"
        licences = os.path.join(root, info, "licenses")
        os.makedirs(licences)
        for name in ("LICENSE", "NOTICE"):
            shutil.copyfile(os.path.join(ROOT, name), os.path.join(licences, name))
        originals, library = stage(folder, root, is_portable)
        platform = bundle.bundle(root, licences, originals, library) if is_portable else stay_here(root, folder)
        tag = f"{python_tag}-{python_tag}-{platform}"
        write_info(root, tag)
        name = f"{stem()}-{tag}.whl"
        os.makedirs(out, exist_ok=True)
        write_wheel(root, os.path.join(out, name))
    return name


# The hooks of PEP 517.


def settings_of(config_settings):
    settings = dict(config_settings or {})
    folder, portable = settings.pop("build-dir", ""), settings.pop("portable", "0")
    if settings:
        raise SystemExit(f"config setting {', '.join(settings)}: expected build-dir=FOLDER or portable=1")
    if portable not in ("0", "1"):
        raise SystemExit(f"config setting portable={portable}: expected 0 or 1")
    if folder and not os.path.isdir(os.path.join(folder, PACKAGE)):
        raise SystemExit(f"config setting build-dir={folder}: no Python package was built there (cmake --build {folder} --target ovoid_package)")
    return os.path.abspath(folder) if folder else "", portable == "1"


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    settings_of(config_settings)
    return write_info(metadata_directory, "py3-none-any")  # the tag is not read from here


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    folder, is_portable = settings_of(config_settings)
    folder = folder or build()
    module, _ = extension(folder)
    if not module.endswith(sysconfig.get_config_var("EXT_SUFFIX")):
        raise SystemExit(f"{module} is not for this Python, {sys.executable}")
    return make_wheel(wheel_directory, folder, is_portable)


def build_sdist(sdist_directory, config_settings=None):
    """The files that git knows, or, without git, all but what was built."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    files = listed.stdout.split("\0") if listed.returncode == 0 and listed.stdout else glob.glob("**", root_dir=ROOT, recursive=True)
    name = f"{stem()}.tar.gz"
    with tarfile.open(os.path.join(sdist_directory, name), "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for file in sorted(files):
            if os.path.isfile(os.path.join(ROOT, file)) and not file.startswith(("build/", ".git")):
                archive.add(os.path.join(ROOT, file), f"{stem()}/{file}")
        text = metadata().encode()
        entry = tarfile.TarInfo(f"{stem()}/PKG-INFO")
        entry.size = len(text)
        archive.addfile(entry, io.BytesIO(text))
    return name


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--portable", action="store_true")
    parser.add_argument("--build-dir", default="")
    parser.add_argument("out")
    arguments = parser.parse_args()
    folder, is_portable = settings_of({"build-dir": arguments.build_dir, "portable": str(int(arguments.portable))})
    print(os.path.join(arguments.out, make_wheel(arguments.out, folder or build(), is_portable)))


if __name__ == "__main__":
    main()
