# SPDX-License-Identifier: Apache-2.0
"""Draws with the plugin in pvpython: plugin_test.py OvoidVolume.so FOLDER [load]. Fails if a representation is missing or draws nothing,
if an opaque sphere is not hidden, or if a property does not arrive. FOLDER holds adaptive.vthb (adaptive_grid.py), and takes states: a
second run, with `load`, fails if they draw another picture. tests/paraview/run.sh runs both."""
import os
import sys

import numpy as np
from paraview import simple, smstate
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

NAME = "Ovoid volume"


def picture(view):
    simple.Render(view)
    grab = vtkWindowToImageFilter()
    grab.SetInput(view.GetRenderWindow())
    grab.ReadFrontBufferOff()
    grab.Update()
    return vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).astype(int)


def empty_view():
    view = simple.CreateView("RenderView")
    view.ViewSize = [200, 200]
    view.UseColorPaletteForBackground = 0
    view.Background = [0, 0, 0]
    view.OrientationAxesVisibility = 0
    return view


def shown(source, view, place="POINTS"):
    display = simple.Show(source, view)
    available = display.GetProperty("Representation").Available
    assert NAME in available, available
    simple.ColorBy(display, (place, "RTData"))
    display.SetRepresentationType(NAME)
    display.RescaleTransferFunctionToDataRange(False)
    view.ResetCamera(True)
    simple.Render(view)
    return display


def check(name, source, change, place="POINTS"):
    view = empty_view()
    display = shown(source, view, place)
    alone = picture(view)
    assert alone.max() > 100 and (alone.max(axis=1) > 20).mean() > 0.1, f"{name}: nothing shows"
    sphere = simple.Sphere(Radius=6, Center=[10, 0, 0])  # half outside
    simple.Show(sphere, view)
    with_sphere = picture(view)
    assert np.abs(with_sphere - alone).max() > 20, f"{name}: the sphere does not show"
    simple.Hide(source, view)
    assert np.abs(with_sphere - picture(view)).max() > 50, f"{name}: nothing is before the sphere"
    simple.Show(source, view)
    simple.Hide(sphere, view)
    change(display)
    assert np.abs(picture(view) - alone).max() > 5, f"{name}: its property changes nothing"
    simple.Delete(view)
    print(f"{name}: drawn", flush=True)


def smooth(display):
    display.OvoidKernel = "B-spline that smooths"


def unshaded(display):
    display.OvoidShade = 0


def short_unit(display):
    display.ScalarOpacityUnitDistance = 0.2 * display.ScalarOpacityUnitDistance


def check_all(folder):
    wavelet = simple.Wavelet()
    cells = simple.PointDatatoCellData(Input=wavelet)
    centers = simple.CellCenters(Input=cells)
    adaptive = simple.XMLUniformGridAMRReader(FileName=[os.path.join(folder, "adaptive.vthb")])
    adaptive.CellArrayStatus = ["RTData"]
    adaptive.DefaultNumberOfLevels = 0
    check("an image", wavelet, smooth)
    check("a mesh", simple.AppendDatasets(Input=[wavelet]), unshaded)
    check("boxes", simple.AppendDatasets(Input=[cells]), short_unit, "CELLS")
    check("a structured grid", simple.Transform(Input=wavelet), unshaded)
    check("points", centers, short_unit)
    check("an adaptive grid", adaptive, unshaded, "CELLS")


# An image whose array RTData has red, green, blue and opacity, a red half and a blue one, and beside it an array that is 0 in the red half.
def image_of_colors(folder):
    side = 16
    image = vtkImageData()
    image.SetDimensions(side, side, side)
    right = (np.mgrid[0:side, 0:side, 0:side][2] >= side // 2).ravel()
    rgba = np.stack([255 * ~right, 0 * right, 255 * right, 0 * right + 200], axis=1).astype(np.uint8)
    for name, values in (("RTData", rgba), ("right", right.astype(np.float32)), ("ramp", np.linspace(0, 1, side ** 3, dtype=np.float32))):
        array = numpy_to_vtk(values, deep=1)
        array.SetName(name)
        image.GetPointData().AddArray(array)
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(os.path.join(folder, "colors.vti"))
    writer.SetInputData(image)
    writer.Write()
    return simple.XMLImageDataReader(FileName=[writer.GetFileName()])


# Of the left and of the right half of a picture, as bright as they get in red, green and blue.
def halves(view):
    pixels = picture(view).reshape(200, 200, 3)
    return pixels[:, :90].max(axis=(0, 1)), pixels[:, 110:].max(axis=(0, 1))


def check_colors(folder):
    view = empty_view()
    source = image_of_colors(folder)
    display = shown(source, view)
    display.MapScalars = 0
    display.ScalarOpacityFunction.Points = [0, 0, 0.5, 0, 255, 1, 0.5, 0]  # of the fourth component, not of the length of all
    left, right = halves(view)
    assert left[0] > 100 and left[2] < 20 and right[2] > 100 and right[0] < 20, f"colours as they are: {left}, {right}"
    display.MapScalars = 1
    simple.ColorBy(display, ("POINTS", "ramp"))
    display.RescaleTransferFunctionToDataRange(False)
    display.UseSeparateOpacityArray = 1
    display.OpacityArrayName = ["POINTS", "right"]
    left, right = halves(view)
    assert left.max() < 60 and right.max() > 150, f"an opacity array: {left}, {right}"
    simple.Delete(view)
    print("colours and opacities: drawn", flush=True)


def check_modes():
    view = empty_view()
    wavelet = simple.Wavelet()
    display = shown(wavelet, view)
    display.BlendMode = "Slice"
    display.OvoidSliceFunction.Normal = [0.1, 0, 1]
    pictures = []
    for place in (-5, 5):
        display.OvoidSliceFunction.Origin = [0, 0, place]
        pictures.append(picture(view))
        assert pictures[-1].max() > 100, "a slice: nothing shows"
    assert np.abs(pictures[0] - pictures[1]).max() > 50, "a slice: stays where it was"
    display.BlendMode = "Isosurface"
    for values in ([120], [120, 180]):
        display.IsosurfaceValues = values
        pictures.append(picture(view))
        assert pictures[-1].max() > 100, "isosurfaces: nothing shows"
    assert np.abs(pictures[2] - pictures[3]).max() > 20, "isosurfaces: the second does not show"
    display.BlendMode = "Composite"
    curves = picture(view)
    display.UseTransfer2D = 1
    display.TransferFunction2D = simple.GetTransferFunction2D("RTData")
    display.TransferFunction2D.Boxes = [150, 0, 60, 1, 1, 0, 0, 0.5]
    table = picture(view).reshape(-1, 3)
    assert table[:, 0].max() > 50 and table[:, 1:].max() < 20, f"a two-dimensional function: {table.max(axis=0)}"
    assert np.abs(table.reshape(curves.shape) - curves).max() > 50, "a two-dimensional function: the curves are drawn"
    simple.Delete(view)
    print("slices, isosurfaces, a two-dimensional function: drawn", flush=True)


# A state of each kind of representation, with values that are not the defaults.
def save(folder):
    view = empty_view()
    wavelet = simple.Wavelet()
    display = shown(wavelet, view)
    display.OvoidKernel = "Gaussian"
    display.OvoidSampleDistance = 0.75
    points = simple.CellCenters(Input=simple.PointDatatoCellData(Input=wavelet))
    of_points = shown(points, view)
    of_points.Position = [25, 0, 0]
    of_points.OvoidShade = 0
    view.ResetCamera(True)
    np.save(os.path.join(folder, "state.npy"), picture(view))
    simple.SaveState(os.path.join(folder, "state.pvsm"))
    with open(os.path.join(folder, "state.py"), "w", encoding="ascii") as file:
        file.write(smstate.get_state())


def check_state(folder, name, load):
    simple.ResetSession()
    load(os.path.join(folder, name))
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = [200, 200]
    difference = np.abs(picture(view) - np.load(os.path.join(folder, "state.npy"))).max()
    assert difference <= 1, f"{name}: {difference} of 255 from the picture that it was saved with"
    display = simple.GetDisplayProperties(simple.FindSource("Wavelet1"), view)
    assert display.Representation == NAME and display.OvoidSampleDistance == 0.75, f"{name}: properties are lost"
    print(f"{name}: loaded", flush=True)


def run_script(path):
    with open(path, encoding="ascii") as file:
        exec(compile(file.read(), path, "exec"), {})  # as pvpython runs a state


def main(plugin, folder, what="draw"):
    simple.LoadPlugin(plugin, remote=False, ns=globals())
    if what == "load":
        check_state(folder, "state.pvsm", simple.LoadState)
        check_state(folder, "state.py", run_script)
    else:
        check_all(folder)
        check_colors(folder)
        check_modes()
        simple.ResetSession()
        simple.LoadPlugin(plugin, remote=False, ns=globals())
        save(folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
