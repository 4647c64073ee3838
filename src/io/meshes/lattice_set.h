// SPDX-License-Identifier: Apache-2.0
// Several lattices that a file calls parts of one thing: the blocks that the processes of a
// simulation have written, or the grids of adaptive levels.
#pragma once

#include <string>
#include <vector>

#include "io/meshes/amr_boxes.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// Cartesian. The arrays have a tuple per sample, or per cell between samples; an axis of one sample
// has one cell.
struct LatticePart {
  std::string block;  // what ReadOptions::block calls it
  LatticeGeometry lattice;
  std::vector<DataArray> arrays;
};

// One lattice, if the parts lie in one and fill it (where they overlap the later one counts); else
// boxes, if they have arrays of cells or overlap with different spacings: finer ones cover coarser
// ones, and arrays of samples become the means of each cell's corners, with a note; else a mesh.
// `dataset` has source, format and notes; blocks are those of mesh_of_parts(). Throws Error:
// kInvalidArgument for an unknown block or array; kFileFormat if there is no array that all have,
// or parts differ in its type; kUnsupported for boxes that do not run along the world's axes.
Dataset dataset_of_lattices(Dataset dataset, std::vector<LatticePart> parts,
                            const ReadOptions& options);

// A lattice as a structured mesh.
MeshPart mesh_part_of(LatticePart part);

// A lattice of samples as a grid of the cells between them, which runs along the world's axes. Of
// arrays of samples each cell has the mean of its corners.
AmrGrid amr_grid_of_lattice(const std::string& source, int level, const LatticePart& part);

}  // namespace ovoid::io
