// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"
#include "ovoid/math.h"
#include "vtk_arrays.h"

class vtkPointSet;

namespace ovoid::mappers {

// A vtkPointSet with the one array that is drawn, as its files are read: a mesh, or, where no cell
// encloses anything (points, vertices, lines and polygons of vtkPolyData), particles, or, of voxels
// with data at cells, the boxes of an adaptive grid. Hidden and
// duplicate cells are left out. `world_from_data` moves the points; the identity shares them.
// Values are shared, but those of cells where some are left out. Throws Error: kInvalidArgument for
// an empty set, cells that contradict themselves, and a mesh without an array.
Dataset point_set_dataset(vtkPointSet* points, const DrawnValues& drawn,
                          const Affine3& world_from_data);

}  // namespace ovoid::mappers
