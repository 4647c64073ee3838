// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Files that are the time steps of one volume, in the order given, one each: reads the one that
// options.step says, or the first whose array varies, and no other. That all are there is looked at
// first, and what their headers tell of kind, dimensions and spacings (check_step_outlines): of all
// files if step 0 or none is asked for, else of that step and the first. Throws Error.
// Files of a format that sorts its inputs are its reader's.
Dataset read_step_files(const std::vector<std::string>& paths, const ReadOptions& options);

// The step that options.step says, or the first whose array varies, of steps that `read` reads one
// at a time, with options that say no step. `name`: of all, for messages. Throws Error.
Dataset read_one_step(
    const std::string& name, std::int64_t num_steps, const ReadOptions& options,
    const std::function<Dataset(std::int64_t step, const ReadOptions& own)>& read);

}  // namespace ovoid::io
