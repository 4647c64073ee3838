// SPDX-License-Identifier: Apache-2.0
// Space cut in two, again and again, until there are as many parts as are wanted.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ovoid/error.h"
#include "ovoid/kernel_field.h"
#include "ovoid/space_part.h"

namespace ovoid {
namespace {

// The two sides of the plane dot(normal, x) = offset.
SpacePart with_side(const SpacePart& part, const Vec3& normal, double offset, bool is_beyond) {
  SpacePart out = part;
  out.sides.push_back({normal, offset, is_beyond});
  return out;
}

class LatticeSplitter {
 public:
  LatticeSplitter(const LatticeGeometry& geometry, std::vector<SpacePart>& parts)
      : index_from_world_(geometry.world_from_index.inverse()), parts_(parts) {}

  // Samples [lo, hi) along each axis.
  void split(const Index3& lo, const Index3& hi, const SpacePart& part, int count) {
    if (count == 1) {
      parts_.push_back(part);
      return;
    }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 3; ++a) {
      if (hi[a] - lo[a] > hi[axis] - lo[axis]) axis = a;
    }
    const int before = count / 2;
    const double begin = static_cast<double>(lo[axis]);
    double at = begin + static_cast<double>(hi[axis] - lo[axis]) * before / count;
    const double brick = kBrickEdge;
    if (hi[axis] - lo[axis] >= count * kBrickEdge) at = std::round(at / brick) * brick;
    Index3 middle_hi = hi;
    Index3 middle_lo = lo;
    middle_hi[axis] = middle_lo[axis] = static_cast<std::int64_t>(std::floor(at));
    // Half a sample before number `at`: between two samples, where it is a whole number.
    const auto row = static_cast<Eigen::Index>(axis);
    const Vec3 normal = index_from_world_.linear().row(row).transpose();
    const double offset = at - 0.5 - index_from_world_.translation()[row];
    split(lo, middle_hi, with_side(part, normal, offset, false), before);
    split(middle_lo, hi, with_side(part, normal, offset, true), count - before);
  }

 private:
  static constexpr int kBrickEdge = 8;

  Affine3 index_from_world_;
  std::vector<SpacePart>& parts_;
};

class KernelSplitter {
 public:
  KernelSplitter(const KernelSource& source, std::vector<SpacePart>& parts)
      : source_(source), parts_(parts) {}

  void split(std::span<std::int64_t> bricks, const SpacePart& part, int count) {
    if (count == 1) {
      parts_.push_back(part);
      return;
    }
    Bounds3 middles;
    std::int64_t num_kernels = 0;
    for (const std::int64_t brick : bricks) {
      middles.extend(middle_of(brick));
      num_kernels += source_.brick(brick).count;
    }
    Eigen::Index axis = 0;
    if (!middles.isEmpty()) middles.sizes().maxCoeff(&axis);
    std::sort(bricks.begin(), bricks.end(), [&](std::int64_t a, std::int64_t b) {
      return std::pair(middle_of(a)[axis], a) < std::pair(middle_of(b)[axis], b);
    });
    const int before = count / 2;
    const std::int64_t wanted = num_kernels * before / count;
    std::size_t middle = 0;
    for (std::int64_t sum = 0; middle < bricks.size() && sum < wanted; ++middle)
      sum += source_.brick(bricks[middle]).count;
    double at = 0;  // of no bricks: anywhere
    if (!bricks.empty())
      at = 0.5 * (middle_of(bricks[middle > 0 ? middle - 1 : 0])[axis] +
                  middle_of(bricks[std::min(middle, bricks.size() - 1)])[axis]);
    const Vec3 normal = Vec3::Unit(axis);
    split(bricks.first(middle), with_side(part, normal, at, false), before);
    split(bricks.subspan(middle), with_side(part, normal, at, true), count - before);
  }

 private:
  Vec3 middle_of(std::int64_t brick) const { return source_.brick(brick).support.center(); }

  const KernelSource& source_;
  std::vector<SpacePart>& parts_;
};

}  // namespace

std::vector<SpacePart> split_space(const Field& field, int count) {
  if (count < 1 || count > kMostParts)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("parts: {}, must be 1 to {}", count, kMostParts));
  std::vector<SpacePart> parts;
  if (const KernelField* const set = field.kernels()) {
    std::vector<std::int64_t> bricks(static_cast<std::size_t>(set->source().num_bricks()));
    std::iota(bricks.begin(), bricks.end(), 0);
    KernelSplitter(set->source(), parts).split(bricks, {}, count);
  } else if (const LatticeField* const lattice = field.lattice()) {
    LatticeSplitter(lattice->geometry(), parts)
        .split({0, 0, 0}, lattice->geometry().dims, {}, count);
  } else {
    throw Error(ErrorCode::kInvalidArgument, "field: is empty");
  }
  return parts;
}

}  // namespace ovoid
