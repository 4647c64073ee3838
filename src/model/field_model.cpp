// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "ovoid/model.h"

namespace ovoid {

Field make_field(const Dataset& dataset, const FieldModelOptions& options, std::stop_token stop) {
  if (dataset.kind == DatasetKind::kLattice)
    return make_lattice_field(dataset, options.lattice, nullptr, std::move(stop));
  return make_kernel_field(dataset, options.kernels, nullptr, std::move(stop));
}

}  // namespace ovoid
