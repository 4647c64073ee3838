# SPDX-License-Identifier: Apache-2.0
"""Waves as a slice, as isosurfaces that are seen through, and by a function of value and gradient, as a program for VTK's own mapper:
vtk_examples.py runs it with both."""
import vtk

source = vtk.vtkRTAnalyticSource()
source.SetWholeExtent(-24, 24, -24, 24, -24, 24)
source.SetXFreq(12)
source.SetYFreq(10)
source.SetZFreq(8)
source.Update()
lo, hi = source.GetOutput().GetScalarRange()
DISTANCE = 0.5  # of the mapper's samples and of the functions' opacities


def property_of(opacities):
    colors, curve = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    for share, *rgb in ((0, 0.2, 0.3, 0.8), (0.5, 0.3, 0.7, 0.6), (0.7, 1, 0.8, 0.4), (1, 0.9, 0.1, 0.1)):
        colors.AddRGBPoint(lo + share * (hi - lo), *rgb)
    for share, opacity in opacities:
        curve.AddPoint(lo + share * (hi - lo), opacity)
    prop = vtk.vtkVolumeProperty()
    prop.SetInterpolationTypeToLinear()
    prop.SetColor(colors)
    prop.SetScalarOpacity(curve)
    prop.SetScalarOpacityUnitDistance(DISTANCE)
    return prop


def by_value_and_gradient(steps=64):
    """Where values are high: red where they change little, else white."""
    image = vtk.vtkImageData()
    image.SetDimensions(steps, steps, 1)
    image.AllocateScalars(vtk.VTK_FLOAT, 4)
    for row in range(steps):
        for column in range(steps):
            value, gradient = column / (steps - 1), row / (steps - 1)
            opacity = 0.08 * max(0, min(1, (value - 0.55) / 0.1))
            for channel, number in enumerate((0.9, min(1, 6 * gradient), min(1, 6 * gradient), opacity)):
                image.SetScalarComponentFromFloat(column, row, 0, channel, number)
    return image


renderer = vtk.vtkRenderer()
renderer.SetBackground(0.1, 0.1, 0.2)


def add(prop, place):
    mapper = vtk.vtkGPUVolumeRayCastMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetSampleDistance(DISTANCE)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(prop)
    volume.SetPosition(place, 0, 0)
    renderer.AddVolume(volume)
    return mapper


sliced = property_of([(0, 0.3), (0.5, 0.9), (1, 1)])
plane = vtk.vtkPlane()
plane.SetOrigin(-55, 0, 0)
plane.SetNormal(0.2, 0.3, 1)
sliced.SetSliceFunction(plane)
add(sliced, -55).SetBlendModeToSlice()

surfaces = property_of([(0.5, 0.2), (0.7, 0.5), (0.85, 1)])
surfaces.ShadeOn()
surfaces.SetAmbient(0.3)
for i, share in enumerate((0.5, 0.7, 0.85)):
    surfaces.GetIsoSurfaceValues().SetValue(i, lo + share * (hi - lo))
add(surfaces, 0).SetBlendModeToIsoSurface()

table = property_of([(0, 0), (1, 0)])
table.SetTransferFunctionMode(vtk.vtkVolumeProperty.TF_2D)
table.SetTransferFunction2D(by_value_and_gradient())
add(table, 55)

window = vtk.vtkRenderWindow()
window.SetSize(480, 170)
window.AddRenderer(renderer)
camera = renderer.GetActiveCamera()
camera.SetPosition(0, 70, 250)
camera.SetFocalPoint(0, 0, 0)
camera.SetViewAngle(14)
renderer.ResetCameraClippingRange()
window.Render()
