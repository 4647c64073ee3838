// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Reads options.step, or the first of `num_steps` whose array varies (data::is_worth_showing),
// which is told in a note; the first if none does. `read` reads one step. Sets num_steps, step and
// times; `times` may be empty. `name` is the input, for messages. Throws Error
// (kInvalidArgument) for a step that is not there, (kFileFormat) if there is none, kCancelled.
Dataset read_mesh_step(const std::string& name, std::int64_t num_steps,
                       const std::vector<double>& times, const ReadOptions& options,
                       const std::function<Dataset(std::int64_t step)>& read);

}  // namespace ovoid::io
