// SPDX-License-Identifier: Apache-2.0
#include "io/core/signatures.h"

#include <filesystem>

#include "io/core/text_scanner.h"

namespace ovoid::io {

bool is_gzip(std::string_view start) noexcept { return start.starts_with("\x1f\x8b"); }

// "BZh", the level, and the first block's magic, which is pi, or the end's, the square root of pi.
bool is_bzip2(std::string_view start) noexcept {
  if (!start.starts_with("BZh") || start.size() < 7) return false;
  const std::string_view magic = start.substr(4, 3);
  return magic == "\x31\x41\x59" || magic == "\x17\x72\x45";
}

bool is_hdf5(std::string_view start) noexcept { return start.starts_with("\x89HDF\r\n\x1a\n"); }

bool has_dicom_header(std::string_view start) noexcept {
  constexpr std::size_t kPreamble = 128;
  if (start.size() < kDicomStart || start.substr(kPreamble, 4) != "DICM") return false;
  // Group 2, always in explicit little endian: the letters of a value representation. A picture
  // whose samples happen to read DICM has no such thing behind them.
  const std::string_view element = start.substr(kPreamble + 4, 6);
  const auto is_letter = [](char c) { return c >= 'A' && c <= 'Z'; };
  return element[0] == 2 && element[1] == 0 && is_letter(element[4]) && is_letter(element[5]);
}

std::string picture_format_of(std::string_view start) {
  if (has_dicom_header(start)) return {};
  using namespace std::string_view_literals;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (start.starts_with(magic)) return "TIFF";
  }
  if (start.starts_with("\x89PNG")) return "PNG";
  if (start.starts_with("\xff\xd8\xff")) return "JPEG";
  if (start.starts_with("BM") && start.size() >= 10 && start.substr(6, 4) == "\0\0\0\0"sv)
    return "BMP";
  return {};
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
