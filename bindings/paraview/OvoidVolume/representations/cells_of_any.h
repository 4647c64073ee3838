// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkSmartPointer.h>

class vtkDataObject;
class vtkUnstructuredGrid;

namespace ovoid::paraview {

// Data of other kinds as cells, with all arrays that every part has: an adaptive grid's finest
// cells as voxels, points as vertices, a structured grid's cells; of vtkCompositeDataSet the parts
// of these kinds. Null for a vtkUnstructuredGrid and what consists of them, which are cells as they
// are. Cells that VTK hides, and those that another piece has, too, are left out of adaptive grids.
vtkSmartPointer<vtkUnstructuredGrid> cells_of_any(vtkDataObject* data);

}  // namespace ovoid::paraview
