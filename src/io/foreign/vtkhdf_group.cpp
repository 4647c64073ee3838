// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/vtkhdf_group.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_storage.h"

namespace ovoid::io {
namespace {

constexpr std::size_t kMostMembers = 100'000;
constexpr std::int64_t kMostCounts = std::int64_t{1} << 24;

// The numbers of another file, which the guard before the system's open() lets through or not.
bool lies_elsewhere(hid_t dataset) {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  return plist.is_open() && H5Pget_external_count(plist.get()) > 0;
}

}  // namespace

VtkHdfArray::VtkHdfArray(const Hdf5Objects& objects, Hdf5Handle dataset, std::string place)
    : objects_(&objects), dataset_(std::move(dataset)), place_(std::move(place)) {
  extent_.where = fmt::format("{}: '{}'", objects.name(), place_);
  const Hdf5Handle space(H5Dget_space(dataset_.get()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset_.get()), H5Tclose);
  const auto known = type.is_open() ? hdf5_type_of(type.get()) : std::nullopt;
  if (!known)
    objects.fail(fmt::format("'{}' holds no integers or IEEE floats", place_),
                 ErrorCode::kUnsupported);
  extent_.type = *known;
  const int rank = space.is_open() ? H5Sget_simple_extent_ndims(space.get()) : -1;
  std::array<hsize_t, Hdf5Extent::kMaxRank> sizes{};
  if (rank < 1 || rank > static_cast<int>(sizes.size()) ||
      H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr) != rank)
    objects.fail(fmt::format("'{}': expected 1 to {} axes", place_, sizes.size()));
  for (int axis = 0; axis < rank; ++axis) {
    extent_.dims.push_back(static_cast<std::int64_t>(
        std::min(sizes[static_cast<std::size_t>(axis)], static_cast<hsize_t>(kMaxNumBytes))));
  }
  if (extent_.dims[0] == 0) return;
  checked_num_bytes(extent_.where, extent_.dims, extent_.type.type);
  if (!lies_elsewhere(dataset_.get()))
    check_hdf5_storage(dataset_.get(), extent_, objects.source());
}

DataArray VtkHdfArray::rows(std::int64_t first, std::int64_t count, ReadProgress& progress) const {
  if (first < 0 || count < 0 || first > num_rows() || count > num_rows() - first)
    objects_->fail(fmt::format("'{}' has {} rows: {} from {} on are asked for", place_, num_rows(),
                               count, first));
  std::int64_t row_size = 1;
  for (std::size_t axis = 1; axis < extent_.dims.size(); ++axis) row_size *= extent_.dims[axis];
  constexpr std::int64_t kMostComponents = std::int64_t{1} << 20;
  DataArray array;
  array.type = extent_.type.type;
  array.num_tuples = count;
  if (count > 0 && row_size > kMostComponents) {
    // One layer of a volume, whose axes its reader knows.
    array.num_tuples = count * row_size;
    row_size = 1;
  }
  array.num_components = static_cast<int>(row_size);
  if (count == 0) return array;
  const std::int64_t num_bytes = array.num_tuples * row_size * extent_.item_size();
  require_memory(extent_.where, num_bytes);
  std::byte* to = nullptr;
  array = new_array(std::move(array), to);
  read_hdf5_rows(dataset_.get(), extent_, first, {to, static_cast<std::size_t>(num_bytes)},
                 progress);
  return array;
}

std::vector<VtkHdfGroup::Member> VtkHdfGroup::members() const {
  std::vector<Member> members;
  const auto add = [](hid_t, const char* name, const H5L_info_t* info, void* to) -> herr_t {
    auto& all = *static_cast<std::vector<Member>*>(to);
    all.push_back({name, info->type, H5O_TYPE_UNKNOWN});
    return all.size() > kMostMembers ? -1 : 0;
  };
  if (H5Literate(id(), H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &members) < 0)
    objects().fail(
        fmt::format("group '{}' is broken or has more than {} members", place_, kMostMembers));
  for (Member& member : members) {
    H5O_info_t info{};
    if (member.link == H5L_TYPE_HARD &&
        H5Oget_info_by_name(id(), member.name.c_str(), &info, H5P_DEFAULT) >= 0)
      member.type = info.type;
  }
  return members;
}

bool VtkHdfGroup::has(const std::string& name) const {
  return H5Lexists(id(), name.c_str(), H5P_DEFAULT) > 0;
}

std::optional<VtkHdfGroup> VtkHdfGroup::group(const std::string& name) const {
  if (!has(name)) return std::nullopt;
  std::string place = fmt::format("{}/{}", place_, name);
  Hdf5Handle inner = objects().open(id(), name, place, H5O_TYPE_GROUP);
  return VtkHdfGroup(*file_, std::move(inner), std::move(place));
}

const VtkHdfArray& VtkHdfGroup::needed(const std::string& name) const {
  std::string place = fmt::format("{}/{}", place_, name);
  const auto known = file_->arrays.find(place);
  if (known != file_->arrays.end()) return known->second;
  VtkHdfArray array(objects(), objects().open(id(), name, place, H5O_TYPE_DATASET), place);
  return file_->arrays.emplace(std::move(place), std::move(array)).first->second;
}

std::vector<std::int64_t> VtkHdfGroup::counts(const std::string& name) const {
  const VtkHdfArray& array = needed(name);
  if (array.num_rows() > kMostCounts)
    objects().fail(fmt::format("'{}' has more than {} rows", array.place(), kMostCounts),
                   ErrorCode::kUnsupported);
  const ReadOptions options;
  ReadProgress progress(options, 0);
  return whole_numbers_of(objects(), array.place(), array.rows(0, array.num_rows(), progress));
}

std::int64_t VtkHdfGroup::count_at(const std::string& name, std::int64_t row,
                                   std::int64_t column) const {
  const VtkHdfArray& array = needed(name);
  const ReadOptions options;
  ReadProgress progress(options, 0);
  const auto numbers = whole_numbers_of(objects(), array.place(), array.rows(row, 1, progress));
  if (column >= static_cast<std::int64_t>(numbers.size()))
    objects().fail(fmt::format("'{}' has {} numbers a row: expected {}", array.place(),
                               numbers.size(), column + 1));
  return numbers[static_cast<std::size_t>(column)];
}

std::string VtkHdfGroup::text(const char* name) const {
  constexpr std::size_t kLongest = 64;
  if (H5Aexists(id(), name) <= 0) return {};
  const Hdf5Handle attribute(H5Aopen(id(), name, H5P_DEFAULT), H5Aclose);
  if (!attribute.is_open()) return {};
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1)
    return {};
  if (H5Tis_variable_str(type.get()) > 0) {
    char* letters = nullptr;
    if (H5Aread(attribute.get(), type.get(), &letters) < 0 || letters == nullptr) return {};
    std::string text(letters, ::strnlen(letters, kLongest));
    H5free_memory(letters);
    return text;
  }
  const std::size_t size = H5Tget_size(type.get());
  if (size < 1 || size > kLongest) return {};
  std::string text(size, '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return {};
  text.resize(std::min(text.size(), text.find('\0')));
  while (text.ends_with(' ')) text.pop_back();
  return text;
}

std::vector<std::int64_t> whole_numbers_of(const Hdf5Objects& objects, const std::string& place,
                                           const DataArray& array) {
  std::vector<std::int64_t> numbers;
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    const auto count = static_cast<std::int64_t>(array.bytes.view.size() / sizeof(T));
    numbers.reserve(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count; ++i) {
      const auto value = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
      if (!(value >= 0 && value <= static_cast<double>(kMaxNumBytes)) || value != std::floor(value))
        objects.fail(
            fmt::format("'{}': number {} is {}: expected a whole one from 0", place, i, value));
      numbers.push_back(static_cast<std::int64_t>(value));
    }
  });
  return numbers;
}

}  // namespace ovoid::io
#endif
