#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Arrays of several numbers: vtkOvoidVolumeMapper draws one of them, or independent components together."""
import os
import tempfile
import unittest

import numpy as np
from mapper_case import EXACT, SIDE, TRANSLUCENT, MapperCase, vtks_picture
from ovoid_vtk.vtkOvoid import vtkOvoidUnstructuredGridVolumeMapper, vtkOvoidVolumeMapper
from scene import (BACKGROUND, COLORS, FOG, SHELL, Scene, grid_of, image_of, look_json, over, points_of_pairs, property_of, rendered,
                   together, write)
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction, vtkPlane
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkRenderingCore import vtkLight, vtkVolumeProperty
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper, vtkGPUVolumeRayCastMapper

RED, GREEN, BLUE = ([(0, *rgb), (1.9, *rgb)] for rgb in ((0.9, 0.2, 0.1), (0.1, 0.8, 0.2), (0.2, 0.3, 1.0)))
HAZE = [(0.2, 0), (0.6, 0.1), (1.2, 0)]
FAR_HAZE = [(0.4, 0), (0.8, 0.1), (1.2, 0)]


def joined(*properties, weights=()):
    """One property of components, each as one of `properties` says its only one."""
    prop = vtkVolumeProperty()
    for i, single in enumerate(properties):
        prop.SetColor(i, single.GetRGBTransferFunction())
        prop.SetScalarOpacity(i, single.GetScalarOpacity())
        prop.SetScalarOpacityUnitDistance(i, single.GetScalarOpacityUnitDistance())
        prop.SetShade(i, single.GetShade())
        prop.SetGradientOpacity(i, single.GetGradientOpacity())
        if weights:
            prop.SetComponentWeight(i, weights[i])
    prop.SetInterpolationTypeToLinear()
    return prop


class One(MapperCase):
    def setUp(self):
        super().setUp()
        self.several = together(0 * self.values, self.values, 2 * self.values)

    def test_the_one_with_a_weight(self):
        single = property_of()
        drawn = Scene(self.several, joined(single, single, single, weights=(0, 1, 0))).draw()
        self.assert_shows(drawn)
        self.assert_like(drawn, Scene(self.image, single).draw(), EXACT)

    def test_vector_modes(self):
        scene = Scene(self.several, property_of())
        scene.mapper.SetVectorMode(scene.mapper.COMPONENT)
        scene.mapper.SetVectorComponent(1)
        expected = Scene(self.image, property_of()).draw()
        self.assert_like(scene.draw(), expected, EXACT)
        scene.mapper.SetVectorMode(scene.mapper.MAGNITUDE)
        scaled = property_of(scale=np.sqrt(5))
        scene.volume.SetProperty(scaled)
        self.assert_like(scene.draw(), expected, TRANSLUCENT)

    def test_magnitude_of_one(self):
        """Is the number itself, not its absolute value."""
        image, _ = image_of(-self.values)
        prop = property_of(colors=[(-x, *rgb) for x, *rgb in reversed(COLORS)], opacities=[(-x, y) for x, y in reversed(SHELL)])
        scene = Scene(image, prop)
        expected = scene.draw()
        self.assert_shows(expected)
        scene.mapper.SetVectorMode(scene.mapper.MAGNITUDE)
        self.assert_like(scene.draw(), expected, 0)


class Several(MapperCase):
    def setUp(self):
        super().setUp()
        self.turned = np.ascontiguousarray(np.roll(self.values.transpose(2, 0, 1), 6, axis=2))
        self.third = np.ascontiguousarray(self.values[::-1, :, ::-1].transpose(1, 2, 0))
        self.two = together(self.values, self.turned)

    def assert_like_over(self, values, properties, *flags, prepare=lambda scene: None, bound=TRANSLUCENT):
        """As `ovoid render --over` draws images of each component, each with its look."""
        scene = Scene(together(*values), joined(*properties))
        prepare(scene)
        drawn = scene.draw()
        self.assertEqual(scene.errors, [])
        self.assert_shows(drawn)
        self.assert_like(drawn, over(self.rendered_over(values, properties, *flags), BACKGROUND), bound)

    def rendered_over(self, values, properties, *flags, mixing="added"):
        scene = Scene(self.image, properties[0])
        images = [image_of(each)[0] for each in values]
        with tempfile.TemporaryDirectory() as folder:
            words = ["--mixing", mixing]
            for i, image in enumerate(images[1:]):
                place = os.path.join(folder, str(i))
                os.mkdir(place)
                words += ["--over", write(image, place), "--over-tf", look_json(properties[i + 1])]
            return rendered(images[0], scene, *words, *flags, has_unit="--mode" not in flags)

    def test_two(self):
        self.assert_like_over((self.values, self.turned), (property_of(RED, HAZE, False), property_of(GREEN, SHELL, False)))

    def test_two_with_light(self):
        self.assert_like_over((self.values, self.turned), (property_of(RED, SHELL), property_of(GREEN, HAZE)))

    def test_three(self):
        self.assert_like_over((self.values, self.turned, self.third),
                              [property_of(colors, HAZE, False) for colors in (RED, GREEN, BLUE)])

    def test_four_bytes(self):
        values = [(each * 130).astype(np.uint8) for each in (self.values, self.turned, self.third, self.values[::-1])]
        self.assert_like_over(values, [property_of(colors, HAZE, False, scale=130) for colors in (RED, GREEN, BLUE, COLORS)])

    def test_maximum(self):
        properties = [property_of(colors, [(0.8, 0), (1.9, 0.6)], False) for colors in (RED, GREEN)]
        self.assert_like_over((self.values, self.turned), properties, "--mode", "maximum",
                              prepare=lambda scene: scene.mapper.SetBlendModeToMaximumIntensity())

    def test_minimum(self):
        """Is the maximum of the negated values, of each component."""
        curves = [(0, 0.6), (1.0, 0)], [(-1.0, 0), (0, 0.6)]
        scene = Scene(self.two, joined(*(property_of(colors, curves[0], False) for colors in (RED, GREEN))))
        scene.mapper.SetBlendModeToMinimumIntensity()
        mirrored = [property_of([(-x, *rgb) for x, *rgb in reversed(colors)], curves[1], False) for colors in (RED, GREEN)]
        other = Scene(together(-self.values, -self.turned), joined(*mirrored))
        other.mapper.SetBlendModeToMaximumIntensity()
        drawn = scene.draw()
        self.assert_shows(drawn)
        self.assert_like(drawn, other.draw(), EXACT)

    def test_additive(self):
        """Each component's sum, weighted, and the sum of these."""
        properties = [property_of(RED, [(0.1, 0), (0.5, 0.03), (0.8, 0)], False), property_of(GREEN, [(0.5, 0), (1.9, 0.01)], False)]
        pictures = []
        for weights in ((1, 0), (0, 1), (1, 0.5)):
            scene = Scene(self.two, joined(*properties, weights=weights))
            scene.mapper.SetBlendModeToAdditive()
            scene.draw()
            self.assertEqual(scene.errors, [])
            pictures.append(scene.floats()[..., 0])
        first, second, both = pictures
        self.assertGreater(min(first.max(), second.max()), 0.05)
        self.assertLess((first + second).max(), 1)
        self.assertLess(np.abs(both - first - 0.5 * second).max(), 0.01)

    def test_weights(self):
        """Are factors of opacities, of one component as of several."""
        halved = [(x, 0.5 * y) for x, y in HAZE]
        for rest in (0, 1):
            scene = Scene(self.two, joined(property_of(RED, HAZE), property_of(GREEN, SHELL), weights=(0.5, rest)))
            other = Scene(self.two, joined(property_of(RED, halved), property_of(GREEN, SHELL), weights=(1, rest)))
            drawn = scene.draw()
            self.assert_like(drawn, other.draw(), 0)
            scene.volume.GetProperty().SetComponentWeight(0, 1)
            self.assertGreater(np.abs(drawn - scene.draw()).max(), 10)

    def test_order(self):
        """Each component keeps its own shading, lights and gradient opacity, whichever comes first."""
        curve = vtkPiecewiseFunction()
        curve.AddPoint(0.02, 0)
        curve.AddPoint(0.1, 1)
        shaded, plain = property_of(RED, FOG), property_of(GREEN, HAZE, False)
        shaded.SetGradientOpacity(curve)
        pictures = []
        for values, properties in (((self.values, self.turned), (shaded, plain)), ((self.turned, self.values), (plain, shaded))):
            scene = Scene(together(*values), joined(*properties))
            light = vtkLight()
            light.SetLightTypeToSceneLight()
            light.SetPosition(1, 0.5, 0)
            scene.renderer.AddLight(light)
            pictures.append(scene.draw())
            self.assertEqual(scene.errors, [])
            index = int(properties[1] is shaded)
            for change in (lambda prop, i=index: prop.SetDisableGradientOpacity(i, 1), lambda prop, i=index: prop.SetShade(i, 0)):
                before = scene.draw()
                change(scene.volume.GetProperty())
                self.assertGreater(np.abs(scene.draw() - before).max(), 10)
        self.assert_like(pictures[0], pictures[1], EXACT)

    def test_as_vtk_mixes(self):
        """VTK's own mappers, on black. Each component alone differs from theirs already, by kernels for linear interpolation."""
        values = self.values, self.third
        properties = property_of(RED, HAZE, False), property_of(GREEN, FAR_HAZE, False)
        averaged = over(self.rendered_over(values, properties, mixing="averaged"), (0, 0, 0))

        def scene_of(mapper, *weights):
            scene = Scene(together(*values), joined(*properties, weights=weights), mapper)
            scene.renderer.SetBackground(0, 0, 0)
            return scene
        ours = [scene_of(vtkOvoidVolumeMapper(), 1, weight) for weight in (1, 0)]
        for theirs in (vtkFixedPointVolumeRayCastMapper, vtkGPUVolumeRayCastMapper):
            pictures = [vtks_picture(lambda made=theirs: scene_of(made(), 1, 1)), *[scene.draw() for scene in ours]]
            self.assertEqual(ours[0].errors + ours[1].errors, [])
            inside = pictures[0].max(axis=2) > 20
            self.assertGreater(inside.mean(), 0.1)
            both, one, fogs = (np.abs(picture - pictures[0])[inside].mean() for picture in (*pictures[1:], averaged))
            # Measured: 8.2 and 6.6, 52 and 51, 32 and 31.
            self.assertLess(both, 10)
            self.assertGreater(one, 40)
            self.assertGreater(fogs, 25)

    def test_weights_as_vtk(self):
        properties = property_of(RED, HAZE, False), property_of(GREEN, FAR_HAZE, False)

        def scene_of(mapper, *weights):
            scene = Scene(together(self.values, self.third), joined(*properties, weights=weights), mapper)
            scene.renderer.SetBackground(0, 0, 0)
            return scene
        ours = [scene_of(vtkOvoidVolumeMapper(), 1, weight) for weight in (0.3, 1)]
        pictures = [vtks_picture(lambda: scene_of(vtkFixedPointVolumeRayCastMapper(), 1, 0.3)), *[scene.draw() for scene in ours]]
        self.assertEqual(ours[0].errors + ours[1].errors, [])
        inside = pictures[0].max(axis=2) > 20
        weighted, unweighted = (np.abs(picture - pictures[0])[inside].mean() for picture in pictures[1:])
        self.assertLess(weighted, 9)  # measured: 6.6 and 33
        self.assertGreater(unweighted, 25)

    def test_clipping_plane(self):
        def clip(scene):
            plane = vtkPlane()
            plane.SetNormal(np.sqrt(0.5), np.sqrt(0.5), 0)
            plane.SetOrigin(9, 9, 0)
            scene.mapper.AddClippingPlane(plane)
        self.assert_like_over((self.values, self.turned), (property_of(RED, HAZE), property_of(GREEN, SHELL)), "--clip", "1,1,0,18",
                              prepare=clip)

    def test_half_hidden(self):
        """An opaque plane across all components leaves what clipping at it leaves."""
        pictures = []
        for is_plane in (False, True):
            scene = Scene(self.two, joined(property_of(RED, HAZE, False), property_of(GREEN, SHELL, False)), position=(12, 12, 90))
            scene.mapper.SetImageSheets(1)
            if is_plane:
                source = vtkPlaneSource()
                source.SetOrigin(-99, -99, 10.3)
                source.SetPoint1(99, -99, 10.3)
                source.SetPoint2(-99, 99, 10.3)
                scene.add_actor(source)
            else:
                plane = vtkPlane()
                plane.SetNormal(0, 0, 1)
                plane.SetOrigin(0, 0, 10.3)
                scene.mapper.AddClippingPlane(plane)
            scene.draw()
            self.assertEqual(scene.errors, [])
            pictures.append(255 * scene.floats())
        self.assert_like(*pictures, TRANSLUCENT)

    def test_parts_join(self):
        scene = Scene(self.two, joined(property_of(RED, FOG), property_of(GREEN, HAZE)))
        scene.mapper.ImageSheetsOn()
        self.assert_parts_join(scene, (7.4, 12))

    def test_matrix(self):
        """All components move with the volume."""
        scene = Scene(self.two, joined(property_of(RED, HAZE), property_of(GREEN, SHELL)))
        still = scene.draw()
        scene.volume.SetPosition(40, 0, 0)
        self.assertGreater(np.abs(scene.draw() - still).max(), 10)
        scene.camera.SetPosition(70, 22, 90)
        scene.camera.SetFocalPoint(52, 12, 12)
        self.assert_like(scene.draw(), still, EXACT)

    def test_fields(self):
        """Weights make a field anew only where another component is drawn."""
        scene = Scene(self.two, joined(property_of(RED, HAZE), property_of(GREEN, SHELL)))
        scene.draw()
        made, memory = scene.mapper.GetFieldTime(), scene.mapper.GetFieldMemory()
        self.assertFalse(scene.mapper.GetSharesMemory())
        scene.volume.GetProperty().SetComponentWeight(0, 0.5)
        scene.draw()
        self.assertEqual(scene.mapper.GetFieldTime(), made)
        scene.volume.GetProperty().SetComponentWeight(0, 0)
        scene.draw()
        self.assertGreater(scene.mapper.GetFieldTime(), made)
        self.assertLess(scene.mapper.GetFieldMemory(), 0.6 * memory)
        self.assertEqual(scene.errors, [])


class NotDrawn(MapperCase):
    def setUp(self):
        super().setUp()
        self.three = together(self.values, self.values, self.values)

    def test_five(self):
        self.assert_error(Scene(together(*[self.values] * 5), property_of()), "'values'", "5 independent components", "at most 4")

    def test_blend_modes(self):
        for mode in ("AverageIntensity", "IsoSurface"):
            scene = Scene(self.three, property_of())
            scene.volume.GetProperty().GetIsoSurfaceValues().SetValue(0, 0.6)
            getattr(scene.mapper, f"SetBlendModeTo{mode}")()
            self.assert_error(scene, "blend mode", "3 independent components")

    def test_component_without_values(self):
        image = together(self.values, np.full_like(self.values, np.nan))
        self.assert_error(Scene(image, property_of()), "'values'", "finite")

    def test_vulkan(self):
        """Told, rather than drawn with one component: the device has none, or draws none of several."""
        scene = Scene(self.three, property_of())
        scene.mapper.SetBackend(scene.mapper.VULKAN)
        self.assert_error(scene, "vulkan")

    def test_uneven_grid(self):
        grid = grid_of(self.three.GetPointData().GetScalars(), np.arange(SIDE) ** 1.1)
        self.assert_error(Scene(grid, property_of()), "'values'", "3 independent components", "uneven")

    def test_points(self):
        self.assert_error(Scene(points_of_pairs(), property_of(), vtkOvoidUnstructuredGridVolumeMapper()), "'pairs'", "2 independent components",
                          "one is drawn")


if __name__ == "__main__":
    unittest.main(verbosity=2)
