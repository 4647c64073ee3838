// SPDX-License-Identifier: Apache-2.0
// Kernels in memory, in bricks.
#include "data/kernels/resident_kernels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/kernels/kernel_bricks.h"
#include "data/kernels/kernel_shape.h"
#include "data/lattice/merged_range.h"
#include "data/parallel.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"

namespace ovoid {
namespace {

constexpr std::int64_t kGrain = 16384;

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

void check_lengths(const KernelColumns& columns, std::size_t count) {
  if (count == 0) refuse("centers: empty, expected at least one kernel");
  if (columns.centers.size() % 3 != 0)
    refuse(fmt::format("centers: {} numbers, expected three per kernel", columns.centers.size()));
  if (count > std::numeric_limits<std::uint32_t>::max())
    refuse(fmt::format("centers: {} kernels, expected at most {}", count,
                       std::numeric_limits<std::uint32_t>::max()));
  const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(columns.shape));
  if (columns.shapes.size() != per_kernel * count && columns.shapes.size() != per_kernel)
    refuse(fmt::format("shapes: {} numbers, expected {} for each of {} kernels, or for all",
                       columns.shapes.size(), per_kernel, count));
  if (columns.weights.size() != count && columns.weights.size() != 1)
    refuse(fmt::format("weights: {} numbers, expected one for each of {} kernels, or for all",
                       columns.weights.size(), count));
  if (columns.values.empty() || columns.values.size() > kMaxAttributes)
    refuse(fmt::format("values: {} attributes, expected 1 to {}", columns.values.size(),
                       kMaxAttributes));
  if (columns.attributes.size() != columns.values.size())
    refuse(fmt::format("attributes: {}, expected one for each of {} columns of values",
                       columns.attributes.size(), columns.values.size()));
  if (!columns.ranges.empty() && columns.ranges.size() != columns.values.size())
    refuse(fmt::format("ranges: {}, expected one for each of {} columns of values, or none",
                       columns.ranges.size(), columns.values.size()));
  for (std::size_t a = 0; a < columns.values.size(); ++a) {
    if (columns.values[a].size() != count)
      refuse(fmt::format("values[{}]: {} numbers, expected one for each of {} kernels", a,
                         columns.values[a].size(), count));
  }
  if (!(columns.cutoff >= 1 && columns.cutoff <= KernelColumns::kMaxCutoff))
    refuse(fmt::format("cutoff = {}: must be from 1 to {:g}", columns.cutoff,
                       KernelColumns::kMaxCutoff));
}

// Numbers of one kernel; throws naming column and index.
void check_kernel(const KernelColumns& columns, std::size_t i) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!std::isfinite(columns.centers[3 * i + a]))
      refuse(fmt::format("centers[{}][{}] = {}: must be finite", i, a, columns.centers[3 * i + a]));
  }
  for (std::size_t a = 0; a < columns.values.size(); ++a) {
    if (!std::isfinite(columns.values[a][i]))
      refuse(fmt::format("values[{}][{}] = {}: must be finite", a, i, columns.values[a][i]));
  }
  if (i < columns.weights.size() && !(columns.weights[i] > 0 && std::isfinite(columns.weights[i])))
    refuse(fmt::format("weights[{}] = {}: must be > 0", i, columns.weights[i]));
  const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(columns.shape));
  if (i >= columns.shapes.size() / per_kernel) return;
  constexpr bool kIsDiagonal[6] = {true, false, true, false, false, true};
  for (std::size_t c = 0; c < per_kernel; ++c) {
    const float number = columns.shapes[per_kernel * i + c];
    if (!std::isfinite(number) ||
        (kIsDiagonal[c] && !(number >= std::numeric_limits<float>::min())))
      refuse(fmt::format("shapes[{}][{}] = {}: must be finite{}", i, c, number,
                         kIsDiagonal[c] ? " and > 0" : ""));
  }
}

class ResidentKernels final : public KernelSource {
 public:
  ResidentKernels(const KernelColumns& columns, std::span<const data::KernelGroup> groups,
                  int threads)
      : shape_(columns.shape),
        profile_(columns.profile),
        cutoff_(columns.cutoff),
        attributes_(columns.attributes),
        threads_(threads) {
    count_ = columns.centers.size() / 3;
    check_lengths(columns, count_);
    const std::vector<data::KernelExtent> extents = measure(columns);
    const data::BrickOrder order = data::order_in_bricks(columns.centers, extents, threads, groups);
    firsts_ = order.firsts;
    bricks_.resize(firsts_.size());
    for (std::size_t b = 0; b < bricks_.size(); ++b)
      bricks_[b].count = static_cast<std::int32_t>(order.count_of(b));
    fill(columns, extents, order.kernels);
  }

  KernelShape shape() const noexcept override { return shape_; }
  KernelProfile profile() const noexcept override { return profile_; }
  double cutoff() const noexcept override { return cutoff_; }
  std::span<const KernelAttribute> attributes() const noexcept override { return attributes_; }
  std::int64_t num_kernels() const noexcept override { return static_cast<std::int64_t>(count_); }
  std::int64_t num_bricks() const noexcept override {
    return static_cast<std::int64_t>(bricks_.size());
  }
  const KernelBrick& brick(std::int64_t index) const noexcept override {
    return bricks_[static_cast<std::size_t>(index)];
  }

  KernelView acquire(std::int64_t index, double /*time*/) const override {
    const auto at = static_cast<std::size_t>(index);
    const std::size_t first = firsts_[at];
    KernelView view;
    view.count = bricks_[at].count;
    for (std::size_t a = 0; a < 3; ++a) view.center[a] = centers_[a].data() + first;
    for (std::size_t c = 0; c < shapes_.size(); ++c) view.shape[c] = shapes_[c].data() + first;
    if (!weights_.empty()) view.weight = weights_.data() + first;
    for (std::size_t a = 0; a < values_.size(); ++a) view.value[a] = values_[a].data() + first;
    view.shared_shape = shared_shape_;
    view.shared_weight = shared_weight_;
    return view;
  }

  std::size_t resident_bytes() const noexcept override {
    const std::size_t columns = 3 + shapes_.size() + (weights_.empty() ? 0 : 1) + values_.size();
    return sizeof *this + count_ * columns * sizeof(float) +
           bricks_.size() * (sizeof(KernelBrick) + sizeof(std::size_t));
  }

 private:
  // Checks every kernel, and finds the sizes.
  std::vector<data::KernelExtent> measure(const KernelColumns& columns) const {
    const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(shape_));
    const bool has_own_shapes = columns.shapes.size() > per_kernel || count_ == 1;
    check_kernel(columns, 0);
    const auto extent_of = [&](std::size_t i) -> data::KernelExtent {
      const Vec3 axes = data::semi_axes(shape_, columns.shapes.data() + per_kernel * i);
      return {static_cast<float>(axes[0]), static_cast<float>(axes[2])};
    };
    const data::KernelExtent shared = extent_of(0);
    std::vector<data::KernelExtent> extents(count_);
    data::parallel_ranges({static_cast<std::int64_t>(count_), kGrain, threads_},
                          [&](std::int64_t begin, std::int64_t end) {
                            for (std::int64_t i = begin; i < end; ++i) {
                              const auto at = static_cast<std::size_t>(i);
                              check_kernel(columns, at);
                              extents[at] = has_own_shapes ? extent_of(at) : shared;
                            }
                          });
    return extents;
  }

  Vec3 center(const KernelColumns& columns, std::uint32_t i) const {
    const double* c = columns.centers.data() + std::size_t{3} * i;
    return {c[0], c[1], c[2]};
  }

  void fill(const KernelColumns& columns, std::span<const data::KernelExtent> extents,
            std::span<const std::uint32_t> order) {
    const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(shape_));
    for (auto& column : centers_) column.resize(count_);
    if (columns.shapes.size() > per_kernel) {
      shapes_.resize(per_kernel);
      for (auto& column : shapes_) column.resize(count_);
    } else {
      std::copy(columns.shapes.begin(), columns.shapes.end(), shared_shape_.begin());
    }
    if (columns.weights.size() > 1) weights_.resize(count_);
    shared_weight_ = columns.weights[0];
    values_.resize(columns.values.size());
    for (auto& column : values_) column.resize(count_);
    data::parallel_ranges({static_cast<std::int64_t>(bricks_.size()), 64, threads_},
                          [&](std::int64_t begin, std::int64_t end) {
                            for (std::int64_t b = begin; b < end; ++b)
                              fill_brick(columns, extents, order, static_cast<std::size_t>(b));
                          });
    for (std::size_t a = 0; a < attributes_.size(); ++a) {
      attributes_[a].range = columns.ranges.empty() ? ValueRange{} : columns.ranges[a];
      for (const KernelBrick& brick : bricks_) data::merge(attributes_[a].range, brick.ranges[a]);
    }
  }

  void fill_brick(const KernelColumns& columns, std::span<const data::KernelExtent> extents,
                  std::span<const std::uint32_t> order, std::size_t b) {
    KernelBrick& brick = bricks_[b];
    const std::size_t first = firsts_[b];
    const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(shape_));
    Bounds3 box;
    for (std::int32_t i = 0; i < brick.count; ++i)
      box.extend(center(columns, order[first + static_cast<std::size_t>(i)]));
    brick.origin = box.center();
    brick.least_sigma = std::numeric_limits<float>::infinity();
    for (std::int32_t i = 0; i < brick.count; ++i) {
      const std::size_t to = first + static_cast<std::size_t>(i);
      const std::uint32_t from = order[to];
      const Vec3 at = center(columns, from);
      for (std::size_t a = 0; a < 3; ++a)
        centers_[a][to] =
            static_cast<float>(at[static_cast<int>(a)] - brick.origin[static_cast<int>(a)]);
      const float* numbers =
          shapes_.empty() ? shared_shape_.data() : columns.shapes.data() + per_kernel * from;
      for (std::size_t c = 0; c < shapes_.size(); ++c) shapes_[c][to] = numbers[c];
      if (!weights_.empty()) weights_[to] = columns.weights[from];
      for (std::size_t a = 0; a < values_.size(); ++a) {
        values_[a][to] = columns.values[a][from];
        data::merge(brick.ranges[a], {values_[a][to], values_[a][to]});
      }
      // An ellipsoid reaches sqrt(S_aa) sigmas along axis a: the length of the factor's row.
      const Vec3 sigmas = data::factor_of(shape_, numbers).rowwise().norm();
      brick.support.extend(Bounds3(at - sigmas * cutoff_, at + sigmas * cutoff_));
      const Vec3 stored = brick.origin + Vec3(centers_[0][to], centers_[1][to], centers_[2][to]);
      brick.cells.extend(Bounds3(stored - sigmas, stored + sigmas));
      brick.least_sigma = std::min(brick.least_sigma, extents[from].least);
      brick.greatest_sigma = std::max(brick.greatest_sigma, extents[from].greatest);
    }
  }

  KernelShape shape_;
  KernelProfile profile_;
  double cutoff_;
  std::vector<KernelAttribute> attributes_;
  int threads_;
  std::size_t count_ = 0;
  std::vector<KernelBrick> bricks_;
  std::vector<std::size_t> firsts_;
  std::array<std::vector<float>, 3> centers_;
  std::vector<std::vector<float>> shapes_;
  std::vector<float> weights_;
  std::vector<std::vector<float>> values_;
  std::array<float, 6> shared_shape_{};
  float shared_weight_ = 1;
};

}  // namespace

namespace data {

std::shared_ptr<const KernelSource> resident_kernels(const KernelColumns& columns,
                                                     std::span<const KernelGroup> groups,
                                                     int threads) {
  return std::make_shared<ResidentKernels>(columns, groups, threads);
}

}  // namespace data

std::shared_ptr<const KernelSource> make_kernel_source(const KernelColumns& columns, int threads) {
  return data::resident_kernels(columns, {}, threads);
}

}  // namespace ovoid
