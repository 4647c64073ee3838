// SPDX-License-Identifier: Apache-2.0
#include "data/kernels/kernel_bricks.h"

#include <cmath>
#include <numeric>

#include "data/parallel.h"

namespace ovoid::data {
namespace {

constexpr std::int64_t kKeyGrain = 16384;
constexpr int kClassOctaves = 2;

// Extent of a brick's centres, in least sigmas, up to which float offsets stay within
// kMaxOffsetError: half an ulp is 2^-24 of an offset's binade, and offsets are at most the extent.
const double kMaxExtent = KernelBrick::kMaxOffsetError * std::ldexp(1.0, 24);

class BrickCutter {
 public:
  BrickCutter(std::span<const double> centers, std::span<const KernelExtent> extents, int threads)
      : centers_(centers), extents_(extents), threads_(threads), items_(extents.size()) {}

  BrickOrder order_all() {
    for_each_class([&](std::size_t begin, std::size_t end) { cut_whole(begin, end); });
    return finished();
  }

  BrickOrder order(std::span<const KernelGroup> groups) {
    for (std::size_t i = 0; i < items_.size(); ++i) items_[i] = {0, static_cast<std::uint32_t>(i)};
    for (const KernelGroup& group : groups) {
      if (group.kind == KernelGroup::Kind::kClass) {
        cut_whole(group.begin, group.end);
        continue;
      }
      sort_along(group.cube, group.begin, group.end);
      if (group.kind == KernelGroup::Kind::kBrick) {
        add_brick(group.begin, group.end);
      } else {
        NodeCutter(*this, 0).cut(group.begin, group.end, group.bits);
      }
    }
    return finished();
  }

  // As NodeCutter asks for them.
  std::uint64_t key(std::size_t i) const { return items_[i].key; }
  bool fits(std::size_t begin, std::size_t end) const {
    if (end - begin > KernelBrick::kMaxBrickKernels) return false;
    Bounds3 box;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t i = begin; i < end; ++i) {
      box.extend(center(items_[i].index));
      least = std::min(least, extents_[items_[i].index].least);
    }
    return fits_a_brick(static_cast<std::int64_t>(end - begin), box, least);
  }
  void add_brick(std::size_t begin, std::size_t /*end*/) { firsts_.push_back(begin); }
  // A cluster below the curve's resolution gets a curve of its own.
  void cut_below(std::size_t begin, std::size_t end) { cut_whole(begin, end); }

 private:
  struct SortItem {
    std::uint64_t key;
    std::uint32_t index;
  };

  Vec3 center(std::uint32_t i) const {
    const double* c = centers_.data() + std::size_t{3} * i;
    return {c[0], c[1], c[2]};
  }

  // Brings the kernels of each class together, smallest first.
  template <class Body>
  void for_each_class(const Body& body) {
    const auto class_at = [&](std::size_t i) { return size_class(extents_[i].greatest); };
    int least = std::numeric_limits<int>::max();
    int greatest = std::numeric_limits<int>::min();
    for (std::size_t i = 0; i < items_.size(); ++i) {
      least = std::min(least, class_at(i));
      greatest = std::max(greatest, class_at(i));
    }
    std::vector<std::size_t> starts(static_cast<std::size_t>(greatest - least) + 2, 0);
    for (std::size_t i = 0; i < items_.size(); ++i)
      ++starts[static_cast<std::size_t>(class_at(i) - least) + 1];
    std::partial_sum(starts.begin(), starts.end(), starts.begin());
    std::vector<std::size_t> next(starts.begin(), starts.end() - 1);
    for (std::size_t i = 0; i < items_.size(); ++i)
      items_[next[static_cast<std::size_t>(class_at(i) - least)]++] = {
          0, static_cast<std::uint32_t>(i)};
    for (std::size_t c = 0; c + 1 < starts.size(); ++c) body(starts[c], starts[c + 1]);
  }

  // Through a cube of their own.
  void cut_whole(std::size_t begin, std::size_t end) {
    if (begin == end) return;
    Bounds3 box;
    for (std::size_t i = begin; i < end; ++i) box.extend(center(items_[i].index));
    const std::optional<MortonCube> cube = MortonCube::around(box);
    if (end - begin == 1 || !cube) {
      cut_evenly(begin, end);
      return;
    }
    sort_along(*cube, begin, end);
    NodeCutter(*this, 0).cut(begin, end, kKeyBits);
  }

  void sort_along(const MortonCube& cube, std::size_t begin, std::size_t end) {
    parallel_ranges({static_cast<std::int64_t>(end - begin), kKeyGrain, threads_},
                    [&](std::int64_t from, std::int64_t to) {
                      for (std::int64_t i = from; i < to; ++i) {
                        SortItem& item = items_[begin + static_cast<std::size_t>(i)];
                        item.key = cube.key_of(center(item.index));
                      }
                    });
    std::sort(items_.begin() + static_cast<std::ptrdiff_t>(begin),
              items_.begin() + static_cast<std::ptrdiff_t>(end),
              [](const SortItem& a, const SortItem& b) {
                return a.key != b.key ? a.key < b.key : a.index < b.index;
              });
  }

  // Kernels at one place, or so far apart that their distance is beyond a double.
  void cut_evenly(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; i += KernelBrick::kMaxBrickKernels) add_brick(i, end);
  }

  BrickOrder finished() {
    BrickOrder order;
    order.kernels.reserve(items_.size());
    for (const SortItem& item : items_) order.kernels.push_back(item.index);
    order.firsts = std::move(firsts_);
    return order;
  }

  std::span<const double> centers_;
  std::span<const KernelExtent> extents_;
  int threads_;
  std::vector<SortItem> items_;
  std::vector<std::size_t> firsts_;
};

}  // namespace

int size_class(float greatest_sigma) noexcept { return std::ilogb(greatest_sigma) / kClassOctaves; }

std::optional<MortonCube> MortonCube::around(const Bounds3& box) {
  const double edge = box.sizes().maxCoeff();
  if (!(edge > 0) || !std::isfinite(edge)) return std::nullopt;
  return MortonCube{box.min(), std::ldexp(1.0, kMortonBits) / edge * (1 - 1e-12)};
}

bool fits_a_brick(std::int64_t count, const Bounds3& centers, float least_sigma) {
  return count <= KernelBrick::kMaxBrickKernels &&
         (count == 0 ||
          centers.sizes().maxCoeff() <= kMaxExtent * static_cast<double>(least_sigma));
}

BrickOrder order_in_bricks(std::span<const double> centers, std::span<const KernelExtent> extents,
                           int threads, std::span<const KernelGroup> groups) {
  BrickCutter cutter(centers, extents, threads);
  return groups.empty() ? cutter.order_all() : cutter.order(groups);
}

}  // namespace ovoid::data
