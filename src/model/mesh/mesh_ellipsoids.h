// SPDX-License-Identifier: Apache-2.0
// Shape and weight of a kernel from the cells around a node [Hong 2009].
#pragma once

#include <vector>

#include "model/mesh/ellipsoid_shape.h"
#include "model/mesh/mesh_cells.h"

namespace ovoid::model {

// Shapes. Neighbours n_i of node p at bisectors d_i = (n_i - p) / 2 give the covariance
// 3 sum w d d^T / sum w, then its volume is scaled to the node's own: det L = V / 8, as a lattice
// of cells V has it, sigma half the spacing, so that the many diagonals of tetrahedra do not make a
// kernel wide. The weights w:
//   - solids: each cell's corner counts its edges equally, by the cell's volume. A node on a face
//     has half as many corners along the face as inside and as many inwards, so that the missing
//     neighbours weigh as if they were mirrored. Nothing in it is bound to right angles or to equal
//     edges, and stretched cells keep their shape. (Weights by the area of the dual faces, from the
//     stiffness matrix of linear elements, were 0.8 to 1.5 dB worse on stretched tetrahedra: obtuse
//     ones spoil them.)
//   - surfaces and lines, where there are no solids: by the edge.
// V is the node's part of the cells' volumes (equal parts of each cell) over the share of the full
// solid angle that the cells fill: at a boundary, the volume that it would have inside.
//
// Weights, but for what the cut-off takes (ellipsoid_set.cpp). A full kernel has w = V / ((2
// pi)^(3/2) det L), a boundary one a share of that, which is also the sum of weights it is fitted
// to: the share of the solid angle, but at least kLeastShare, since a corner of a box fills only an
// eighth and the sum of weights must stay over KernelField::kLeastWeight there. The field so ends
// within about half a spacing outside the mesh.
inline constexpr double kLeastShare = 0.3;

// One per node; of nodes that another stands for, or that have no place, it means nothing.
std::vector<SiteKernel> node_kernels(const ModelRun& run, const MeshNodes& nodes,
                                     const MeshCells& cells, const CellMeasures& measures);

// Cell data: the kernel of a cell has the covariance of its nodes about their mean, scaled to the
// cell's volume: of a box, sigma is half the edge along each.
SiteKernel cell_kernel(const CellMoments& moments, double volume);

}  // namespace ovoid::model
