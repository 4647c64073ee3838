// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

// The time that a file of one step names, from its first lines. None if its format has none, or it
// is not there. It need not be finite. Throws what reading throws.
std::optional<double> named_time(const ByteSource& source);

// By format: the field data TimeValue, the time step.
std::optional<double> time_of_vtk_xml(const ByteSource& source);
std::optional<double> time_of_dump(const ByteSource& source);

// Throws Error(kFileFormat) naming the step unless the times are finite and rise. `files`: of the
// steps, one each, or the one of all.
void check_step_times(const std::vector<std::string>& files, const std::vector<double>& times);

}  // namespace ovoid::io
