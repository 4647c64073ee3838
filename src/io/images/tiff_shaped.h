// SPDX-License-Identifier: Apache-2.0
// tifffile's description of the arrays that it writes: a JSON object with their shape,
// their axes and what its caller has added: spacing, unit, times.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/images/tiff_description.h"
#include "io/images/tiff_file.h"

namespace ovoid::io {

// The series of a file whose first page is described so, one behind the other; none for other
// files. Pages that are no planes of (y, x) have TiffStack::order. Where shape and pages contradict
// each other the pages are slices, and a note of the stack says so. Throws Error(kUnsupported) for
// more axes than there are letters for.
std::vector<TiffStack> shaped_stacks(const TiffFile& file);

// Letters (io/core/axis_order.h) for axes whose names are not known, '?' in `letters`: time,
// channels and z, the slowest first, as far as they are free; passed where there is one sample.
// False if there are too few.
bool name_unknown_axes(const std::vector<std::int64_t>& shape, std::string* letters);

}  // namespace ovoid::io
