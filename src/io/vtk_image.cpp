// SPDX-License-Identifier: Apache-2.0
#include "io/vtk_image.h"

#include <fmt/format.h>

#include "ovoid/error.h"

namespace ovoid::io {

Dataset read_vtk_image(const ByteSource& source, FileKind, const ReadOptions&) {
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: this build has no VTK and cannot read VTI and legacy VTK files",
                          source.name()));
}

void write_vtk_image(const Dataset&, const std::string& path) {
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: this build has no VTK and cannot write VTI and legacy VTK files", path));
}

}  // namespace ovoid::io
