// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

// The time that a file of one step names, from its first lines: the field data TimeValue of VTK's
// XML files, the time step of a LAMMPS dump. None if it names none, or not there. It need not be
// finite. Throws what reading throws.
std::optional<double> named_time(const ByteSource& source);

// Throws Error(kFileFormat) naming the step unless the times are finite and rise. `files`: of the
// steps, one each, or the one of all.
void check_step_times(const std::vector<std::string>& files, const std::vector<double>& times);

}  // namespace ovoid::io
