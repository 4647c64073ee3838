// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "ovoid/dataset.h"

namespace ovoid::data {

// Of a series that nobody chose a step of: reads one after the other until one is worth showing
// (data/bookkeeping.h) by its array `array`, and notes which it is; of none that is, the first
// again. `name`: of the series, for the note; empty: the step's own source.
Dataset shown_step(const std::string& name, std::int64_t num_steps, const std::string& array,
                   const std::function<Dataset(std::int64_t step)>& read);

// Which step was chosen, for Dataset::notes.
std::string chosen_step_note(const std::string& name, std::int64_t step, std::int64_t num_steps);

}  // namespace ovoid::data
