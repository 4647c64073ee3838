#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds every #include to the direction of dependencies that ARCHITECTURE.md draws.

A file belongs to a part by its folder, a public header by PUBLIC below. A part may include what ALLOWED says, and third-party
headers where OUTSIDE says. Tests beside their sources may include any part.
"""
import os
import re
import sys

from sources import project_files, read_text

# Which part stands behind each public header. A new header needs a line here.
PUBLIC = {
    "error.h": "data", "export.h": "data", "version.h": "data", "math.h": "data", "lattice.h": "data", "lattice_levels.h": "data", "lattice_boxes.h": "data", "kernels.h": "data", "kernel_field.h": "data", "kernel_team.h": "data", "field.h": "data", "surface.h": "data", "dataset.h": "data", "series.h": "data", "relevant.h": "data",
    "model.h": "model", "resample.h": "model", "slices.h": "model", "hyperslice.h": "model", "coarse.h": "model",
    "labels.h": "labels",
    "fit.h": "fit", "simplify.h": "fit",
    "solid.h": "solid",
    "camera.h": "view", "transfer_function.h": "view", "transfer_function_2d.h": "view", "look.h": "view", "image.h": "view",
    "render_options.h": "view", "depth_limits.h": "view", "space_part.h": "view", "deep_image.h": "view", "label_style.h": "view", "crop.h": "view", "channels.h": "view",
    "scene.h": "scene", "framing.h": "scene",
    "annotate.h": "annotate",
    "io.h": "io", "encode.h": "io", "output_files.h": "io",
    "lattice_file.h": "io",
    "renderer.h": "render", "sampler.h": "render", "pick.h": "render", "devices.h": "render",
    "ovoid.h": "everything",
}

# part -> parts whose headers it may include besides its own. `view:public` is view's public headers only: readers
# and writers of cameras, looks and pictures need those nouns, not what view does with them.
ALLOWED = {
    "data": set(),
    "simd": {"data"},
    "model": {"data", "simd"},
    "fit": {"data", "model", "io:public"},  # how many bytes a file will have
    "solid": {"data", "model", "fit"},
    "labels": {"data", "simd", "view"},
    "view": {"data"},
    "scene": {"data", "view", "labels"},
    "annotate": {"data", "view"},
    "io": {"data", "view:public"},
    "io/foreign": {"data", "io", "view:public"},  # io itself, the library, sees none of it
    "render": {"data", "model", "labels", "simd", "view", "scene", "render/reference", "render/cpu", "render/vulkan"},  # src/render itself: chooses the back end
    "render/reference": {"data", "view", "scene", "render"},
    "render/cpu": {"data", "view", "scene", "render", "render/shared", "simd"},
    "render/vulkan": {"data", "view", "render", "render/shared"},
    "render/without_vulkan": {"data", "view", "render"},
    "render/shared": {"data", "view", "render"},
    "everything": {"data", "model", "fit", "solid", "labels", "view", "scene", "annotate", "io", "render"},
}

# Third-party headers and the places that may see them, by prefix of the path.
OUTSIDE = [
    ("VTK", re.compile(r"^vtk\w*\.h"), ("src/io/foreign/", "bindings/", "bench/")),
    ("GDCM", re.compile(r"^gdcm\w*\.h"), ("src/io/foreign/", "src/io/dicom/test_dicom")),
    ("Linux's sandboxes", re.compile(r"^(linux/landlock|seccomp)\.h"), ("apps/reader/",)),
    ("HDF5", re.compile(r"^hdf5(_hl)?\.h"), ("src/io/", "tests/cli/lattice_test.cpp")),
    ("OpenVDB", re.compile(r"^(openvdb|tbb)/"), ("src/io/foreign/", "tests/vdb/")),
    ("Highway", re.compile(r"^hwy/"), ("src/render/cpu/", "src/simd/", "src/labels/", "src/model/particles/nearest_squares.cpp", "bench/")),
    ("Vulkan", re.compile(r"^(volk\.h|vulkan/)"), ("src/render/vulkan/",)),
    ("GLFW, Dear ImGui and OpenGL", re.compile(r"^(GLFW/|GL/|imgui|backends/imgui)"), ("apps/viewer/",)),
    ("pybind11", re.compile(r"^pybind11/"), ("python/",)),
    ("MPI", re.compile(r"^mpi\.h"), ("apps/mpi/",)),
    ("OpenEXR", re.compile(r"^(OpenEXR/)?(Imf|Imath|Iex)|^Imath/"), ("src/io/", "apps/", "tests/")),
    ("libpng", re.compile(r"^png\.h"), ("src/io/", "tests/")),
    ("libjpeg", re.compile(r"^jpeglib\.h"), ("src/io/",)),
    ("giflib", re.compile(r"^gif_lib\.h"), ("src/io/", "tests/")),
    ("Voro++", re.compile(r"^voro\+\+/"), ("src/model/", "bench/")),
    ("zlib and bzip2", re.compile(r"^(zlib|bzlib)\.h"), ("src/io/", "tests/")),
    ("Blosc, Zstandard and LZ4", re.compile(r"^(blosc|zstd|lz4)\.h"), ("src/io/zarr/", "src/io/images/", "src/io/foreign/vdb_unpacking.cpp")),
    ("pugixml", re.compile(r"^pugixml\.hpp$"), ("src/io/", "tests/")),
    ("nlohmann-json", re.compile(r"^nlohmann/"), ("src/io/", "apps/", "python/", "tests/", "bench/")),
    ("CLI11", re.compile(r"^CLI/"), ("bench/",)),
    ("GoogleTest", re.compile(r"^g(test|mock)/"), ("tests/",)),
    ("fmt", re.compile(r"^fmt/"), ("src/", "apps/", "bindings/", "python/", "tests/", "bench/")),
    ("Eigen", re.compile(r"^Eigen/"), ("",)),
    ("Eigen's Fourier transform", re.compile(r"^unsupported/Eigen/FFT$"), ("src/model/",)),
    ("Eigen's Levenberg-Marquardt, which tests compare with", re.compile(r"^unsupported/Eigen/(NonLinearOptimization|NumericalDiff)$"), ("src/fit/",)),
]
# A C++20 standard header has no dot and no slash; the rest are POSIX ones that the program needs.
STANDARD = re.compile(r"^[a-z0-9_]+$")
POSIX = re.compile(r"^(sys/|unistd\.h|fcntl\.h|signal\.h|stdio\.h|stdlib\.h|dlfcn\.h|setjmp\.h|spawn\.h|poll\.h|sched\.h|malloc\.h|link\.h|immintrin\.h|x86intrin\.h)")
PROGRAMS = ("src/", "apps/", "python/", "tests/", "bench/")
# A unit test beside its source, or what several of them share.
IS_TEST = re.compile(r"(_test\.cpp|/test_\w+\.h)$")
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>|(\w+))')


def part_of(path):
    """The part a project file belongs to, or None for programs, tests and benchmarks, which may join all."""
    if path.startswith("include/ovoid/"):
        return PUBLIC.get(os.path.basename(path), "unknown")
    pieces = path.split("/")
    if pieces[0] != "src":
        return None
    inner = "/".join(pieces[1:3])  # other folders within a part are rooms of it
    return inner if inner in ALLOWED else pieces[1]


def resolve(path, included):
    """The project file that an include names, or None. A shader's words (lattice.inc) are made of its source while building."""
    if included.endswith(".inc"):
        beside = os.path.dirname(path)
        sources = {os.path.join(beside, *folder, included[:-4] + ".comp") for folder in ((), ("shaders",))}
        return path if sources & SHADERS else None
    for folder in (os.path.dirname(path), "include", "src", "tests", "bench", "apps/ovoid", "apps/viewer"):
        candidate = os.path.normpath(os.path.join(folder, included))
        if candidate in FILES:
            return candidate
    return None


def check_own(path, target):
    part, wanted = part_of(path), part_of(target)
    is_public = target.startswith("include/")
    if path.startswith("bindings/") and not is_public and os.path.dirname(path) != os.path.dirname(target):
        return f"a binding sees the public headers and its own alone ({target})"
    if path.startswith("include/") and not is_public:
        return "a public header includes a private one"
    if part is None or IS_TEST.search(path) or part == wanted:
        return None
    allowed = ALLOWED.get(part)
    if allowed is None or wanted == "unknown":
        return f"'{part if allowed is None else target}' is not in the tables of {os.path.relpath(__file__)}"
    if wanted in allowed or is_public and f"{wanted}:public" in allowed:
        return None
    return f"{part} must not see {wanted} ({target})"


def check_outside(path, included):
    public = path.startswith("include/")
    if STANDARD.match(included):
        return None
    for name, pattern, places in OUTSIDE:
        if not pattern.match(included):
            continue
        if public and name != "Eigen":
            return f"a public header shows {name}"
        if name == "GoogleTest" and IS_TEST.search(path) or path.startswith(places):
            return None
        return f"{name} is seen outside {', '.join(places)}"
    if POSIX.match(included) and path.startswith(PROGRAMS):
        return None
    return f"'{included}' is neither the project's, nor standard, nor a library it stands on"


def check_file(path):
    for number, line in enumerate(read_text(path).split("\n"), 1):
        match = INCLUDE.match(line)
        if not match or match.group(3):  # a macro: Highway's foreach_target names the file itself
            continue
        included = match.group(1) or match.group(2)
        target = resolve(path, included)
        if match.group(1) and target is None and not path.startswith("examples/"):
            message = check_outside(path, included) if included.startswith(("hwy/", "vtk")) else "no such file in the project"
        elif path.startswith("examples/"):
            message = None  # built against the installed package, by a test
        else:
            message = check_own(path, target) if target else check_outside(path, included)
        if message:
            yield f"{path}:{number}: {message}"


def main():
    findings = [finding for path in sorted(FILES) for finding in check_file(path)]
    print("\n".join(findings + [f"{len(FILES)} files"]))
    return 1 if findings else 0


FILES = set(project_files("*.h", "*.cpp"))
SHADERS = set(project_files("*.comp"))

if __name__ == "__main__":
    sys.exit(main())
