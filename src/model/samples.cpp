// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#include "data/parallel.h"
#include "model/sample_formulas.h"
#include "model/sample_sets.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid {

namespace {

using model::Formula;
using model::SampleKind;

constexpr std::int64_t kMaxSide = 8192;

constexpr std::int64_t kMaxCount = std::int64_t{1} << 30;

const SampleKind& kind_of(const std::string& name) {
  for (const SampleKind& kind : model::sample_kinds()) {
    if (name == kind.name) return kind;
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("sample '{}': must be one of {}", name, fmt::join(sample_names(), ", ")));
}

// Null: not one of them.
const model::SampleSet* find_set(const std::string& name) {
  for (const model::SampleSet& set : model::sample_sets()) {
    if (name == set.name) return &set;
  }
  return nullptr;
}

Dataset make_set(const model::SampleSet& set, const MakeOptions& options) {
  if (options.size != Index3{0, 0, 0})
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("size = {} x {} x {}: '{}' is no lattice; count is its number of {}",
                            options.size[0], options.size[1], options.size[2], set.name, set.noun));
  if (options.type != ScalarType::kFloat32)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("type = {}: must be float32 for '{}'",
                                                         name_of(options.type), set.name));
  const std::int64_t count = options.count == 0 ? set.default_count : options.count;
  if (count < set.least_count || count > kMaxCount)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("count = {}: must be {} to {} for '{}'", count, set.least_count,
                            kMaxCount, set.name));
  try {
    Dataset dataset = set.make(count, options.seed);
    dataset.source = set.name;
    dataset.format = "formula";
    return dataset;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("count = {}: no memory for so many {}", count, set.noun));
  }
}

Index3 dims_of(const SampleKind& kind, const Index3& size) {
  if (size == Index3{0, 0, 0}) return {kind.default_size, kind.default_size, kind.default_size};
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] < 1 || size[axis] > kMaxSide) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("size[{}] = {}: must be 1 to {}", axis, size[axis], kMaxSide));
    }
  }
  return size;
}

// The first and last samples of an axis stand on -1 and 1; a single one stands on 0, for the whole
// length.
LatticeGeometry cube_lattice(const Index3& dims) {
  Vec3 origin = Vec3::Zero();
  Vec3 spacing = Vec3::Constant(2);
  for (int axis = 0; axis < 3; ++axis) {
    if (dims[axis] == 1) continue;
    origin[axis] = -1;
    spacing[axis] = 2 / static_cast<double>(dims[axis] - 1);
  }
  LatticeGeometry geometry;
  geometry.dims = dims;
  geometry.world_from_index = Eigen::Translation3d(origin) * Eigen::Scaling(spacing);
  return geometry;
}

// The formula at all samples; to(value) makes the stored number.
template <class T, class To>
Bytes evaluate(const LatticeGeometry& geometry, const Formula& formula, const To& to) {
  const Index3& dims = geometry.dims;
  const auto count = static_cast<std::size_t>(num_samples(dims));
  std::shared_ptr<T[]> samples;
  try {
    samples = std::make_shared_for_overwrite<T[]>(count);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, fmt::format("size = {} x {} x {}: no memory for {} bytes",
                                                     dims[0], dims[1], dims[2], count * sizeof(T)));
  }
  data::parallel_ranges({dims[1] * dims[2], 1, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      const std::int64_t slice = row / dims[1];
      const auto y = static_cast<double>(row - slice * dims[1]);
      const auto z = static_cast<double>(slice);
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        const Vec3 position = geometry.world_from_index * Vec3(static_cast<double>(x), y, z);
        samples[row * dims[0] + x] = to(formula(position));
      }
    }
  });
  const std::span<const T> view(samples.get(), count);
  return {std::move(samples), std::as_bytes(view)};
}

// The formula's range is spread over the type's.
template <class T>
Bytes evaluate_scaled(const LatticeGeometry& geometry, const Formula& formula,
                      const SampleKind& kind) {
  constexpr double kFull = std::numeric_limits<T>::max();
  return evaluate<T>(geometry, formula, [&](double value) {
    const double share = (value - kind.lo) / (kind.hi - kind.lo);
    return static_cast<T>(std::lround(std::clamp(share, 0.0, 1.0) * kFull));
  });
}

Bytes evaluate_as(ScalarType type, const LatticeGeometry& geometry, const Formula& formula,
                  const SampleKind& kind) {
  switch (type) {
    case ScalarType::kFloat32:
      return evaluate<float>(geometry, formula,
                             [](double value) { return static_cast<float>(value); });
    case ScalarType::kUInt8:
      return evaluate_scaled<std::uint8_t>(geometry, formula, kind);
    case ScalarType::kUInt16:
      return evaluate_scaled<std::uint16_t>(geometry, formula, kind);
    default:
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("type = {}: must be float32, uint8 or uint16", name_of(type)));
  }
}

}  // namespace

std::vector<std::string> sample_names() {
  std::vector<std::string> names;
  for (const SampleKind& kind : model::sample_kinds()) names.emplace_back(kind.name);
  for (const model::SampleSet& set : model::sample_sets()) names.emplace_back(set.name);
  return names;
}

std::string describe_sample(const std::string& name) {
  if (const model::SampleSet* set = find_set(name))
    return fmt::format("{}, {} {}", set->description, set->default_count, set->noun);
  const SampleKind& kind = kind_of(name);
  return fmt::format("{}, {}^3", kind.description, kind.default_size);
}

Dataset make_sample(const std::string& name, const MakeOptions& options) {
  if (const model::SampleSet* set = find_set(name)) return make_set(*set, options);
  if (options.count != 0)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("count = {}: '{}' is a lattice; size is its samples", options.count, name));
  const SampleKind& kind = kind_of(name);
  Dataset dataset;
  dataset.source = name;
  dataset.format = "formula";
  dataset.lattice = cube_lattice(dims_of(kind, options.size));
  dataset.space = kind.space;
  DataArray array;
  array.name = name;
  array.type = options.type;
  array.num_tuples = num_samples(dataset.lattice.dims);
  // Scaled to an integer type, the numbers are no longer in the unit.
  if (options.type == ScalarType::kFloat32) array.unit = kind.unit;
  array.bytes = evaluate_as(options.type, dataset.lattice, kind.make(options.seed), kind);
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

}  // namespace ovoid
