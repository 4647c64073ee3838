// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/vdb_points.h"

#include <fmt/format.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "data/names_text.h"
#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using openvdb::points::AttributeArray;
using openvdb::points::AttributeHandle;
using openvdb::points::AttributeSet;
using openvdb::points::PointDataGrid;
using Leaf = openvdb::points::PointDataTree::LeafNodeType;

constexpr std::string_view kPositions = "P";
constexpr std::int64_t kMostAttributeComponents = 64;

// Writes the values of a leaf's points behind each other.
using WriteValues = void (*)(const AttributeArray&, std::byte*);

template <typename T>
void write_values(const AttributeArray& array, std::byte* to) {
  const AttributeHandle<T> handle(array);
  const openvdb::Index stride = array.stride();
  for (openvdb::Index point = 0; point < array.size(); ++point) {
    for (openvdb::Index i = 0; i < stride; ++i, to += sizeof(T)) {
      const T value = handle.get(point, i);
      std::memcpy(to, &value, sizeof(T));
    }
  }
}

// How values of a type that OpenVDB calls so become an array's.
struct ValueKind {
  std::string_view name;
  ScalarType type;
  int num_components;
  WriteValues write;
};

const ValueKind* kind_of(std::string_view name) {
  using namespace openvdb;
  static constexpr ValueKind kKinds[] = {
      {"float", ScalarType::kFloat32, 1, write_values<float>},
      {"double", ScalarType::kFloat64, 1, write_values<double>},
      {"bool", ScalarType::kUInt8, 1, write_values<bool>},
      {"int8", ScalarType::kInt8, 1, write_values<std::int8_t>},
      {"int16", ScalarType::kInt16, 1, write_values<std::int16_t>},
      {"int32", ScalarType::kInt32, 1, write_values<std::int32_t>},
      {"int64", ScalarType::kInt64, 1, write_values<std::int64_t>},
      {"vec3s", ScalarType::kFloat32, 3, write_values<Vec3f>},
      {"vec3d", ScalarType::kFloat64, 3, write_values<Vec3d>},
      {"vec3i", ScalarType::kInt32, 3, write_values<Vec3i>}};
  const auto* const found = std::find_if(std::begin(kKinds), std::end(kKinds),
                                         [&](const ValueKind& kind) { return kind.name == name; });
  return found == std::end(kKinds) ? nullptr : found;
}

// An attribute of all leaves, as that of the first is.
struct Attribute {
  std::string name;
  const ValueKind* kind = nullptr;
  std::int64_t stride = 1;
  DataArray array;
  std::byte* to = nullptr;

  std::int64_t bytes_of_point() const noexcept {
    return stride * kind->num_components * static_cast<std::int64_t>(size_of(kind->type));
  }
};

class PointReader {
 public:
  PointReader(VdbFile& file, const VdbGrid& grid, const ReadOptions& options, Dataset& dataset)
      : file_(file), described_(grid), options_(options), dataset_(dataset) {}

  void read() {
    const openvdb::GridBase::Ptr base = file_.read(described_);
    const auto grid = openvdb::GridBase::grid<PointDataGrid>(base);
    file_.guarded([&] { check(*grid); });
    if (num_points_ == 0) fail("has no points");
    list_attributes(*grid);
    dataset_.kind = DatasetKind::kParticles;
    std::byte* to = nullptr;
    dataset_.positions = new_array({"", ScalarType::kFloat64, 3, num_points_, "", false, {}}, to);
    ReadProgress progress(options_, num_bytes_);
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf)
      file_.guarded([&] { read_leaf(*leaf, grid->transform(), to, progress); });
    for (Attribute& attribute : attributes_) dataset_.arrays.push_back(std::move(attribute.array));
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code, fmt::format("{}: grid '{}' {}", file_.source(), described_.name, what));
  }

  // Every leaf's points are counted, and all its attributes have as many values.
  void check(const PointDataGrid& grid) {
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
      const AttributeSet& set = leaf->attributeSet();
      const std::size_t at = set.find(std::string(kPositions));
      if (at == AttributeSet::INVALID_POS) fail("has points without a place");
      leaf->validateOffsets();
      const AttributeArray& positions = *set.getConst(at);
      if (positions.valueType() != std::string_view("vec3s") || positions.stride() != 1) {
        fail(fmt::format("has places of type {}: expected vec3s", positions.valueType()),
             ErrorCode::kUnsupported);
      }
      num_points_ += positions.size();
    }
  }

  void list_attributes(const PointDataGrid& grid) {
    const AttributeSet& set = grid.tree().cbeginLeaf()->attributeSet();
    std::vector<std::string> left_out;
    num_bytes_ = num_points_ * 3 * static_cast<std::int64_t>(sizeof(double));
    for (const auto& [name, at] : set.descriptor().map()) {
      const AttributeArray& stored = *set.getConst(at);
      if (name == kPositions || openvdb::points::isGroup(stored)) continue;
      Attribute attribute;
      attribute.name = name;
      attribute.kind = kind_of(std::string(stored.valueType()));
      attribute.stride = stored.stride();
      const bool is_read =
          attribute.kind != nullptr && stored.hasConstantStride() &&
          !openvdb::points::isString(stored) &&
          attribute.stride * attribute.kind->num_components <= kMostAttributeComponents;
      if (!is_read) {
        left_out.push_back(name);
        continue;
      }
      num_bytes_ += num_points_ * attribute.bytes_of_point();
      attributes_.push_back(std::move(attribute));
    }
    require_memory(fmt::format("{}: {} points with {} attributes", file_.source(), num_points_,
                               attributes_.size()),
                   num_bytes_);
    for (Attribute& attribute : attributes_) {
      const auto components = static_cast<int>(attribute.stride * attribute.kind->num_components);
      attribute.array =
          new_array({attribute.name, attribute.kind->type, components, num_points_, "", false, {}},
                    attribute.to);
    }
    if (left_out.empty()) return;
    dataset_.notes.push_back(fmt::format("{}: attributes that hold no numbers are left out: {}",
                                         file_.source(), data::names_text(left_out)));
  }

  void read_leaf(const Leaf& leaf, const openvdb::math::Transform& transform, std::byte*& to,
                 ReadProgress& progress) {
    const AttributeSet& set = leaf.attributeSet();
    const AttributeArray& places = *set.getConst(set.find(std::string(kPositions)));
    const AttributeHandle<openvdb::Vec3f> handle(places);
    openvdb::Index point = 0;
    for (openvdb::Index voxel = 0; voxel < Leaf::SIZE; ++voxel) {
      const openvdb::Vec3d at = leaf.offsetToGlobalCoord(voxel).asVec3d();
      for (const openvdb::Index end = leaf.getValue(voxel); point < end; ++point) {
        const openvdb::Vec3d world = transform.indexToWorld(at + handle.get(point));
        std::memcpy(to, world.asPointer(), 3 * sizeof(double));
        to += 3 * sizeof(double);
      }
    }
    for (Attribute& attribute : attributes_) {
      const std::size_t at_name = set.find(attribute.name);
      const AttributeArray* const stored =
          at_name == AttributeSet::INVALID_POS ? nullptr : set.getConst(at_name);
      if (stored == nullptr || stored->valueType() != attribute.kind->name ||
          stored->stride() != attribute.stride || stored->size() != places.size())
        fail(fmt::format("has leaves with different attributes '{}'", attribute.name));
      attribute.kind->write(*stored, attribute.to);
      attribute.to += static_cast<std::int64_t>(places.size()) * attribute.bytes_of_point();
    }
    progress.advance(static_cast<std::int64_t>(places.size()) * num_bytes_ / num_points_);
  }

  VdbFile& file_;
  const VdbGrid& described_;
  const ReadOptions& options_;
  Dataset& dataset_;
  std::int64_t num_points_ = 0;
  std::int64_t num_bytes_ = 0;
  std::vector<Attribute> attributes_;
};

}  // namespace

void read_vdb_points(VdbFile& file, const VdbGrid& grid, const ReadOptions& options,
                     Dataset& dataset) {
  PointReader(file, grid, options, dataset).read();
}

}  // namespace ovoid::io
