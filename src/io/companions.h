// SPDX-License-Identifier: Apache-2.0
// The files that belong to the one that is named, by format: those that are there, paths as the
// named one's. What the headers claim is not believed: a list ends at the first file that is
// missing. All throw Error for a header that cannot be read.
#pragma once

#include <string>
#include <vector>

#include "io/core/byte_source.h"

namespace ovoid::io {

std::vector<std::string> nrrd_companions(const ByteSource& source);
std::vector<std::string> metaimage_companions(const ByteSource& source);
std::vector<std::string> nifti_companions(const ByteSource& source);    // the samples of a pair
std::vector<std::string> vtk_xml_companions(const ByteSource& source);  // whose own may be more
std::vector<std::string> ensight_companions(const ByteSource& source);

// NAME, NAME.hierarchy and what is named in it, which lies beside it whatever folder it says.
std::vector<std::string> enzo_companions(const ByteSource& source);

}  // namespace ovoid::io
