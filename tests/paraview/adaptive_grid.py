# SPDX-License-Identifier: Apache-2.0
"""Writes an adaptive grid of two levels, for ranks to read: pvpython adaptive_grid.py OUT.vthb."""
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkAMRBox, vtkOverlappingAMR, vtkUniformGrid
from vtkmodules.vtkIOXML import vtkXMLUniformGridAMRWriter

SIDE = 8  # cells of a grid along each axis
ORIGIN = -16.0


def grid_at(first, spacing):
    """Of a level: `first` is its first cell along each axis."""
    grid = vtkUniformGrid()
    origin = [ORIGIN + spacing * cell for cell in first]
    grid.SetOrigin(*origin)
    grid.SetSpacing(spacing, spacing, spacing)
    grid.SetDimensions(SIDE + 1, SIDE + 1, SIDE + 1)
    z, y, x = np.meshgrid(*[start + spacing * (np.arange(SIDE) + 0.5) for start in reversed(origin)], indexing="ij")
    values = np.exp(-(x * x + y * y + z * z) / 128) + 0.2 * np.sin(0.5 * x) * np.cos(0.4 * y + 0.3 * z)
    array = numpy_to_vtk(values.ravel(), deep=1)
    array.SetName("RTData")
    grid.GetCellData().AddArray(array)
    return grid


def main(path):
    """Eight grids of cells 2 wide; in the middle eight of cells 1 wide."""
    adaptive = vtkOverlappingAMR()
    adaptive.Initialize(2, [8, 8])
    adaptive.SetOrigin([ORIGIN] * 3)
    adaptive.SetGridDescription(8)  # VTK_XYZ_GRID
    for level, (spacing, start) in enumerate([(2.0, 0), (1.0, 8)]):
        adaptive.SetSpacing(level, [spacing] * 3)
        for number in range(8):
            first = [start + SIDE * (number >> axis & 1) for axis in range(3)]
            adaptive.SetAMRBox(level, number, vtkAMRBox(first, [cell + SIDE - 1 for cell in first]))
            adaptive.SetDataSet(level, number, grid_at(first, spacing))
    for level in range(2):
        adaptive.SetRefinementRatio(level, 2)
    adaptive.GenerateParentChildInformation()
    writer = vtkXMLUniformGridAMRWriter()
    writer.SetFileName(path)
    writer.SetInputData(adaptive)
    writer.Write()


if __name__ == "__main__":
    main(sys.argv[1])
