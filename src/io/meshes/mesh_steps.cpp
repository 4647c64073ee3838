// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_steps.h"

#include <fmt/format.h>

#include "data/shown_step.h"
#include "io/core/sample_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {

Dataset read_mesh_step(const std::string& name, std::int64_t num_steps,
                       const std::vector<double>& times, const ReadOptions& options,
                       const std::function<Dataset(std::int64_t step)>& read) {
  if (num_steps < 1)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: has no time steps", name));
  check_num_steps(name, num_steps);
  if (options.step) check_step(name, *options.step, num_steps);
  const auto finish = [&](Dataset dataset, std::int64_t step) {
    dataset.num_steps = num_steps;
    dataset.step = step;
    if (num_steps > 1 || !times.empty()) dataset.times = times;
    return dataset;
  };
  if (options.step) return finish(read(*options.step), *options.step);
  return data::shown_step(name, num_steps, options.array, [&](std::int64_t step) {
    if (options.stop.stop_requested())
      throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
    return finish(read(step), step);
  });
}

}  // namespace ovoid::io
