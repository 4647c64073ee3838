# SPDX-License-Identifier: Apache-2.0
"""Draws with the plugin in pvpython: plugin_test.py OvoidVolume.so FOLDER [load]. Fails if a representation is missing or draws nothing,
if an opaque sphere is not hidden, or if a property does not arrive. FOLDER holds adaptive.vthb (adaptive_grid.py), and takes states: a
second run, with `load`, fails if they draw another picture. tests/paraview/run.sh runs both."""
import os
import sys

import numpy as np
from paraview import simple, smstate
from vtkmodules.util.numpy_support import vtk_to_numpy
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
        simple.ResetSession()
        simple.LoadPlugin(plugin, remote=False, ns=globals())
        save(folder)


if __name__ == "__main__":
    main(*sys.argv[1:])
