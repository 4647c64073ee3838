// SPDX-License-Identifier: Apache-2.0
#include "io/images/raw.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// "256x256x128"
std::optional<Index3> parse_dims(std::string_view text) {
  Index3 dims{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto result = std::from_chars(text.data(), text.data() + text.size(), dims[axis]);
    if (result.ec != std::errc{} || dims[axis] < 1) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(result.ptr - text.data()));
    if (axis < 2) {
      if (!text.starts_with('x')) return std::nullopt;
      text.remove_prefix(1);
    }
  }
  if (!text.empty()) return std::nullopt;
  return dims;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> result;
  std::size_t begin = 0;
  while (true) {
    const auto end = text.find(separator, begin);
    result.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return result;
    begin = end + 1;
  }
}

}  // namespace

RawOptions parse_raw_name(const std::string& path) {
  RawOptions result;
  const std::string whole = path.ends_with(".gz") ? path.substr(0, path.size() - 3) : path;
  const auto parts = split(std::filesystem::path(whole).stem().string(), '_');
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    const auto dims = parse_dims(parts[i]);
    const auto type = find_scalar_type(parts[i + 1]);
    if (!dims || !type) continue;
    result.dims = dims;
    result.type = type;
  }
  return result;
}

Dataset read_raw(const ByteSource& source, const ReadOptions& options) {
  const RawOptions from_name = parse_raw_name(source.name());
  const auto dims = options.raw.dims ? options.raw.dims : from_name.dims;
  const auto type = options.raw.type ? options.raw.type : from_name.type;
  if (!dims || !type) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: a file without a header needs {}, or a name like "
                            "x_256x256x256_uint8.raw",
                            source.name(),
                            !dims && !type ? "dimensions (--dims) and a type (--type)"
                            : !dims        ? "dimensions (--dims)"
                                           : "a type (--type)"));
  }
  const std::int64_t num_bytes = checked_num_bytes(source.name(), *dims, *type);
  const bool is_gzip = source.name().ends_with(".gz") && source.text(0, 2) == "\x1f\x8b";
  if (!is_gzip && source.size() != num_bytes) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: holds {} bytes, {} needs {}", source.name(), source.size(),
                            layout_text(*dims, *type), num_bytes));
  }

  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "raw";
  dataset.lattice.dims = *dims;
  if (options.raw.spacing)
    dataset.lattice.world_from_index.linear() = options.raw.spacing->asDiagonal();
  check_geometry("spacing", dataset.lattice.world_from_index);
  if (options.raw.dims && from_name.dims && *options.raw.dims != *from_name.dims) {
    dataset.notes.push_back(fmt::format("{}: the name says {}: taken as {}, as given",
                                        source.name(), dims_text(*from_name.dims),
                                        dims_text(*dims)));
  }
  StepLayout layout;
  layout.num_bytes = num_bytes;
  layout.type = *type;
  layout.is_big_endian = options.raw.big_endian;
  SampleParts parts;
  parts.encoding = is_gzip ? Encoding::kGzip : Encoding::kRaw;
  parts.each = {num_bytes, 0, *type, source.name(), layout_text(*dims, *type)};
  parts.open = [&source](std::int64_t) {
    SamplePart part;
    part.source = &source;
    return part;
  };
  ReadOptions step_options = options;
  step_options.step.reset();  // a file without a header has one
  std::vector<std::string> behind;
  StepSamples samples = read_step(parts, layout, step_options, behind);
  if (!behind.empty()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: holds more than the {} bytes that {} needs", source.name(),
                            num_bytes, parts.each.layout));
  }
  dataset.arrays.push_back(
      {"values", *type, 1, num_samples(*dims), "", false, std::move(samples.bytes)});
  dataset.arrays.back().stored = std::move(samples.stored);
  return dataset;
}

void write_raw(const DataArray& array, const std::string& path, const std::stop_token& stop) {
  AtomicFile file(path, stop);
  file.write(array.bytes.view.data(), array.bytes.view.size());
  file.commit();
}

}  // namespace ovoid::io
