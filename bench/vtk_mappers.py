#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The mappers for VTK: what they add to a frame, and tetrahedra beside VTK's own mapper. vtk_mappers.py [--frames N] [GRID.vti...]

Overhead is what Render() takes beside Ovoid's renderer and OpenGL (reading depth, drawing the picture), as a share of the frame: of the
given grids, or a formula's; alone, with an opaque plane half inside, and of a mesh of a million tetrahedra. Then the same mesh with
vtkProjectedTetrahedraMapper, which does not shade, and with Ovoid's, shaded: whole frames of the window, the camera turned a little for
each, both in this run on this machine. Prints Markdown for docs/performance.md. Needs python3-vtk9, python3-numpy, a display (xvfb-run) and
the Python module ovoid_vtk on the path."""
import argparse
import statistics
import sys
import time

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401
from ovoid_vtk.vtkOvoid import vtkOvoidUnstructuredGridVolumeMapper, vtkOvoidVolumeMapper
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkIOXML import vtkXMLImageDataReader
from vtkmodules.vtkRenderingCore import vtkActor, vtkColorTransferFunction, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkVolume, vtkVolumeProperty
from vtkmodules.vtkRenderingVolume import vtkProjectedTetrahedraMapper

SIZE = (512, 512)
TETRAHEDRA_SIDE = 60  # 59^3 cells of five tetrahedra each: 1.03 million
GRID_SIDE = 128


def grid(side):
    z, y, x = np.mgrid[-1:1:side * 1j, -1:1:side * 1j, -1:1:side * 1j]
    values = (np.sqrt(x * x + y * y + z * z) + 0.15 * np.sin(7 * x) * np.sin(6 * y)).astype(np.float32)
    image = vtkImageData()
    image.SetDimensions(side, side, side)
    image.SetSpacing(*[1 / (side - 1)] * 3)
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=1))
    return image


def grid_of_file(path):
    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    if image.GetPointData().GetScalars() is None:
        image.GetPointData().SetActiveScalars(image.GetPointData().GetArrayName(0))
    return image


def tetrahedra():
    split = vtkDataSetTriangleFilter()
    split.SetInputData(grid(TETRAHEDRA_SIDE))
    split.Update()
    return split.GetOutput()


def scene(mapper, data, shade, has_plane=False):
    """Faint at both ends of the values, so that most of the data shows."""
    lo, hi = data.GetScalarRange()
    mapper.SetInputData(data)
    colors, opacities, prop = vtkColorTransferFunction(), vtkPiecewiseFunction(), vtkVolumeProperty()
    colors.AddRGBPoint(lo, 0.2, 0.3, 0.8)
    colors.AddRGBPoint(hi, 0.8, 0.2, 0.1)
    for share, opacity in ((0, 0), (0.25, 0.02), (0.5, 0.3), (0.75, 0.02), (1, 0.02)):
        opacities.AddPoint(lo + share * (hi - lo), opacity)
    prop.SetColor(colors)
    prop.SetScalarOpacity(opacities)
    prop.SetInterpolationTypeToLinear()
    prop.SetShade(int(shade))
    prop.SetScalarOpacityUnitDistance(data.GetLength() / 200)
    volume, renderer, window = vtkVolume(), vtkRenderer(), vtkRenderWindow()
    volume.SetMapper(mapper)
    volume.SetProperty(prop)
    renderer.AddVolume(volume)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*SIZE)
    window.AddRenderer(renderer)
    if has_plane:
        source, plane_mapper, plane = vtkPlaneSource(), vtkPolyDataMapper(), vtkActor()
        plane_mapper.SetInputConnection(source.GetOutputPort())
        plane.SetMapper(plane_mapper)
        plane.SetScale(2 * data.GetLength())
        plane.SetPosition(*data.GetCenter())
        renderer.AddActor(plane)
    renderer.ResetCamera()
    renderer.GetActiveCamera().Azimuth(20)
    renderer.GetActiveCamera().Elevation(15)
    renderer.GetActiveCamera().Zoom(1.5)
    return renderer, window


def one_frame(renderer, window):
    """Seconds, the camera turned by a hundredth of a degree."""
    renderer.GetActiveCamera().Azimuth(0.01)
    renderer.ResetCameraClippingRange()
    began = time.perf_counter()
    window.Render()
    window.WaitForCompletion()
    return time.perf_counter() - began


def overhead_row(name, mapper, data, frames, has_plane=False):
    renderer, window = scene(mapper, data, True, has_plane)
    mapper.AutoAdjustSampleDistancesOff()
    parts = []

    window.Render()  # makes the field
    for _ in range(frames):
        one_frame(renderer, window)
        parts.append((mapper.GetRenderTime(), mapper.GetFrameTime(), mapper.GetDisplayTime()))
    whole, frame, screen = (1e3 * statistics.median(column) for column in zip(*parts))
    share = statistics.median((all_ - frame_ - screen_) / all_ for all_, frame_, screen_ in parts)
    return f"| {name} | {whole:.1f} | {frame:.1f} | {screen:.1f} | {100 * share:.1f} % |"


def compared(mesh, frames):
    """Both take turns, so that what else the machine does is shared."""
    mappers = {"vtkProjectedTetrahedraMapper, unshaded": (vtkProjectedTetrahedraMapper(), False),
               "vtkOvoidUnstructuredGridVolumeMapper, shaded": (vtkOvoidUnstructuredGridVolumeMapper(), True)}
    scenes, first, seconds = {}, {}, {}
    for name, (mapper, shade) in mappers.items():
        if shade:
            mapper.AutoAdjustSampleDistancesOff()
        scenes[name] = scene(mapper, mesh, shade)
        began = time.perf_counter()
        scenes[name][1].Render()
        first[name] = time.perf_counter() - began
        seconds[name] = []
    for _ in range(frames):
        for name, (renderer, window) in scenes.items():
            seconds[name].append(one_frame(renderer, window))
    return first, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--frames", type=int, default=11)
    parser.add_argument("grids", nargs="*")
    options = parser.parse_args()
    mesh = tetrahedra()
    print(f"{mesh.GetNumberOfCells()} tetrahedra, {mesh.GetNumberOfPoints()} points; pictures {SIZE[0]} x {SIZE[1]}; medians of {options.frames}\n")
    print("| scene | Render() ms | Ovoid's renderer | OpenGL | overhead |\n|---|---:|---:|---:|---:|")
    grids = {path.rsplit("/", 1)[-1]: grid_of_file(path) for path in options.grids} or {f"{GRID_SIDE}^3 samples": grid(GRID_SIDE)}
    for name, image in grids.items():
        print(overhead_row(name, vtkOvoidVolumeMapper(), image, options.frames), flush=True)
        print(overhead_row(f"{name}, a plane half inside", vtkOvoidVolumeMapper(), image, options.frames, True), flush=True)
    print(overhead_row("a million tetrahedra", vtkOvoidUnstructuredGridVolumeMapper(), mesh, options.frames), flush=True)
    print(overhead_row("a million tetrahedra, a plane half inside", vtkOvoidUnstructuredGridVolumeMapper(), mesh, options.frames, True), flush=True)
    first, seconds = compared(mesh, options.frames)
    print("\n| a million tetrahedra | first frame s | then ms | least to greatest | ratio |\n|---|---:|---:|---:|---:|")
    slowest = statistics.median(seconds["vtkProjectedTetrahedraMapper, unshaded"])
    for name, times in seconds.items():
        median = statistics.median(times)
        print(f"| {name} | {first[name]:.1f} | {1e3 * median:.0f} | {1e3 * min(times):.0f} to {1e3 * max(times):.0f} | {slowest / median:.1f} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
