#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Blend modes that show surfaces: slices and isosurfaces."""
import unittest

import numpy as np
from mapper_case import EXACT, TRANSLUCENT, MapperCase
from ovoid_vtk.vtkOvoid import vtkOvoidVolumeMapper
from scene import Scene, image_of, property_of, together
from vtkmodules.vtkCommonDataModel import vtkPlane, vtkSphere
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

GRAYS = [(0, 0, 0, 0), (1.9, 1, 1, 1)]
RAINBOW = [(0, 0.9, 0.1, 0.1), (0.5, 0.9, 0.8, 0.1), (0.9, 0.1, 0.8, 0.3), (1.9, 0.1, 0.3, 1.0)]
ASLANT = (0.3, 0.2, 1), (12, 12, 10)
OPAQUE = [(0, 1), (1.9, 1)]


def plane_at(normal, origin):
    plane = vtkPlane()
    plane.SetNormal(*np.array(normal) / np.linalg.norm(normal))
    plane.SetOrigin(*origin)
    return plane


def wall(z):
    source = vtkPlaneSource()
    source.SetOrigin(-99, -99, z)
    source.SetPoint1(99, -99, z)
    source.SetPoint2(-99, 99, z)
    return source


class Slices(MapperCase):
    def slice_of(self, data, prop=None, normal=ASLANT[0], origin=ASLANT[1], mapper=None, **named):
        prop = prop or property_of(GRAYS, OPAQUE, False)
        prop.SetSliceFunction(plane_at(normal, origin))
        scene = Scene(data, prop, mapper, **named)
        scene.mapper.SetBlendModeToSlice()
        return scene

    def as_program(self, *flags, normal=ASLANT[0], origin=ASLANT[1]):
        """The slice alone: the field has no opacity."""
        words = ",".join(map(str, (*normal, float(np.dot(normal, origin)))))
        return "--slice", words, "--slice-map", "gray", "--slice-range", "0,1.9", "--slice-empty", "--opacity", "0:0", *flags

    def test_aslant(self):
        self.assert_like_program(self.slice_of(self.image), *self.as_program())

    def test_parallel(self):
        scene = self.slice_of(self.image)
        scene.camera.ParallelProjectionOn()
        scene.camera.SetParallelScale(17)
        self.assert_like_program(scene, *self.as_program())

    def test_opacity(self):
        """Is that of the value, whatever the unit distance, and not of a length."""
        for unit in (1, 7):
            prop = property_of(GRAYS, [(0, 0.6), (1.9, 0.6)], False, unit_distance=unit)
            self.assert_like_program(self.slice_of(self.image, prop), *self.as_program("--slice-opacity", "0.6"), bound=TRANSLUCENT)

    def test_weight_and_gradient_opacity(self):
        """A weight is a factor of the opacity; gradients and light do not count."""
        expected = self.slice_of(self.image, property_of(GRAYS, [(0, 0.3), (1.9, 0.3)], False)).draw()
        prop = property_of(GRAYS, [(0, 0.6), (1.9, 0.6)], True)
        prop.SetComponentWeight(0, 0.5)
        prop.GetGradientOpacity().AddPoint(0, 0)
        prop.GetGradientOpacity().AddPoint(0.1, 1)
        drawn = self.slice_of(together(self.values, 0 * self.values), prop)
        prop.SetComponentWeight(1, 0)
        self.assert_like(drawn.draw(), expected, EXACT)

    def test_clipping_planes_and_cropping(self):
        """Cut the slice."""
        whole = self.slice_of(self.image).draw()
        self.assert_shows(whole)
        clipped = self.slice_of(self.image)
        clipped.mapper.AddClippingPlane(plane_at((1, 0, 0), (12, 0, 0)))
        cropped = self.slice_of(self.image)
        cropped.mapper.CroppingOn()
        cropped.mapper.SetCroppingRegionPlanes(12, 99, -99, 99, -99, 99)
        regions = self.slice_of(self.image)
        regions.mapper.CroppingOn()
        regions.mapper.SetCroppingRegionPlanes(12, 99, -99, 99, -99, 99)
        regions.mapper.SetCroppingRegionFlags(1 << 13 | 1 << 14)  # what lies beyond 99, too, which is nothing
        empty = self.slice_of(self.image, normal=(0, 0, 1), origin=(0, 0, 99)).draw()
        pictures = [scene.draw() for scene in (clipped, cropped, regions)]
        for picture in pictures:
            self.assert_shows(picture)
            self.assert_like(picture, pictures[0], EXACT)
            is_kept = np.abs(picture - empty).max(axis=2) > 0
            self.assertGreater(is_kept.mean(), 0.3 * (np.abs(whole - empty).max(axis=2) > 0).mean())
            self.assert_like(picture[is_kept], whole[is_kept], EXACT)
        self.assertGreater(np.abs(pictures[0] - whole).max(), 50)

    def test_clipping_range(self):
        scene = self.slice_of(self.image, position=(12, 12, 100))
        whole = scene.draw()
        scene.renderer.ResetCameraClippingRange = lambda: None
        scene.camera.SetClippingRange(90, 200)
        near = scene.draw()
        self.assert_shows(near)
        self.assertGreater(np.abs(near - whole).max(), 50)

    def test_opaque_props(self):
        """Hide what is behind them, and are hidden."""
        scene = self.slice_of(self.image, normal=(0, 0, 1), origin=(12, 12, 10), position=(12, 12, 90))
        alone = scene.draw()
        actor = scene.add_actor(wall(9), (1, 0, 0))
        before = scene.draw()
        inside = np.abs(alone - alone[0, 0]).max(axis=2) > 0
        self.assertGreater(inside.mean(), 0.1)
        self.assert_like(before[inside], alone[inside], EXACT)
        actor.SetPosition(0, 0, 3)
        hidden = scene.draw()
        self.assert_like(hidden[inside], np.broadcast_to((255, 0, 0), hidden[inside].shape), EXACT)

    def test_parts_join(self):
        self.assert_parts_join(self.slice_of(self.image, normal=(0, 1, 0.8)), (7.4, 12))

    def test_matrix(self):
        """The plane is the world's, and stays where it is."""
        scene = self.slice_of(self.image, normal=(1, 0, 0), origin=(10, 0, 0), position=(90, 22, 20))
        still = scene.draw()
        scene.volume.SetPosition(-3, 0, 0)
        moved = self.slice_of(image_of(self.values, origin=(-3, 0, 0))[0], normal=(1, 0, 0), origin=(10, 0, 0), position=(90, 22, 20))
        drawn = scene.draw()
        self.assert_like(drawn, moved.draw(), EXACT)
        self.assertGreater(np.abs(drawn - still).max(), 20)

    def test_moved_plane(self):
        """Makes no field anew."""
        scene = self.slice_of(self.image)
        before, made = scene.draw(), scene.mapper.GetFieldTime()
        scene.volume.GetProperty().GetSliceFunction().SetOrigin(12, 12, 15)
        self.assertGreater(np.abs(scene.draw() - before).max(), 20)
        self.assertEqual(scene.mapper.GetFieldTime(), made)

    def test_as_vtk(self):
        """VTK's reads its texture from face to face, so that samples stand up to half a spacing beside their places."""
        pictures = []
        for mapper, origin in ((vtkGPUVolumeRayCastMapper(), 10), (vtkOvoidVolumeMapper(), 10), (vtkOvoidVolumeMapper(), 12)):
            scene = self.slice_of(self.image, property_of(RAINBOW, [(0, 0.2), (1.9, 1)], False), origin=(12, 12, origin), mapper=mapper)
            if mapper.IsA("vtkGPUVolumeRayCastMapper"):
                mapper.SetAutoAdjustSampleDistances(0)
            scene.renderer.SetBackground(0, 0, 0)
            pictures.append(scene.draw())
            self.assertEqual(scene.errors, [])
        inside = pictures[0].max(axis=2) > 20
        self.assertGreater(inside.mean(), 0.1)
        drawn, moved = (np.abs(picture - pictures[0])[inside].mean() for picture in pictures[1:])
        self.assertLess(drawn, 4)  # measured: 3.1, and 6.6 of a plane two spacings away
        self.assertGreater(moved, 5)

    def test_not_drawn(self):
        scene = Scene(self.image, property_of())
        scene.mapper.SetBlendModeToSlice()
        self.assert_error(scene, "blend mode slice", "no SliceFunction")
        scene = self.slice_of(self.image)
        scene.volume.GetProperty().SetSliceFunction(vtkSphere())
        self.assert_error(scene, "blend mode slice", "vtkSphere")
        self.assert_error(self.slice_of(together(self.values, self.values)), "blend mode slice", "2 independent components")
        prop = property_of()
        prop.IndependentComponentsOff()
        self.assert_error(self.slice_of(together(self.values, self.values), prop), "blend mode slice", "2 dependent components")


class Isosurfaces(MapperCase):
    CURVE = [(0.35, 1), (0.5, 0.6), (0.9, 0.4), (1.4, 0)]  # values rise from the middle

    def surfaces_of(self, *values, data=None, prop=None, mapper=None):
        prop = prop or property_of(RAINBOW, self.CURVE)
        for i, value in enumerate(values):
            prop.GetIsoSurfaceValues().SetValue(i, value)
        scene = Scene(data or self.image, prop, mapper)
        scene.mapper.SetBlendModeToIsoSurface()
        return scene

    def assert_like_surfaces(self, scene, iso, **named):
        self.assert_like_program(scene, "--mode", "isosurface", "--iso", iso, has_unit=False, **named)

    def test_opaque(self):
        self.assert_like_surfaces(self.surfaces_of(0.3), "0.3")

    def test_see_through(self):
        """The opacity is that of the value."""
        self.assert_like_surfaces(self.surfaces_of(0.5), "0.5::0.6", bound=TRANSLUCENT)

    def test_several(self):
        """In any order, and one of them twice."""
        self.assert_like_surfaces(self.surfaces_of(0.35, 0.9, 0.5, 0.35), "0.35,0.5::0.6,0.9::0.4", bound=TRANSLUCENT)

    def test_none_that_shows(self):
        scene = self.surfaces_of(1.4, 1.5)
        empty = scene.draw()
        self.assertEqual(scene.errors, [])
        self.assert_like(empty, np.broadcast_to(empty[0, 0], empty.shape), 0)

    def test_unit_distance(self):
        """Is of no surface."""
        one, other = self.surfaces_of(0.35, 0.5), self.surfaces_of(0.35, 0.5)
        other.volume.GetProperty().SetScalarOpacityUnitDistance(0.2)
        self.assert_like(one.draw(), other.draw(), 0)

    def test_clipping_plane(self):
        scene = self.surfaces_of(0.35, 0.9)
        scene.mapper.AddClippingPlane(plane_at((0, 0, -1), (0, 0, 12)))
        self.assert_like_program(scene, "--mode", "isosurface", "--iso", "0.35,0.9::0.4", "--clip=0,0,-1,-12", has_unit=False,
                                 bound=TRANSLUCENT)

    def test_half_hidden(self):
        """An opaque wall hides what is behind it."""
        hidden, cut = self.surfaces_of(0.35, 0.5), self.surfaces_of(0.35, 0.5)
        for scene in (hidden, cut):
            scene.mapper.ImageSheetsOn()
        hidden.add_actor(wall(12))
        cut.mapper.AddClippingPlane(plane_at((0, 0, 1), (0, 0, 12)))
        for scene in (hidden, cut):
            scene.draw()
            self.assertEqual(scene.errors, [])
        self.assertGreater(cut.floats()[..., 3].max(), 0.3)
        differs = np.abs(hidden.floats() - cut.floats()).max(axis=2) > 1 / 255
        self.assertLess(differs.sum(), 0.01 * (cut.floats()[..., 3] > 0).sum())  # measured: 4 of 830, where surfaces meet the wall

    def test_weight(self):
        prop = property_of(RAINBOW, self.CURVE)
        prop.SetComponentWeight(0, 0.5)
        prop.SetComponentWeight(1, 0)
        drawn = self.surfaces_of(0.5, 0.9, data=together(self.values, 0 * self.values), prop=prop).draw()
        halved = property_of(RAINBOW, [(x, 0.5 * y) for x, y in self.CURVE])
        self.assert_shows(drawn)
        self.assert_like(drawn, self.surfaces_of(0.5, 0.9, prop=halved).draw(), EXACT)

    def test_as_vtk(self):
        """VTK's own mapper, whose crossings are the first samples behind them."""
        pictures = []
        for mapper, values in ((vtkGPUVolumeRayCastMapper(), (0.35, 0.5, 0.9)), (vtkOvoidVolumeMapper(), (0.35, 0.5, 0.9)),
                               (vtkOvoidVolumeMapper(), (0.9,))):
            scene = self.surfaces_of(*values, mapper=mapper)
            if mapper.IsA("vtkGPUVolumeRayCastMapper"):
                mapper.SetAutoAdjustSampleDistances(0)
                mapper.SetSampleDistance(0.1)
            scene.renderer.SetBackground(0, 0, 0)
            pictures.append(scene.draw())
            self.assertEqual(scene.errors, [])
        inside = pictures[0].max(axis=2) > 20
        self.assertGreater(inside.mean(), 0.1)
        drawn, one = (np.abs(picture - pictures[0])[inside].mean() for picture in pictures[1:])
        self.assertLess(drawn, 2.5)  # measured: 1.7, and 10 of the last surface alone
        self.assertGreater(one, 8)

    def test_not_drawn(self):
        scene = self.surfaces_of()
        scene.volume.GetProperty().GetIsoSurfaceValues().SetNumberOfContours(0)
        self.assert_error(scene, "blend mode isosurface", "empty")
        self.assert_error(self.surfaces_of(*np.linspace(0.2, 0.9, 17)), "blend mode isosurface", "17 values", "at most 16")


if __name__ == "__main__":
    unittest.main(verbosity=2)
