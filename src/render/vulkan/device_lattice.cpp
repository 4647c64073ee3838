// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/device_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "data/parallel.h"
#include "ovoid/error.h"

namespace ovoid::vulkan {
namespace {

constexpr std::int64_t kCubeEdge = device::kStoredEdge;
constexpr std::int64_t kEndless = std::int64_t{1} << 30;

std::int64_t cubes(std::int64_t lo, std::int64_t hi) {
  return (hi - lo + kCubeEdge - 1) / kCubeEdge;
}

Index3 brick_counts(const BrickSource& source) {
  Index3 counts = source.geometry().cells();
  for (std::int64_t& n : counts) n = (n + source.brick_edge() - 1) / source.brick_edge();
  return counts;
}

// Where a box's samples go.
struct Packing {
  std::byte* to;
  Index3 lo, hi;     // cells
  std::size_t size;  // of a sample
  std::int64_t cubes_x, cubes_y, cubes_z;

  std::byte* row(std::int64_t sublattice, std::int64_t x, std::int64_t y, std::int64_t z) const {
    const std::int64_t cube = ((z / kCubeEdge) * cubes_y + y / kCubeEdge) * cubes_x +
                              x / kCubeEdge + sublattice * cubes_x * cubes_y * cubes_z;
    const std::int64_t sample = cube * (kCubeEdge * kCubeEdge * kCubeEdge) +
                                ((z % kCubeEdge) * kCubeEdge + y % kCubeEdge) * kCubeEdge +
                                x % kCubeEdge;
    return to + static_cast<std::size_t>(sample) * size;
  }
};

// Copies what a brick's view has of cells [lo, hi), which lie in the box.
void copy_brick(const BrickView& view, const Packing& packing, int num_sublattices,
                const Index3& lo, const Index3& hi) {
  const auto* from = static_cast<const std::byte*>(view.data);
  for (std::int64_t layer = std::max(lo[2] * num_sublattices, view.lo[2]);
       layer < std::min(hi[2] * num_sublattices, view.hi[2]); ++layer) {
    const std::int64_t sublattice = layer % num_sublattices;
    const std::int64_t z = layer / num_sublattices - packing.lo[2];
    for (std::int64_t j = std::max(lo[1], view.lo[1]); j < std::min(hi[1], view.hi[1]); ++j) {
      const std::int64_t first = std::max(lo[0], view.lo[0]);
      const std::int64_t last = std::min(hi[0], view.hi[0]);
      const std::byte* row =
          from + static_cast<std::size_t>((first - view.lo[0]) + (j - view.lo[1]) * view.stride_y +
                                          (layer - view.lo[2]) * view.stride_z) *
                     packing.size;
      for (std::int64_t i = first; i < last;) {
        const std::int64_t x = i - packing.lo[0];
        const std::int64_t count = std::min(last - i, kCubeEdge - x % kCubeEdge);
        const std::size_t bytes = static_cast<std::size_t>(count) * packing.size;
        std::memcpy(packing.row(sublattice, x, j - packing.lo[1], z), row, bytes);
        row += bytes;
        i += count;
      }
    }
  }
}

}  // namespace

std::size_t stored_size(const LatticeField& field) {
  return size_of(field.source().acquire(0, 0, 0, 0.0).type);
}

DeviceLattice::DeviceLattice(std::shared_ptr<Device> device, const LatticeField& field,
                             const BoxCut& cut)
    : device_(std::move(device)),
      id_(field.id()),
      version_(field.version()),
      cells_(field.geometry().cells()),
      num_sublattices_(field.geometry().num_sublattices()),
      cut_(cut),
      residency_(cut.most_bytes) {
  const BrickSource& source = field.source();
  type_ = source.acquire(0, 0, 0, 0.0).type;
  const Index3 counts = brick_counts(source);
  missing_.resize(static_cast<std::size_t>(num_samples(counts)));
  std::atomic<bool> any = false;
  data::parallel_ranges({counts[2], 4, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    bool any_here = false;
    for (std::int64_t z = begin; z < end; ++z) {
      for (std::int64_t y = 0; y < counts[1]; ++y) {
        for (std::int64_t x = 0; x < counts[0]; ++x) {
          if (!source.has_missing(x, y, z)) continue;
          missing_[static_cast<std::size_t>((z * counts[1] + y) * counts[0] + x)] =
              static_cast<std::uint8_t>(device::kMissingBit);
          any_here = true;
        }
      }
    }
    if (any_here) any = true;
  });
  may_miss_ = any;
  cut_boxes(std::min<std::uint64_t>(cut.most_bytes, device_->limits().maxStorageBufferRange));
}

std::uint64_t DeviceLattice::bytes_of(const Index3& lo, const Index3& hi) const noexcept {
  const std::int64_t count = cubes(lo[0], hi[0]) * cubes(lo[1], hi[1]) * cubes(lo[2], hi[2]);
  return static_cast<std::uint64_t>(count) * (kCubeEdge * kCubeEdge * kCubeEdge) *
         static_cast<std::uint64_t>(num_sublattices_) * size_of(type_);
}

// Halves the longest side until the largest box fits.
void DeviceLattice::cut_boxes(std::uint64_t most_bytes) {
  for (;;) {
    boxes_.clear();
    Index3 edge{};
    for (std::size_t a = 0; a < 3; ++a) edge[a] = (cells_[a] + num_boxes_[a] - 1) / num_boxes_[a];
    std::uint64_t largest = 0;
    Index3 b{};
    for (b[2] = 0; b[2] < num_boxes_[2]; ++b[2]) {
      for (b[1] = 0; b[1] < num_boxes_[1]; ++b[1]) {
        for (b[0] = 0; b[0] < num_boxes_[0]; ++b[0]) {
          LatticeBox box;
          for (std::size_t a = 0; a < 3; ++a) {
            box.own_lo[a] = std::min(b[a] * edge[a], cells_[a]);
            box.own_hi[a] = std::min(box.own_lo[a] + edge[a], cells_[a]);
            box.stored_lo[a] =
                std::max<std::int64_t>(box.own_lo[a] - cut_.reach, 0) / kCubeEdge * kCubeEdge;
            box.stored_hi[a] = std::min(box.own_hi[a] + cut_.reach, cells_[a]);
          }
          box.bytes = bytes_of(box.stored_lo, box.stored_hi);
          largest = std::max(largest, box.bytes / size_of(type_) * cut_.sample_bytes);
          boxes_.push_back(std::move(box));
        }
      }
    }
    if (largest <= most_bytes) return;
    const auto longest =
        static_cast<std::size_t>(std::max_element(edge.begin(), edge.end()) - edge.begin());
    if (edge[longest] <= kCubeEdge)
      throw Error(ErrorCode::kOutOfMemory,
                  fmt::format("backend vulkan: {} bytes of device memory hold no part of the field "
                              "with all that its kernels reach: expected a larger device memory "
                              "limit, or backend cpu",
                              most_bytes));
    num_boxes_[longest] *= 2;
  }
}

std::vector<std::size_t> DeviceLattice::front_to_back(const Vec3& eye) const {
  // A ray goes away from the eye's box along every axis, so sums of distances rise.
  std::vector<std::pair<std::int64_t, std::size_t>> order;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const LatticeBox& box = boxes_[i];
    std::int64_t distance = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double at = eye[static_cast<Eigen::Index>(a)];
      const std::int64_t edge = boxes_.front().own_hi[a] - boxes_.front().own_lo[a];
      const double clamped = std::clamp(at, -1.0, static_cast<double>(cells_[a]));
      // Before all boxes, behind all, or in one.
      const std::int64_t eye_box = at < 0 ? -1
                                   : at >= static_cast<double>(cells_[a])
                                       ? num_boxes_[a]
                                       : static_cast<std::int64_t>(clamped) / edge;
      distance += std::abs(box.own_lo[a] / edge - eye_box);
    }
    order.emplace_back(distance, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> numbers;
  numbers.reserve(order.size());
  for (const auto& [distance, i] : order) {
    const LatticeBox& box = boxes_[i];
    if (box.own_lo[0] < box.own_hi[0] && box.own_lo[1] < box.own_hi[1] &&
        box.own_lo[2] < box.own_hi[2])
      numbers.push_back(i);
  }
  return numbers;
}

std::vector<std::byte> DeviceLattice::pack(const LatticeBox& box, const LatticeField& field) const {
  const BrickSource& source = field.source();
  std::vector<std::byte> bytes(box.bytes);
  const Packing packing{bytes.data(),
                        box.stored_lo,
                        box.stored_hi,
                        size_of(type_),
                        cubes(box.stored_lo[0], box.stored_hi[0]),
                        cubes(box.stored_lo[1], box.stored_hi[1]),
                        cubes(box.stored_lo[2], box.stored_hi[2])};
  const std::int64_t edge = source.brick_edge();
  Index3 first{}, last{};
  for (std::size_t a = 0; a < 3; ++a) {
    first[a] = box.stored_lo[a] / edge;
    last[a] = (box.stored_hi[a] + edge - 1) / edge;
  }
  data::parallel_ranges({last[2] - first[2], 1, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t bz = first[2] + begin; bz < first[2] + end; ++bz) {
      for (std::int64_t by = first[1]; by < last[1]; ++by) {
        for (std::int64_t bx = first[0]; bx < last[0]; ++bx) {
          const Index3 b{bx, by, bz};
          Index3 lo{}, hi{};
          for (std::size_t a = 0; a < 3; ++a) {
            lo[a] = std::max(b[a] * edge, box.stored_lo[a]);
            hi[a] = std::min((b[a] + 1) * edge, box.stored_hi[a]);
          }
          copy_brick(source.acquire(bx, by, bz, 0.0), packing, num_sublattices_, lo, hi);
        }
      }
    }
  });
  return bytes;
}

const LatticeBox& DeviceLattice::acquire(std::size_t box, const LatticeField& field,
                                         Commands& commands) {
  LatticeBox& own = boxes_[box];
  residency_.touch(own);
  if (own.data.is_empty())
    residency_.send<LatticeBox>(own, boxes_, pack(own, field), device_, commands);
  return own;
}

device::BoxConstants DeviceLattice::constants_of(const LatticeBox& box) const {
  device::BoxConstants constants{};
  const auto outer = [&](std::int64_t at, std::size_t a) {
    const std::int64_t end = at <= 0 ? -kEndless : at >= cells_[a] ? kEndless : at;
    return static_cast<std::int32_t>(end);
  };
  const auto whole = [](std::int64_t n) { return static_cast<std::int32_t>(n); };
  constants.own_lo = {outer(box.own_lo[0], 0), outer(box.own_lo[1], 1), outer(box.own_lo[2], 2), 0};
  constants.own_hi = {outer(box.own_hi[0], 0), outer(box.own_hi[1], 1), outer(box.own_hi[2], 2), 0};
  constants.stored_lo = {whole(box.stored_lo[0]), whole(box.stored_lo[1]), whole(box.stored_lo[2]),
                         0};
  const Index3 stored{cubes(box.stored_lo[0], box.stored_hi[0]),
                      cubes(box.stored_lo[1], box.stored_hi[1]),
                      cubes(box.stored_lo[2], box.stored_hi[2])};
  constants.stored_bricks = {whole(stored[0]), whole(stored[1]), whole(stored[2]),
                             whole(stored[0] * stored[1] * stored[2] * kCubeEdge * kCubeEdge)};
  return constants;
}

}  // namespace ovoid::vulkan
