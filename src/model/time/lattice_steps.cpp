// SPDX-License-Identifier: Apache-2.0
#include "model/time/lattice_steps.h"

#include <fmt/format.h>

#include "ovoid/error.h"

namespace ovoid::model {

Dataset LatticeSteps::read(std::int64_t step, std::stop_token stop) const {
  if (step < 0 || step >= num_steps()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: step {}: expected 0 to {}", name_, step, num_steps() - 1));
  }
  LatticeGeometry lattice = lattice_;
  if (kind_ == SeriesKind::kStaggered && step % 2 == 1)
    lattice.world_from_index.translate(Vec3::Constant(0.5));
  Dataset dataset = make(step, lattice, stop);
  dataset.lattice = lattice;
  dataset.num_steps = num_steps();
  dataset.step = step;
  dataset.times = times_;
  dataset.series = kind_;
  return dataset;
}

}  // namespace ovoid::model
