#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The Python package against the program, and against what others do from Python: python.py [--sides N...] [--runs N] [PART...]

PARTs are peers, program, memory, threads, loop, import and interact; without any, all are measured. Run by /usr/bin/python3 with the package on
PYTHONPATH, on a screen that may be virtual (make bench BENCH=python). Each first picture is of a process of its own, peers by turns, and
begins with the array in memory and ends with a PNG on the disk; what is imported counts. VTK's calls are those that PyVista's
`plotter.add_volume(array); plotter.screenshot()` makes, on the processor and, with Mesa's software driver, on the graphics device."""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time

from magnification import OVOID
from tables import grid

PARTS = ("peers", "program", "memory", "threads", "loop", "import", "interact")
LIMIT_S = 600  # of one process

MAKE_ARRAY = """
import time
import numpy
def status(key):
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith(key))
side = {side}
places = numpy.linspace(-1, 1, side, dtype="f4")
array = numpy.empty((side, side, side), "u1")
for k, z in enumerate(places):
    square = places[:, None] ** 2 + places**2 + z * z
    array[k] = 220 * numpy.exp(-2.5 * square) * (0.7 + 0.3 * numpy.sin(14 * places[:, None]) * numpy.sin(14 * places) * numpy.sin(14 * z))
before, begin = status("VmRSS"), time.perf_counter()
"""
TELL = """
print("seconds", time.perf_counter() - begin, "MiB", status("VmHWM") - before)
"""

# The same look for all: viridis and an opacity that rises with the value, over 0 to 255, unlit, 512 x 512 pixels.
OURS = """
import ovoid
ovoid.render(array, size=(512, 512), cmap="viridis", clim=(0, 255), opacity=[0, 0.1], shade=False, view="+z", fit="box").save("ovoid.png")
"""
VTK = """
import vtkmodules.vtkRenderingOpenGL2
import vtkmodules.vtkRenderingVolumeOpenGL2
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume, vtkVolumeProperty, vtkWindowToImageFilter
from vtkmodules.{module} import {mapper}
image = vtkImageData()
image.SetDimensions(array.shape[::-1])
image.GetPointData().SetScalars(numpy_to_vtk(array.ravel()))
mapper = {mapper}()
mapper.SetInputData(image)
colors, opacities = vtkColorTransferFunction(), vtkPiecewiseFunction()
for value, color in ((0, (0.27, 0, 0.33)), (64, (0.23, 0.32, 0.55)), (128, (0.13, 0.57, 0.55)), (191, (0.37, 0.79, 0.38)), (255, (0.99, 0.91, 0.15))):
    colors.AddRGBPoint(value, *color)
opacities.AddPoint(0, 0)
opacities.AddPoint(255, 0.1)
prop = vtkVolumeProperty()
prop.SetColor(colors)
prop.SetScalarOpacity(opacities)
prop.SetInterpolationTypeToLinear()
volume = vtkVolume()
volume.SetMapper(mapper)
volume.SetProperty(prop)
renderer = vtkRenderer()
renderer.AddVolume(volume)
renderer.ResetCamera()
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.SetSize(512, 512)
window.AddRenderer(renderer)
window.Render()
shot = vtkWindowToImageFilter()
shot.SetInput(window)
writer = vtkPNGWriter()
writer.SetFileName("vtk.png")
writer.SetInputConnection(shot.GetOutputPort())
writer.Write()
"""
YT = """
import yt
yt.set_log_level(50)
grid = yt.load_uniform_grid({"density": array}, array.shape, bbox=numpy.array([[0.0, side]] * 3))
scene = yt.create_scene(grid, field=("stream", "density"))
scene[0].set_log(False)
transfer = yt.ColorTransferFunction((0, 255))
transfer.map_to_colormap(0, 255, scale=0.1, scale_func=lambda values, lo, hi: (values - lo) / (hi - lo), colormap="viridis")
scene[0].transfer_function = transfer
scene.camera.resolution = (512, 512)
scene.save("yt.png", sigma_clip=4)
"""
WAYS = {
    "ovoid": OURS,
    "VTK, vtkFixedPointVolumeRayCastMapper": VTK.format(module="vtkRenderingVolume", mapper="vtkFixedPointVolumeRayCastMapper"),
    "VTK, vtkGPUVolumeRayCastMapper (Mesa)": VTK.format(module="vtkRenderingVolume", mapper="vtkGPUVolumeRayCastMapper"),
    "yt": YT,
}
PYVISTA_LINES = 3  # pv.Plotter(off_screen=True), add_volume, screenshot; and its import


def run(code, folder, *words, limit_s=LIMIT_S):
    """What a process prints, as pairs; None where it fails or takes too long."""
    try:
        done = subprocess.run([sys.executable, "-c", code, *words], cwd=folder, capture_output=True, text=True, check=True,
                              timeout=limit_s)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        told = (getattr(error, "stderr", "") or b"").strip() or str(error)
        print(f"  failed: {str(told).splitlines()[-1]}", file=sys.stderr)
        return None
    found = done.stdout.split()
    return dict(zip(found[::2], map(float, found[1::2])))


def lines_of(code):
    return len([line for line in code.splitlines() if line.strip()])


def least_and_median(times, digits=2):
    return f"{min(times):.{digits}f}", f"{statistics.median(times):.{digits}f}"


def measure_peers(options, folder):
    rows, ours = [], None
    for side in options.sides:
        taken = {name: [] for name in WAYS}
        for _ in range(options.runs):
            for name, code in WAYS.items():
                if name == "yt" and side > 256 or taken[name] is None:
                    continue  # it takes floats of 64 bits, and copies of them: more than 10 GiB
                found = run(MAKE_ARRAY.format(side=side) + code + TELL, folder)
                taken[name] = None if found is None else taken[name] + [found]
        for name, found in taken.items():
            if not found:
                rows.append([f"{side}^3", name, "-", "-", "-", "-", str(lines_of(WAYS[name]))])
                continue
            least, median = least_and_median([one["seconds"] for one in found])
            ours = float(median) if name == "ovoid" else ours
            rows.append([f"{side}^3", name, least, median, f"{float(median) / ours:.1f}", f"{statistics.median(one['MiB'] for one in found):.0f}",
                         str(lines_of(WAYS[name]))])
    print("\n".join(grid(["uint8", "way", "least, s", "median, s", "to ours", "memory beyond the array, MiB", "lines"], rows)))
    print(f"\nPyVista's words for VTK's calls are {PYVISTA_LINES + 1} lines.")


def measure_program(options, folder):
    """The default look and settings but for the size; the program reads its file from memory, as the system keeps it there."""
    side = max(options.sides)
    ours = "import ovoid\novoid.render(array, size=(512, 512)).save('p.png')\n"
    path = os.path.join(folder, "a.nrrd")
    run(MAKE_ARRAY.format(side=side) + f"import ovoid\novoid.write({path!r}, array)\n" + TELL, folder)
    program, package, memory = [], [], []
    for _ in range(options.runs):
        begin = time.perf_counter()
        subprocess.run([OVOID, "render", path, "--size", "512x512", "-o", os.path.join(folder, "q.png")], check=True, capture_output=True)
        program.append(time.perf_counter() - begin)
        found = run(MAKE_ARRAY.format(side=side) + ours + TELL, folder)
        package.append(found["seconds"])
        memory.append(found["MiB"])
    with open(os.path.join(folder, "p.png"), "rb") as p, open(os.path.join(folder, "q.png"), "rb") as q:
        print(f"the same bytes: {p.read() == q.read()}")
    rows = [["the program, of a file", *least_and_median(program), "-"],
            ["ovoid.render, of an array", *least_and_median(package), f"{statistics.median(memory) / (side**3 / 2**20):.0%}"]]
    print("\n".join(grid([f"{side}^3 uint8", "least, s", "median, s", "memory beyond the array"], rows)))


def measure_memory(options, folder):
    """What is resident beside an array, step by step; the greatest of a step, and what stays after it."""
    side = max(options.sides)
    code = MAKE_ARRAY.format(side=side) + """
import sys
def tell(step):
    print(step + "_stays", status("VmRSS") - before, step + "_most", status("VmHWM") - before)
    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")  # the greatest begins anew
tell("array")
import ovoid
ovoid.Scene
tell("import")
ovoid.render(array[:8, :8, :8], size=(512, 512), occlusion=0, shadows=0)
tell("small")
scene = ovoid.Scene(array, size=(512, 512), kernel=sys.argv[1])
scene.render(size=(16, 16), occlusion=0, shadows=0)
tell("field")
scene.render(occlusion=0, shadows=0)
tell("picture")
scene.render()
tell("light")
"""
    steps = [("import", "the package and its libraries"), ("small", "a picture of 8^3 samples, 512 x 512"), ("field", "a field of the array"),
             ("picture", "its picture, 512 x 512"), ("light", "the same with occlusion")]
    rows = []
    kernels = ("gaussian", "bspline")
    found = [run(code, folder, kernel) for kernel in kernels]
    if None in found:
        return
    for step, name in steps:
        rows.append([name, *(f"{one[step + end]:.0f}" for one in found for end in ("_stays", "_most"))])
    print("\n".join(grid([f"MiB beyond {side**3 / 2**20:.0f} of the array, after", *(f"{kernel}{end}" for kernel in kernels for end in ("", ", most"))], rows)))


def measure_threads(options, folder):
    """Two pictures at once, each by one thread: of two of Python's, and of two programs."""
    import numpy
    import ovoid

    side, count = 128, 5 * options.runs
    z, y, x = numpy.mgrid[-1:1:side * 1j, -1:1:side * 1j, -1:1:side * 1j]
    array = (200 * numpy.exp(-3 * (x**2 + y**2 + z**2))).astype("u1")
    path = os.path.join(folder, "b.nrrd")
    ovoid.write(path, array)

    def frames(times):
        scene = ovoid.Scene(array, size=(512, 512), threads=1)
        scene.render()
        for _ in range(count):
            begin = time.perf_counter()
            scene.render()
            times.append(1000 * (time.perf_counter() - begin))

    def at_once(number):
        times = [[] for _ in range(number)]
        threads = [threading.Thread(target=frames, args=(one,)) for one in times]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return statistics.median(sum(times, []))

    def programs(number):
        outs = [os.path.join(folder, f"profile{i}.json") for i in range(number)]
        running = [subprocess.Popen([OVOID, "render", path, "--size", "512x512", "--threads", "1", "--repeat", str(count), f"--profile={out}", "-o",
                                     out + ".png"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for out in outs]
        for process in running:
            process.wait()
        found = []
        for out in outs:
            with open(out, encoding="utf-8") as file:
                found.append(json.load(file)["frame_ms"]["median"])
        return statistics.median(found)

    rows = [[name, f"{measure(1):.0f}", f"{measure(2):.0f}"] for name, measure in (("threads of Python", at_once), ("programs", programs))]
    print("\n".join(grid([f"{side}^3, 512 x 512, ms a picture", "one alone", "two at once"], rows)))


def measure_loop(options, folder):
    code = """
import sys, numpy, ovoid
def resident():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096 / 2**20
array = numpy.random.default_rng(1).random((24, 24, 24))
for i in range(1, int(sys.argv[1]) + 1):
    ovoid.render(array, size=(64, 48)).numpy()
    if i in (100, 1000, 10000):
        print(i, resident())
"""
    found = run(code, folder, str(10000 if options.runs > 1 else 1000), limit_s=6 * LIMIT_S) or {}
    print("\n".join(grid(["pictures", "resident, MiB"], [[name, f"{value:.1f}"] for name, value in found.items()])))


def measure_import(options, folder):
    rows = []
    for what in ("pass", "import ovoid", "import ovoid; ovoid.render", "import numpy"):
        taken = []
        for _ in range(5 * options.runs):
            begin = time.perf_counter()
            subprocess.run([sys.executable, "-c", what], check=True)
            taken.append(1000 * (time.perf_counter() - begin))
        rows.append([f"`{what}`", *least_and_median(taken, 1)])
    print("\n".join(grid(["a process of", "least, ms", "median, ms"], rows)))


def measure_interact(options, folder):
    """Pictures that reach the widget while its azimuth changes a hundred times a second."""
    code = """
import sys, time, numpy, ovoid
seconds, side = float(sys.argv[1]), int(sys.argv[2])
z, y, x = numpy.mgrid[-1:1:side * 1j, -1:1:side * 1j, -1:1:side * 1j].astype("f4")
array = (200 * numpy.exp(-3 * (x**2 + y**2 + z**2)) * (1 + numpy.sin(9 * x) * numpy.sin(9 * y) * numpy.sin(9 * z)) / 2).astype("u1")
widget = ovoid.interact(array, size=(1024, 768))
count, widths = 0, []
def shown(change):
    global count
    count += 1
    widths.append(widget._size.size[0])
widget._image.observe(shown, "value")
def turn(until):
    while time.perf_counter() < until:
        widget.controls["azimuth"].value = (widget.controls["azimuth"].value + 181) % 360 - 180
        time.sleep(0.01)
turn(time.perf_counter() + 2)
count, widths[:] = 0, []
turn(time.perf_counter() + seconds)
print("pictures", count / seconds, "width", numpy.median(widths))
begin = time.perf_counter()
widget._queue.rest(60)
print("still", time.perf_counter() - begin)
"""
    found = run(code, folder, str(3 * options.runs), "256")
    if found is not None:
        print(f"256^3 uint8, 1024 x 768: {found['pictures']:.1f} pictures a second, {found['width']:.0f} pixels wide while it moves; "
              f"{found['still']:.1f} s from the last change to the full picture")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--sides", type=int, nargs="+", default=[256, 512], help="samples along each axis")
    parser.add_argument("--runs", type=int, default=5)
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f"{', '.join(unknown)}: expected {', '.join(PARTS)}")
    with tempfile.TemporaryDirectory() as folder:
        for part in options.parts or PARTS:
            print(f"\n### {part}\n", flush=True)
            globals()[f"measure_{part}"](options, folder)


if __name__ == "__main__":
    main()
