// SPDX-License-Identifier: Apache-2.0
// From a tree of voxels to a lattice's samples. The background is written everywhere first, then
// what the tree says otherwise: tiles, then leaves of 8^3 voxels. Nothing in a file says where
// memory is written: nodes are cut off at the box, wherever they claim to be.
#include "io/foreign/vdb_samples.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "data/scalar_visit.h"
#include "io/core/point_arrays.h"
#include "io/core/work_done.h"

namespace ovoid::io {
namespace {

// What a voxel's value is in the array.
template <typename T>
struct Stored {
  using Type = T;
};
template <>
struct Stored<bool> {
  using Type = std::uint8_t;
};
template <typename T>
struct Stored<openvdb::math::Vec3<T>> {
  using Type = openvdb::math::Vec3<T>;
  static_assert(sizeof(Type) == 3 * sizeof(T));
};

template <typename T>
class BoxOfSamples {
 public:
  BoxOfSamples(const VoxelBox& box, T* samples) : box_(box), dims_(box.dims()), samples_(samples) {}

  void fill(T value, ReadProgress& progress) {
    constexpr std::int64_t kStep = ReadProgress::kChunk / static_cast<std::int64_t>(sizeof(T));
    const std::int64_t count = dims_[0] * dims_[1] * dims_[2];
    for (std::int64_t i = 0; i < count; i += kStep) {
      const std::int64_t now = std::min(kStep, count - i);
      std::fill_n(samples_ + i, now, value);
      progress.advance(now * static_cast<std::int64_t>(sizeof(T)));
    }
  }

  // The node of dim^3 voxels at `origin`, as far as it is in the box. `value_at(x, y, z)`: of the
  // voxel there, counted from its origin.
  template <typename Value>
  void write_node(const openvdb::Coord& origin, std::int64_t dim, const Value& value_at) {
    Index3 first, last;  // within the node
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t at = origin[static_cast<int>(a)];
      first[a] = std::max<std::int64_t>(box_.first[a] - at, 0);
      last[a] = std::min<std::int64_t>(box_.last[a] - at, dim - 1);
      if (last[a] < first[a]) return;
    }
    add_work_done((last[0] - first[0] + 1) * (last[1] - first[1] + 1) * (last[2] - first[2] + 1) *
                  static_cast<std::int64_t>(sizeof(T)));
    for (std::int64_t z = first[2]; z <= last[2]; ++z) {
      for (std::int64_t y = first[1]; y <= last[1]; ++y) {
        const std::int64_t row =
            ((z + origin[2] - box_.first[2]) * dims_[1] + y + origin[1] - box_.first[1]) * dims_[0];
        T* const to = samples_ + row + (origin[0] - box_.first[0]);
        for (std::int64_t x = first[0]; x <= last[0]; ++x) to[x] = value_at(x, y, z);
      }
    }
  }

 private:
  VoxelBox box_;
  Index3 dims_;
  T* samples_;
};

template <typename Tree, typename T>
void write_tiles(const Tree& tree, BoxOfSamples<T>& box) {
  const auto background = static_cast<T>(tree.background());
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    const auto value = static_cast<T>(*tile);
    if (value == background) continue;
    openvdb::CoordBBox where;
    tile.getBoundingBox(where);
    // From the level, since the far end of a damaged one may not be a number.
    std::int64_t dim = 1;
    switch (tile.getLevel()) {
      case 1:
        dim = Tree::LeafNodeType::DIM;
        break;
      case 2:
        dim = Tree::RootNodeType::ChildNodeType::ChildNodeType::DIM;
        break;
      default:
        dim = Tree::RootNodeType::ChildNodeType::DIM;
        break;
    }
    box.write_node(where.min(), dim,
                   [value](std::int64_t, std::int64_t, std::int64_t) { return value; });
  }
}

template <typename Tree, typename T>
void write_leaves(const Tree& tree, BoxOfSamples<T>& box) {
  using Leaf = typename Tree::LeafNodeType;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    box.write_node(leaf->origin(), Leaf::DIM, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
      constexpr std::int64_t kBits = Leaf::LOG2DIM;
      const std::int64_t offset = (((x << kBits) + y) << kBits) + z;
      return static_cast<T>(leaf->getValue(static_cast<openvdb::Index>(offset)));
    });
  }
}

template <typename Grid>
void write_samples(const Grid& grid, const VoxelBox& box, std::byte* to, ReadProgress& progress) {
  using T = typename Stored<typename Grid::ValueType>::Type;
  BoxOfSamples<T> samples(box, reinterpret_cast<T*>(to));
  samples.fill(static_cast<T>(grid.background()), progress);
  write_tiles(grid.tree(), samples);
  write_leaves(grid.tree(), samples);
}

using GridsOfNumbers =
    openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid,
                      openvdb::Int64Grid, openvdb::BoolGrid, openvdb::MaskGrid, openvdb::Vec3SGrid,
                      openvdb::Vec3DGrid, openvdb::Vec3IGrid>;

}  // namespace

DataArray dense_samples(const openvdb::GridBase& grid, const VdbGrid& described,
                        const VoxelBox& box, ReadProgress& progress) {
  const Index3 dims = box.dims();
  DataArray description;
  description.name = described.name;
  description.type = described.values->type;
  description.num_components = described.values->num_components;
  description.num_tuples = dims[0] * dims[1] * dims[2];
  std::byte* to = nullptr;
  DataArray array = new_array(std::move(description), to);
  [[maybe_unused]] const bool is_known = grid.apply<GridsOfNumbers>(
      [&](const auto& typed) { write_samples(typed, box, to, progress); });
  assert(is_known);
  return array;
}

}  // namespace ovoid::io
