// SPDX-License-Identifier: Apache-2.0
// The order of kernels in bricks. They are sorted by size class, then along a Morton curve within
// the class, and cut into bricks at the nodes of the octree that the curve follows. Kernels of one
// brick are so of similar size, their offsets from its origin keep their digits even where radii
// span eight decades, and a brick's box is not blown up by one large kernel.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "data/kernels/morton.h"
#include "ovoid/kernel_field.h"

namespace ovoid::data {

inline constexpr int kKeyBits = 3 * kMortonBits;

// Sigmas of a kernel's shortest and longest axis.
struct KernelExtent {
  float least = 0, greatest = 0;
};

// Sizes within a factor 4 share a class.
int size_class(float greatest_sigma) noexcept;

// The cube that a Morton curve runs through; none where there is no extent to run through, or one
// beyond a double.
struct MortonCube {
  Vec3 low = Vec3::Zero();
  double scale = 1;  // to the curve's integers

  static std::optional<MortonCube> around(const Bounds3& box);
  std::uint64_t key_of(const Vec3& at) const { return morton_key((at - low) * scale); }
};

// Whether kernels can be a brick: so many of them, with centres in the box, none smaller than the
// sigma.
bool fits_a_brick(std::int64_t count, const Bounds3& centers, float least_sigma);

// Cuts items in the order of their keys at the nodes of the octree. Items has: key(i);
// fits(begin, end), whether they can be a brick; add_brick(begin, end); and
// cut_below(begin, end), for what cannot at a node whose keys are the same down to bit `last`.
template <class Items>
class NodeCutter {
 public:
  NodeCutter(Items& items, int last) : items_(items), last_(last) {}

  // A node: the items [begin, end), equal in all bits of their keys from `bits` up.
  void cut(std::size_t begin, std::size_t end, int bits) {
    if (begin == end) return;
    if (items_.fits(begin, end)) return items_.add_brick(begin, end);
    if (bits == last_) return items_.cut_below(begin, end);
    const int below = bits - 3;
    std::size_t first = begin;  // of the children that wait to share a brick
    std::size_t from = begin;
    for (std::uint64_t child = 0; child < 8; ++child) {
      const std::size_t to = end_of_child(from, end, below, child);
      if (!items_.fits(first, to)) {
        if (first < from) items_.add_brick(first, from);
        first = from;
        if (!items_.fits(from, to)) {
          cut(from, to, below);
          first = to;
        }
      }
      from = to;
    }
    if (first < end) items_.add_brick(first, end);
  }

 private:
  std::size_t end_of_child(std::size_t from, std::size_t end, int below,
                           std::uint64_t child) const {
    std::size_t count = end - from;
    while (count > 0) {
      const std::size_t half = count / 2;
      if ((items_.key(from + half) >> below & 7U) <= child) {
        from += half + 1;
        count -= half + 1;
      } else {
        count = half;
      }
    }
    return from;
  }

  Items& items_;
  int last_;
};

// Kernels of a part of the order, before they are cut.
struct KernelGroup {
  enum class Kind {
    kClass,  // all of a size class: with a curve of its own
    kNode,   // of a node of the octree, equal in the bits of their keys from `bits` up
    kBrick,  // a brick
  };
  Kind kind = Kind::kClass;
  std::size_t begin = 0, end = 0;  // kernels, by number
  MortonCube cube{};               // of nodes and bricks
  int bits = kKeyBits;             // of nodes
};

// Numbers of kernels in the order of their bricks, and where each of these begins.
struct BrickOrder {
  std::vector<std::uint32_t> kernels;
  std::vector<std::size_t> firsts;

  std::size_t count_of(std::size_t brick) const noexcept {
    return (brick + 1 < firsts.size() ? firsts[brick + 1] : kernels.size()) - firsts[brick];
  }
};

// `centers` [n, 3]. Of equal keys the lower number comes first, so that the order is one. Without
// groups the kernels are all that there are.
BrickOrder order_in_bricks(std::span<const double> centers, std::span<const KernelExtent> extents,
                           int threads, std::span<const KernelGroup> groups = {});

}  // namespace ovoid::data
