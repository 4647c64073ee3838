#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""vtkOvoidVolumeMapper draws what `ovoid render` draws, and means what VTK's mappers mean."""
import unittest

import numpy as np
from mapper_case import EXACT, SIDE, TRANSLUCENT, MapperCase
from ovoid_vtk.vtkOvoid import vtkOvoidVolumeMapper
from scene import BACKGROUND, COLORS, FOG, HEIGHT, SHELL, WIDTH, Scene, bumps, image_of, over, picture_of, property_of, rendered
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction, vtkPlane, vtkRectilinearGrid
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkFiltersSources import vtkPlaneSource
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkLight
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper


class Pictures(MapperCase):
    def test_perspective(self):
        self.assert_like_program(Scene(self.image, property_of()))

    def test_floats(self):
        """Before OpenGL the picture is the program's, and its depth lies on the ray."""
        scene = Scene(self.image, property_of())
        scene.draw()
        self.assertLess(np.abs(scene.floats() - rendered(self.image, scene)).max(), 1e-6)
        depths = vtkImageData()
        scene.mapper.GetDepthImage(depths)
        nearest = depths.GetScalarRange()[0]
        self.assertGreater(nearest, 50)  # the eye is some 80 before the middle of a volume of 24
        self.assertLess(nearest, 90)

    def test_two_windows(self):
        """What belongs to one window is not used in another, nor after its window is gone."""
        scene, other = Scene(self.image, property_of()), Scene(self.image, property_of())
        expected = scene.draw()
        other.volume.SetMapper(scene.mapper)
        self.assert_like(other.draw(), expected, 0)
        self.assert_like(scene.draw(), expected, 0)
        scene.renderer.RemoveVolume(scene.volume)
        scene.window.Finalize()
        self.assert_like(other.draw(), expected, 0)

    def test_parallel(self):
        scene = Scene(self.image, property_of())
        scene.camera.SetParallelProjection(1)
        scene.camera.SetParallelScale(17)
        self.assert_like_program(scene)

    def test_translucent(self):
        self.assert_like_program(Scene(self.image, property_of(opacities=FOG, shade=False)), bound=TRANSLUCENT)

    def test_unit_distance(self):
        self.assert_like_program(Scene(self.image, property_of(opacities=FOG, shade=False, unit_distance=0.3)), bound=TRANSLUCENT)

    def test_material(self):
        prop = property_of()
        prop.SetAmbient(0.3)
        prop.SetDiffuse(0.5)
        prop.SetSpecular(0.6)
        prop.SetSpecularPower(30)
        self.assert_like_program(Scene(self.image, prop))

    def test_gradient_opacity(self):
        prop = property_of(opacities=FOG)
        spacing = (1, 2, 3)  # VTK's gradients are per mean spacing, the program's per length
        image, _ = image_of(self.values, spacing)
        curve = vtkPiecewiseFunction()
        curve.AddPoint(0.05, 0)
        curve.AddPoint(0.2, 1)
        prop.SetGradientOpacity(curve)
        scene = Scene(image, prop, position=(60, 50, 190), focal_point=(12, 24, 36))
        self.assert_like_program(scene, "--gradient-opacity", "0.025:0,0.1:1", data=image, bound=TRANSLUCENT)
        opaque = scene.draw()
        prop.DisableGradientOpacityOn()
        self.assertGreater(np.abs(scene.draw() - opaque).max(), 10)

    def test_two_lights(self):
        scene = Scene(self.image, property_of())
        for direction, intensity in (((1, 0, 0), 0.5), ((0, 1, 1), 0.25)):
            light = vtkLight()
            light.SetLightTypeToSceneLight()
            light.SetPosition(*direction)
            light.SetFocalPoint(0, 0, 0)
            light.SetIntensity(intensity)
            scene.renderer.AddLight(light)
        prop = scene.volume.GetProperty()
        drawn = scene.draw()
        prop.SetDiffuse(0.5 * prop.GetDiffuse())  # the first light's intensity
        prop.SetSpecular(0.5 * prop.GetSpecular())
        expected = rendered(self.image, scene, "--light", "1,0,0", "--light", "0,1,1@0.5")
        self.assert_like(drawn, over(expected, BACKGROUND), EXACT)

    def test_no_light(self):
        scene = Scene(self.image, property_of())
        light = vtkLight()
        light.SwitchOff()
        scene.renderer.AutomaticLightCreationOff()
        scene.renderer.AddLight(light)
        drawn = scene.draw()
        scene.volume.GetProperty().SetDiffuse(0)
        scene.volume.GetProperty().SetSpecular(0)
        self.assert_like(drawn, over(rendered(self.image, scene), BACKGROUND), EXACT)

    def test_bytes(self):
        image, _ = image_of(bumps(SIDE, np.uint8))
        self.assert_like_program(Scene(image, property_of(scale=255 / 1.9)), data=image)

    def test_cell_data(self):
        image = vtkImageData()
        image.SetDimensions(SIDE + 1, SIDE + 1, SIDE + 1)
        image.GetCellData().SetScalars(self.array)
        self.assert_like_program(Scene(image, property_of()), data=image)

    def test_even_rectilinear_grid(self):
        self.draw_rectilinear(np.arange(SIDE) * 1.0)

    def test_uneven_rectilinear_grid(self):
        self.draw_rectilinear(np.arange(SIDE) ** 1.1 * 0.7)

    def draw_rectilinear(self, coordinates):
        grid = vtkRectilinearGrid()
        grid.SetDimensions(SIDE, SIDE, SIDE)
        axis = numpy_to_vtk(coordinates, deep=1)
        grid.SetXCoordinates(axis)
        grid.SetYCoordinates(axis)
        grid.SetZCoordinates(axis)
        grid.GetPointData().SetScalars(self.array)
        self.assert_like_program(Scene(grid, property_of()), data=grid)


class Kernels(MapperCase):
    def test_each(self):
        for kernel, flags in (("BSpline", ["bspline", "--prefilter"]), ("CatmullRom", ["catmull-rom"]), ("Gaussian", ["gaussian"]),
                              ("SmoothingBSpline", ["bspline", "--no-prefilter"])):
            scene = Scene(self.image, property_of())
            getattr(scene.mapper, f"SetKernelTo{kernel}")()
            self.assert_like_program(scene, "--kernel", *flags)


class BlendModes(MapperCase):
    def assert_mode(self, scene, mode, *flags):
        self.assert_like_program(scene, "--mode", mode, *flags, has_unit=False, bound=TRANSLUCENT)

    def test_maximum(self):
        scene = Scene(self.image, property_of(opacities=[(0.5, 0), (1.9, 1)], shade=False))
        scene.mapper.SetBlendModeToMaximumIntensity()
        self.assert_mode(scene, "maximum")

    def test_minimum(self):
        scene = Scene(self.image, property_of(opacities=[(0, 1), (1.0, 0)], shade=False))
        scene.mapper.SetBlendModeToMinimumIntensity()
        drawn = scene.draw()
        self.assert_shows(drawn)
        negated, _ = image_of(-self.values)
        mirrored = Scene(negated, property_of(colors=[(-x, *rgb) for x, *rgb in reversed(COLORS)],
                                              opacities=[(-1.0, 0), (0, 1)], shade=False))
        mirrored.mapper.SetBlendModeToMaximumIntensity()
        self.assert_like(drawn, mirrored.draw(), EXACT)

    def test_average(self):
        scene = Scene(self.image, property_of(opacities=[(0.3, 0), (1.9, 1)], shade=False))
        scene.mapper.SetBlendModeToAverageIntensity()
        self.assert_mode(scene, "mean")

    def test_additive(self):
        """As VTK's own mapper adds up, but for its samples. Nothing is added at the faces, which lie half a spacing further out here."""
        pictures = []
        for mapper in (vtkOvoidVolumeMapper(), vtkGPUVolumeRayCastMapper()):
            scene = Scene(self.image, property_of(opacities=[(0.1, 0), (0.5, 0.3), (0.8, 0)], shade=False), mapper)
            scene.mapper.SetBlendModeToAdditive()
            scene.renderer.SetBackground(0, 0, 0)
            if len(pictures) == 1:
                mapper.SetAutoAdjustSampleDistances(0)
                mapper.SetSampleDistance(0.25)
            pictures.append(scene.draw())
            self.assertEqual(scene.errors, [])
        self.assertGreater(pictures[0].max(), 80)
        inside = pictures[1].max(axis=2) > 20
        self.assertGreater(inside.mean(), 0.1)
        self.assertLess(np.abs(pictures[0] - pictures[1])[inside].mean(), 3)
        self.assertLess(abs(pictures[0].mean() - pictures[1].mean()), 0.02 * pictures[1].mean())


class Cuts(MapperCase):
    def test_cropping_to_a_box(self):
        scene = Scene(self.image, property_of(opacities=FOG))
        scene.mapper.CroppingOn()
        scene.mapper.SetCroppingRegionPlanes(5, 20, 3, 24, 0, 13)
        self.assert_like_program(scene, "--clip", "1,0,0,5", "--clip=-1,0,0,-20", "--clip", "0,1,0,3", "--clip=0,-1,0,-24",
                                 "--clip", "0,0,1,0", "--clip=0,0,-1,-13", bound=TRANSLUCENT)

    def test_cropping_regions(self):
        """One corner region is a box, too; all regions are everything; a fence and its inverse are not the same."""
        scene = Scene(self.image, property_of(opacities=FOG, shade=False))
        whole = over(rendered(self.image, scene, "--sheets", "image"), BACKGROUND)
        scene.mapper.CroppingOn()
        scene.mapper.SetCroppingRegionPlanes(6, 12, 6, 12, 6, 12)
        scene.mapper.SetCroppingRegionFlags(0x7FFFFFF)
        self.assert_like(scene.draw(), whole, TRANSLUCENT)
        scene.mapper.SetCroppingRegionFlags(1 << 26)  # beyond all upper planes
        corner = scene.draw()
        self.assert_shows(corner)
        clips = ("--clip", "1,0,0,12", "--clip", "0,1,0,12", "--clip", "0,0,1,12")
        self.assert_like(corner, over(rendered(self.image, scene, "--sheets", "image", *clips), BACKGROUND), TRANSLUCENT)
        scene.mapper.SetCroppingRegionPlanes(6, 12, 6, 12, 6, 12)
        scene.mapper.SetCroppingRegionFlagsToFence()
        fence = scene.draw()
        scene.mapper.SetCroppingRegionFlagsToInvertedFence()
        self.assertGreater(np.abs(scene.draw() - fence).max(), 10)

    def test_clipping_planes(self):
        scene = Scene(self.image, property_of(opacities=FOG))
        for normal, origin in (((1, 1, 0), (9, 9, 0)), ((0, -1, 0.5), (0, 18, 0))):
            plane = vtkPlane()
            plane.SetNormal(*np.array(normal) / np.linalg.norm(normal))
            plane.SetOrigin(*origin)
            scene.mapper.AddClippingPlane(plane)
        self.assert_like_program(scene, "--clip", "1,1,0,18", "--clip", "0,-1,0.5,-18", bound=TRANSLUCENT)

    def test_clipping_range(self):
        scene = Scene(self.image, property_of(opacities=FOG), position=(12, 12, 100))
        scene.renderer.ResetCameraClippingRange = lambda: None  # of the scene, which draws with this range
        scene.camera.SetClippingRange(85, 95)
        scene.window.Render()
        flags = ("--clip=0,0,-1,-15", "--clip", "0,0,1,5")
        self.assert_like(picture_of(scene.window), over(rendered(self.image, scene, *flags), BACKGROUND), TRANSLUCENT)


class Geometry(MapperCase):
    """Opaque things in the scene."""

    def plane_at(self, scene, z):
        plane = vtkPlaneSource()
        plane.SetOrigin(-99, -99, z)
        plane.SetPoint1(99, -99, z)
        plane.SetPoint2(-99, 99, z)
        return scene.add_actor(plane, color=(1, 0.5, 0))

    def scene(self):
        return Scene(self.image, property_of(opacities=FOG, shade=False), position=(12, 12, 90))

    def test_behind(self):
        scene = self.scene()
        self.plane_at(scene, -20)
        self.assert_like(scene.draw(), over(rendered(self.image, scene), (1, 0.5, 0)), TRANSLUCENT)

    def test_in_front(self):
        scene = self.scene()
        self.plane_at(scene, 40)
        self.assert_like(scene.draw(), np.broadcast_to([255, 127.5, 0], (HEIGHT, WIDTH, 3)), EXACT)

    def test_half_inside(self):
        for samples in (0, 4):
            scene = self.scene()
            scene.window.SetMultiSamples(samples)
            self.plane_at(scene, 10.3)
            drawn = scene.draw()
            expected = rendered(self.image, scene, "--clip", "0,0,1,10.3", "--sheets", "image")
            self.assert_like(drawn, over(expected, (1, 0.5, 0)), TRANSLUCENT)

    def test_aslant(self):
        """In the parallel projection, too: what a slanted plane leaves is what clipping at it leaves."""
        scene = self.scene()
        scene.camera.SetParallelProjection(1)
        scene.camera.SetParallelScale(16)
        plane = self.plane_at(scene, 0)
        plane.RotateY(30)
        plane.AddPosition(12, 12, 12)
        normal = np.array([np.sin(np.pi / 6), 0, np.cos(np.pi / 6)])
        drawn = scene.draw()
        clip = ",".join(str(x) for x in (*normal, normal @ [12, 12, 12]))
        self.assert_like(drawn, over(rendered(self.image, scene, "--clip", clip, "--sheets", "image"), (1, 0.5, 0)), TRANSLUCENT)


class Views(MapperCase):
    def test_matrix(self):
        """The volume is turned, moved, and stretched along one axis, as another image says it of itself."""
        image, _ = image_of(self.values, spacing=(1.5, 1, 0.8), origin=(3, -2, 7))
        image.SetDirectionMatrix(0, -1, 0, 1, 0, 0, 0, 0, 1)
        scene = Scene(self.image, property_of(), focal_point=(-10, 16, 15))
        scene.volume.SetScale(1.5, 1, 0.8)
        scene.volume.RotateZ(90)
        scene.volume.SetPosition(3, -2, 7)
        self.assert_like_program(scene, data=image)

    def test_shear(self):
        """An oblique lattice is drawn: the sheared volume seen along z is the plain one, its layers moved."""
        matrix = vtkMatrix4x4()
        matrix.SetElement(0, 2, 0.5)
        scene = Scene(self.image, property_of(opacities=[(0, 1), (0.5, 1), (0.6, 0)], shade=False), position=(18, 12, 90),
                      focal_point=(18, 12, 12))
        scene.volume.SetUserMatrix(matrix)
        drawn = scene.draw()
        self.assertEqual(scene.errors, [])
        self.assert_shows(drawn)

    def test_window_center(self):
        """A larger screenshot comes in tiles, whose cameras look past their middle."""
        scene = Scene(self.image, property_of())
        scene.draw()
        tiles = picture_of(scene.window, scale=2)
        scene.window.SetSize(2 * WIDTH, 2 * HEIGHT)
        self.assert_like(tiles, scene.draw(), TRANSLUCENT)

    def test_viewport(self):
        scene = Scene(self.image, property_of())
        alone = scene.draw()
        scene.window.SetSize(2 * WIDTH, HEIGHT)
        scene.renderer.SetViewport(0.5, 0, 1, 1)
        self.assert_like(scene.draw()[:, WIDTH:], alone, EXACT)

    def test_coarse_pictures(self):
        """Where the window grants no time, pictures have fewer pixels."""
        scene = Scene(self.image, property_of())
        full = scene.draw()
        self.assertEqual(scene.mapper.GetImageSampleDistance(), 1)
        scene.window.SetDesiredUpdateRate(100000)
        coarse = scene.draw()
        self.assertGreater(scene.mapper.GetImageSampleDistance(), 1)
        self.assertLess(np.abs(coarse - full).mean(), 8)
        scene.mapper.AutoAdjustSampleDistancesOff()
        self.assert_like(scene.draw(), full, EXACT)

    def test_camera_that_shears(self):
        scene = Scene(self.image, property_of())
        scene.camera.SetViewShear(0.5, 0, 1)
        self.assert_error(scene, "camera", "shears")


class Memory(MapperCase):
    def test_samples_are_shared(self):
        for dtype in (np.float32, np.uint8):
            image, array = image_of(bumps(SIDE, dtype))
            count = array.GetReferenceCount()
            scene = Scene(image, property_of())
            scene.draw()
            self.assertTrue(scene.mapper.GetSharesMemory())
            self.assertGreater(array.GetReferenceCount(), count)
            self.assertLess(scene.mapper.GetFieldMemory(), 5 * SIDE ** 3)  # a float of a coefficient each, and ranges
        image, _ = image_of(self.values.astype(np.float64))
        scene = Scene(image, property_of())
        scene.draw()
        self.assertFalse(scene.mapper.GetSharesMemory())

    def test_a_changed_array_is_noticed(self):
        scene = Scene(self.image, property_of())
        scene.draw()
        made = scene.mapper.GetFieldTime()
        self.values[...] = np.roll(self.values, 6, axis=2)
        scene.draw()
        self.assertEqual(scene.mapper.GetFieldTime(), made)
        self.array.Modified()
        self.assert_like_program(scene)
        self.assertGreater(scene.mapper.GetFieldTime(), made)

    def test_nothing_else_makes_the_field_anew(self):
        scene = Scene(self.image, property_of())
        scene.draw()
        made = scene.mapper.GetFieldTime()
        scene.camera.Azimuth(20)
        scene.volume.SetProperty(property_of(opacities=FOG))
        scene.volume.RotateX(30)
        scene.volume.SetScale(1, 2, 1)
        scene.mapper.CroppingOn()
        scene.mapper.Modified()
        self.image.Modified()
        scene.draw()
        self.assertEqual(scene.errors, [])
        self.assertEqual(scene.mapper.GetFieldTime(), made)


class Functions(MapperCase):
    """What VTK's functions say between their nodes."""

    def test_midpoints_logarithms_and_spaces(self):
        def logarithmic(color):
            color.RemoveAllPoints()
            color.AddRGBPoint(0.1, 1, 0, 0)
            color.AddRGBPoint(1.9, 0, 0, 1)
            color.SetScaleToLog10()

        def bent(color):
            color.AddRGBPoint(0.45, 1, 1, 0, 0.2, 0.6)

        for change in (logarithmic, bent, lambda color: color.SetColorSpaceToHSV(), lambda color: color.SetColorSpaceToLab(),
                       lambda color: color.SetColorSpaceToDiverging(), lambda color: color.ClampingOff()):
            prop = property_of()
            change(prop.GetRGBTransferFunction())
            dense = self.same_in_small_steps(prop.GetRGBTransferFunction())
            drawn = Scene(self.image, prop).draw()
            prop.SetColor(dense)
            self.assert_like(drawn, Scene(self.image, prop).draw(), 3.0)

    def same_in_small_steps(self, function):
        dense = vtkColorTransferFunction()
        for x in np.linspace(0, 1.9, 800):
            dense.AddRGBPoint(x, *function.GetColor(x))
        return dense

    def test_gray(self):
        prop = property_of()
        gray = vtkPiecewiseFunction()
        gray.AddPoint(0.2, 0, 0.3, 0.5)
        gray.AddPoint(0.9, 1)
        prop.SetColor(gray)
        drawn = Scene(self.image, prop).draw()
        self.assertLess(np.ptp(drawn[HEIGHT // 2, WIDTH // 2]), 2)
        color = vtkColorTransferFunction()
        for x in np.linspace(0, 1, 400):
            color.AddRGBPoint(x, *[gray.GetValue(x)] * 3)
        prop.SetColor(color)
        self.assert_like(drawn, Scene(self.image, prop).draw(), 3.0)


class Parts(MapperCase):
    def test_parts_join(self):
        """At a sample, and between two."""
        scene = Scene(self.image, property_of(opacities=FOG))
        scene.mapper.ImageSheetsOn()
        self.assert_parts_join(scene, (7.4, 12))


class Errors(MapperCase):
    def test_no_input(self):
        self.assert_error(Scene(vtkImageData(), property_of()), "empty")
        depths = vtkImageData()
        Scene(self.image, property_of()).mapper.GetDepthImage(depths)  # before the first frame
        self.assertEqual(depths.GetNumberOfPoints(), 0)

    def test_no_finite_value(self):
        image, _ = image_of(np.full((4, 4, 4), np.nan, np.float32))
        self.assert_error(Scene(image, property_of(), position=(2, 2, 20), focal_point=(2, 2, 2)), "values", "finite")

    def test_missing_array(self):
        scene = Scene(self.image, property_of())
        scene.mapper.SetScalarModeToUsePointFieldData()
        scene.mapper.SelectScalarArray("pressure")
        self.assert_error(scene, "'pressure'", "values")
        image = vtkImageData()
        image.SetDimensions(4, 4, 4)
        self.assert_error(Scene(image, property_of(), position=(2, 2, 20), focal_point=(2, 2, 2)), "no scalars")

    def test_no_property(self):
        """VTK makes one: an opaque volume, all in black and white."""
        scene = Scene(self.image, None)
        self.assert_shows(scene.draw())
        self.assertEqual(scene.errors, [])

    def test_a_good_frame_follows(self):
        scene = Scene(self.image, property_of())
        good = scene.draw()
        scene.mapper.SetBlendModeToSlice()
        scene.draw()
        self.assertEqual(len(scene.errors), 1)
        scene.mapper.SetBlendModeToComposite()
        self.assert_like(scene.draw(), good, EXACT)

    def test_degenerate_matrix(self):
        scene = Scene(self.image, property_of())
        scene.volume.SetScale(1, 1, 1e-300)
        scene.draw()
        self.assertEqual(len(scene.errors), 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
