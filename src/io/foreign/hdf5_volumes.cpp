// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_volumes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/chunked_array.h"
#include "io/core/point_arrays.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_chunks.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A volume whose dataset is open and was checked against the file.
struct OpenVolume {
  const Hdf5Volume* volume = nullptr;
  std::shared_ptr<const Hdf5Handle> stored;
  Hdf5Extent extent;
  std::vector<std::int64_t> sizes;  // that are read
  CfAttributes attributes{};

  ScalarType type() const { return cf_type(attributes, extent.type.type); }
  bool is_whole() const noexcept { return sizes == extent.dims; }
};

OpenVolume opened(const Hdf5File& file, const Hdf5Volume& volume) {
  const Hdf5Dataset& dataset = *volume.dataset;
  const std::string where = fmt::format("{}: '{}'", file.source().name(), dataset.path);
  OpenVolume open{&volume,
                  std::make_shared<const Hdf5Handle>(
                      H5Dopen2(file.id(), dataset.path.c_str(), H5P_DEFAULT), H5Dclose),
                  {where, *dataset.type, dataset.dims, true},
                  volume.sizes.empty() ? dataset.dims : volume.sizes};
  if (!open.stored->is_open()) throw Error(ErrorCode::kFileFormat, where + " is broken");
  checked_num_bytes(where, dataset.dims, dataset.type->type);
  check_hdf5_storage(open.stored->get(), open.extent, file.source());
  open.attributes = hdf5_cf_attributes(open.stored->get());
  return open;
}

// Those that can be read; of one alone the error is thrown.
std::vector<OpenVolume> opened_all(const Hdf5File& file, const std::vector<Hdf5Volume>& volumes,
                                   std::vector<std::string>& notes) {
  std::vector<OpenVolume> open;
  std::optional<Error> first;
  for (const Hdf5Volume& volume : volumes) {
    try {
      open.push_back(opened(file, volume));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnsupported) throw;
      if (!first) first = error;
      notes.push_back(fmt::format("{}: it is left out", error.what()));
    }
  }
  if (!open.empty() || !first) return open;
  throw *first;
}

void tell(const OpenVolume& open, std::vector<std::string>& notes) {
  if (std::string note = hdf5_type_note(open.extent.where, open.extent.type); !note.empty())
    notes.push_back(std::move(note));
  if (const std::int64_t num_gaps = num_hdf5_gaps(open.stored->get(), open.extent); num_gaps > 0) {
    notes.push_back(fmt::format("{}: {} of its chunks were never written: they hold its fill value",
                                open.extent.where, num_gaps));
  }
}

void apply_cf(const OpenVolume& open, DataArray& array, std::vector<std::string>& notes) {
  const CfNumbers numbers = cf_numbers(open.attributes, open.type(), CfFill::kNone);
  apply_cf_numbers(open.extent.where, numbers, array, notes);
}

// Axes whose samples lie as a dataset has them.
bool is_plain(const OpenVolume& open) {
  return open.is_whole() && (open.volume->axes == "zyx" || open.volume->axes == "zyxc");
}

// As it lies in the file, where it stays if memory does not hold it.
void add_plain(const Hdf5File& file, const OpenVolume& open, const ReadOptions& options,
               ReadProgress& progress, Dataset& dataset) {
  const Hdf5Extent& extent = open.extent;
  DataArray array{open.volume->name,
                  open.type(),
                  extent.dims.size() == 4 ? static_cast<int>(extent.dims[3]) : 1,
                  num_samples(dataset.lattice.dims),
                  "",
                  false,
                  {}};
  if (array.num_components == 1 && stays_in_file(extent.type.type, extent.num_bytes(), options)) {
    if (const auto at = place_of_hdf5_storage(file.id(), open.stored->get(), extent))
      array.stored = samples_told(*at);
  }
  if (!array.stored) {
    std::byte* to = nullptr;
    array = new_array(std::move(array), to);
    read_hdf5_storage(open.stored->get(), extent, to, progress);
  }
  apply_cf(open, array, dataset.notes);
  dataset.arrays.push_back(std::move(array));
}

// Samples that are read at once, along each axis: whole chunks of the file where it has any, so
// that each is unpacked once, of time and channels as few as can be, and about 64 MiB.
std::vector<std::int64_t> boxes_of(const OpenVolume& open) {
  constexpr std::int64_t kMost = std::int64_t{64} << 20;
  const std::vector<std::int64_t> units = hdf5_chunk_sizes(open.stored->get(), open.extent);
  std::vector<std::int64_t> box = open.sizes;
  const auto num_bytes = [&] {
    return checked_num_bytes(open.extent.where, box, open.extent.type.type);
  };
  for (std::size_t axis = 0; axis < box.size(); ++axis) {
    const bool is_step =
        open.volume->axes[axis] == 't' || (open.volume->axes[axis] == 'c' && axis + 1 < box.size());
    if (!is_step && num_bytes() <= kMost) break;
    const std::int64_t one = std::min(units[axis], box[axis]);
    box[axis] = one;
    const std::int64_t wanted = kMost / std::max<std::int64_t>(num_bytes() / one, 1);
    if (!is_step) box[axis] = std::clamp(wanted / one * one, one, open.sizes[axis]);
  }
  return box;
}

// `reading` outlives it.
ChunkedArray chunked(const OpenVolume& open, Hdf5Reading& reading) {
  ChunkedArray array;
  array.where = open.extent.where;
  array.name = open.volume->name;
  array.axes = open.volume->axes;
  array.shape = open.sizes;
  array.chunk = boxes_of(open);
  read_chunks_of_hdf5(open.stored, open.extent, reading, array);
  array.type = open.type();
  check_chunked(array);
  return array;
}

void add_in_order(const std::vector<OpenVolume>& volumes, const ReadOptions& options,
                  Dataset& dataset) {
  ReadOptions quiet = options;
  quiet.progress = {};
  Hdf5Reading reading{{}, ReadProgress(quiet, 0)};
  std::vector<ChunkedArray> arrays;
  arrays.reserve(volumes.size());
  for (const OpenVolume& open : volumes) arrays.push_back(chunked(open, reading));
  ReadOptions own = options;
  own.array.clear();
  own.may_stay_in_file = false;  // the library reads in its own process
  read_chunked(arrays, own, dataset);
  std::size_t next = 0;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    for (std::int64_t c = 0; c < arrays[i].num_channels(); ++c, ++next)
      apply_cf(volumes[i], dataset.arrays[next], dataset.notes);
  }
}

}  // namespace

void read_hdf5_volumes(const Hdf5File& file, const std::vector<Hdf5Volume>& volumes,
                       const ReadOptions& options, Dataset& dataset) {
  const std::vector<OpenVolume> open = opened_all(file, volumes, dataset.notes);
  for (const OpenVolume& one : open) tell(one, dataset.notes);
  if (!std::all_of(open.begin(), open.end(), is_plain)) return add_in_order(open, options, dataset);
  std::int64_t total = 0;
  for (const OpenVolume& one : open) total += file.num_bytes(*one.volume->dataset);
  ReadProgress progress(options, total);
  const std::vector<std::int64_t>& dims = open.front().extent.dims;
  dataset.lattice.dims = {dims[2], dims[1], dims[0]};
  for (const OpenVolume& one : open) add_plain(file, one, options, progress, dataset);
}

std::string hdf5_path_text(const std::string& path) {
  constexpr std::size_t kMost = 80;
  return path.size() <= kMost ? path : "..." + path.substr(path.size() - kMost + 3);
}

std::string hdf5_list(const std::vector<const Hdf5Dataset*>& datasets) {
  constexpr std::size_t kListed = 8;
  std::string list;
  for (std::size_t i = 0; i < std::min(kListed, datasets.size()); ++i)
    list += fmt::format("{}'{}' [{}]", i == 0 ? "" : ", ", hdf5_path_text(datasets[i]->path),
                        fmt::join(datasets[i]->dims, ", "));
  if (datasets.size() > kListed) list += fmt::format(" and {} more", datasets.size() - kListed);
  return list;
}

const Hdf5Dataset* hdf5_named(const Hdf5File& file, const std::string& asked,
                              const std::vector<const Hdf5Dataset*>& among) {
  const std::string path = asked.starts_with('/') ? asked : "/" + asked;
  std::vector<const Hdf5Dataset*> found;
  for (const Hdf5Dataset* const one : among) {
    if (one->path == path) return one;
    if (one->path.ends_with(path)) found.push_back(one);
  }
  if (found.size() > 1) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: holds several grids: {}: choose one with --array",
                            file.source().name(), hdf5_list(found)));
  }
  return found.empty() ? nullptr : found[0];
}

}  // namespace ovoid::io
#endif
