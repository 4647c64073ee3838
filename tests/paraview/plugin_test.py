# SPDX-License-Identifier: Apache-2.0
"""Draws with the plugin in pvpython: plugin_test.py OvoidVolume.so. Fails if a representation is missing or draws nothing, if an opaque
sphere is not hidden, or if a property does not arrive. scripts/paraview.sh runs it."""
import sys

import numpy as np
from paraview import simple
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


def shown(source, view):
    display = simple.Show(source, view)
    available = display.GetProperty("Representation").Available
    assert NAME in available, available
    simple.ColorBy(display, ("POINTS", "RTData"))
    display.SetRepresentationType(NAME)
    display.RescaleTransferFunctionToDataRange(False)
    view.ResetCamera(True)
    simple.Render(view)
    return display


def check(source, name, change):
    view = empty_view()
    display = shown(source, view)
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
    print(f"{name}: drawn")


def main(plugin):
    simple.LoadPlugin(plugin, remote=False, ns=globals())
    wavelet = simple.Wavelet()
    wavelet.UpdatePipeline()
    mesh = simple.AppendDatasets(Input=[wavelet])  # an unstructured grid of voxels
    mesh.UpdatePipeline()

    def smooth(display):
        display.OvoidKernel = "B-spline that smooths"

    def unshaded(display):
        display.OvoidShade = 0
    check(wavelet, "an image", smooth)
    check(mesh, "a mesh", unshaded)


if __name__ == "__main__":
    main(sys.argv[1])
