// SPDX-License-Identifier: Apache-2.0
// XDMF's topologies of cells.
#pragma once

#include <cstdint>
#include <string>

#include "io/xdmf/xdmf_items.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// "3DSMesh", "2DCoRectMesh" and their like: what they are, the geometry says.
bool is_xdmf_structured(const std::string& type);

// Are there no cells: Polyvertex without node numbers, or NoTopology?
bool is_xdmf_points(const XdmfTree& tree, XdmfNode topology);

// The cells of an unstructured topology of `num_nodes` nodes. Throws Error naming it: kFileFormat,
// kUnsupported for a kind of cells that is not known.
Cells read_xdmf_cells(const XdmfTree& tree, const XdmfItems& items, XdmfNode topology,
                      std::int64_t num_nodes);

// The name of a topology's or geometry's kind, in small letters.
std::string xdmf_topology_type(const XdmfTree& tree, XdmfNode topology);

}  // namespace ovoid::io
