// SPDX-License-Identifier: Apache-2.0
// One uniform grid of an XDMF file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/meshes/mesh_parts.h"
#include "io/xdmf/xdmf_items.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

struct XdmfGrid {
  std::optional<LatticeGeometry> lattice;  // of equal spacing; else `part` has nodes and cells
  MeshPart part;                           // its arrays are the lattice's, too
};

// Topology, geometry and attributes: the one called `array` alone if there is one. `notes` gets
// what is left out. Throws Error naming the element.
XdmfGrid read_xdmf_grid(const XdmfTree& tree, const XdmfItems& items, XdmfNode grid,
                        const std::string& array, std::vector<std::string>& notes);

}  // namespace ovoid::io
