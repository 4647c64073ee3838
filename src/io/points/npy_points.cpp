// SPDX-License-Identifier: Apache-2.0
#include "io/points/npy_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "data/names_text.h"
#include "io/core/atomic_file.h"
#include "io/core/point_arrays.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "io/core/short_floats.h"
#include "io/core/zip_file.h"
#include "io/images/npy.h"
#include "io/images/npy_header.h"
#include "io/images/npz_volume.h"
#include "io/points/point_columns.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMaxNpzComponents = 64;

// An array of one axis, or two: rows, of which a share may be read, and components.
DataArray npy_rows(const ByteSource& source, const ReadOptions& options) {
  NpySamples read = read_npy_samples(source, options, options.share);
  const auto& shape = read.header.shape;
  DataArray array{"", read.type.type, 1, read.rows.count, "", false, {}};
  if (shape.size() == 2) array.num_components = static_cast<int>(shape[1]);
  if (!read.header.is_fortran_order || array.num_components == 1) {
    array.bytes = read.samples.release();
    widen_short_floats(read.type.short_float, array);
    return array;
  }
  std::byte* to = nullptr;
  array = new_array(std::move(array), to);
  transpose_items(read.samples.bytes().data(), to, array.num_components, array.num_tuples,
                  size_of(array.type));
  widen_short_floats(read.type.short_float, array);
  return array;
}

// The rows and components that an entry's header promises; nothing for what is no list.
std::optional<std::pair<std::int64_t, std::int64_t>> rows_of(const NpyHeader& header) {
  const auto& shape = header.shape;
  if (shape.empty() || shape.size() > 2) return std::nullopt;
  const std::int64_t components = shape.size() == 2 ? shape[1] : 1;
  if (shape[0] < 1 || components < 1 || components > kMaxNpzComponents) return std::nullopt;
  return std::pair(shape[0], components);
}

// The entry of the positions; none if the archive has none. A volume may be called like positions.
const ZipEntry* positions_entry(const ByteSource& source, const std::vector<ZipEntry>& entries) {
  const ZipEntry* found = nullptr;
  for (const ZipEntry& entry : entries) {
    const std::string_view name = npz_array_name(entry.name);
    if (name != "positions" && !is_position_name(name)) continue;
    const auto header = npz_header(source, entry);
    if (header && header->shape.size() > 2) continue;
    if (name == "positions") return &entry;
    if (found != nullptr) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: {} and {} may both be the positions: call one 'positions'",
                              source.name(), data::name_text(npz_array_name(found->name)),
                              data::name_text(name)));
    }
    found = &entry;
  }
  return found;
}

[[noreturn]] void refuse_spacing(const ByteSource& source) {
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("{}: holds points: a spacing can be given for volumes only", source.name()));
}

void add_npz_array(const ByteSource& source, const ZipEntry& entry, std::int64_t num_rows,
                   const ReadOptions& options, Dataset& dataset) {
  const std::string_view name = npz_array_name(entry.name);
  const auto leave_out = [&](const std::string& why) {
    dataset.notes.push_back(
        fmt::format("{}: {} is left out: {}", source.name(), data::name_text(name), why));
  };
  DataArray array;
  try {
    const auto header = npz_header(source, entry);
    if (!header) return leave_out("it is no array");
    const auto rows = rows_of(*header);
    if (!rows || rows->first != num_rows) {
      return leave_out(fmt::format("its shape is ({}): expected {} rows",
                                   fmt::join(header->shape, ", "), num_rows));
    }
    array = npy_rows(*open_zip_entry(source, entry).source, options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnsupported) throw;
    return leave_out("its type is no number type that is read");
  }
  array.name = name;
  dataset.arrays.push_back(std::move(array));
}

}  // namespace

bool is_npy_of_points(std::span<const std::int64_t> shape) noexcept {
  return shape.size() == 2 && shape[0] > kMaxUnclearPoints && (shape[1] == 3 || shape[1] == 4);
}

Dataset read_npy_points(const ByteSource& source, const ReadOptions& options) {
  if (options.raw.spacing) refuse_spacing(source);
  DataArray rows = npy_rows(source, options);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPY";
  dataset.kind = DatasetKind::kParticles;
  const std::int64_t num_rows = read_npy_header(source).shape[0];
  dataset.notes.push_back(fmt::format("{}: shape ({}, {}) taken as points x, y, z{}", source.name(),
                                      num_rows, rows.num_components,
                                      rows.num_components == 4 ? " with a value" : ""));
  if (rows.num_components == 4) {
    DataArray values = take_components(rows, 3, 1);
    values.name = "value";
    dataset.arrays.push_back(std::move(values));
    rows = take_components(rows, 0, 3);
  }
  dataset.positions = floating_values(rows);
  dataset.positions.name = "positions";
  set_share(dataset, options.share, num_rows);
  return dataset;
}

Dataset read_npz(const ByteSource& source, const ReadOptions& options) {
  const std::vector<ZipEntry> entries = read_zip_entries(source);
  refuse_other_zip(source, entries);
  const ZipEntry* const found =
      options.raw.axis_order.empty() ? positions_entry(source, entries) : nullptr;
  if (found == nullptr) return read_npz_volume(source, entries, options);
  if (options.raw.spacing) refuse_spacing(source);
  const ZipEntry& positions = *found;
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "NPZ";
  dataset.kind = DatasetKind::kParticles;
  std::int64_t num_rows = 0;
  {
    const ZipMember member = open_zip_entry(source, positions);
    const auto rows = rows_of(read_npy_header(*member.source));
    if (!rows || rows->second != 3) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: shape ({}): expected (N, 3)", member.source->name(),
                              fmt::join(read_npy_header(*member.source).shape, ", ")));
    }
    num_rows = rows->first;
    dataset.positions = floating_values(npy_rows(*member.source, options));
    dataset.positions.name = "positions";
  }
  for (const ZipEntry& entry : entries)
    if (&entry != &positions) add_npz_array(source, entry, num_rows, options, dataset);
  set_share(dataset, options.share, num_rows);
  shorten_notes(dataset.notes);
  return dataset;
}

void write_npz(const Dataset& dataset, const std::string& path, const std::stop_token& stop) {
  AtomicFile file(path, stop);
  ZipWriter zip(file);
  const auto add = [&](const DataArray& array, const std::string& name) {
    std::vector<std::int64_t> shape{array.num_tuples};
    if (array.num_components > 1) shape.push_back(array.num_components);
    zip.add(name + ".npy", npy_header(array.type, shape), array.bytes.view);
  };
  add(dataset.positions, "positions");
  for (const DataArray& array : dataset.arrays) add(array, array.name);
  zip.finish();
  file.commit();
}

}  // namespace ovoid::io
