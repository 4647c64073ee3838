// SPDX-License-Identifier: Apache-2.0
#include "io/formats.h"

#include <cstddef>
#include <filesystem>

#include "io/core/text_scanner.h"
#include "io/dicom/dicom_elements.h"
#include "io/images/metaimage_header.h"
#include "io/images/nifti_header.h"
#include "io/images/npy.h"
#include "io/images/nrrd_header.h"
#include "io/images/slc.h"
#include "io/points/ply_header.h"

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
  if (looks_like_nifti(start)) return FileKind::kNifti;
  if (looks_like_slc(start)) return FileKind::kSlc;
  if (looks_like_metaimage(start)) return FileKind::kMetaImage;
  if (start.starts_with("# vtk DataFile")) return FileKind::kVtkLegacy;
  if (looks_like_ply(start)) return FileKind::kPly;
  if (start.starts_with("PK\x03\x04") || start.starts_with("PK\x05\x06")) return FileKind::kZip;
  if (is_hdf5(start)) return FileKind::kHdf5;
  if (start.starts_with("ITEM: TIMESTEP") || start.starts_with("ITEM: UNITS"))
    return FileKind::kLammpsDump;
  if (start.starts_with("\xef\xbb\xbf")) start.remove_prefix(3);  // a byte order mark
  const auto first = start.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && start[first] == '<' &&
      start.find("<VTKFile") != std::string_view::npos) {
    return FileKind::kVtkXml;
  }
  if (looks_like_dicom(whole)) return FileKind::kDicom;
  return FileKind::kUnknown;
}

std::string picture_format_of(std::string_view start) {
  using namespace std::string_view_literals;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (start.starts_with(magic)) return "TIFF";
  }
  if (start.starts_with("\x89PNG")) return "PNG";
  if (start.starts_with("\xff\xd8\xff")) return "JPEG";
  if (start.starts_with("BM") && has_at(start, 6, "\0\0\0\0"sv)) return "BMP";
  return {};
}

bool is_hdf5(std::string_view start) noexcept { return start.starts_with("\x89HDF\r\n\x1a\n"); }

std::string unsupported_kind_of(std::string_view start) {
  if (looks_like_analyze(start)) return "an ANALYZE 7.5 header";
  if (is_gzip(start)) return "a gzip file of something other than NIfTI or text";
  if (is_bzip2(start)) return "a bzip2 file of something other than text";
  if (start.find("<Xdmf") != std::string_view::npos)
    return "an XDMF file, for which distributions' VTK has no reader (write VTU or VTKHDF instead)";
  if (const std::string picture = picture_format_of(start); !picture.empty())
    return "a " + picture + " picture";
  if (has_at(start, 0, "\x76\x2f\x31\x01")) return "an OpenEXR picture";
  return {};
}

bool is_gzip(std::string_view start) noexcept { return start.starts_with("\x1f\x8b"); }

// "BZh", the level, and the first block's magic, which is pi, or the end's, the square root of pi.
bool is_bzip2(std::string_view start) noexcept {
  return start.starts_with("BZh") &&
         (has_at(start, 4, "\x31\x41\x59") || has_at(start, 4, "\x17\x72\x45"));
}

std::string ending_of(const std::string& path) {
  const std::filesystem::path whole(path);
  std::string ending = whole.extension().string();
  if (ending == ".gz" || ending == ".GZ") ending = whole.stem().extension().string() + ending;
  return lower(ending);
}

std::string plain_ending_of(const std::string& path) {
  const std::filesystem::path whole(path);
  const std::string ending = lower(whole.extension().string());
  return ending == ".gz" || ending == ".bz2" ? lower(whole.stem().extension().string()) : ending;
}

}  // namespace ovoid::io
