// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/mesh_steps.h"

#include <fmt/format.h>

#include "data/bookkeeping.h"
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
  for (std::int64_t step = 0; step < num_steps; ++step) {
    if (options.stop.stop_requested())
      throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
    Dataset dataset = read(step);
    if (!data::is_worth_showing(dataset, options.array)) continue;
    if (num_steps > 1) dataset.notes.push_back(chosen_step_note(name, step, num_steps));
    return finish(std::move(dataset), step);
  }
  return finish(read(0), 0);
}

}  // namespace ovoid::io
