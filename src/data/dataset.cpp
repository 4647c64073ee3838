// SPDX-License-Identifier: Apache-2.0
#include "ovoid/dataset.h"

#include <fmt/format.h>

#include <algorithm>

#include "data/default_array.h"
#include "data/names_text.h"
#include "data/varies.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

std::string listed_names(const std::vector<DataArray>& arrays) {
  std::vector<std::string> names;
  names.reserve(arrays.size());
  for (const DataArray& array : arrays) names.push_back(array.name);
  return data::names_text(names);
}

}  // namespace

const char* name_of(Space space) noexcept {
  switch (space) {
    case Space::kNone:
      return "none";
    case Space::kLps:
      return "LPS";
    case Space::kRas:
      return "RAS";
  }
  return "none";
}

const char* name_of(DatasetKind kind) noexcept {
  switch (kind) {
    case DatasetKind::kLattice:
      return "lattice";
    case DatasetKind::kMesh:
      return "mesh";
    case DatasetKind::kBoxes:
      return "boxes";
    case DatasetKind::kParticles:
      return "particles";
    case DatasetKind::kKernels:
      return "kernels";
  }
  return "lattice";
}

const char* name_of(SeriesKind kind) noexcept {
  return kind == SeriesKind::kStaggered ? "staggered" : "steps";
}

std::int64_t Cells::count() const noexcept {
  if (!is_structured()) return static_cast<std::int64_t>(types.size());
  // A grid one node thick has flat cells.
  std::int64_t cells = 1;
  for (const std::int64_t n : dims) cells *= std::max<std::int64_t>(n - 1, 1);
  return cells;
}

const DataArray& Dataset::array(const std::string& name) const& {
  if (arrays.empty()) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': has no arrays", source));
  }
  if (name.empty()) {
    if (share && !share->array.empty()) return array(share->array);
    return *data::default_array(*this, data::varies);
  }
  const auto found = std::find_if(arrays.begin(), arrays.end(),
                                  [&](const DataArray& a) { return a.name == name; });
  if (found == arrays.end()) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("array '{}': not in '{}', which has {}",
                                                         name, source, listed_names(arrays)));
  }
  return *found;
}

}  // namespace ovoid
