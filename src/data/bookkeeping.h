// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ovoid/dataset.h"

namespace ovoid::data {

// Arrays that programs leave beside the data: VTK's (vtkGhostType, vtkValidPointMask), and numbers
// of nodes, cells and blocks (GlobalNodeId, ObjectId and their like).
bool is_bookkeeping(const DataArray& array);

// The same, knowing what the array is of: numbers and kinds of particles ("id", "type", ...) in
// what is no lattice, particles' places once more, and the shapes of stored kernels.
bool is_bookkeeping(const Dataset& dataset, const DataArray& array);

// One of three columns that hold a vector, as vx does beside vy and vz: says little by itself.
bool is_part_of_vector(const Dataset& dataset, const DataArray& array);

// What most people look at first, by its name.
bool is_density(const DataArray& array);

// Should this time step be the one that is shown without a choice? True if the array `name` varies
// in it; without a name, if some array varies that is not bookkeeping, of nodes if any such array
// is of nodes. Throws as Dataset::array does.
bool is_worth_showing(const Dataset& dataset, const std::string& name);

}  // namespace ovoid::data
