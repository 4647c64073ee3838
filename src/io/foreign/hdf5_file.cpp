// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "data/scalar_visit.h"
#include "io/core/memory.h"
#include "io/core/point_arrays.h"
#include "io/foreign/hdf5_attributes.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// The sizes of a simple dataspace of up to `max_rank` axes; nothing for another.
std::optional<std::vector<std::int64_t>> dims_of(hid_t space, int max_rank) {
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0 || rank > max_rank || H5Sget_simple_extent_type(space) == H5S_NULL)
    return std::nullopt;
  std::array<hsize_t, H5S_MAX_RANK> dims{};
  if (H5Sget_simple_extent_dims(space, dims.data(), nullptr) < 0) return std::nullopt;
  std::vector<std::int64_t> result;
  for (int i = 0; i < rank; ++i) {
    if (dims[static_cast<std::size_t>(i)] > static_cast<hsize_t>(kMaxNumBytes)) return std::nullopt;
    result.push_back(static_cast<std::int64_t>(dims[static_cast<std::size_t>(i)]));
  }
  return result;
}

}  // namespace

bool is_hard_link(hid_t group, const std::string& name) {
  H5L_info_t info{};
  return H5Lget_info(group, name.c_str(), &info, H5P_DEFAULT) >= 0 && info.type == H5L_TYPE_HARD;
}

Hdf5File::Hdf5File(const std::string& path, std::size_t max_rank)
    : name_(path), max_rank_(static_cast<int>(max_rank)), source_(open_file(path)) {
  file_ = {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
  if (!file_.is_open()) fail("the HDF5 library cannot open it: is the file truncated?");
  const Hdf5Handle root(H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose);
  if (!root.is_open()) fail("the root group is broken");
  list(root.get(), "", 0);
}

void Hdf5File::fail(const std::string& what, bool is_unsupported) const {
  throw Error(is_unsupported ? ErrorCode::kUnsupported : ErrorCode::kFileFormat,
              fmt::format("{}: {}", name_, what));
}

void Hdf5File::list(hid_t group, const std::string& path, int depth) {
  if (depth > kMaxDepth) fail(fmt::format("groups are more than {} deep", kMaxDepth), true);
  std::vector<std::string> names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
    static_cast<std::vector<std::string>*>(to)->emplace_back(name);
    return static_cast<std::vector<std::string>*>(to)->size() > kMaxObjects ? -1 : 0;
  };
  if (H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names) < 0)
    fail(fmt::format("group '{}/' is broken or has more than {} members", path, kMaxObjects));
  for (const std::string& name : names) {
    if (++num_objects_ > kMaxObjects)
      fail(fmt::format("has more than {} objects", kMaxObjects), true);
    if (!is_hard_link(group, name)) continue;
    H5O_info_t info{};
    if (H5Oget_info_by_name(group, name.c_str(), &info, H5P_DEFAULT) < 0) continue;
    if (info.type == H5O_TYPE_DATASET) describe(group, path, name);
    if (info.type != H5O_TYPE_GROUP) continue;
    const Hdf5Handle inner(H5Gopen2(group, name.c_str(), H5P_DEFAULT), H5Gclose);
    if (inner.is_open()) groups_.push_back(fmt::format("{}/{}", path, name));
    if (inner.is_open()) paths_.insert(groups_.back());
    if (inner.is_open()) list(inner.get(), fmt::format("{}/{}", path, name), depth + 1);
  }
}

void Hdf5File::describe(hid_t group, const std::string& path, const std::string& name) {
  const Hdf5Handle dataset(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.is_open()) return;
  const Hdf5Handle space(H5Dget_space(dataset.get()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset.get()), H5Tclose);
  if (!space.is_open() || !type.is_open()) return;
  Hdf5Dataset described{fmt::format("{}/{}", path, name), path.empty() ? "/" : path, name, {}, {}};
  paths_.insert(described.path);
  described.type = hdf5_type_of(type.get());
  if (!described.type) described.type_text = hdf5_type_text(type.get());
  if (auto dims = dims_of(space.get(), max_rank_)) {
    if (dims->empty()) dims->push_back(1);  // a single number
    described.dims = std::move(*dims);
    datasets_.push_back(std::move(described));
    return;
  }
  constexpr std::size_t kKept = 64;
  if (others_.size() == kKept) return;
  described.dims = dims_of(space.get(), H5S_MAX_RANK).value_or(std::vector<std::int64_t>());
  others_.push_back(std::move(described));
}

bool Hdf5File::exists(const std::string& path) const {
  return H5Lexists(file_.get(), path.c_str(), H5P_DEFAULT) > 0;
}

const Hdf5Dataset* Hdf5File::find(const std::string& path) const noexcept {
  const auto found = std::find_if(datasets_.begin(), datasets_.end(),
                                  [&](const Hdf5Dataset& dataset) { return dataset.path == path; });
  return found == datasets_.end() ? nullptr : &*found;
}

Hdf5Handle Hdf5File::object(const std::string& path) const {
  const std::string whole = path.empty() ? "/" : path;
  if (whole != "/" && !paths_.contains(whole)) return {};  // links that lead elsewhere are none
  return {H5Oopen(file_.get(), whole.c_str(), H5P_DEFAULT), H5Oclose};
}

std::int64_t Hdf5File::num_bytes(const Hdf5Dataset& dataset) const {
  const auto count = checked_product(dataset.dims).value_or(0);
  return std::min(count, kMaxNumBytes / 8) *
         static_cast<std::int64_t>(dataset.type ? size_of(dataset.type->type) : 0);
}

std::int64_t Hdf5Table::rows_at_once() const {
  return hdf5_run_at_once(dataset_.get(), extent_, is_transposed_ ? 1 : 0);
}

DataArray Hdf5Table::read(const Rows& rows, ReadProgress& progress) const {
  const ScalarType type = extent_.type.type;
  const std::int64_t columns = is_transposed_            ? extent_.dims[0]
                               : extent_.dims.size() > 1 ? extent_.dims[1]
                                                         : 1;
  const auto num_bytes = static_cast<std::size_t>(rows.count * columns * extent_.item_size());
  const DataArray described{name_, type, static_cast<int>(columns), rows.count, "", false, {}};
  std::byte* to = nullptr;
  DataArray array = new_array(described, to);
  if (!is_transposed_) {
    read_hdf5_rows(dataset_.get(), extent_, rows.first, {to, num_bytes}, progress);
    return array;
  }
  read_hdf5_columns(dataset_.get(), extent_, rows.first, {to, num_bytes}, progress);
  DataArray turned = new_array(described, to);
  transpose_items(array.bytes.view.data(), to, columns, rows.count, size_of(type));
  return turned;
}

Hdf5Extent Hdf5File::checked(const Hdf5Dataset& described, hid_t dataset) const {
  const std::string where = fmt::format("{}: '{}'", name_, described.path);
  if (dataset < 0 || !described.type) fail(fmt::format("'{}' is broken", described.path));
  checked_num_bytes(where, described.dims, described.type->type);
  Hdf5Extent extent{where, *described.type, described.dims};
  check_hdf5_storage(dataset, extent, *source_);
  return extent;
}

Hdf5Table Hdf5File::open(const Hdf5Dataset& described, bool is_transposed) const {
  Hdf5Handle dataset(H5Dopen2(file_.get(), described.path.c_str(), H5P_DEFAULT), H5Dclose);
  if (described.dims.size() > 2) fail(fmt::format("'{}' is no table", described.path));
  Hdf5Extent extent = checked(described, dataset.get());
  return {described.name, std::move(dataset), std::move(extent), is_transposed};
}

void Hdf5File::check(const Hdf5Dataset& described) const {
  const Hdf5Handle dataset(H5Dopen2(file_.get(), described.path.c_str(), H5P_DEFAULT), H5Dclose);
  checked(described, dataset.get());
}

std::vector<double> Hdf5File::values(const Hdf5Dataset& described) const {
  const Hdf5Handle dataset(H5Dopen2(file_.get(), described.path.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Extent extent = checked(described, dataset.get());
  require_memory(extent.where, extent.num_bytes() + extent.num_numbers() * std::int64_t{8});
  std::vector<std::byte> bytes(static_cast<std::size_t>(extent.num_bytes()));
  const ReadOptions options;
  ReadProgress progress(options, 0);
  read_hdf5_storage(dataset.get(), extent, bytes.data(), progress);
  return data::visit_scalar(extent.type.type, [&]<class T>(std::type_identity<T>) {
    std::vector<double> values;
    values.reserve(bytes.size() / sizeof(T));
    for (std::int64_t i = 0; i < extent.num_numbers(); ++i)
      values.push_back(static_cast<double>(data::load_scalar<T>(bytes.data(), i)));
    return values;
  });
}

std::vector<double> Hdf5File::numbers(const std::string& object, const std::string& name) const {
  constexpr std::int64_t kMost = 4096;
  const Hdf5Dataset* const dataset = find(fmt::format("{}/{}", object == "/" ? "" : object, name));
  if (dataset != nullptr && dataset->type && dataset->dims.size() <= 2) {
    const auto count = checked_product(dataset->dims);
    if (count && *count >= 1 && *count <= kMost) return values(*dataset);
  }
  const Hdf5Handle holder = this->object(object);
  return holder.is_open() ? hdf5_numbers(holder.get(), name.c_str(), kMost) : std::vector<double>();
}

std::vector<std::string> Hdf5File::texts(const std::string& object, const std::string& name) const {
  constexpr std::size_t kMost = 4096;
  const Hdf5Handle holder = this->object(object);
  return holder.is_open() ? hdf5_texts(holder.get(), name.c_str(), kMost)
                          : std::vector<std::string>();
}

std::optional<std::string> Hdf5File::text(const std::string& object,
                                          const std::string& name) const {
  const Hdf5Handle holder = this->object(object);
  return holder.is_open() ? hdf5_joined_text(holder.get(), name.c_str()) : std::nullopt;
}

}  // namespace ovoid::io
#endif
