// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ovoid/dataset.h"
#include "ovoid/math.h"
#include "vtk_arrays.h"

class vtkDataSet;

namespace ovoid::mappers {

// A vtkImageData or a vtkRectilinearGrid with the one array that is drawn, as its files are read: a
// lattice; a rectilinear grid whose spacing varies, a mesh of its cells. Values are shared, but
// where points or cells are blanked, whose values are missing. `world_from_data` moves a mesh; a
// lattice stays in the data's own coordinates. Throws Error: kInvalidArgument for
// an empty grid, kUnsupported for other data.
Dataset grid_dataset(vtkDataSet* grid, const DrawnValues& drawn, const Affine3& world_from_data);

}  // namespace ovoid::mappers
