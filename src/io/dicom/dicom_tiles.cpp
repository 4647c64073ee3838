// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "io/core/numbers.h"

namespace ovoid::io {
namespace {

// The CSA header is little-endian in files of any byte order.
class CsaBytes {
 public:
  explicit CsaBytes(std::string_view bytes) : bytes_(bytes) {}

  std::size_t left() const { return bytes_.size(); }
  std::string_view take(std::size_t count) {
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(taken.size());
    return taken;
  }
  std::int32_t integer() {
    const std::string_view taken = take(4);
    return taken.size() == 4 ? number_at<std::int32_t>(taken.data(), false) : -1;
  }

 private:
  std::string_view bytes_;
};

std::string_view up_to_zero(std::string_view text) { return text.substr(0, text.find('\0')); }

std::string_view without_spaces(std::string_view text) {
  const auto first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

void keep_csa_tag(std::string_view name, const std::vector<double>& values, CsaHeader& header) {
  if (values.empty()) return;
  if (name == "NumberOfImagesInMosaic") header.num_slices = values[0];
  if (name == "B_value") header.b_value = values[0];
  if (name == "SliceNormalVector" && values.size() >= 3)
    header.normal = Vec3(values[0], values[1], values[2]);
}

}  // namespace

CsaHeader read_csa_header(std::string_view bytes) {
  constexpr std::size_t kTag = 84, kItem = 16;  // bytes before a tag's items, before a value
  CsaHeader header;
  CsaBytes csa(bytes);
  const bool is_second = bytes.starts_with("SV10");
  if (is_second) csa.take(8);
  const std::int32_t num_tags = csa.integer();
  csa.take(4);
  std::int32_t first_num_items = 0;  // which the first version adds to every length
  for (std::int32_t tag = 0; tag < num_tags && csa.left() >= kTag; ++tag) {
    const std::string_view name = up_to_zero(csa.take(64));
    csa.take(12);  // multiplicity, representation, syngo's type
    const std::int32_t num_items = csa.integer();
    csa.take(4);
    if (tag == 0) first_num_items = num_items;
    std::vector<double> values;
    for (std::int32_t item = 0; item < num_items && csa.left() >= kItem; ++item) {
      const std::array<std::int32_t, 4> head{csa.integer(), csa.integer(), csa.integer(),
                                             csa.integer()};
      const std::int64_t length =
          is_second ? head[1] : static_cast<std::int64_t>(head[0]) - first_num_items;
      if (length < 0 || length > static_cast<std::int64_t>(csa.left())) return header;
      const auto size = static_cast<std::size_t>(length);
      const std::string_view text = without_spaces(up_to_zero(csa.take(size)));
      csa.take((4 - size % 4) % 4);
      const auto value = parse_real(text);
      if (value && std::abs(*value) <= 1e30) values.push_back(*value);
    }
    keep_csa_tag(name, values, header);
  }
  return header;
}

DicomTiles divide_tiles(const StatedTiles& stated, std::int64_t rows, std::int64_t columns,
                        std::int64_t num_frames) {
  constexpr double kMost = 65535;
  DicomTiles tiles;
  if (!stated.is_mosaic && !stated.is_grid) return tiles;
  const std::string what = stated.is_mosaic ? "a mosaic of Siemens (ImageType MOSAIC)"
                                            : "a grid of United Imaging (ImageType VFRAME)";
  auto count = stated.csa.num_slices;
  if (!count || *count < 1) count = stated.num_slices;
  if (!count || *count < 1) count = stated.num_slice_times;
  if (!count && stated.is_grid && !stated.positions.empty())
    count = static_cast<double>(stated.positions.size());
  if (!count || !(*count >= 1 && *count <= kMost) || *count != std::floor(*count)) {
    tiles.fault = fmt::format("{} that does not say of how many slices", what);
    return tiles;
  }
  const auto num_slices = static_cast<std::int64_t>(*count);
  const auto across = static_cast<std::int64_t>(std::ceil(std::sqrt(*count)));
  const std::int64_t down = stated.is_mosaic ? across : (num_slices + across - 1) / across;
  const auto num_positions = static_cast<std::int64_t>(stated.positions.size());
  if (num_frames != 1) {
    tiles.fault = fmt::format("{} in {} frames", what, num_frames);
  } else if (rows % down != 0 || columns % across != 0) {
    tiles.fault = fmt::format(
        "{} of {} slices, {} x {} tiles, which do not divide its {} x {} "
        "samples",
        what, num_slices, across, down, columns, rows);
  } else if (stated.is_grid && num_slices > 1 &&
             (num_positions < num_slices ||
              std::any_of(stated.positions.begin(), stated.positions.begin() + num_slices,
                          [](const auto& position) { return !position; }))) {
    tiles.fault = fmt::format(
        "{} of {} slices that states not all of their positions "
        "(0065,xx51)",
        what, num_slices);
  } else {
    tiles = {num_slices, across, down, {}, {}};
  }
  if (stated.num_slices && *stated.num_slices >= 1 && *stated.num_slices != *count) {
    tiles.note = fmt::format(
        "{} of {} slices by its CSA header, of {:.0f} by (0019,xx0a): the "
        "former is taken",
        what, num_slices, *stated.num_slices);
  }
  return tiles;
}

}  // namespace ovoid::io
