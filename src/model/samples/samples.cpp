// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <numbers>
#include <utility>
#include <vector>

#include "data/parallel.h"
#include "model/samples/sample_formulas.h"
#include "model/samples/sample_sets.h"
#include "model/time/lattice_steps.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "ovoid/resample.h"

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
  if (options.lattice != LatticeKind::kCartesian)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("lattice = {}: '{}' is no lattice",
                                                         name_of(options.lattice), set.name));
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
  const std::int64_t own = kind.default_size;
  if (size == Index3{0, 0, 0}) return {own, own, own};
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

// The formulas, one for each component, at all samples; to(value) makes the stored number.
template <class T, class To>
Bytes evaluate(const LatticeGeometry& geometry, const std::vector<Formula>& formulas,
               const To& to) {
  const Index3& dims = geometry.dims;
  const std::size_t count = static_cast<std::size_t>(num_samples(dims)) * formulas.size();
  std::shared_ptr<T[]> samples;
  try {
    samples = std::make_shared_for_overwrite<T[]>(count);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, fmt::format("size = {} x {} x {}: no memory for {} bytes",
                                                     dims[0], dims[1], dims[2], count * sizeof(T)));
  }
  data::parallel_ranges({dims[1] * dims[2], 1, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      const std::int64_t layer = row / dims[1];
      const std::int64_t y = row - layer * dims[1];
      T* out = samples.get() + static_cast<std::size_t>(row * dims[0]) * formulas.size();
      for (std::int64_t x = 0; x < dims[0]; ++x) {
        const Vec3 position = geometry.world_from_index * geometry.index_position({x, y, layer});
        for (const Formula& formula : formulas) *out++ = to(formula(position));
      }
    }
  });
  const std::span<const T> view(samples.get(), count);
  return {std::move(samples), std::as_bytes(view)};
}

// The formula's range is spread over the type's.
template <class T>
Bytes evaluate_scaled(const LatticeGeometry& geometry, const std::vector<Formula>& formulas,
                      const SampleKind& kind) {
  constexpr double kFull = std::numeric_limits<T>::max();
  return evaluate<T>(geometry, formulas, [&](double value) {
    const double share = (value - kind.lo) / (kind.hi - kind.lo);
    return static_cast<T>(std::lround(std::clamp(share, 0.0, 1.0) * kFull));
  });
}

Bytes evaluate_as(ScalarType type, const LatticeGeometry& geometry,
                  const std::vector<Formula>& formulas, const SampleKind& kind) {
  switch (type) {
    case ScalarType::kFloat32:
      return evaluate<float>(geometry, formulas,
                             [](double value) { return static_cast<float>(value); });
    case ScalarType::kUInt8:
      return evaluate_scaled<std::uint8_t>(geometry, formulas, kind);
    case ScalarType::kUInt16:
      return evaluate_scaled<std::uint16_t>(geometry, formulas, kind);
    default:
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("type = {}: must be float32, uint8 or uint16", name_of(type)));
  }
}

Dataset sampled(const SampleKind& kind, const LatticeGeometry& lattice, double time,
                const MakeOptions& options) {
  Dataset dataset;
  dataset.source = kind.name;
  dataset.format = "formula";
  dataset.lattice = lattice;
  dataset.space = kind.space;
  DataArray array;
  array.name = kind.name;
  array.type = options.type;
  array.num_tuples = num_samples(lattice.dims);
  // Scaled to an integer type, the numbers are no longer in the unit.
  if (options.type == ScalarType::kFloat32) array.unit = kind.unit;
  std::vector<Formula> formulas{kind.make(options.seed, time)};
  if (kind.make_second != nullptr) formulas.push_back(kind.make_second(options.seed, time));
  array.num_components = static_cast<int>(formulas.size());
  array.bytes = evaluate_as(options.type, lattice, formulas, kind);
  dataset.arrays.push_back(std::move(array));
  return dataset;
}

class SampleSteps final : public model::LatticeSteps {
 public:
  SampleSteps(const SampleKind& sample, std::int64_t num_steps, SeriesKind kind,
              const MakeOptions& options)
      : LatticeSteps(kind, sample.name),
        sample_(sample),
        options_(options),
        last_(static_cast<double>(num_steps - 1)) {
    LatticeGeometry lattice = cube_lattice(dims_of(sample, options.size));
    const bool is_staggered = kind == SeriesKind::kStaggered;
    if (is_staggered) {
      lattice = step_lattice(lattice, kind, 1.0);
    } else if (options.lattice == LatticeKind::kBodyCentred) {
      lattice = body_centred_like(lattice);
    }
    const double distance = is_staggered ? 1 / std::numbers::sqrt2 : 1.0;
    std::vector<double> times;
    for (std::int64_t i = 0; static_cast<double>(i) * distance <= last_ + 1e-9; ++i)
      times.push_back(static_cast<double>(i) * distance);
    set_steps(lattice, std::move(times));
  }

 private:
  Dataset make(std::int64_t step, const LatticeGeometry& lattice,
               const std::stop_token& /*stop*/) const override {
    return sampled(sample_, lattice, times()[static_cast<std::size_t>(step)] / last_, options_);
  }

  const SampleKind& sample_;
  MakeOptions options_;
  double last_;  // time of the last Cartesian step
};

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
  if (!(options.time >= 0 && options.time <= 1)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("time = {}: must be within 0 to 1", options.time));
  }
  LatticeGeometry lattice = cube_lattice(dims_of(kind, options.size));
  if (options.lattice == LatticeKind::kBodyCentred) lattice = body_centred_like(lattice);
  return sampled(kind, lattice, options.time, options);
}

bool sample_moves(const std::string& name) {
  const auto kinds = model::sample_kinds();
  return std::any_of(kinds.begin(), kinds.end(),
                     [&](const SampleKind& kind) { return name == kind.name && kind.moves; });
}

std::shared_ptr<const StepSource> make_sample_steps(const std::string& name, std::int64_t num_steps,
                                                    SeriesKind kind, const MakeOptions& options) {
  const SampleKind& sample = kind_of(name);
  if (!sample.moves)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("sample '{}': does not move", name));
  constexpr std::int64_t kMostSteps = 100'000;
  if (num_steps < 2 || num_steps > kMostSteps) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("steps = {}: must be 2 to {}", num_steps, kMostSteps));
  }
  return std::make_shared<SampleSteps>(sample, num_steps, kind, options);
}

}  // namespace ovoid
