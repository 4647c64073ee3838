// SPDX-License-Identifier: Apache-2.0
#include "model/coarse_field.h"

#include <fmt/format.h>

#include <cmath>
#include <new>

#include "data/parallel.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {

Field coarse_field(const Field& field, const CoarseOptions& options) {
  data::require_field(field);
  if (!(options.length >= 0) || !std::isfinite(options.length)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("length = {}: must be >= 0 and finite", options.length));
  }
  data::resolve_threads(options.threads);
  try {
    if (const KernelField* const set = field.kernels()) return model::coarse_kernels(*set, options);
    return model::coarse_lattice(*field.lattice(), options);
  } catch (const std::bad_alloc&) {
    throw Error(
        ErrorCode::kOutOfMemory,
        fmt::format("coarse field: no memory for an eighth of {} kernels", field.num_kernels()));
  }
}

}  // namespace ovoid
