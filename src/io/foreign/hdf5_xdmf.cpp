// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_xdmf.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>

#include "io/core/samples.h"
#include "io/foreign/file_checks.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_storage.h"
#include "io/xdmf/xdmf.h"
#include "io/xdmf/xdmf_items.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// What must stay open while rows are read.
struct OpenHdf5Item {
  Hdf5Silence silence;
  std::unique_ptr<ByteSource> source;
  Hdf5Handle file, dataset;
};

[[noreturn]] void fail_item(const std::string& where, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", where, what));
}

// Along hard links alone: others may lead out of the file.
Hdf5Handle open_hdf5_item(const std::string& where, hid_t file, const std::string& path) {
  Hdf5Handle here(H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose);
  std::size_t at = path.find_first_not_of('/');
  while (at != std::string::npos) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    const std::string name = path.substr(at, end - at);
    at = path.find_first_not_of('/', end);
    if (!here.is_open() || !is_hard_link(here.get(), name))
      fail_item(where, "there is no such dataset in the file");
    here = at == std::string::npos
               ? Hdf5Handle(H5Dopen2(here.get(), name.c_str(), H5P_DEFAULT), H5Dclose)
               : Hdf5Handle(H5Gopen2(here.get(), name.c_str(), H5P_DEFAULT), H5Gclose);
  }
  if (!here.is_open() || H5Iget_type(here.get()) != H5I_DATASET) fail_item(where, "is no dataset");
  return here;
}

XdmfStored stored_hdf5_item(const std::string& where, const std::string& file,
                            const std::string& path, ReadProgress& progress) {
  const auto open = std::make_shared<OpenHdf5Item>();
  open->source = open_file(file);
  check_hdf5_size(*open->source);
  open->file = {H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
  if (!open->file.is_open()) fail_item(file, "the HDF5 library cannot open it");
  open->dataset = open_hdf5_item(where, open->file.get(), path);
  const Hdf5Handle space(H5Dget_space(open->dataset.get()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(open->dataset.get()), H5Tclose);
  const auto known = type.is_open() ? hdf5_type_of(type.get()) : std::nullopt;
  if (!known)
    fail_item(where, "holds no numbers that are read: integers of 1 to 8 bytes, floats of 4 or 8");
  const int rank = H5Sget_simple_extent_ndims(space.get());
  std::array<hsize_t, H5S_MAX_RANK> sizes{};
  if (rank < 0 || rank > static_cast<int>(Hdf5Extent::kMaxRank) ||
      H5Sget_simple_extent_type(space.get()) == H5S_NULL ||
      H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr) < 0)
    fail_item(where, fmt::format("has {} axes: expected 0 to {}", rank, Hdf5Extent::kMaxRank));
  XdmfStored stored;
  stored.type = known->type;
  for (int axis = 0; axis < rank; ++axis) {
    const hsize_t size = sizes[static_cast<std::size_t>(axis)];
    stored.dims.push_back(static_cast<std::int64_t>(
        std::min(size, static_cast<hsize_t>(kMaxNumBytes))));  // refused below
  }
  if (stored.dims.empty()) stored.dims.push_back(1);
  checked_num_bytes(where, stored.dims, stored.type);
  const Hdf5Extent extent{where, *known, stored.dims};
  check_hdf5_storage(open->dataset.get(), extent, *open->source);
  stored.read = [open, extent, &progress](std::int64_t first, std::span<std::byte> out) {
    read_hdf5_rows(open->dataset.get(), extent, first, out, progress);
  };
  return stored;
}

}  // namespace

Dataset read_xdmf_with_hdf5(const ByteSource& source, const ReadOptions& options) {
  set_xdmf_hdf5(stored_hdf5_item);
  return read_xdmf(source, options, open_file);
}

}  // namespace ovoid::io
#endif
