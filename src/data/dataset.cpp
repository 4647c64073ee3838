// SPDX-License-Identifier: Apache-2.0
#include "ovoid/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid {

namespace {

// True if two finite values of one component differ. Ends at the first difference, so real data
// costs next to nothing.
bool varies(const DataArray& array) {
  return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const auto stored = static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T));
    const std::int64_t components = std::max(array.num_components, 1);
    const std::byte* bytes = array.bytes.view.data();
    for (std::int64_t c = 0; c < components; ++c) {
      bool has_first = false;
      T first{};
      for (std::int64_t i = c; i < stored; i += components) {
        const T value = data::load_scalar<T>(bytes, i);
        if constexpr (std::is_floating_point_v<T>) {
          if (!std::isfinite(value)) continue;
        }
        if (!has_first) {
          first = value;
          has_first = true;
        } else if (value != first) {
          return true;
        }
      }
    }
    return false;
  });
}

// VTK's filters leave arrays such as vtkValidPointMask and vtkGhostType beside the data.
bool is_bookkeeping(const DataArray& array) { return array.name.starts_with("vtk"); }

std::string listed_names(const std::vector<DataArray>& arrays) {
  std::string names;
  for (const DataArray& array : arrays) {
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", array.name);
  }
  return names;
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

const DataArray& Dataset::array(const std::string& name) const {
  if (arrays.empty()) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': has no arrays", source));
  }
  if (name.empty()) {
    const auto found = std::find_if(arrays.begin(), arrays.end(), [](const DataArray& candidate) {
      return !is_bookkeeping(candidate) && varies(candidate);
    });
    return found != arrays.end() ? *found : arrays.front();
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
