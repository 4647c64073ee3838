#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The wheels of the Python package: wheel_test.py BUILD WORK [vtk] [--hardened].

Both kinds are made of what lies in BUILD, and installed in a virtual environment. The portable one must pass its check, which must
find each kind of damage; both must draw the bytes of BUILD's own package, and neither may load anything of BUILD. Ends with 77, which
is skipped, where python3-venv or patchelf is missing.
"""
import glob
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.append(os.path.join(ROOT, "python", "wheel"))
sys.dont_write_bytecode = True
import check  # noqa: E402

# Draws; reads what it has written, and says what was loaded.
SCRIPT = """
import sys
import numpy, ovoid
z, y, x = numpy.mgrid[-1:1:24j, -1:1:28j, -1:1:32j]
array = numpy.exp(-3 * (x - 0.2) ** 2 - 5 * y**2 - 4 * z**2).astype("f4")
ovoid.render(array, size=(96, 72)).save("picture.png")
for name in sys.argv[1:]:
    ovoid.write(name, array)
    try:
        assert (next(iter(ovoid.read(name).arrays.values())) == array).all(), name
    except ovoid.Unsupported as error:
        print(error)
ovoid.write("points.ply", ovoid.particles(array.reshape(-1, 3)[:100], {"speed": numpy.arange(100.0)}))
ovoid.render("points.ply", size=(96, 72)).save("points.jpg")
with open("/proc/self/maps") as maps:
    print(*sorted({line.split()[-1] for line in maps if ".so" in line}), sep="\\n")
"""
SAMPLES = ("v.nrrd", "v.nii.gz", "v.npy")


def run(*command, folder=None, **variables):
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "LD_", "OVOID_", "PIP_"))}
    done = subprocess.run(command, cwd=folder, env={**environment, **variables}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def draw(python, folder, *samples, **variables):
    """The picture's bytes, and what the script has printed."""
    os.makedirs(folder)
    printed = run(python, "-c", SCRIPT, *samples, folder=folder, **variables)
    with open(os.path.join(folder, "picture.png"), "rb") as file:
        return file.read(), printed


def demand(holds, words):
    if not holds:
        sys.exit(words)


def damage_is_found(wheel, work):
    """Each damage to an unpacked wheel has its finding."""
    match = check.NAME.fullmatch(os.path.basename(wheel))
    whole = os.path.join(work, "whole")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(whole)
    info = f"{match['stem']}.dist-info"
    notice = os.path.join(info, "licenses", "NOTICE")
    png = os.path.relpath(glob.glob(os.path.join(whole, "ovoid.libs", "libpng16-*"))[0], whole)
    core = os.path.relpath(glob.glob(os.path.join(whole, "ovoid", "_core.*"))[0], whole)

    def edit(path, old, new):
        with open(path, encoding="ascii") as file:
            text = file.read()
        with open(path, "w", encoding="ascii") as file:
            file.write(text.replace(old, new))

    older = check.NAME.fullmatch(re.sub("manylinux_2_[0-9]+", "manylinux_2_17", match[0]))
    damages = (
        (lambda root: os.remove(os.path.join(root, png)), match, r"needs libpng16-.*, which is neither in the wheel nor in every Linux"),
        (lambda root: run("patchelf", "--set-rpath", "/usr/lib/x", os.path.join(root, core)), match, r"RPATH leads out of the wheel: /usr/lib/x"),
        (lambda root: run("patchelf", "--set-rpath", "$ORIGIN:", os.path.join(root, core)), match, r"RPATH leads out of the wheel: $"),
        (lambda root: run("patchelf", "--set-rpath", "$ORIGIN/../../x", os.path.join(root, core)), match, r"RPATH leads out of the wheel: \$ORIGIN/"),
        (lambda root: run("patchelf", "--add-needed", "libX11.so.6", os.path.join(root, core)), match, r"_core.*needs libX11.so.6"),
        (lambda root: shutil.copy(os.path.join(root, png), os.path.join(root, "ovoid.libs", "libother.so.1")), match, r"libother.so.1: nothing needs it"),
        (lambda root: edit(os.path.join(root, notice), "libpng16-", "png-"), match, r"libpng16-.*: NOTICE does not name it"),
        (lambda root: os.remove(os.path.join(root, info, "licenses", "libpng16-16.txt")), match, r"the licence of libpng16-16 is missing"),
        (lambda root: edit(os.path.join(root, "ovoid", "__init__.py"), "import", "import "), match, r"ovoid/__init__.py: differs from RECORD"),
        (lambda root: os.mkdir(os.path.join(root, "tests")), match, r"tests: has no business in the wheel"),
        (lambda root: None, older, r"libovoid-.*wants GLIBC_2\.\d+, and the tag allows GLIBC_2\.17"),
    )
    for index, (damage, name, finding) in enumerate(damages):
        root = os.path.join(work, f"damaged{index}")
        shutil.copytree(whole, root)
        damage(root)
        findings = check.check_folder(root, name)[0]
        demand(any(re.search(finding, line) for line in findings), f"the check does not find '{finding}', but\n" + "\n".join(findings))
        shutil.rmtree(root)


def main(build, work, *parts):
    if shutil.which("patchelf") is None or importlib.util.find_spec("ensurepip") is None:
        print("skipped: patchelf or python3-venv is not installed")
        return 77
    build, work = os.path.realpath(build), os.path.realpath(work)
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    expected, _ = draw(sys.executable, os.path.join(work, "from_build"), PYTHONPATH=os.path.join(build, "python"))
    run(sys.executable, "-m", "venv", "--system-site-packages", "venv", folder=work)
    python = os.path.join(work, "venv", "bin", "python")

    back_end = os.path.join(ROOT, "python", "wheel", "back_end.py")
    wheel = run(sys.executable, back_end, "--portable", "--build-dir", build, work, PYTHONDONTWRITEBYTECODE="1").strip()
    findings, summary = check.check(wheel)
    demand(not findings, "\n".join(findings))
    with zipfile.ZipFile(wheel) as archive:
        demand(not [name for name in archive.namelist() if "_window" in name or "ovoid-read" in name], "the portable wheel has what needs VTK or a screen")
    print(os.path.basename(wheel), summary)
    damage_is_found(wheel, work)
    run(python, "-m", "pip", "install", "--no-index", "--no-deps", wheel)
    picture, printed = draw(python, os.path.join(work, "portable"), *SAMPLES, "v.vti")
    demand(picture == expected, "the portable wheel draws another picture")
    demand(f"{work}/venv/" in printed and build + "/" not in printed.replace(work, ""), f"what the portable wheel loads:\n{printed}")
    bundled = [re.sub("-[0-9a-f]{8}", "", os.path.basename(path)) for path in check.elf_files(os.path.join(work, "whole", "ovoid.libs"))]
    borrowed = [line for line in printed.splitlines() if os.path.basename(line).startswith(tuple(bundled)) and not line.startswith(work)]
    demand(not borrowed, f"the portable wheel does not load its own: {borrowed}")
    if not glob.glob("/usr/libexec/ovoid/ovoid-read") + glob.glob("/usr/local/libexec/ovoid/ovoid-read"):
        demand("v.vti: this format is read by the program ovoid-read" in printed, f"no word of the missing reader:\n{printed}")

    run(python, "-m", "pip", "install", "--no-index", "--no-deps", "--force-reinstall", ".", "--config-settings", f"build-dir={build}", folder=ROOT,
        PYTHONDONTWRITEBYTECODE="1")
    picture, printed = draw(python, os.path.join(work, "local"), *SAMPLES, *(["v.vti"] if "vtk" in parts else []))
    demand(picture == expected, "what pip installs from the checkout draws another picture")
    demand("ovoid-read" not in printed, f"the reader was not installed: {printed}")
    run(sys.executable, os.path.join(ROOT, "scripts", "check_binaries.py"), *(["--hardened"] if "--hardened" in parts else []),
        glob.glob(os.path.join(work, "venv", "lib", "python3*", "site-packages", "ovoid"))[0])
    demand("/site-packages/ovoid/libovoid.so" in printed and build + "/" not in printed.replace(work, ""), f"what the wheel of the checkout loads:\n{printed}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
