// SPDX-License-Identifier: Apache-2.0
#include "ovoid/dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "data/varies.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

// What numbers particles, as programs call it.
constexpr std::array<std::string_view, 14> kParticleNumbers{
    "id",    "ids",     "particleid", "particleids",  "particle_id",    "particle_ids", "pid",
    "index", "indices", "atom_id",    "globalnodeid", "particle_index", "tag",          "itype"};

// The shapes of stored kernels.
constexpr std::array<std::string_view, 3> kKernelShapes{"scale", "rotation", "weight"};

bool has_name(std::span<const std::string_view> names, const std::string& name) {
  std::string lower = name;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::find(names.begin(), names.end(), lower) != names.end();
}

// VTK's filters leave arrays such as vtkValidPointMask and vtkGhostType beside the data.
bool is_bookkeeping(const Dataset& dataset, const DataArray& array) {
  return array.name.starts_with("vtk") ||
         (dataset.kind != DatasetKind::kLattice && has_name(kParticleNumbers, array.name)) ||
         (dataset.kind == DatasetKind::kKernels && has_name(kKernelShapes, array.name));
}

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

std::int64_t Cells::count() const noexcept {
  if (!is_structured()) return static_cast<std::int64_t>(types.size());
  // A grid one node thick has flat cells.
  std::int64_t cells = 1;
  for (const std::int64_t n : dims) cells *= std::max<std::int64_t>(n - 1, 1);
  return cells;
}

const DataArray& Dataset::array(const std::string& name) const {
  if (arrays.empty()) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': has no arrays", source));
  }
  if (name.empty()) {
    const auto found =
        std::find_if(arrays.begin(), arrays.end(), [this](const DataArray& candidate) {
          return !is_bookkeeping(*this, candidate) && data::varies(candidate);
        });
    if (found != arrays.end()) return *found;
    const auto constant = std::find_if(arrays.begin(), arrays.end(), [this](const DataArray& a) {
      return !is_bookkeeping(*this, a);
    });
    return constant != arrays.end() ? *constant : arrays.front();
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
