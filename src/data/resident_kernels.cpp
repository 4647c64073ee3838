// SPDX-License-Identifier: Apache-2.0
// Kernels in memory. They are sorted by size class, then along a Morton curve within the class, and
// cut into bricks at the nodes of the octree that the curve follows. Kernels of one brick are so of
// similar size, their offsets from its origin keep their digits even where radii span eight
// decades, and a brick's box is not blown up by one large kernel.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "data/kernel_shape.h"
#include "data/morton.h"
#include "data/parallel.h"
#include "ovoid/error.h"
#include "ovoid/kernel_field.h"

namespace ovoid {
namespace {

constexpr std::int64_t kGrain = 16384;
constexpr int kClassOctaves = 2;  // sizes within a factor 4 share a class

// Extent of a brick's centres, in least sigmas, up to which float offsets stay within
// kMaxOffsetError: half an ulp is 2^-24 of an offset's binade, and offsets are at most the extent.
const double kMaxExtent = KernelBrick::kMaxOffsetError * std::ldexp(1.0, 24);

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

struct Extent {
  float least = 0, greatest = 0;  // sigmas
};

struct SortItem {
  std::uint64_t key;
  std::uint32_t index;
};

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
  ResidentKernels(const KernelColumns& columns, int threads)
      : shape_(columns.shape),
        profile_(columns.profile),
        cutoff_(columns.cutoff),
        attributes_(columns.attributes),
        threads_(threads) {
    count_ = columns.centers.size() / 3;
    check_lengths(columns, count_);
    measure(columns);
    sort_into_bricks(columns);
    fill(columns);
    extents_ = {};
    items_ = {};
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
  void measure(const KernelColumns& columns) {
    const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(shape_));
    const bool has_own_shapes = columns.shapes.size() > per_kernel || count_ == 1;
    check_kernel(columns, 0);
    const auto extent_of = [&](std::size_t i) -> Extent {
      const Vec3 axes = data::semi_axes(shape_, columns.shapes.data() + per_kernel * i);
      return {static_cast<float>(axes[0]), static_cast<float>(axes[2])};
    };
    const Extent shared = extent_of(0);
    extents_.resize(count_);
    data::parallel_ranges({static_cast<std::int64_t>(count_), kGrain, threads_},
                          [&](std::int64_t begin, std::int64_t end) {
                            for (std::int64_t i = begin; i < end; ++i) {
                              const auto at = static_cast<std::size_t>(i);
                              check_kernel(columns, at);
                              extents_[at] = has_own_shapes ? extent_of(at) : shared;
                            }
                          });
    const auto [least, greatest] = std::minmax_element(
        extents_.begin(), extents_.end(),
        [](const Extent& a, const Extent& b) { return a.greatest < b.greatest; });
    least_class_ = class_of(least->greatest);
    num_classes_ = class_of(greatest->greatest) - least_class_ + 1;
  }

  static int class_of(float sigma) noexcept { return std::ilogb(sigma) / kClassOctaves; }

  Vec3 center(const KernelColumns& columns, std::uint32_t i) const {
    const double* c = columns.centers.data() + std::size_t{3} * i;
    return {c[0], c[1], c[2]};
  }

  void sort_into_bricks(const KernelColumns& columns) {
    items_.resize(count_);
    std::vector<std::size_t> starts(static_cast<std::size_t>(num_classes_) + 1, 0);
    const auto class_at = [&](std::size_t i) {
      return static_cast<std::size_t>(class_of(extents_[i].greatest) - least_class_);
    };
    for (std::size_t i = 0; i < count_; ++i) ++starts[class_at(i) + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::size_t> next(starts.begin(), starts.end() - 1);
    for (std::size_t i = 0; i < count_; ++i)
      items_[next[class_at(i)]++] = {0, static_cast<std::uint32_t>(i)};
    for (std::size_t c = 0; c + 1 < starts.size(); ++c)
      sort_range(columns, starts[c], starts[c + 1]);
  }

  // Sorts [begin, end) along a Morton curve through its own bounding cube and cuts it into bricks.
  void sort_range(const KernelColumns& columns, std::size_t begin, std::size_t end) {
    if (begin == end) return;
    Bounds3 box;
    for (std::size_t i = begin; i < end; ++i) box.extend(center(columns, items_[i].index));
    const double edge = box.sizes().maxCoeff();
    if (end - begin == 1 || !(edge > 0) || !std::isfinite(edge)) {
      cut_evenly(begin, end);
      return;
    }
    const double scale = std::ldexp(1.0, data::kMortonBits) / edge * (1 - 1e-12);
    const Vec3 low = box.min();
    data::parallel_ranges({static_cast<std::int64_t>(end - begin), kGrain, threads_},
                          [&](std::int64_t from, std::int64_t to) {
                            for (std::int64_t i = from; i < to; ++i) {
                              SortItem& item = items_[begin + static_cast<std::size_t>(i)];
                              const Vec3 at = (center(columns, item.index) - low) * scale;
                              item.key = data::morton_key(at);
                            }
                          });
    // The index decides between equals, so that the order is one.
    std::sort(items_.begin() + static_cast<std::ptrdiff_t>(begin),
              items_.begin() + static_cast<std::ptrdiff_t>(end),
              [](const SortItem& a, const SortItem& b) {
                return a.key != b.key ? a.key < b.key : a.index < b.index;
              });
    cut_node(columns, begin, end, 3 * data::kMortonBits);
  }

  bool fits_a_brick(const KernelColumns& columns, std::size_t begin, std::size_t end) const {
    if (end - begin > KernelBrick::kMaxBrickKernels) return false;
    Bounds3 box;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t i = begin; i < end; ++i) {
      box.extend(center(columns, items_[i].index));
      least = std::min(least, extents_[items_[i].index].least);
    }
    return box.sizes().maxCoeff() <= kMaxExtent * static_cast<double>(least);
  }

  // An octree node: the items [begin, end), equal in all key bits from `bits` up.
  void cut_node(const KernelColumns& columns, std::size_t begin, std::size_t end, int bits) {
    if (begin == end) return;
    if (fits_a_brick(columns, begin, end)) {
      add_brick(begin, end);
      return;
    }
    if (bits == 0) {  // a cluster below the curve's resolution gets a curve of its own
      sort_range(columns, begin, end);
      return;
    }
    const int below = bits - 3;
    std::size_t first = begin;  // of the children that wait to share a brick
    std::size_t from = begin;
    for (std::uint64_t child = 0; child < 8; ++child) {
      const std::size_t to = static_cast<std::size_t>(
          std::partition_point(
              items_.begin() + static_cast<std::ptrdiff_t>(from),
              items_.begin() + static_cast<std::ptrdiff_t>(end),
              [&](const SortItem& item) { return (item.key >> below & 7U) <= child; }) -
          items_.begin());
      if (!fits_a_brick(columns, first, to)) {
        if (first < from) add_brick(first, from);
        first = from;
        if (!fits_a_brick(columns, from, to)) {
          cut_node(columns, from, to, below);
          first = to;
        }
      }
      from = to;
    }
    if (first < end) add_brick(first, end);
  }

  // Kernels at one place, or so far apart that their distance is beyond a double.
  void cut_evenly(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i += KernelBrick::kMaxBrickKernels)
      add_brick(i, std::min<std::size_t>(end, i + KernelBrick::kMaxBrickKernels));
  }

  void add_brick(std::size_t begin, std::size_t end) {
    firsts_.push_back(begin);
    bricks_.emplace_back().count = static_cast<std::int32_t>(end - begin);
  }

  void fill(const KernelColumns& columns) {
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
                              fill_brick(columns, static_cast<std::size_t>(b));
                          });
    for (std::size_t a = 0; a < attributes_.size(); ++a) {
      attributes_[a].range = columns.ranges.empty() ? ValueRange{} : columns.ranges[a];
      for (const KernelBrick& brick : bricks_) merge(attributes_[a].range, brick.ranges[a]);
    }
  }

  static void merge(ValueRange& range, const ValueRange& other) {
    if (range.is_empty()) {
      range = other;
    } else {
      range.lo = std::min(range.lo, other.lo);
      range.hi = std::max(range.hi, other.hi);
    }
  }

  void fill_brick(const KernelColumns& columns, std::size_t b) {
    KernelBrick& brick = bricks_[b];
    const std::size_t first = firsts_[b];
    const auto per_kernel = static_cast<std::size_t>(num_shape_numbers(shape_));
    Bounds3 box;
    for (std::int32_t i = 0; i < brick.count; ++i)
      box.extend(center(columns, items_[first + static_cast<std::size_t>(i)].index));
    brick.origin = box.center();
    brick.least_sigma = std::numeric_limits<float>::infinity();
    for (std::int32_t i = 0; i < brick.count; ++i) {
      const std::size_t to = first + static_cast<std::size_t>(i);
      const std::uint32_t from = items_[to].index;
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
        merge(brick.ranges[a], {values_[a][to], values_[a][to]});
      }
      // An ellipsoid reaches sqrt(S_aa) sigmas along axis a: the length of the factor's row.
      const Vec3 reach = data::factor_of(shape_, numbers).rowwise().norm() * cutoff_;
      brick.support.extend(Bounds3(at - reach, at + reach));
      brick.least_sigma = std::min(brick.least_sigma, extents_[from].least);
      brick.greatest_sigma = std::max(brick.greatest_sigma, extents_[from].greatest);
    }
  }

  KernelShape shape_;
  KernelProfile profile_;
  double cutoff_;
  std::vector<KernelAttribute> attributes_;
  int threads_;
  std::size_t count_ = 0;
  int least_class_ = 0, num_classes_ = 1;
  std::vector<Extent> extents_;  // while sorting
  std::vector<SortItem> items_;  // while sorting
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

std::shared_ptr<const KernelSource> make_kernel_source(const KernelColumns& columns, int threads) {
  return std::make_shared<ResidentKernels>(columns, threads);
}

}  // namespace ovoid
