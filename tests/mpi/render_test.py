# SPDX-License-Identifier: Apache-2.0
"""One picture by several processes, against one process's: render_test.py MPIEXEC OVOID [NUMBER...]. Also what happens
when something goes wrong for one of them. Ends with 77 (skipped) where processes cannot be started here."""
import json
import math
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time

MPIEXEC, OVOID = sys.argv[1:3]
# For each commit a power of two and another number; more on a few processors take minutes.
NUMBERS = [int(n) for n in sys.argv[3:]] or ([1, 2, 3, 4, 7] if os.environ.get("OVOID_TEST_NIGHTLY") == "1" else [2, 3])
SMALL = ["--size", "96x72", "--backend", "cpu"]
failures = []


def expect(holds, what):
    if not holds:
        failures.append(what)
        print("FAILED:", what)


def environment(**more):
    # Open MPI refuses root, and more processes than processors, unless it is told otherwise.
    return dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_hwloc_base_binding_policy="none",
                OMPI_MCA_mpi_yield_when_idle="1", **more)


def run(words, processes=0, **more):
    launcher = [MPIEXEC, "-n", str(processes)] if processes else []
    return subprocess.run(launcher + words, env=environment(**more), capture_output=True, text=True, timeout=120)


def render(words, out, processes=0, **more):
    done = run([OVOID, "render", *words, *SMALL, "-o", out], processes, **more)
    expect(done.returncode == 0, f"{words} by {processes}: {done.stderr}")
    return done


def numbers(path):
    """The float32 values of a .npy file."""
    with open(path, "rb") as file:
        data = file.read()
    header = struct.unpack_from("<H", data, 8)[0]
    values = data[10 + header:]
    return struct.unpack(f"<{len(values) // 4}f", values)


def expect_same(a, b, what):
    first, second = numbers(a), numbers(b)
    expect(len(first) == len(second), what + ": of another size")
    expect(max(first[3::4]) > 0, what + ": shows nothing")
    greatest = max(abs(x - y) for x, y in zip(first, second))
    expect(greatest <= 1 / 255, f"{what}: differs by {255 * greatest:.2f}/255")
    print(f"{what}: {255 * greatest:.4f}/255")


def layers(folder, levels):
    """Adaptive grids: `levels` of 12^3 cells, each within the one before."""
    names = []
    for level in range(levels):
        edge = 0.5**level
        cells = " ".join(f"{math.hypot(i - 6, j - 5, k - 4) * edge:.5g}"
                         for k in range(12) for j in range(12) for i in range(12))
        names.append(f"grid-{level}.vti")
        with open(os.path.join(folder, names[-1]), "w") as file:
            file.write(f'''<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">
<ImageData WholeExtent="0 12 0 12 0 12" Origin="0 0 0" Spacing="{edge} {edge} {edge}"><Piece Extent="0 12 0 12 0 12">
<CellData><DataArray type="Float32" Name="far" format="ascii">{cells}</DataArray></CellData>
</Piece></ImageData></VTKFile>''')
    path = os.path.join(folder, "layers.vth")
    with open(path, "w") as file:
        blocks = "".join(f'<Block level="{level}"><DataSet index="0" file="{name}"/></Block>'
                         for level, name in enumerate(names))
        file.write(f'<VTKFile type="vtkHierarchicalBoxDataSet" version="1.1">'
                   f"<vtkHierarchicalBoxDataSet>{blocks}</vtkHierarchicalBoxDataSet></VTKFile>")
    return path


def piece(path, first, last):
    """Hexahedra of a bent bar between two of its sections, as a VTU file."""
    nodes = [(x, y + 0.02 * x * x, z) for x in range(first, last + 1) for y in range(5) for z in range(4)]
    cells = []
    for x in range(last - first):
        for y in range(4):
            for z in range(3):
                at = [(x + i) * 20 + (y + j) * 4 + z + k for i, j, k in
                      ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
                cells.append(" ".join(map(str, at)))
    numbers_of = lambda values: " ".join(map(str, values))
    with open(path, "w") as file:
        file.write(f'''<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="{len(nodes)}" NumberOfCells="{len(cells)}">
<PointData><DataArray type="Float32" Name="v" format="ascii">{numbers_of(math.sin(x) + y for x, y, z in nodes)}</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{numbers_of(c for node in nodes for c in node)}</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">{" ".join(cells)}</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">{numbers_of(range(8, 8 * len(cells) + 8, 8))}</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">{numbers_of([12] * len(cells))}</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>''')


def pieces(folder, count):
    """A mesh in pieces, one per file."""
    sources = ""
    for p in range(count):
        piece(os.path.join(folder, f"bar-{p}.vtu"), 3 * p, 3 * p + 3)
        sources += f'<Piece Source="bar-{p}.vtu"/>'
    path = os.path.join(folder, "bar.pvtu")
    with open(path, "w") as file:
        file.write(f'<VTKFile type="PUnstructuredGrid" version="0.1"><PUnstructuredGrid GhostLevel="0"><PPointData>'
                   f'<PDataArray type="Float32" Name="v"/></PPointData><PPoints><PDataArray type="Float64" '
                   f'NumberOfComponents="3"/></PPoints>{sources}</PUnstructuredGrid></VTKFile>')
    return path


def make_data(folder):
    """Each kind of data: a lattice, a mesh, particles, stored kernels; with VTK a mesh in pieces and adaptive grids."""
    data = {}
    for name, kind, more in (("head", "head.nrrd", ["--size", "40"]), ("fin", "fin.vtu", ["--count", "1500"]),
                             ("galaxy", "galaxy.npz", ["--count", "3000"])):
        path = os.path.join(folder, kind)
        made = run([OVOID, "make", name, *more, "-o", path])
        if made.returncode == 0:
            data[name] = path
        else:
            print("not drawn:", name, made.stderr)
    bar = pieces(folder, 5)
    if run([OVOID, "info", bar]).returncode == 0:
        data["bar"], data["layers"] = bar, layers(folder, 2)
    kernels = os.path.join(folder, "kernels.ply")
    if "fin" in data and run([OVOID, "convert", data["fin"], "-o", kernels]).returncode == 0:
        data["kernels"] = kernels
    return data


def pictures(folder, data):
    looks = {"head": [[], ["--mode", "mip"], ["--mode", "mean"], ["--iso", "120", "--mode", "isosurface"]],
             "fin": [["--surface=0"], [], ["--surface=0.3"]], "bar": [["--surface=0"], ["--surface=0.4"]],
             "layers": [[]], "galaxy": [[], ["--points"]], "kernels": [[]]}
    whole, together = os.path.join(folder, "whole.npy"), os.path.join(folder, "together.npy")
    for name, path in data.items():
        for i, look in enumerate(looks[name]):
            render([path, *look, "--sheets", "image"], whole)
            for processes in NUMBERS if i == 0 else NUMBERS[-1:]:
                render([path, *look], together, processes)
                expect_same(whole, together, f"{name} {' '.join(look)} by {processes}")


def cloud(path, count, writes_header):
    """Particles of two crowds and a few beside, in no order: x, y, z, v in a table or a periodic LAMMPS dump."""
    random.seed(7)
    rows = []
    for i in range(count):
        size = 4 if i % 40 == 0 else 0.8 if i % 2 else 0.1
        middle = (5, 5, 5) if i % 2 else (5.9, 5.3, 4.8)
        rows.append([min(max(m + size * random.gauss(0, 0.5), 0.01), 9.99) for m in middle] + [random.random()])
    with open(path, "w") as file:
        if writes_header:
            file.write("x,y,z,v\n" + "".join(",".join(f"{number:.7g}" for number in row) + "\n" for row in rows))
            return
        file.write(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS pp pp pp\n" + 3 * "0 10\n")
        file.write("ITEM: ATOMS id x y z v\n")
        for i, row in enumerate(rows):
            file.write(f"{i + 1} " + " ".join(f"{number:.7g}" for number in row) + "\n")


def in_files(folder, path):
    """Lattices that memory does not hold, which are read from their file, or from what was unpacked."""
    whole, together = os.path.join(folder, "one.npy"), os.path.join(folder, "many.npy")
    packed = os.path.join(folder, "packed.nii.gz")
    expect(run([OVOID, "convert", path, "-o", packed]).returncode == 0, "not converted: " + packed)
    for words in ([path, "--memory-limit", "50K"], [path, "--memory-limit", "50K", "--mode", "mip"],
                  [packed, "--memory-limit", "50K"]):
        done = render([*words, "--sheets", "image"], whole)
        expect("read from a file" in done.stderr, "not in a file: " + done.stderr)
        for processes in NUMBERS if words[-1] == "50K" else NUMBERS[-1:]:
            render(words, together, processes)
            expect_same(whole, together, f"{words} by {processes}")


def labels(path):
    """Three balls of a label each, as NRRD."""
    balls = (((9, 9, 9), 5), ((15, 12, 12), 6), ((11, 17, 9), 4))
    samples = bytearray(24**3)
    for number, (middle, radius) in enumerate(balls):
        for i in range(24**3):
            if math.dist((i % 24, i // 24 % 24, i // 576), middle) < radius:
                samples[i] = number + 1
    with open(path, "wb") as file:
        file.write(b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nspace directions: (0.08,0,0) (0,0.08,0) (0,0,0.08)\n"
                   b"space dimension: 3\nspace origin: (-0.9,-0.9,-0.9)\nencoding: raw\n\n" + bytes(samples))


def box(path, low, high):
    """A box as an STL file of text."""
    corner = [[(low, high)[i >> a & 1] for a in range(3)] for i in range(8)]
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    with open(path, "w") as file:
        file.write("solid box\n")
        for q in quads:
            for triangle in (q[:3], (q[0], q[2], q[3])):
                file.write("facet normal 0 0 0\nouter loop\n" + "".join(
                    "vertex " + " ".join(map(str, corner[i])) + "\n" for i in triangle) + "endloop\nendfacet\n")
        file.write("endsolid box\n")


def scenes(folder, data):
    """What is seen beside a field, and several volumes: by processes, and as parts in files."""
    whole, together, plain = (os.path.join(folder, name) for name in ("w.npy", "t.npy", "plain.npy"))
    ball, map_of_labels, surface = (os.path.join(folder, name) for name in ("ball.nrrd", "labels.nrrd", "box.stl"))
    run([OVOID, "make", "ball", "--size", "24", "-o", ball])
    labels(map_of_labels)
    box(surface, -0.3, 0.4)
    seen_through = [ball, "--colormap", "gray", "--opacity", "0:0,1:0.02"]
    render([*seen_through, "--sheets", "image"], plain)
    for words in ([*seen_through, "--slice", "z"],
                  [*seen_through, "--add", surface, "--add-opacity", "0.5", "--shadows", "0.5"],
                  [*seen_through, "--labels", map_of_labels, "--label-opacity", "2=0.4"], [map_of_labels],
                  [*seen_through, "--over", map_of_labels, "--over-range", "0,4"], [data["galaxy"], "--slice", "y"]):
        render([*words, "--sheets", "image"], whole)
        if words[0] == ball:
            expect(max(abs(x - y) for x, y in zip(numbers(whole), numbers(plain))) > 0.1, f"{words}: shows no more")
        render(words, together, NUMBERS[-1])
        expect_same(whole, together, f"{words[-4:]} by {NUMBERS[-1]}")
        together_of_parts(folder, words, together)
        expect_same(whole, together, f"{words[-4:]} in parts")
    # Parts of another scene are of another picture.
    for k, height in ((1, "0.1"), (2, "0.2")):
        render([ball, "--slice", f"z={height}", "--part", f"{k}/2"], os.path.join(folder, f"s{k}.exr"))
    strange = run([OVOID, "composite", *(os.path.join(folder, f"s{k}.exr") for k in (1, 2)), "-o", together])
    expect(strange.returncode == 1 and "'slice'" in strange.stderr, strange.stderr)


def shares(folder):
    """Particles whose rows, kernels and sizes several processes share, against those that one has alone."""
    whole, together = os.path.join(folder, "alone.npy"), os.path.join(folder, "shared.npy")
    for name, flags in (("cloud.csv", ["--array", "v"]), ("cloud.csv", ["--quantity", "density"]), ("cloud.dump", []),
                        ("cloud.csv", ["--array", "v", "--anisotropic"]), ("cloud.csv", ["--shadows", "0.7"])):
        path = os.path.join(folder, name)
        if not os.path.exists(path):
            cloud(path, 6000, name.endswith(".csv"))
        render([path, *flags, "--sheets", "image"], whole)
        for processes in NUMBERS[-3:]:
            render([path, *flags], together, processes)
            expect_same(whole, together, f"{name} {' '.join(flags)} by {processes}")


def peak_mib(folder, path, processes):
    out = os.path.join(folder, f"peak-{processes}.json")
    limit = ["--memory-limit", "2M"]  # of what is fetched
    render([path, *limit, f"--profile={out}"], os.path.join(folder, "p.npy"), processes)
    with open(out) as file:
        return json.load(file)["peak_mib"]["greatest"]


def memory_of_shares(folder, few):
    """What each of several processes takes for many particles, more than for a few, is less than what one alone does."""
    many = os.path.join(folder, "many.npz")
    run([OVOID, "make", "galaxy", "--count", "600000", "-o", many])
    alone, shared = (peak_mib(folder, many, n) - peak_mib(folder, few, n) for n in (1, 4))
    print(f"600,000 particles: {alone:.0f} MiB alone, {shared:.0f} by each of 4")
    expect(shared < 0.75 * alone, f"particles: {alone} MiB alone, {shared} by each of 4")


def profile(folder, path):
    out = os.path.join(folder, "profile.json")
    render([path, f"--profile={out}"], os.path.join(folder, "p.npy"), 2)
    with open(out) as file:
        told = json.load(file)
    expect(told["processes"] == 2 and told["draw_ms"]["greatest"] >= told["draw_ms"]["least"] > 0, str(told))
    expect(told["bytes_sent"] > 0 and told["peak_mib"]["least"] > 1, str(told))


def together_of_parts(folder, words, out):
    """Draws three parts to files, which are returned, and puts them together."""
    files = [os.path.join(folder, f"part-{k}.exr") for k in (1, 2, 3)]
    for k, file in enumerate(files):
        render([*words, "--part", f"{k + 1}/3"], file)
    done = run([OVOID, "composite", *files, "-o", out])
    expect(done.returncode == 0, f"parts of {words} cannot be put together: {done.stderr}")
    return files


def parts(folder, path):
    """Without MPI: parts as files."""
    whole, together = os.path.join(folder, "w.npy"), os.path.join(folder, "t.npy")
    render([path, "--sheets", "image"], whole)
    files = together_of_parts(folder, [path], together)
    expect_same(whole, together, "parts as files")
    lacking = run([OVOID, "composite", *files[:2], "-o", together])
    expect(lacking.returncode == 1 and "of 3 parts these are not given: 3" in lacking.stderr, lacking.stderr)
    other = os.path.join(folder, "other.exr")
    render([path, "--part", "3/3", "--azimuth", "10"], other)
    strange = run([OVOID, "composite", *files[:2], other, "-o", together])
    expect(strange.returncode == 1 and "another picture" in strange.stderr and "'camera'" in strange.stderr,
           strange.stderr)


def our_lines(text):
    return [line for line in text.splitlines() if line.startswith("ovoid: error:")]


def faults(folder, path, mesh):
    out = os.path.join(folder, "fault.npy")
    # A file that one of them does not have: a launcher script takes it away from the second process.
    script = os.path.join(folder, "one-lacks-it.sh")
    with open(script, "w") as file:
        file.write('#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK$PMI_RANK" = 1 ] && set -- "$1" "$2" /nowhere.nrrd '
                   '"$4" "$5" "$6" "$7"\nexec "$@"\n')
    os.chmod(script, 0o755)
    done = run([script, OVOID, "render", path, "-o", out, "--size", "32x32"], 3)
    lines = our_lines(done.stderr)
    expect(done.returncode != 0 and len(lines) == 1 and "process 1 of 3" in lines[0] and "/nowhere.nrrd" in lines[0],
           f"a missing file: {done.stderr}")
    expect(not os.path.exists(out), "a missing file: a picture all the same")
    # Other data than the rest, of the same size and range.
    other = os.path.join(folder, "other.nrrd")
    with open(path, "rb") as file:
        header, samples = file.read().split(b"\n\n", 1)
    with open(other, "wb") as file:
        values = [samples[i:i + 4] for i in range(0, len(samples), 4)]
        file.write(header + b"\n\n" + b"".join(reversed(values)))
    with open(script, "w") as file:
        file.write(f'#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK$PMI_RANK" = 2 ] && set -- "$1" "$2" {other} '
                   '"$4" "$5" "$6" "$7"\nexec "$@"\n')
    done = run([script, OVOID, "render", path, "-o", out, "--size", "32x32"], 3)
    lines = our_lines(done.stderr)
    expect(done.returncode != 0 and len(lines) == 1 and "another picture" in lines[0] and "'data'" in lines[0],
           f"other data: {done.stderr}")
    expect(not os.path.exists(out), "other data: a picture all the same")
    # The same header of other samples, which nobody reads whole.
    detached = [os.path.join(folder, f"{name}.nhdr") for name in ("detached", "other")]
    run([OVOID, "convert", path, "-o", detached[0]])
    with open(detached[0]) as file:
        header = file.read()
    raw = next(word for word in header.split() if word.endswith(".raw"))
    for place, what in ((detached[0], values), (detached[1], reversed(values))):
        name = os.path.basename(place)[:-4] + "samples"
        with open(place, "w") as file:
            file.write(header.replace(raw, "samples.raw"))
        os.makedirs(os.path.join(folder, name))
        shutil.move(place, os.path.join(folder, name, "x.nhdr"))
        with open(os.path.join(folder, name, "samples.raw"), "wb") as file:
            file.write(b"".join(what))
    with open(script, "w") as file:
        file.write(f'#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK$PMI_RANK" = 2 ] && set -- "$1" "$2" {folder}/other.samples/x.nhdr '
                   '"$4" "$5" "$6" "$7"\nexec "$@"\n')
    here = os.path.join(folder, "detached.samples", "x.nhdr")
    done = run([script, OVOID, "render", here, "--memory-limit", "50K", "-o", out], 3)
    lines = our_lines(done.stderr)
    expect(done.returncode != 0 and len(lines) == 1 and "process 2 of 3: its file has other samples" in lines[0],
           f"other data in a file: {done.stderr}")
    expect(not os.path.exists(out), "other data in a file: a picture all the same")
    # All of them wrong in the same way: one line.
    done = run([OVOID, "render", "/nowhere.nrrd", "-o", out], 3)
    expect(done.returncode != 0 and len(our_lines(done.stderr)) == 1, f"missing everywhere: {done.stderr}")
    done = run([OVOID, "info", path], 2)
    expect(done.returncode != 0 and len(our_lines(done.stderr)) == 1, f"another command: {done.stderr}")
    # A launcher whose MPI is not the program's own: each process sees itself alone.
    done = run([OVOID, "render", path, "-o", out], PMI_SIZE="3", PMI_RANK="0")
    expect(done.returncode != 0 and "3 processes were started" in done.stderr, f"another MPI: {done.stderr}")
    expect(not os.path.exists(out), "another MPI: a picture all the same")
    # Flags that only some were given.
    with open(script, "w") as file:
        file.write('#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK$PMI_RANK" = 1 ] && set -- "$@" --profile\nexec "$@"\n')
    done = run([script, OVOID, "render", path, "-o", out], 2)
    expect(done.returncode != 0 and "'profile' differs" in done.stderr, f"other flags: {done.stderr}")
    done = run([OVOID, "render", path, "-o", out, "--repeat", "3"], 2)
    expect(done.returncode != 0 and len(our_lines(done.stderr)) == 1, f"usage: {done.stderr}")
    # One that dies.
    with open(script, "w") as file:
        file.write('#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK$PMI_RANK" = 1 ] && kill -9 $$\nexec "$@"\n')
    start = time.monotonic()
    done = run([script, OVOID, "render", path, "-o", out], 3)
    expect(done.returncode != 0 and time.monotonic() - start < 60, f"killed: {done.stderr}")
    # One that never comes: what reads its mesh for it sleeps.
    sleeper = os.path.join(folder, "sleeper.sh")
    with open(sleeper, "w") as file:
        file.write("#!/bin/sh\nexec sleep 100\n")
    os.chmod(sleeper, 0o755)
    with open(script, "w") as file:
        file.write(f'#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK$PMI_RANK" = 1 ] && export OVOID_READER={sleeper}\nexec "$@"\n')
    start = time.monotonic()
    done = run([script, OVOID, "render", mesh, "-o", out], 3, OVOID_MPI_WAIT="3")
    lines = our_lines(done.stderr)
    expect(done.returncode != 0 and time.monotonic() - start < 60, f"asleep: {done.stderr}")
    expect(len(lines) == 1 and "has waited 3 s" in lines[0], f"asleep: {done.stderr}")
    expect(not os.path.exists(out), "one that does not come: a picture all the same")


def memory(folder):
    """A lattice larger than what any of the processes may take, with samples in the file."""
    path = os.path.join(folder, "large.nrrd")
    run([OVOID, "make", "head", "--size", "160", "-o", path])
    alone, together = os.path.join(folder, "alone.npy"), os.path.join(folder, "limited.npy")
    limit = ["--memory-limit", "2M"]
    render([path, *limit, "--sheets", "image"], alone)
    render([path, *limit], together, 3)
    expect_same(alone, together, "a lattice larger than the limit")


def main():
    if run(["true"], 2).returncode != 0:
        print("skipped:", run(["true"], 2).stderr)
        return 77
    folder = tempfile.mkdtemp()
    try:
        data = make_data(folder)
        pictures(folder, data)
        in_files(folder, data["head"])
        scenes(folder, data)
        profile(folder, data["head"])
        parts(folder, data["head"])
        faults(folder, data["head"], data["fin"])
        memory(folder)
        shares(folder)
        memory_of_shares(folder, data["galaxy"])
    finally:
        shutil.rmtree(folder)
    print(f"{len(failures)} failures")
    return 1 if failures else 0


sys.exit(main())
