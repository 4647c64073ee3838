// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace ovoid::io {

// Throws Error(kInvalidArgument) naming both files and what differs if their headers alone show
// that they are no steps of one dataset: another kind of data, other dimensions, other spacings. Of
// each file the header is read, of most formats 512 bytes; what cannot be told so cheaply, or is
// broken, is left to the reader of the whole, and to Series.
void check_step_outlines(const std::string& first, const std::vector<std::string>& others);

}  // namespace ovoid::io
