// SPDX-License-Identifier: Apache-2.0
// VTK's XML files that name other files: pieces (.pvti .pvtr .pvts .pvtu .pvtp .vtpd), blocks (.vtm
// .vtpc), adaptive grids (.vth .vthb) and time series (.pvd).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// Sets within sets, and the files of one of them, or of all of them together.
inline constexpr int kMaxVtkSetDepth = 8;
inline constexpr std::int64_t kMaxVtkSetFiles = 10000;

// Do these first bytes begin a file of VTK's XML, of its legacy format?
bool begins_like_vtk_xml(std::string_view start) noexcept;
bool begins_like_legacy_vtk(std::string_view start) noexcept;

// What the root of an XML file says it is: "ImageData", "vtkMultiBlockDataSet", "Collection"; empty
// if it is no VTKFile.
std::string vtk_xml_type(const ByteSource& source);

// Is this what the root of such a file says it is?
bool is_vtk_set(const std::string& xml_type) noexcept;

// "PVTU", "VTM", ... for a type that is_vtk_set().
const char* format_of_vtk_set(const std::string& xml_type) noexcept;

// A file that a set names.
struct VtkSetFile {
  std::string path;
  std::string block;   // "outer/inner", where the set has blocks; its pieces share it
  int level = 0;       // adaptive grids
  double time = 0;     // time series
  std::string extent;  // pieces of grids, as it stands
};

// What is said of all steps of a time series by attributes of its element Collection, which other
// programs pass over: TimeUnit, and Space of the world (none, LPS or RAS). Throws Error for
// another.
struct VtkSeriesPlace {
  std::string time_unit;
  Space space = Space::kNone;
};
VtkSeriesPlace vtk_series_place(const ByteSource& source);

// The files of a set, in the order they stand; names count from the set's folder. Throws Error.
std::vector<VtkSetFile> vtk_set_files(const ByteSource& source);

}  // namespace ovoid::io
