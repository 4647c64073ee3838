// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/file_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <system_error>

#include "io/core/json_file.h"
#include "io/core/signatures.h"
#include "io/core/text_scanner.h"
#include "io/formats.h"
#include "io/meshes/mesh_steps.h"
#include "io/read_source.h"
#include "io/step_outline.h"
#include "io/vtk/vtk_set_files.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::string_view kVersion = "\"file-series-version\"";

// The step's own errors name its file; that it comes from this series is said where it is missing.
std::unique_ptr<ByteSource> open_step(const ByteSource& series, const std::string& path,
                                      const Opener& open) {
  try {
    return open(path);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kFileNotFound) throw;
    throw Error(error.code(), fmt::format("{}: names a step that cannot be read: {}", series.name(),
                                          error.what()));
  }
}

Dataset read_step_of(const FileSeries& series, std::size_t step, const ByteSource& source,
                     const ReadOptions& options, const Opener& open) {
  const auto file = open_step(source, series.paths[step], open);
  const Format* const format = format_by_content(*file);
  if (format != nullptr && format->name == std::string_view(kFileSeries)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: a file series within a file series", file->name()));
  }
  Dataset dataset = read_source(*file, options, open, series.paths);
  if (dataset.num_steps == 1) return dataset;
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: has {} steps of its own: expected one, as {} names it as a step",
                          file->name(), dataset.num_steps, source.name()));
}

}  // namespace

bool is_file_series(const ByteSource& source, std::string_view start) {
  if (!trimmed(start).starts_with('{')) return false;
  return start.find(kVersion) != std::string_view::npos || ending_of(source.name()) == ".series";
}

FileSeries file_series(const ByteSource& source) {
  if (source.size() > static_cast<std::int64_t>(kMaxJsonBytes)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: has {} bytes: file series of at most {} are read", source.name(),
                            source.size(), kMaxJsonBytes));
  }
  const Json json = parse_json(source.text(0, source.size()), source.name());
  const JsonValue files = JsonValue(json, source.name() + ": ").object().member("files").array();
  if (files.size() == 0) files.refuse("expected at least one file");
  if (files.size() > static_cast<std::size_t>(kMaxVtkSetFiles)) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: names {} files: at most {} are read",
                                                     source.name(), files.size(), kMaxVtkSetFiles));
  }
  std::vector<std::string> paths;
  std::vector<double> times;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const JsonValue file = files.element(i).object();
    const std::string name = file.member("name").string();
    if (name.empty()) file.member("name").refuse("expected the name of a file");
    paths.push_back(path_beside(source.name(), name));
    if (file.has("time")) times.push_back(file.member("time").number());
  }
  if (times.size() != paths.size()) return {std::move(paths), {}};
  std::vector<std::size_t> order(paths.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return times[a] < times[b]; });
  FileSeries series;
  for (const std::size_t i : order) {
    series.paths.push_back(paths[i]);
    series.times.push_back(times[i]);
  }
  return series;
}

std::vector<std::string> file_series_companions(const ByteSource& source) {
  std::vector<std::string> files;
  for (const std::string& path : file_series(source).paths) {
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) files.push_back(path);
  }
  return files;
}

Dataset read_file_series(const ByteSource& source, const ReadOptions& options, const Opener& open) {
  const FileSeries series = file_series(source);
  for (const std::string& path : series.paths) open_step(source, path, open);
  // Whoever goes through a series asks for step after step: all are compared when it is opened.
  if (options.step.value_or(0) == 0)
    check_step_outlines(series.paths.front(), {series.paths.begin() + 1, series.paths.end()});
  return read_mesh_step(source.name(), static_cast<std::int64_t>(series.paths.size()), series.times,
                        options, [&](std::int64_t step) {
                          ReadOptions own = options;
                          own.step.reset();
                          // Of a step's rows, shares would choose each its own.
                          if (!options.step) own.share.reset();
                          return read_step_of(series, static_cast<std::size_t>(step), source, own,
                                              open);
                        });
}

}  // namespace ovoid::io
