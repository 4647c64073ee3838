// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "io/core/byte_source.h"

namespace ovoid::io {

// What VTK calls an extent: the first and last index along each axis, of an image or a piece of it.
struct VtkExtent {
  std::array<std::int64_t, 3> lo{};
  std::array<std::int64_t, 3> hi{};

  // Samples along each axis; zeros if the extent is empty, as pieces may be.
  std::array<std::int64_t, 3> dims() const;
  bool contains(const VtkExtent& other) const;
  // Neighbours share the samples between them, but no cell.
  bool shares_cells(const VtkExtent& other) const;
};

// "i0 i1 j0 j1 k0 k1". Throws Error(kFileFormat) naming the field.
VtkExtent parse_vtk_extent(const ByteSource& source, const std::string& field,
                           const std::string& text);

}  // namespace ovoid::io
