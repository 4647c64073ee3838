// SPDX-License-Identifier: Apache-2.0
#include "io/formats.h"

#include <cstddef>
#include <filesystem>

#include "io/dicom_elements.h"
#include "io/npy.h"
#include "io/nrrd_header.h"

namespace ovoid::io {
namespace {

bool has_at(std::string_view start, std::size_t offset, std::string_view magic) {
  return start.size() >= offset + magic.size() && start.substr(offset, magic.size()) == magic;
}

}  // namespace

FileKind kind_of(std::string_view start) noexcept {
  const std::string_view whole = start;
  if (looks_like_nrrd(start)) return FileKind::kNrrd;
  if (looks_like_npy(start)) return FileKind::kNpy;
  if (start.starts_with("# vtk DataFile")) return FileKind::kVtkLegacy;
  if (start.starts_with("\xef\xbb\xbf")) start.remove_prefix(3);  // a byte order mark
  const auto first = start.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && start[first] == '<' &&
      start.find("<VTKFile") != std::string_view::npos) {
    return FileKind::kVtkXml;
  }
  if (looks_like_dicom(whole)) return FileKind::kDicom;
  return FileKind::kUnknown;
}

std::string unsupported_kind_of(std::string_view start) {
  using namespace std::string_view_literals;
  if (has_at(start, 344, "n+1\0"sv) || has_at(start, 344, "ni1\0"sv) || has_at(start, 4, "n+2\0"sv))
    return "a NIfTI file";
  if (has_at(start, 0, "\x89HDF\r\n")) return "an HDF5 file";
  if (has_at(start, 0, "CDF\x01") || has_at(start, 0, "CDF\x02")) return "a netCDF or Exodus file";
  if (has_at(start, 0, "ObjectType =") || has_at(start, 0, "NDims =")) return "a MetaImage header";
  if (has_at(start, 0, "ply\n") || has_at(start, 0, "ply\r")) return "a PLY file";
  if (has_at(start, 0, "PK\x03\x04")) return "a zip archive or an NPZ file";
  if (has_at(start, 0, "\x1f\x8b")) return "a gzip file";
  if (has_at(start, 0, "BZh")) return "a bzip2 file";
  if (has_at(start, 0, "\x89PNG")) return "a PNG picture";
  if (has_at(start, 0, "\x76\x2f\x31\x01")) return "an OpenEXR picture";
  return {};
}

std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return ending;
}

}  // namespace ovoid::io
