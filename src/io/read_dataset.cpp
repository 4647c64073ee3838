// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "io/check_dataset.h"
#include "io/core/byte_source.h"
#include "io/core/row_share.h"
#include "io/dicom/dicom.h"
#include "io/dicom/dicom_elements.h"
#include "io/formats.h"
#include "io/images/raw.h"
#include "io/images/slices.h"
#include "io/input_files.h"
#include "io/meshes/plot3d.h"
#include "io/read_source.h"
#include "io/reader/reader_session.h"
#include "io/step_files.h"
#include "io/unread_formats.h"
#include "io/zarr/zarr.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

Dataset read_any(const io::ByteSource& source, const ReadOptions& options, const io::Opener& open,
                 const std::vector<std::string>& steps) {
  const io::Format* const format = io::format_of(source, options.raw);
  if (format == nullptr) io::refuse_unknown(source);
  if (options.faces && format->name == std::string_view("PLY"))
    return io::read_as(io::format_called(io::kPlyFaces), source, options, open);
  return io::read_as(*format, source, options, open, steps);
}

// Readers of files that hold one volume, or one step, need not look at what was asked for.
void check_choice(const Dataset& dataset, const ReadOptions& options) {
  if (!options.block.empty() && dataset.blocks.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: block '{}': the input is one volume and has no blocks",
                            dataset.source, options.block));
  }
  if (options.step.value_or(0) >= dataset.num_steps || options.step.value_or(0) < 0) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: step {}: expected 0 to {}", dataset.source, *options.step,
                            dataset.num_steps - 1));
  }
}

// What a file wrote into a message must not steer the terminal that shows it, nor break the line.
std::string printable_name(std::string text) {
  for (char& c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) c = '?';
  }
  return text;
}

// Is the first of several inputs half of a PLOT3D dataset? The flags of raw files say that it is
// not.
bool is_plot3d(const std::string& path, const RawOptions& raw, io::Plot3dContent content) {
  const RawOptions from_name = io::parse_raw_name(path);
  if (raw.dims || raw.type || from_name.dims || from_name.type) return false;
  const auto source = io::open_file(path);
  return io::format_by_content(*source) == nullptr && io::find_plot3d(*source, content).has_value();
}

// Nothing that indexes what was read has to ask whether its parts fit each other.
void check_parts(const Dataset& dataset) {
  try {
    io::check_dataset(dataset);
  } catch (const Error& error) {
    throw Error(error.code(),
                fmt::format("{}: contradicts itself: {}", dataset.source, error.what()));
  }
}

// What every reader's result goes through, and its error.
template <typename Read>
Dataset finished(const Read& read, const ReadOptions& options) {
  try {
    io::check_share(options.share);
    Dataset dataset = read();
    check_choice(dataset, options);
    check_parts(dataset);
    io::cut_to_share(dataset, options.share);
    for (std::string& note : dataset.notes) note = printable_name(std::move(note));
    for (DataArray& array : dataset.arrays) {
      array.name = printable_name(std::move(array.name));
      array.unit = printable_name(std::move(array.unit));
    }
    for (DatasetBlock& block : dataset.blocks) {
      block.name = printable_name(std::move(block.name));
      block.description = printable_name(std::move(block.description));
    }
    return dataset;
  } catch (const Error& error) {
    throw Error(error.code(), printable_name(error.what()));
  }
}

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

// A missing file is told as such, whatever it was meant to be.
bool is_dicom(const std::string& path) {
  return io::looks_like_dicom(io::open_file(path)->text(0, 512));
}

// A folder, or several files: the slices of a DICOM series.
Dataset read_dicom_parts(const std::vector<std::string>& paths, const ReadOptions& options) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (is_folder(path)) {
      if (const std::string unread = io::unread_folder_of(path); !unread.empty())
        throw Error(ErrorCode::kUnsupported, fmt::format("{}: {}", path, unread));
      const std::vector<std::string> inner = io::dicom_files_in(path);
      files.insert(files.end(), inner.begin(), inner.end());
      continue;
    }
    if (!is_dicom(path)) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is no DICOM file: expected more slices of the series that {} "
                              "belongs to",
                              path, paths[0]));
    }
    files.push_back(path);
  }
  const std::string source =
      paths.size() == 1 ? paths[0] : fmt::format("{} and {} more", paths[0], paths.size() - 1);
  io::refuse_raw_options(source, io::format_called("DICOM"), options.raw);
  return io::read_dicom(source, files, options);
}

// A folder of slices, or several pictures; nothing if the paths are something else.
std::optional<Dataset> read_slice_parts(const std::vector<std::string>& paths,
                                        const ReadOptions& options) {
  const bool is_named = !is_folder(paths[0]);
  if (is_named ? paths.size() < 2 || !io::is_slice_file(paths[0]) : !io::is_slice_folder(paths[0]))
    return std::nullopt;
  if (!is_named && paths.size() > 1) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: is a folder of slices, of which one is read: expected it alone",
                            paths[0]));
  }
  io::refuse_raw_options(paths[0], io::format_called("folder of slices"), options.raw);
  return finished(
      [&] {
        return is_named ? io::read_slice_files(paths, options)
                        : io::read_slice_folder(paths[0], options);
      },
      options);
}

}  // namespace

namespace io {

Dataset read_source(const ByteSource& source, const ReadOptions& options, const Opener& open,
                    const std::vector<std::string>& steps) {
  return finished([&] { return read_any(source, options, open, steps); }, options);
}

}  // namespace io

Dataset read_dataset(const std::vector<std::string>& paths, const ReadOptions& options) {
  if (paths.empty()) throw Error(ErrorCode::kInvalidArgument, "input: no file is named");
  std::vector<std::string> described;  // a Zarr folder stands for the file that describes it
  described.reserve(paths.size());
  for (const std::string& path : paths) described.push_back(io::zarr_description_of(path));
  if (described != paths) return read_dataset(described, options);
  if (!options.session) {
    ReadOptions own = options;
    own.session = std::make_shared<ReaderSession>(paths);
    return read_dataset(paths, own);
  }
  if (auto slices = read_slice_parts(paths, options)) return std::move(*slices);
  if (is_folder(paths[0]) || (paths.size() > 1 && is_dicom(paths[0])))
    return finished([&] { return read_dicom_parts(paths, options); }, options);
  if (paths.size() == 2 && is_plot3d(paths[0], options.raw, io::Plot3dContent::kSolution) &&
      is_plot3d(paths[1], options.raw, io::Plot3dContent::kGrid)) {
    return finished([&] { return io::read_plot3d(paths[1], {paths[0]}, options); }, options);
  }
  if (paths.size() > 1 && is_plot3d(paths[0], options.raw, io::Plot3dContent::kGrid)) {
    const std::vector<std::string> solutions(paths.begin() + 1, paths.end());
    return finished([&] { return io::read_plot3d(paths[0], solutions, options); }, options);
  }
  if (paths.size() > 1) return io::read_step_files(paths, options);
  return io::read_source(*io::open_file(paths[0]), options,
                         io::opener_of_named_files(paths[0], options));
}

}  // namespace ovoid
