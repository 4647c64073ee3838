// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/hdf5_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "io/byte_source.h"
#include "io/decompressors.h"
#include "io/point_arrays.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kSmallFile = 65536;  // so much a filter may always make

std::optional<ScalarType> hdf5_type(hid_t type) {
  const std::size_t size = H5Tget_size(type);
  const H5T_class_t type_class = H5Tget_class(type);
  if (type_class == H5T_FLOAT)  // half floats fit single ones
    return size <= 4 ? ScalarType::kFloat32 : ScalarType::kFloat64;
  if (type_class != H5T_INTEGER) return std::nullopt;
  const bool is_signed = H5Tget_sign(type) == H5T_SGN_2;
  switch (size) {
    case 1:
      return is_signed ? ScalarType::kInt8 : ScalarType::kUInt8;
    case 2:
      return is_signed ? ScalarType::kInt16 : ScalarType::kUInt16;
    case 4:
      return is_signed ? ScalarType::kInt32 : ScalarType::kUInt32;
    case 8:
      return is_signed ? ScalarType::kInt64 : ScalarType::kUInt64;
    default:
      return std::nullopt;
  }
}

hid_t memory_type(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return H5T_NATIVE_UINT8;
    case ScalarType::kInt8:
      return H5T_NATIVE_INT8;
    case ScalarType::kUInt16:
      return H5T_NATIVE_UINT16;
    case ScalarType::kInt16:
      return H5T_NATIVE_INT16;
    case ScalarType::kUInt32:
      return H5T_NATIVE_UINT32;
    case ScalarType::kInt32:
      return H5T_NATIVE_INT32;
    case ScalarType::kUInt64:
      return H5T_NATIVE_UINT64;
    case ScalarType::kInt64:
      return H5T_NATIVE_INT64;
    case ScalarType::kFloat32:
      return H5T_NATIVE_FLOAT;
    case ScalarType::kFloat64:
      break;
  }
  return H5T_NATIVE_DOUBLE;
}

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

// Links outside the file are not followed; in it, soft ones neither: what they mean is listed where
// it is.
bool is_hard_link(hid_t group, const std::string& name) {
  H5L_info_t info{};
  return H5Lget_info(group, name.c_str(), &info, H5P_DEFAULT) >= 0 && info.type == H5L_TYPE_HARD;
}

}  // namespace

Hdf5File::Hdf5File(const std::string& path) : name_(path), file_size_(open_file(path)->size()) {
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
    if (inner.is_open()) list(inner.get(), fmt::format("{}/{}", path, name), depth + 1);
  }
}

void Hdf5File::describe(hid_t group, const std::string& path, const std::string& name) {
  const Hdf5Handle dataset(H5Dopen2(group, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.is_open()) return;
  const Hdf5Handle space(H5Dget_space(dataset.get()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset.get()), H5Tclose);
  if (!space.is_open() || !type.is_open()) return;
  auto dims = dims_of(space.get(), 2);
  if (!dims || dims->empty()) return;
  datasets_.push_back({fmt::format("{}/{}", path, name), path.empty() ? "/" : path, name,
                       std::move(*dims), hdf5_type(type.get())});
}

bool Hdf5File::exists(const std::string& path) const {
  return H5Lexists(file_.get(), path.c_str(), H5P_DEFAULT) > 0;
}

std::int64_t Hdf5File::num_bytes(const Hdf5Dataset& dataset) const {
  const auto count = checked_product(dataset.dims).value_or(0);
  return std::min(count, kMaxNumBytes / 8) *
         static_cast<std::int64_t>(dataset.type ? size_of(*dataset.type) : 0);
}

// Throws unless the file can hold what the dataset claims.
void Hdf5File::check_storage(hid_t dataset, const Hdf5Dataset& described,
                             std::int64_t num_bytes) const {
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  if (!plist.is_open()) fail(fmt::format("'{}' is broken", described.path));
  const H5D_layout_t layout = H5Pget_layout(plist.get());
  if (H5Pget_external_count(plist.get()) > 0 || layout == H5D_VIRTUAL)
    fail(fmt::format("'{}' lies in other files, which are not read", described.path), true);
  // Filters make at most what deflate can, and what was never written is not worth more.
  std::int64_t most = file_size_;
  if (layout == H5D_CHUNKED) most = file_size_ * kMaxDeflateRatio + kSmallFile;
  std::array<hsize_t, H5S_MAX_RANK> chunk{};
  const int rank =
      layout == H5D_CHUNKED ? H5Pget_chunk(plist.get(), H5S_MAX_RANK, chunk.data()) : 0;
  double chunk_size = rank > 0 ? static_cast<double>(size_of(*described.type)) : 0;
  for (int i = 0; i < rank; ++i)
    chunk_size *= static_cast<double>(chunk[static_cast<std::size_t>(i)]);
  if (num_bytes > most || chunk_size > static_cast<double>(most)) {
    fail(fmt::format("'{}' claims {} bytes in chunks of {}, more than a file of {} bytes can hold",
                     described.path, num_bytes, chunk_size, file_size_));
  }
  for (int i = 0; i < H5Pget_nfilters(plist.get()); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t num_values = 0;
    char filter_name[64] = "";
    const H5Z_filter_t filter =
        H5Pget_filter2(plist.get(), static_cast<unsigned>(i), &flags, &num_values, nullptr,
                       sizeof(filter_name), filter_name, &config);
    if (filter >= 0 && H5Zfilter_avail(filter) > 0) continue;
    fail(fmt::format("'{}' is compressed by filter {} ({}), which this HDF5 library does not have",
                     described.path, filter, filter_name),
         true);
  }
}

// Whole chunks, so that none is unpacked twice, and about as much as a progress bar wants.
std::int64_t Hdf5File::rows_at_a_time(hid_t dataset, std::int64_t row_size) const {
  const std::int64_t wanted = std::max<std::int64_t>(1, ReadProgress::kChunk / row_size);
  const Hdf5Handle plist(H5Dget_create_plist(dataset), H5Pclose);
  std::array<hsize_t, H5S_MAX_RANK> chunk{};
  if (H5Pget_layout(plist.get()) != H5D_CHUNKED ||
      H5Pget_chunk(plist.get(), H5S_MAX_RANK, chunk.data()) < 1)
    return wanted;
  const auto rows = std::max<std::int64_t>(1, static_cast<std::int64_t>(chunk[0]));
  return std::max<std::int64_t>(1, (wanted + rows - 1) / rows) * rows;
}

DataArray Hdf5File::read(const Hdf5Dataset& described, bool is_transposed,
                         ReadProgress& progress) const {
  const std::string where = fmt::format("{}: '{}'", name_, described.path);
  const Hdf5Handle dataset(H5Dopen2(file_.get(), described.path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.is_open() || !described.type) fail(fmt::format("'{}' is broken", described.path));
  const std::int64_t total = checked_num_bytes(where, described.dims, *described.type);
  check_storage(dataset.get(), described, total);
  const std::int64_t rows = described.dims[0];
  const std::int64_t columns = described.dims.size() > 1 ? described.dims[1] : 1;
  const std::int64_t row_size = total / rows;
  std::byte* to = nullptr;
  DataArray array = new_array(
      {described.name, *described.type, static_cast<int>(columns), rows, "", false, {}}, to);
  const std::int64_t step = rows_at_a_time(dataset.get(), row_size);
  const Hdf5Handle file_space(H5Dget_space(dataset.get()), H5Sclose);
  for (std::int64_t first = 0; first < rows; first += step) {
    const int rank = static_cast<int>(described.dims.size());
    const std::array<hsize_t, 2> start{static_cast<hsize_t>(first), 0};
    const std::array<hsize_t, 2> count{static_cast<hsize_t>(std::min(step, rows - first)),
                                       static_cast<hsize_t>(columns)};
    const Hdf5Handle memory(H5Screate_simple(rank, count.data(), nullptr), H5Sclose);
    if (H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                            nullptr) < 0 ||
        H5Dread(dataset.get(), memory_type(*described.type), memory.get(), file_space.get(),
                H5P_DEFAULT, to + first * row_size) < 0)
      fail(fmt::format("'{}': rows {} and on cannot be read: is the file damaged?", described.path,
                       first));
    progress.advance(static_cast<std::int64_t>(count[0]) * row_size);
  }
  if (!is_transposed) return array;
  DataArray turned = new_array(
      {described.name, *described.type, static_cast<int>(rows), columns, "", false, {}}, to);
  transpose_items(array.bytes.view.data(), to, rows, columns, size_of(array.type));
  return turned;
}

std::vector<double> Hdf5File::numbers(const std::string& object, const std::string& name) const {
  constexpr std::int64_t kMost = 4096;
  if (!exists(object)) return {};
  const auto read_all = [&](hid_t space, hid_t type, const auto& read) {
    std::vector<double> values;
    const auto dims = dims_of(space, 2);
    const auto count = dims ? checked_product(*dims) : std::nullopt;
    if (!count || *count < 1 || *count > kMost || !hdf5_type(type)) return values;
    values.resize(static_cast<std::size_t>(*count));
    if (read(values.data()) < 0) values.clear();
    return values;
  };
  if (H5Aexists_by_name(file_.get(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0) {
    const Hdf5Handle attribute(
        H5Aopen_by_name(file_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    if (!attribute.is_open()) return {};
    const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose);
    const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose);
    return read_all(space.get(), type.get(),
                    [&](double* to) { return H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, to); });
  }
  const std::string path = fmt::format("{}/{}", object, name);
  if (!exists(path)) return {};
  const Hdf5Handle dataset(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.is_open()) return {};
  const Hdf5Handle space(H5Dget_space(dataset.get()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset.get()), H5Tclose);
  return read_all(space.get(), type.get(), [&](double* to) {
    return H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, to);
  });
}

}  // namespace ovoid::io
#endif
