// SPDX-License-Identifier: Apache-2.0
#include "data/shown_step.h"

#include <fmt/format.h>

#include "data/bookkeeping.h"

namespace ovoid::data {

Dataset shown_step(const std::string& name, std::int64_t num_steps, const std::string& array,
                   const std::function<Dataset(std::int64_t step)>& read) {
  for (std::int64_t step = 0; step < num_steps; ++step) {
    Dataset dataset = read(step);
    if (!is_worth_showing(dataset, array)) continue;
    if (num_steps > 1) {
      dataset.notes.push_back(
          chosen_step_note(name.empty() ? dataset.source : name, step, num_steps));
    }
    return dataset;
  }
  return read(0);
}

std::string chosen_step_note(const std::string& name, std::int64_t step, std::int64_t num_steps) {
  return fmt::format("{}: step {} of {}, the first that varies; choose with --step", name, step,
                     num_steps);
}

}  // namespace ovoid::data
