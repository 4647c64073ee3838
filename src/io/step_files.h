// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Files that are the time steps of one volume, in the order given, one each: reads the one that
// options.step says, or the first whose array varies, and no other. That all are there is looked at
// first; that they have the same lattice is not, since they are not read. Throws Error.
Dataset read_step_files(const std::vector<std::string>& paths, const ReadOptions& options);

}  // namespace ovoid::io
