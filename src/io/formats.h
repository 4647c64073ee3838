// SPDX-License-Identifier: Apache-2.0
// The formats of datasets, one row each. All that depends on a file's format is told from here: how
// it is recognised, who reads it, which files belong to it, what is written and what that loses.
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/byte_source.h"
#include "io/step_outline.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Compression that a format is read through: its text alone, or a header that stays at the front.
enum class Packing { kNone, kGzip, kGzipOrBzip2 };

// Where the samples of a lattice are, as far as a written file says.
enum class PlaceInFile { kWhole, kNoSpace, kInSpaceAlone, kNone };

// How a format is written.
struct FormatWriter {
  std::vector<std::string_view> endings;
  std::vector<DatasetKind> kinds;
  // Of a dataset that was checked: of lattices at least one array, of points all of one length.
  void (*write)(const Dataset&, const std::string& path, const std::stop_token&) = nullptr;
  bool is_one_array = false;        // on a lattice of its own (lattice_of)
  bool keeps_scale = false;         // else arrays are written as plain_values()
  bool takes_body_centred = false;  // else Cartesian lattices alone
  PlaceInFile place = PlaceInFile::kWhole;
  const char* library = nullptr;                                   // that it takes
  std::string (*samples_path)(const std::string& path) = nullptr;  // a second file
  void (*check_samples_path)(const std::string& path) = nullptr;   // throws if it is not ours
};

struct Format {
  const char* name;  // as docs/formats.md calls it
  // Of names that promise the format; a file that is called so and is of none is told so.
  std::vector<std::string_view> endings;

  // Either tells the format from the first 512 bytes, unpacked as `packing` allows, or from the
  // file and its name. With neither the format is told otherwise (format_of, read_dataset).
  bool (*begins)(std::string_view start) = nullptr;
  bool (*is_file)(const ByteSource& source, std::string_view start) = nullptr;
  Packing packing = Packing::kNone;

  // Without a reader here, ovoid-read has one (io/foreign), which stands on `library`.
  Dataset (*read)(const ByteSource&, const ReadOptions&, const Opener&) = nullptr;
  const char* library = nullptr;
  // A lattice is where something is, and of a series where something is at any time: the reader in
  // ovoid-read is told all files.
  bool shares_lattice = false;
  // Several inputs may be parts of one step: the reader in ovoid-read is told all files, and sorts
  // them.
  bool sorts_inputs = false;
  bool says_layout = true;   // the flags of raw files contradict it,
  bool says_spacing = true;  // --spacing too
  bool says_axes = true;     // and --axis-order

  // The files that belong to the one named, beside it and as far as they are there. Opens none.
  std::vector<std::string> (*companions)(const ByteSource&) = nullptr;
  bool names_inputs = false;            // of which each may have companions of its own
  std::vector<DatasetKind> kinds = {};  // that it may hold; empty: any
  StepOutline (*outline)(const ByteSource&) = nullptr;         // what more a header tells
  std::optional<double> (*time)(const ByteSource&) = nullptr;  // that the file names

  std::vector<FormatWriter> writers = {};
};

// In the order in which they are tried and told.
const std::vector<Format>& formats();

// The faces of PLY files, as read_dataset() takes them where they are asked for.
inline constexpr const char* kPlyFaces = "PLY surfaces";

// The row of that name, which there must be.
const Format& format_called(std::string_view name);

// Is the library that a row names, VTK, HDF5 or OpenVDB, in this build?
bool has_library(std::string_view name);

// The format that the file's content, or its name where that decides, has; null if it has none.
const Format* format_by_content(const ByteSource& source);

// The same, and else raw where flags or name say dimensions and type, and tables of points by name.
const Format* format_of(const ByteSource& source, const RawOptions& raw);

// Reads a file of that format, here or in ovoid-read. `steps`: the files of the series that it is
// one of, or none. Throws Error.
Dataset read_as(const Format& format, const ByteSource& source, const ReadOptions& options,
                const Opener& open, const std::vector<std::string>& steps = {});

// Are all files of one format whose reader sorts its inputs?
bool are_sorted_by_reader(const std::vector<std::string>& paths);

// Throws the Error that tells what a file without a format may be, and what is read.
[[noreturn]] void refuse_unknown(const ByteSource& source);

// Throws Error(kInvalidArgument) for flags of raw files given with a file that says these things
// itself: one of both is a mistake. `source` names it in the message.
void refuse_raw_options(const std::string& source, const Format& format, const RawOptions& raw);

bool is_one_of(const std::vector<std::string_view>& endings, const std::string& ending);

// By the ending of `path`. Throws Error(kUnsupported) if none is written so, or not in this build.
const FormatWriter& writer_for(const std::string& path);

}  // namespace ovoid::io
