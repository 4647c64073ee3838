// SPDX-License-Identifier: Apache-2.0
// Looks of every kind: tells from the content which reader is meant, and holds what it returns to
// what a look must be.
#include <fmt/format.h>

#include <algorithm>

#include "io/core/line_ends.h"
#include "io/core/text_file.h"
#include "io/core/text_scanner.h"
#include "io/looks/look_readers.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace io {
namespace {

struct Signature {
  std::string_view bytes;
  const char* kind;
};

// What people hand over by mistake.
constexpr Signature kSignatures[] = {
    {"\x89PNG", "a PNG picture"},         {"\xff\xd8\xff", "a JPEG picture"},
    {"v/1\x01", "an OpenEXR picture"},    {"NRRD", "an NRRD volume"},
    {"\x93NUMPY", "a NumPy array"},       {"# vtk DataFile", "a legacy VTK dataset"},
    {"ObjectType", "a MetaImage volume"}, {"\x1f\x8b", "gzip-compressed data"},
    {"PK\x03\x04", "a ZIP archive"},      {"\x89HDF", "an HDF5 file"},
    {"%PDF", "a PDF document"},           {"ply\n", "a PLY file"},
};

// Only text is left: anything else has zeros or other control characters near its start.
bool is_binary(std::string_view text) {
  constexpr std::size_t kLookedAt = 4096;
  return std::any_of(text.begin(), text.begin() + std::min(text.size(), kLookedAt),
                     [](char c) { return static_cast<unsigned char>(c) < 0x20 && !is_blank(c); });
}

[[noreturn]] void refuse_kind(const LookFile& file, const std::string& kind) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}, {}", file.path, kind, kExpectedLook));
}

Look read_json_look(const LookFile& file) {
  const Json json = parse_json(file.text, file.path);
  if (json.is_object() && json.contains("volumeProperties")) return read_slicer_json(file, json);
  if (json.is_object() && json.contains("position") && json.contains("focal_point")) {
    refuse_kind(file, "looks like a camera (--camera)");
  }
  return read_paraview_json(file, json);
}

Look read_any_look(const LookFile& file) {
  for (const Signature& signature : kSignatures) {
    if (file.text.starts_with(signature.bytes)) {
      refuse_kind(file, fmt::format("looks like {}", signature.kind));
    }
  }
  if (is_binary(file.text)) refuse_kind(file, "looks like binary data");
  const auto first = std::find_if_not(file.text.begin(), file.text.end(), is_blank);
  if (first == file.text.end()) refuse_kind(file, "is empty");
  if (*first == '[' || *first == '{') return read_json_look(file);
  return *first == '<' ? read_xml_look(file) : read_text_look(file);
}

}  // namespace

std::string printable(std::string_view name) {
  constexpr std::size_t kShown = 80;
  std::string shown(name.substr(0, kShown));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, '?');
  return shown;
}

void refuse_name(const LookFile& file, const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 10;
  std::string has = names.empty() ? "no names" : "";
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    has += (has.empty() ? "" : ", ") + printable(names[i]);
  }
  if (names.size() > kShown) has += fmt::format(" and {} more", names.size() - kShown);
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("preset = {}: {} has {}", file.wanted, file.path, has));
}

}  // namespace io

Look read_look(const std::string& path, const std::string& name) {
  return look_from_text(io::read_text(path, io::kMaxJsonBytes), path, name);
}

Look look_from_text(const std::string& text, const std::string& source_name,
                    const std::string& name) {
  io::require_size(text.size(), io::kMaxJsonBytes, source_name);
  io::LookFile file{source_name, text, name};
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (file.text.starts_with(kByteOrderMark)) file.text.erase(0, kByteOrderMark.size());
  io::unify_line_ends(file.text);
  Look look = io::read_any_look(file);
  look.transfer_function.sort();
  try {
    look.validate();
  } catch (const Error& error) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source_name, error.what()));
  }
  return look;
}

TransferFunction read_transfer_function(const std::string& path, const std::string& preset) {
  return read_look(path, preset).transfer_function;
}

}  // namespace ovoid
