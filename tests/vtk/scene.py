# SPDX-License-Identifier: Apache-2.0
"""Scenes of VTK with Ovoid's mappers, and the same scenes drawn by the program `ovoid render`."""
import json
import os
import subprocess
import tempfile

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  the render windows
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  VTK's own mappers
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction, vtkPolyData, vtkRectilinearGrid
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter, vtkXMLPolyDataWriter, vtkXMLRectilinearGridWriter, vtkXMLUnstructuredGridWriter
from vtkmodules.vtkRenderingCore import (vtkActor, vtkColorTransferFunction, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkVolume,
                                         vtkVolumeProperty, vtkWindowToImageFilter)

from ovoid_vtk.vtkOvoid import vtkOvoidVolumeMapper

WIDTH, HEIGHT = 160, 120
BACKGROUND = (0.2, 0.4, 0.6)  # 51, 102, 153
WRITERS = {"vtkImageData": (vtkXMLImageDataWriter, "vti"), "vtkUnstructuredGrid": (vtkXMLUnstructuredGridWriter, "vtu"),
           "vtkPolyData": (vtkXMLPolyDataWriter, "vtp"), "vtkRectilinearGrid": (vtkXMLRectilinearGridWriter, "vtr")}


def bumps(side, dtype=np.float32):
    """A ball with bumps, of values 0 to about 1.9 (bytes: 0 to 255)."""
    z, y, x = np.mgrid[-1:1:side * 1j, -1:1:side * 1j, -1:1:side * 1j]
    values = np.sqrt(x * x + y * y + z * z) + 0.15 * np.sin(7 * x) * np.sin(6 * y)
    values -= values.min()
    return (values * (255 / values.max())).astype(dtype) if dtype == np.uint8 else values.astype(dtype)


def grid_of(values, coordinates):
    """A rectilinear grid of an image's values, with the same coordinates along all axes."""
    grid, axis = vtkRectilinearGrid(), numpy_to_vtk(np.asarray(coordinates, dtype=float), deep=1)
    grid.SetDimensions(*3 * [len(coordinates)])
    grid.SetXCoordinates(axis)
    grid.SetYCoordinates(axis)
    grid.SetZCoordinates(axis)
    grid.GetPointData().SetScalars(values)
    return grid


def points_of_pairs():
    """The corners of a cube, with an array 'pairs' of two components."""
    cloud, points = vtkPolyData(), vtkPoints()
    for i in range(8):
        points.InsertNextPoint(i & 1, i >> 1 & 1, i >> 2)
    cloud.SetPoints(points)
    array = numpy_to_vtk(np.random.default_rng(1).random((8, 2)), deep=1)
    array.SetName("pairs")
    cloud.GetPointData().SetScalars(array)
    return cloud


def image_of(values, spacing=(1, 1, 1), origin=(0, 0, 0)):
    """The image, and its array, which shares the values' memory."""
    image = vtkImageData()
    image.SetDimensions(*values.shape[2::-1])
    image.SetSpacing(*spacing)
    image.SetOrigin(*origin)
    array = numpy_to_vtk(values.reshape(-1, *values.shape[3:]), deep=0)
    array.SetName("values")
    image.GetPointData().SetScalars(array)
    return image, array


def together(*values):
    """An image of several components."""
    return image_of(np.stack(values, axis=3))[0]


COLORS = [(0, 0.9, 0.1, 0.1), (0.7, 0.2, 0.8, 0.3), (1.9, 0.1, 0.3, 1.0)]
SHELL = [(0.3, 0), (0.5, 0.8), (0.7, 0)]
FOG = [(0, 0.0), (1.9, 0.08)]


def property_of(colors=COLORS, opacities=SHELL, shade=True, unit_distance=1.0, scale=1.0):
    """`scale`: of the values."""
    prop = vtkVolumeProperty()
    color, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
    for x, *rgb in colors:
        color.AddRGBPoint(x * scale, *rgb)
    for x, value in opacities:
        opacity.AddPoint(x * scale, value)
    prop.SetColor(color)
    prop.SetScalarOpacity(opacity)
    prop.SetShade(int(shade))
    prop.SetInterpolationTypeToLinear()
    prop.SetScalarOpacityUnitDistance(unit_distance)
    return prop


class Scene:
    """A window with one volume in it."""

    def __init__(self, data, prop, mapper=None, position=(30, 22, 90), focal_point=(12, 12, 12)):
        self.mapper = mapper or vtkOvoidVolumeMapper()
        self.mapper.SetInputData(data)
        self.errors = []
        self.mapper.AddObserver("ErrorEvent", self._note)
        self.volume = vtkVolume()
        self.volume.SetMapper(self.mapper)
        self.volume.SetProperty(prop)
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(*BACKGROUND)
        self.renderer.AddVolume(self.volume)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(WIDTH, HEIGHT)
        self.window.AddRenderer(self.renderer)
        camera = self.renderer.GetActiveCamera()
        camera.SetPosition(*position)
        camera.SetFocalPoint(*focal_point)
        camera.SetViewUp(0.1, 1, 0)
        self.camera = camera

    def _note(self, _object, _event, message):
        self.errors.append(message)
    _note.CallDataType = "string0"

    def add_actor(self, poly_data_source, color=(1, 1, 1)):
        mapper, actor = vtkPolyDataMapper(), vtkActor()
        mapper.SetInputConnection(poly_data_source.GetOutputPort())
        actor.SetMapper(mapper)
        actor.GetProperty().SetLighting(False)
        actor.GetProperty().SetColor(*color)
        self.renderer.AddActor(actor)
        return actor

    def draw(self):
        """[height, width, 3] bytes as floats in [0, 255], row 0 at the top."""
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        return picture_of(self.window)

    def floats(self):
        """The last frame's own picture, [height, width, 4]."""
        image = vtkImageData()
        self.mapper.GetColorImage(image)
        width, height, _ = image.GetDimensions()
        return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 4)[::-1]


def picture_of(window, scale=1):
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetScale(scale)
    grab.SetShouldRerender(int(scale > 1))
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1].astype(float)


def over(picture, behind):
    """A premultiplied picture over a colour, as a PNG has it: in bytes, rounded."""
    return np.round(255 * (picture[..., :3] + (1 - picture[..., 3:]) * np.asarray(behind)))


def write(data, folder):
    writer_class, ending = WRITERS[data.GetClassName()]
    path = os.path.join(folder, "data." + ending)
    writer = writer_class()
    writer.SetFileName(path)
    writer.SetInputData(data)
    writer.Write()
    return path


def look_json(prop):
    color, opacity = prop.GetRGBTransferFunction(), prop.GetScalarOpacity()
    node, rgb, points = [0.0] * 6, [], []
    for i in range(color.GetSize()):
        color.GetNodeValue(i, node)
        rgb += node[:4]
    node = [0.0] * 4
    for i in range(opacity.GetSize()):
        opacity.GetNodeValue(i, node)
        points += node
    return json.dumps([{"Name": "test", "ColorSpace": "RGB", "RGBPoints": rgb, "Points": points}])


def rendered(data, scene, *flags, has_unit=True):
    """What `ovoid render` draws of data and the scene's property and camera: [height, width, 4] floats."""
    camera, prop = scene.camera, scene.volume.GetProperty()
    view = {"position": camera.GetPosition(), "focal_point": camera.GetFocalPoint(), "view_up": camera.GetViewUp(),
            "view_angle": camera.GetViewAngle(), "parallel_projection": bool(camera.GetParallelProjection()),
            "parallel_scale": camera.GetParallelScale()}
    words = ["--tf", look_json(prop), "--camera", json.dumps(view), "--size", f"{WIDTH}x{HEIGHT}"]
    if prop.GetShade():
        lights = [] if "--light" in flags else ["--light", "headlight"]
        words += ["--shade", *lights, "--ambient", str(prop.GetAmbient()), "--diffuse", str(prop.GetDiffuse()),
                  "--specular", str(prop.GetSpecular()), "--specular-power", str(prop.GetSpecularPower())]
    elif "--mode" not in flags:
        words += ["--no-shade"]
    if has_unit:
        words += ["--unit-distance", str(prop.GetScalarOpacityUnitDistance())]
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "picture.npy")
        command = [os.environ["OVOID_PROGRAM"], "render", write(data, folder), "-o", out, *words, *flags]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
        return np.load(out)
