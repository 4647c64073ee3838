#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two-dimensional transfer functions: colour and opacity by value and gradient."""
import json
import tempfile
import unittest

import numpy as np
from mapper_case import EXACT, TRANSLUCENT, MapperCase
from ovoid_vtk.vtkOvoid import vtkOvoidUnstructuredGridVolumeMapper, vtkOvoidVolumeMapper
from scene import Scene, image_of, property_of, together
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPolyData
from vtkmodules.vtkRenderingCore import vtkVolumeProperty
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper


def table(columns=64, rows=32):
    """[rows, columns, 4]: a band of values, opaque where the gradient is steep enough; colours by both."""
    gradient, value = np.mgrid[0:1:rows * 1j, 0:1:columns * 1j]
    opacity = 0.3 * np.clip(1 - np.abs(value - 0.35) / 0.15, 0, 1) * np.clip((gradient - 0.1) / 0.2, 0, 1)
    return np.stack([value, 1 - value, gradient, opacity], axis=2).astype(np.float32)


def function_of(entries):
    function = vtkImageData()
    rows, columns, count = entries.shape
    function.SetDimensions(columns, rows, 1)
    function.GetPointData().SetScalars(numpy_to_vtk(entries.reshape(-1, count), deep=1))
    return function


def property_2d(entries=None, shade=False, **named):
    prop = property_of(shade=shade, **named)
    prop.SetTransferFunctionMode(vtkVolumeProperty.TF_2D)
    prop.SetTransferFunction2D(function_of(table() if entries is None else entries))
    return prop


class Drawn(MapperCase):
    def as_json(self, entries, values, spacing=1.0):
        """Entries from end to end of the values, and from no change over `spacing` to one of a quarter of their range."""
        lo, hi = float(values.min()), float(values.max())
        rows, columns, _ = entries.shape
        return json.dumps({"Values": [lo, hi], "Gradients": [0, 0.25 * (hi - lo) / spacing], "Size": [columns, rows],
                           "RGBA": [float(x) for x in entries.ravel()]})

    def assert_like_table(self, scene, entries, values, spacing=1.0, data=None):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            file.write(self.as_json(entries, values, spacing))
            file.flush()
            self.assert_like_program(scene, "--tf2d", file.name, data=data, bound=TRANSLUCENT)

    def test_table(self):
        self.assert_like_table(Scene(self.image, property_2d()), table(), self.values)

    def test_light(self):
        self.assert_like_table(Scene(self.image, property_2d(shade=True)), table(), self.values)

    def test_spacing(self):
        """Gradients are per mean spacing, as of gradient opacity."""
        image, _ = image_of(self.values, (1, 2, 3))
        scene = Scene(image, property_2d(), position=(60, 50, 190), focal_point=(12, 24, 36))
        self.assert_like_table(scene, table(), self.values, spacing=2, data=image)

    def test_unit_distance(self):
        self.assert_like_table(Scene(self.image, property_2d(unit_distance=0.4)), table(), self.values)

    def test_steep_gradients(self):
        """Beyond the last row that row's entry counts: a ball whose edge is steeper than the table ends."""
        z, y, x = np.mgrid[-1:1:25j, -1:1:25j, -1:1:25j]
        ball = (2 * (x * x + y * y + z * z < 0.5)).astype(np.float32)
        entries = np.zeros((16, 16, 4), np.float32)
        entries[-1, 4:12] = 0.9, 0.6, 0.2, 0.5
        self.assert_like_table(Scene(image_of(ball)[0], property_2d(entries)), entries, ball, data=image_of(ball)[0])

    def test_large_tables(self):
        """Are made smaller: of 1024 x 512 entries as many as the library takes."""
        small, large = (Scene(self.image, property_2d(table(*size))).draw() for size in ((256, 128), (1024, 512)))
        self.assert_shows(small)
        self.assert_like(small, large, 4)  # bends of the table lie between entries

    def test_weight(self):
        entries = table()
        entries[..., 3] *= 0.5
        prop = property_2d()
        prop.SetComponentWeight(0, 0.5)
        prop.SetTransferFunction2D(1, function_of(np.zeros_like(entries)))
        drawn = Scene(together(self.values, self.values), prop).draw()
        self.assert_shows(drawn)
        self.assert_like(drawn, Scene(self.image, property_2d(entries)).draw(), EXACT)

    def test_independent_components(self):
        """Each has a table of its own."""
        other = np.ascontiguousarray(self.values[::-1])
        prop, blue = property_2d(), table()
        blue[..., :3] = 0, 0, 1
        prop.SetTransferFunction2D(1, function_of(blue))
        both = Scene(together(self.values, other), prop).draw()
        pictures = [Scene(image_of(values)[0], property_2d(entries)).draw() for values, entries in ((self.values, table()), (other, blue))]
        for alone in pictures:
            self.assertGreater(np.abs(both - alone).max(), 20)

    def test_changes(self):
        """A table that is written to is noticed with its Modified(), and makes no field anew."""
        scene = Scene(self.image, property_2d())
        before, made = scene.draw(), scene.mapper.GetFieldTime()
        entries = table()
        entries[..., :3] = 1, 0, 0
        function = scene.volume.GetProperty().GetTransferFunction2D()
        function.GetPointData().SetScalars(numpy_to_vtk(entries.reshape(-1, 4), deep=1))
        self.assertGreater(np.abs(scene.draw() - before).max(), 50)
        self.assertEqual(scene.mapper.GetFieldTime(), made)
        scene.volume.GetProperty().SetTransferFunctionMode(vtkVolumeProperty.TF_1D)
        self.assert_like(scene.draw(), Scene(self.image, property_of(shade=False)).draw(), 0)

    def test_particles(self):
        cloud, points = vtkPolyData(), vtkPoints()
        rng = np.random.default_rng(3)
        places = rng.normal(12, 4, (3000, 3))
        for place in places:
            points.InsertNextPoint(place)
        cloud.SetPoints(points)
        array = numpy_to_vtk(places[:, 0].copy(), deep=1)
        array.SetName("x")
        cloud.GetPointData().SetScalars(array)
        entries = table()
        entries[..., 3] = 0.2
        scene = Scene(cloud, property_2d(entries), vtkOvoidUnstructuredGridVolumeMapper())
        self.assert_shows(scene.draw())
        self.assertEqual(scene.errors, [])

    def test_as_vtk(self):
        """VTK's own mapper, on black, whose opacities are per sample: here a unit distance apart."""
        pictures = []
        for mapper in (vtkGPUVolumeRayCastMapper(), vtkOvoidVolumeMapper(), None):
            prop = property_2d()
            if mapper is None:
                prop.SetTransferFunctionMode(vtkVolumeProperty.TF_1D)
            scene = Scene(self.image, prop, mapper)
            scene.renderer.SetBackground(0, 0, 0)
            prop.SetScalarOpacityUnitDistance(0.25)
            if not pictures:
                mapper.SetAutoAdjustSampleDistances(0)
                mapper.SetSampleDistance(0.25)
            pictures.append(scene.draw())
            self.assertEqual(scene.errors, [])
        inside = pictures[0].max(axis=2) > 20
        self.assertGreater(inside.mean(), 0.05)
        drawn, flat = (np.abs(picture - pictures[0])[inside].mean() for picture in pictures[1:])
        self.assertLess(drawn, 2)  # measured: 1.1, and of the curves 44
        self.assertGreater(flat, 20)


class NotDrawn(MapperCase):
    def test_no_function(self):
        prop = property_of()
        prop.SetTransferFunctionMode(vtkVolumeProperty.TF_2D)
        self.assert_error(Scene(self.image, prop), "TransferFunction2D", "not set")

    def test_components(self):
        prop = property_2d()
        prop.GetTransferFunction2D().GetPointData().SetScalars(numpy_to_vtk(np.zeros((64 * 32, 3), np.float32), deep=1))
        self.assert_error(Scene(self.image, prop), "TransferFunction2D", "3 components")

    def test_volume(self):
        prop = property_2d()
        prop.GetTransferFunction2D().SetDimensions(8, 8, 32)
        self.assert_error(Scene(self.image, prop), "TransferFunction2D", "8 x 8 x 32")

    def test_blend_modes(self):
        for mode in ("MaximumIntensity", "AverageIntensity", "Additive", "IsoSurface"):
            scene = Scene(self.image, property_2d())
            scene.volume.GetProperty().GetIsoSurfaceValues().SetValue(0, 0.6)
            getattr(scene.mapper, f"SetBlendModeTo{mode}")()
            self.assert_error(scene, "two-dimensional", "composite alone")

    def test_dependent(self):
        prop = property_2d()
        prop.IndependentComponentsOff()
        self.assert_error(Scene(together(self.values, self.values), prop), "two-dimensional", "dependent")

    def test_vulkan(self):
        scene = Scene(self.image, property_2d())
        scene.mapper.SetBackend(scene.mapper.VULKAN)
        self.assert_error(scene, "vulkan")


if __name__ == "__main__":
    unittest.main(verbosity=2)
