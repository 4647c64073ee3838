#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""vtkOvoidUnstructuredGridVolumeMapper draws what `ovoid render` draws of the same meshes and particles."""
import unittest

import numpy as np
from mapper_case import EXACT, TRANSLUCENT, MapperCase
from ovoid_vtk.vtkOvoid import vtkOvoidUnstructuredGridVolumeMapper
from scene import BACKGROUND, FOG, HEIGHT, WIDTH, Scene, bumps, image_of, over, property_of, rendered
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, VTK_WEDGE, vtkDataSetAttributes, vtkPolyData, vtkStructuredGrid, vtkUnstructuredGrid
from vtkmodules.vtkFiltersCore import vtkAppendFilter, vtkCellCenters, vtkPointDataToCellData
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter
from vtkmodules.vtkFiltersSources import vtkPlaneSource

COARSE = 9


def tetrahedra(side=COARSE):
    image, _ = image_of(bumps(side), spacing=[24 / (side - 1)] * 3)
    split = vtkDataSetTriangleFilter()
    split.SetInputData(image)
    split.Update()
    return split.GetOutput()


def hexahedra(side=COARSE):
    append = vtkAppendFilter()
    append.AddInputData(image_of(bumps(side), spacing=[24 / (side - 1)] * 3)[0])
    append.Update()
    return append.GetOutput()


def with_wedges(grid):
    """Every second hexahedron as two wedges."""
    mixed = vtkUnstructuredGrid()
    mixed.SetPoints(grid.GetPoints())
    mixed.GetPointData().SetScalars(grid.GetPointData().GetScalars())
    for c in range(grid.GetNumberOfCells()):
        ids = [grid.GetCell(c).GetPointId(i) for i in range(8)]
        ids = [ids[i] for i in (0, 1, 3, 2, 4, 5, 7, 6)] if grid.GetCellType(c) == 11 else ids  # a voxel's order
        if c % 2:
            mixed.InsertNextCell(VTK_HEXAHEDRON, 8, ids)
        else:
            for wedge in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)):
                mixed.InsertNextCell(VTK_WEDGE, 6, [ids[i] for i in wedge])
    return mixed


class MeshCase(MapperCase):
    def scene(self, data, prop=None):
        return Scene(data, prop or property_of(), vtkOvoidUnstructuredGridVolumeMapper())

    def assert_drawn(self, data, *flags, bound=EXACT, prop=None):
        self.assert_like_program(self.scene(data, prop), *flags, data=data, bound=bound)


class Pictures(MeshCase):
    def test_tetrahedra(self):
        self.assert_drawn(tetrahedra())

    def test_translucent(self):
        self.assert_drawn(tetrahedra(), bound=TRANSLUCENT, prop=property_of(opacities=FOG, shade=False))

    def test_cells_of_several_kinds(self):
        self.assert_drawn(with_wedges(hexahedra()))

    def test_gradient_opacity(self):
        """Its length is the kernels' distance, which is the grid's."""
        prop = property_of(opacities=FOG)
        prop.GetGradientOpacity().RemoveAllPoints()
        prop.GetGradientOpacity().AddPoint(0.05, 0)
        prop.GetGradientOpacity().AddPoint(0.3, 1)
        scene = self.scene(tetrahedra(), prop)
        with_it = scene.draw()
        prop.DisableGradientOpacityOn()
        self.assertGreater(np.abs(scene.draw() - with_it).max(), 10)

    def test_cell_data(self):
        to_cells = vtkPointDataToCellData()
        to_cells.SetInputData(tetrahedra())
        to_cells.Update()
        grid = to_cells.GetOutput()
        grid.GetCellData().SetActiveScalars("values")
        self.assert_drawn(grid)

    def test_structured_grid(self):
        points = vtkPoints()
        points.SetData(numpy_to_vtk(vtk_to_numpy(hexahedra().GetPoints().GetData()), deep=1))
        grid = vtkStructuredGrid()
        grid.SetDimensions(COARSE, COARSE, COARSE)
        grid.SetPoints(points)
        grid.GetPointData().SetScalars(hexahedra().GetPointData().GetScalars())
        drawn = self.scene(grid).draw()
        self.assert_shows(drawn)
        self.assert_like(drawn, self.scene(hexahedra()).draw(), EXACT)

    def test_hidden_cells(self):
        grid = tetrahedra()
        flags = np.zeros(grid.GetNumberOfCells(), np.uint8)
        flags[grid.GetNumberOfCells() // 2:] = vtkDataSetAttributes.HIDDENCELL
        ghosts = numpy_to_vtk(flags, deep=1)
        ghosts.SetName(vtkDataSetAttributes.GhostArrayName())
        grid.GetCellData().AddArray(ghosts)
        self.assert_drawn(grid, "--array", "values")

    def test_particles(self):
        """A cloud of points with values at them, without cells, and with vertices."""
        random = np.random.default_rng(7)
        points = vtkPoints()
        points.SetData(numpy_to_vtk(random.uniform(0, 24, (1500, 3)), deep=1))
        values = numpy_to_vtk(random.uniform(0, 1.9, 1500).astype(np.float32), deep=1)
        values.SetName("values")
        cloud = vtkPolyData()
        cloud.SetPoints(points)
        cloud.GetPointData().SetScalars(values)
        self.assert_drawn(cloud)
        centers = vtkCellCenters()
        centers.VertexCellsOn()
        centers.SetInputData(tetrahedra())
        centers.Update()
        of_cells = centers.GetOutput()
        of_cells.GetPointData().SetScalars(numpy_to_vtk(np.linspace(0, 1.9, of_cells.GetNumberOfPoints()), deep=1))
        self.assert_shows(self.scene(of_cells).draw())

    def test_particles_without_values(self):
        """Their density, as the program draws it."""
        points = vtkPoints()
        points.SetData(numpy_to_vtk(np.random.default_rng(7).normal(12, 4, (1500, 3)), deep=1))
        cloud = vtkPolyData()
        cloud.SetPoints(points)
        self.assert_drawn(cloud, prop=property_of(opacities=[(0.2, 0), (0.8, 0.5)]))

    def test_maximum(self):
        scene = self.scene(tetrahedra(), property_of(opacities=[(0.5, 0), (1.9, 1)], shade=False))
        scene.mapper.SetBlendModeToMaximumIntensity()
        self.assert_like_program(scene, "--mode", "maximum", data=tetrahedra(), bound=TRANSLUCENT, has_unit=False)

    def test_plane_half_inside(self):
        """Limits of the mesh's own boundary and of the scene, together."""
        grid = tetrahedra()
        scene = Scene(grid, property_of(opacities=FOG, shade=False), vtkOvoidUnstructuredGridVolumeMapper(), position=(12, 12, 90))
        plane = vtkPlaneSource()
        plane.SetOrigin(-99, -99, 10.3)
        plane.SetPoint1(99, -99, 10.3)
        plane.SetPoint2(-99, 99, 10.3)
        scene.add_actor(plane, color=(1, 0.4, 0))
        drawn = scene.draw()
        self.assertEqual(scene.errors, [])
        expected = over(rendered(grid, scene, "--clip", "0,0,1,10.3"), (1, 0.4, 0))
        # A limit and a clip plane treat a piece of a ray that has one defined end differently: at outlines.
        self.assertLess((np.abs(drawn - expected) > TRANSLUCENT).mean(), 0.002)
        self.assert_like(drawn, expected, 4 * TRANSLUCENT)

    def test_matrix(self):
        grid = tetrahedra()
        scene = self.scene(grid)
        scene.volume.SetScale(1, 0.8, 1.2)
        scene.volume.RotateX(20)
        made = vtkUnstructuredGrid()
        made.DeepCopy(grid)
        matrix = np.array([[scene.volume.GetMatrix().GetElement(i, k) for k in range(4)] for i in range(4)])
        places = vtk_to_numpy(grid.GetPoints().GetData()) @ matrix[:3, :3].T + matrix[:3, 3]
        points = vtkPoints()
        points.SetData(numpy_to_vtk(places, deep=1))
        made.SetPoints(points)
        self.assert_like_program(scene, data=made)


class Changes(MeshCase):
    def test_what_makes_kernels_anew(self):
        grid = tetrahedra()
        scene = self.scene(grid)
        scene.draw()
        made = scene.mapper.GetFieldTime()
        scene.camera.Azimuth(20)
        scene.volume.SetProperty(property_of(opacities=FOG))
        grid.Modified()
        scene.draw()
        self.assertEqual(scene.mapper.GetFieldTime(), made)
        for change in (grid.GetPointData().GetScalars().Modified, grid.GetPoints().Modified, lambda: scene.volume.SetScale(2, 1, 1)):
            change()
            scene.draw()
            self.assertGreater(scene.mapper.GetFieldTime(), made)
            made = scene.mapper.GetFieldTime()
        self.assertEqual(scene.errors, [])


class Parts(MeshCase):
    def test_parts_join(self):
        self.assert_parts_join(self.scene(tetrahedra(), property_of(opacities=FOG)), (7.4, 12))

    def test_parts_sum_up(self):
        """The distance of sheets is that of the whole, whatever the parts are."""
        scene = self.scene(tetrahedra())
        self.assertTrue(scene.mapper.UpdateField(scene.volume))
        whole, sums, endless = scene.mapper.GetFieldSums(), np.zeros(5), float("inf")
        for lo, hi in ((-endless, 12), (12, endless)):
            scene.mapper.SetOwnedBounds(lo, hi, -endless, endless, -endless, endless)
            scene.mapper.UpdateField(scene.volume)
            sums += scene.mapper.GetFieldSums()
        np.testing.assert_allclose(sums, whole, rtol=1e-9)
        distance = scene.mapper.SampleDistanceOf(sums)
        self.assertGreater(distance, 0.2)
        self.assertLess(distance, 2)


class Errors(MeshCase):
    def test_wrong_kind(self):
        mapper = vtkOvoidUnstructuredGridVolumeMapper()
        errors = []

        def note(_object, _event, message):
            errors.append(message)
        note.CallDataType = "string0"
        mapper.AddObserver("ErrorEvent", note)
        mapper.SetInputData(image_of(bumps(4))[0])
        self.assertEqual(len(errors), 1)
        self.assertIn("vtkImageData", errors[0])

    def test_empty(self):
        self.assert_error(self.scene(vtkUnstructuredGrid()), "empty")

    def test_cells_that_contradict_themselves(self):
        grid = tetrahedra()
        grid.InsertNextCell(VTK_HEXAHEDRON, 4, [0, 1, 2, 3])
        self.assert_error(self.scene(grid), "cell", "8")
        grid = tetrahedra()
        grid.InsertNextCell(10, 4, [0, 1, 2, 10 ** 7])
        self.assert_error(self.scene(grid), "10000000")

    def test_no_finite_value(self):
        grid = tetrahedra()
        vtk_to_numpy(grid.GetPointData().GetScalars())[:] = np.nan
        scene = self.scene(grid)
        background = np.broadcast_to(255 * np.array(BACKGROUND), (HEIGHT, WIDTH, 3))
        self.assert_like(scene.draw(), background, EXACT)
        self.assertEqual(len(scene.errors), 1)

    def test_missing_array(self):
        grid = tetrahedra()
        grid.GetPointData().SetActiveScalars(None)
        self.assert_error(self.scene(grid), "no scalars")
        scene = self.scene(tetrahedra())
        scene.mapper.SetScalarModeToUseCellFieldData()
        scene.mapper.SelectScalarArray("pressure")
        self.assert_error(scene, "'pressure'", "values")


if __name__ == "__main__":
    unittest.main(verbosity=2)
