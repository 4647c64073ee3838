// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// What a header tells of a file at little cost.
struct StepOutline {
  std::vector<DatasetKind> kinds;   // that it may hold; empty: any
  std::vector<std::int64_t> sizes;  // as the format orders them; empty: not known
  std::vector<double> spacings;     // of as many axes, or their vectors; empty: not known
};

// By format. Throw Error for a header that cannot be read.
StepOutline outline_of_nrrd(const ByteSource& source);
StepOutline outline_of_nifti(const ByteSource& source);
StepOutline outline_of_metaimage(const ByteSource& source);
StepOutline outline_of_npy(const ByteSource& source);
StepOutline outline_of_vtk_xml(const ByteSource& source);
StepOutline outline_of_legacy_vtk(const ByteSource& source);

// Throws Error(kInvalidArgument) naming both files and what differs if their headers alone show
// that they are no steps of one dataset: another kind of data, other dimensions, other spacings. Of
// each file the header is read, of most formats 512 bytes; what cannot be told so cheaply, or is
// broken, is left to the reader of the whole, and to Series.
void check_step_outlines(const std::string& first, const std::vector<std::string>& others);

}  // namespace ovoid::io
