// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5

#include "io/foreign/hdf5_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "io/core/point_arrays.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_file.h"
#include "io/hdf5/hdf5_lattice_format.h"

namespace ovoid::io {

void Hdf5Objects::fail(const std::string& what, ErrorCode code) const {
  throw Error(code, fmt::format("{}: {}", name_, what));
}

std::string Hdf5Objects::text(hid_t object, const std::string& place, const char* name) const {
  if (!has_hdf5_attribute(object, name))
    fail(fmt::format("{}: attribute '{}' is missing", place, name));
  if (auto text = hdf5_text(object, name)) return *text;
  fail(fmt::format("{}: attribute '{}': expected text of a fixed length, at most {} bytes", place,
                   name, kMaxHdf5Text));
}

std::vector<double> Hdf5Objects::numbers(hid_t object, const std::string& place, const char* name,
                                         std::size_t count) const {
  if (!has_hdf5_attribute(object, name))
    fail(fmt::format("{}: attribute '{}' is missing", place, name));
  std::vector<double> values = hdf5_numbers(object, name, count);
  if (values.size() != count) {
    fail(fmt::format("{}: attribute '{}': expected {} number{}", place, name, count,
                     count == 1 ? "" : "s"));
  }
  for (const double value : values) {
    if (!std::isfinite(value))
      fail(fmt::format("{}: attribute '{}': {}: must be finite", place, name, value));
  }
  return values;
}

std::int64_t Hdf5Objects::whole_number(double value, const std::string& place, const char* name,
                                       std::int64_t most, std::int64_t least) const {
  if (value >= static_cast<double>(least) && value <= static_cast<double>(most) &&
      value == std::floor(value))
    return static_cast<std::int64_t>(value);
  fail(fmt::format("{}: attribute '{}': {}: expected a whole number from {} to {}", place, name,
                   value, least, most));
}

std::int64_t Hdf5Objects::count(hid_t object, const std::string& place, const char* name,
                                std::int64_t most) const {
  return whole_number(numbers(object, place, name, 1)[0], place, name, most);
}

Hdf5Handle Hdf5Objects::open(hid_t group, const std::string& name, const std::string& place,
                             H5O_type_t type) const {
  const bool is_group = type == H5O_TYPE_GROUP;
  H5O_info_t info{};
  if (!is_hard_link(group, name) ||
      H5Oget_info_by_name(group, name.c_str(), &info, H5P_DEFAULT) < 0 || info.type != type)
    fail(fmt::format("{} '{}' is missing", is_group ? "group" : "dataset", place));
  Hdf5Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose);
  if (!object.is_open())
    fail(fmt::format("{} '{}' is broken", is_group ? "group" : "dataset", place));
  return object;
}

Hdf5Extent Hdf5Objects::extent_of(hid_t dataset, const std::string& place) const {
  Hdf5Extent extent;
  extent.where = fmt::format("{}: '{}'", name_, place);
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  const auto known = type.is_open() ? hdf5_type_of(type.get()) : std::nullopt;
  if (!known) fail(fmt::format("'{}' holds no integers or IEEE floats", place));
  extent.type = *known;
  const int rank = space.is_open() ? H5Sget_simple_extent_ndims(space.get()) : -1;
  std::array<hsize_t, Hdf5Extent::kMaxRank> dims{};
  if (rank < 1 || rank > static_cast<int>(dims.size()) ||
      H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr) != rank)
    fail(fmt::format("'{}': expected 1 to {} axes", place, dims.size()));
  for (int i = 0; i < rank; ++i) {
    extent.dims.push_back(static_cast<std::int64_t>(
        std::min(dims[static_cast<std::size_t>(i)], static_cast<hsize_t>(kMaxNumBytes))));
  }
  checked_num_bytes(extent.where, extent.dims, extent.type.type);
  check_hdf5_storage(dataset, extent, source_);
  return extent;
}

DataArray Hdf5Objects::samples(hid_t dataset, const Hdf5Extent& extent, DataArray description,
                               ReadProgress& progress) const {
  description.type = extent.type.type;
  std::byte* to = nullptr;
  DataArray array = new_array(std::move(description), to);
  read_hdf5_storage(dataset, extent, to, progress);
  return array;
}

}  // namespace ovoid::io

#endif
