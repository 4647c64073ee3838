// SPDX-License-Identifier: Apache-2.0
// Subdivision solids: a coarse mesh of hexahedra with a density at each vertex stands for a smooth
// solid, which is drawn as a sum of kernels, one or two at each vertex of a level.
// docs/numerics.md, "Subdivision solids", is the definition. [McDonnell 2004, Neophytou 2006]
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/export.h"
#include "ovoid/kernel_field.h"

namespace OVOID_API ovoid {

// Hexahedra and what their vertices carry: a control mesh, or a level of its subdivision. Cells
// that share four vertices are neighbours; a vertex of no cell is not allowed.
struct SolidMesh {
  std::vector<double> positions;  // [num_vertices, 3] x y z, world units, finite
  std::vector<double> densities;  // [num_vertices] finite, of any sign
  // [num_cells] vertices; corner c lies at (c & 1, c >> 1 & 1, c >> 2) of the cell's cube, the
  // order of VTK's voxels.
  std::vector<std::array<std::uint32_t, 8>> cells;
  std::string name = "density";  // of the densities
  std::string unit;              // empty if unknown

  std::size_t num_vertices() const noexcept { return densities.size(); }
  Vec3 position(std::size_t vertex) const noexcept {
    return {positions[3 * vertex], positions[3 * vertex + 1], positions[3 * vertex + 2]};
  }
};

// Throws Error(kInvalidArgument) that names vertex or cell: lengths that do not agree, no cells,
// numbers that are not finite, cells whose vertices do not exist or are the same, vertices of no
// cell, a face of three cells or with other edges in one than in the other, and a corner whose
// edges do not turn the way those of the mesh do on the whole (a cell inside out, or flat).
void check_solid_mesh(const SolidMesh& mesh);

// What of a dataset becomes densities.
struct ControlMeshOptions {
  std::string array{};  // of values per node; empty: Dataset::array()'s default
  int component = 0;    // of its tuples; LatticeModelOptions::kMagnitude: the norm
};

// The hexahedra of a mesh file as a control mesh. Nodes at one place are one vertex, with the
// density of the first; nodes of no cell are left out, and vertices are counted without them.
// Throws Error(kInvalidArgument) that names cell, node or array: a dataset that is no mesh, cells
// that are no hexahedra of 8 nodes, values per cell, missing values, and what check_solid_mesh()
// throws.
SolidMesh make_control_mesh(const Dataset& mesh, const ControlMeshOptions& options = {});

// The control mesh of `ovoid make solid`: a star of five arms, two cells thick, that curls. An edge
// in its middle has five cells around it, ten at the roots of its arms have three.
SolidMesh make_sample_control_mesh();

// A solid mesh as a dataset of kind kMesh, for files: float64 positions, the densities as the one
// array, hexahedra.
Dataset make_solid_dataset(const SolidMesh& mesh);

struct SubdivisionOptions {
  int levels = 1;  // 0 to kMostLevels; each makes eight cells of one
  // Bytes that the level and what is made of it may take, as bytes_of_level() tells; 0: no limit.
  std::size_t memory_limit = 0;
  int threads = 0;  // 0: one per hardware thread
  std::stop_token stop{};

  static constexpr int kMostLevels = 8;
};

// The control mesh after `levels` steps of interpolatory subdivision: vertices stay where they are,
// with their densities, and come first; then new ones of edges, faces and cells. Where the mesh is
// regular a new vertex is that of the 4-point scheme along each axis, -1/16, 9/16, 9/16, -1/16.
// Positions and densities go through the same weights, so that a density which is a linear function
// of the place stays that function. The same bytes for any number of threads. Throws Error: what
// check_solid_mesh() throws; kInvalidArgument for `levels`; kOutOfMemory for more than
// `memory_limit` or 2^32 vertices, before any work; kCancelled. Cost: about a microsecond of one
// thread per new vertex.
SolidMesh subdivide_solid(const SolidMesh& control, const SubdivisionOptions& options = {});

// Bytes, about, that a level (>= 0) of a control mesh takes together with its kernels.
std::size_t bytes_of_level(const SolidMesh& control, int levels) noexcept;

// The kernels that stand for the basis function of a vertex.
enum class SolidBasis {
  // One Gaussian, with values such that the field takes the vertices' densities at the vertices:
  // what then stands for the basis comes within 11 % of it.
  kInterpolating,
  // One Gaussian, the least-squares fit; the value is the density. Comes within 20 % of the basis,
  // and reproduces the constant 1 as 1.35.
  kOneGaussian,
  // Two, of opposite sign, of all that reproduce constants the least-squares fit; values are
  // multiples of the density. Within 14 %.
  kTwoGaussians,
};

const char* name_of(SolidBasis basis) noexcept;  // "interpolating", "one", "two"

// `height` exp(-falloff r^2), r in edges of a cell.
struct BasisGaussian {
  double height = 1, falloff = 2;
};

// The Gaussians of a vertex of density 1; of kInterpolating before values are worked out.
std::span<const BasisGaussian> gaussians_of(SolidBasis basis) noexcept;

struct SolidFieldOptions {
  SolidBasis basis = SolidBasis::kInterpolating;
  double cutoff = 4.0;  // sigmas, in [1, KernelColumns::kMaxCutoff]
  int threads = 0;      // 0: one per hardware thread
  std::stop_token stop{};
};

// The kernels of a level, `sum`: Gaussians at its vertices, mapped by the local frame of the cells
// around, S = J S0 J^T. Values may be negative, weights are positive. Does not depend on the number
// of threads. Throws Error: what check_solid_mesh() throws, but that cells of a level may be turned
// or flat; kInvalidArgument for `cutoff`; kCancelled; kOutOfMemory. Cost: some microseconds of one
// thread per vertex, of kInterpolating some tens.
KernelField make_solid_field(const SolidMesh& level, const SolidFieldOptions& options = {});

}  // namespace ovoid
