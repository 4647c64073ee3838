// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "io/byte_source.h"
#include "io/formats.h"
#include "io/npy.h"
#include "io/nrrd.h"
#include "io/raw.h"
#include "io/vtk_image.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

constexpr const char* kReadable =
    "NRRD, NPY, VTI, legacy VTK, or raw samples with dimensions and type";

// What a raw file cannot say, said about a file that says it itself: one of both is a mistake.
void refuse_raw_options(const std::string& path, const char* format, const RawOptions& raw,
                        bool knows_spacing) {
  const char* const given = raw.dims                       ? "dimensions"
                            : raw.type                     ? "a type"
                            : raw.big_endian               ? "a byte order"
                            : raw.spacing && knows_spacing ? "a spacing"
                                                           : nullptr;
  if (given != nullptr) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: is {} and states its own layout: {} can be given for raw files only", path,
                    format, given));
  }
}

Dataset read_unknown(const io::ByteSource& source, const std::string& start,
                     const ReadOptions& options) {
  const RawOptions from_name = io::parse_raw_name(source.name());
  const std::string ending = io::ending_of(source.name());
  const bool is_raw = options.raw.dims || options.raw.type || (from_name.dims && from_name.type);
  if (is_raw || ending == ".raw") return io::read_raw(source, options);
  if (source.size() == 0)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: is empty", source.name()));
  for (const char* known : {".nrrd", ".nhdr", ".npy", ".vti", ".vtk"}) {
    if (ending == known) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: the name ends in {} but the content does not begin like it",
                              source.name(), known));
    }
  }
  const std::string kind = io::unsupported_kind_of(start);
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: {}: expected {}", source.name(),
                  kind.empty() ? "the format is not known" : "is " + kind + ", which is not read",
                  kReadable));
}

}  // namespace

Dataset read_dataset(const std::vector<std::string>& paths, const ReadOptions& options) {
  if (paths.empty()) throw Error(ErrorCode::kInvalidArgument, "input: no file is named");
  if (paths.size() > 1) {
    throw Error(
        ErrorCode::kUnsupported,
        fmt::format(
            "{}, {}: {} inputs: a volume is one file, or an NRRD header that lists its parts",
            paths[0], paths[1], paths.size()));
  }
  const auto source = io::open_file(paths[0]);
  const std::string start = source->text(0, 512);
  switch (io::kind_of(start)) {
    case io::FileKind::kNrrd:
      refuse_raw_options(paths[0], "NRRD", options.raw, true);
      return io::read_nrrd(*source, options);
    case io::FileKind::kNpy:
      refuse_raw_options(paths[0], "NPY", options.raw, false);
      return io::read_npy(*source, options);
    case io::FileKind::kVtkXml:
    case io::FileKind::kVtkLegacy:
      refuse_raw_options(paths[0], "VTK", options.raw, true);
      return io::read_vtk_image(*source, io::kind_of(start), options);
    case io::FileKind::kUnknown:
      break;
  }
  return read_unknown(*source, start, options);
}

}  // namespace ovoid
