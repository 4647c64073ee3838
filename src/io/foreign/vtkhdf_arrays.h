// SPDX-License-Identifier: Apache-2.0
// What the readers of VTKHDF's kinds of data have in common: which arrays are read, and the grids
// that come out.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "io/core/samples.h"
#include "io/foreign/vtkhdf_group.h"
#include "io/foreign/vtkhdf_steps.h"
#include "io/meshes/amr_boxes.h"
#include "io/meshes/lattice_set.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// What is read, and where what is left out is told.
struct VtkHdfRead {
  std::int64_t step = 0;
  std::string array;  // this one alone, if a group has it; "": all
  ReadProgress* progress = nullptr;
  std::vector<std::string>* notes = nullptr;
};

// What a group of a simple type holds: one of these.
struct VtkHdfContent {
  std::vector<LatticePart> lattices;
  std::vector<MeshPart> meshes;
  std::vector<AmrGrid> grids;
};

// Reads the arrays of `owner`'s group `name`, PointData or CellData, by `rows(name, array)`, which
// sets all but the name. Arrays that hold no numbers, or are stored in a way that is not read, are
// left out with a note.
std::vector<DataArray> read_vtkhdf_arrays(
    const VtkHdfGroup& owner, const char* name, bool is_cell_data, const VtkHdfRead& read,
    const std::function<DataArray(const std::string& name, const VtkHdfArray& array)>& rows);

// UnstructuredGrid and PolyData: the parts of a step. In vtkhdf_mesh.cpp.
std::vector<MeshPart> read_vtkhdf_mesh(const VtkHdfGroup& group, bool is_surface,
                                       const VtkHdfSteps& steps, const VtkHdfRead& read);

// ImageData. In vtkhdf_image.cpp.
LatticePart read_vtkhdf_image(const VtkHdfGroup& group, const VtkHdfSteps& steps,
                              const VtkHdfRead& read);

// OverlappingAMR. In vtkhdf_amr.cpp.
std::vector<AmrGrid> read_vtkhdf_amr(const VtkHdfGroup& group, const VtkHdfSteps& steps,
                                     const VtkHdfRead& read);

}  // namespace ovoid::io
