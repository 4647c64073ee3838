// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/shared_layers.h"

#include "data/lattice/paged_lattice.h"

namespace ovoid::data {

SharedLayers shared_layers(const BrickSource& source) {
  const auto* const paged = dynamic_cast<const PagedLattice*>(&source);
  return paged != nullptr ? paged->layers() : SharedLayers{0, source.geometry().dims[2], nullptr};
}

}  // namespace ovoid::data
