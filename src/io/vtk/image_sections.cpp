// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/image_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

ImageSection section_of(const Dataset& dataset, bool is_cell_data, const std::string& path) {
  ImageSection section;
  std::set<std::string> names;
  for (const DataArray& array : dataset.arrays) {
    if (array.is_cell_data != is_cell_data) continue;
    if (!names.insert(array.name).second) {
      throw Error(
          ErrorCode::kUnsupported,
          fmt::format("{}: two arrays are called '{}', of which VTK reads one: keep one, or "
                      "write .h5",
                      path, array.name.substr(0, 80)));
    }
    section.arrays.push_back(&array);
    if (section.scalars == nullptr && array.num_components == 1) section.scalars = &array;
  }
  return section;
}

}  // namespace

ImageSections image_sections(const Dataset& dataset, const std::string& path) {
  const Index3& dims = dataset.lattice.dims;
  if (*std::max_element(dims.begin(), dims.end()) > kMaxAxisSize) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: dims {}: VTK images have at most {} samples along an axis", path,
                            dims_text(dims), kMaxAxisSize));
  }
  return {section_of(dataset, false, path), section_of(dataset, true, path)};
}

}  // namespace ovoid::io
