// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/surfaces.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/byte_stream.h"
#include "io/core/number_fields.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/meshes/surface_builder.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kStlHeader = 84;    // bytes, the number of triangles at the end
constexpr std::int64_t kStlTriangle = 50;  // bytes: a normal, three corners, two bytes more

[[noreturn]] void fail_surface(const std::string& where, const std::string& what) {
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", where, what));
}

std::int64_t num_stl_triangles(const ByteSource& source) {
  std::array<std::byte, sizeof(std::uint32_t)> bytes;
  source.read(kStlHeader - 4, bytes);
  return number_at<std::uint32_t>(bytes.data(), false);
}

void read_binary_stl(const ByteSource& source, std::int64_t count, ReadProgress& progress,
                     SurfaceBuilder& surface) {
  constexpr std::int64_t kAtATime = ReadProgress::kChunk / kStlTriangle;
  std::vector<std::byte> piece(static_cast<std::size_t>(std::min(count, kAtATime) * kStlTriangle));
  for (std::int64_t first = 0; first < count; first += kAtATime) {
    const std::int64_t now = std::min(kAtATime, count - first);
    const auto part = std::span(piece).first(static_cast<std::size_t>(now * kStlTriangle));
    source.read(kStlHeader + first * kStlTriangle, part);
    for (std::int64_t i = 0; i < now; ++i) {
      const std::byte* const corners = part.data() + i * kStlTriangle + 3 * sizeof(float);
      const auto node = static_cast<std::uint32_t>(surface.num_nodes());
      for (std::size_t c = 0; c < 9; c += 3) {
        const auto number = [&](std::size_t n) {
          return double{number_at<float>(corners + n * sizeof(float), false)};
        };
        surface.add_node({number(c), number(c + 1), number(c + 2)});
      }
      surface.add_face({node, node + 1, node + 2});
    }
    progress.advance(now * kStlTriangle);
  }
}

// The three numbers behind the first word of a line.
std::array<double, 3> place_in(std::string_view line, const LineReader& lines) {
  FieldReader fields(line, Separator::kBlanks);
  fields.skip();
  std::array<double, 3> at{};
  for (double& x : at) {
    if (!fields.number(x))
      fail_surface(lines.where(), fmt::format("'{}' is no number", fields.text().substr(0, 32)));
  }
  return at;
}

void read_text_stl(LineReader& lines, SurfaceBuilder& surface) {
  std::string_view line;
  std::vector<std::uint32_t> corners;
  while (lines.next(line)) {
    const auto word = words(line.substr(0, std::min<std::size_t>(line.size(), 64)));
    if (word.empty()) continue;
    const std::string key = lower(word[0]);
    if (key == "vertex") {
      corners.push_back(static_cast<std::uint32_t>(surface.num_nodes()));
      surface.add_node(place_in(line, lines));
    } else if (key == "endloop" || key == "endfacet") {
      if (corners.size() < 3 && !corners.empty())
        fail_surface(lines.where(), fmt::format("a facet of {} corners", corners.size()));
      surface.add_face(corners);
      corners.clear();
    }
  }
  if (!corners.empty()) fail_surface(lines.where(), "ends within a facet");
}

// "7", "7/1", "7//2", "-1": the corner's number among the nodes so far, from 1, or from the end.
std::uint32_t corner_of(std::string_view text, std::int64_t num_nodes, const LineReader& lines) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc{} && (end == text.data() + text.size() || *end == '/');
  if (is_number && number < 0) number += num_nodes + 1;
  if (!is_number || number < 1 || number > num_nodes) {
    fail_surface(lines.where(), fmt::format("corner '{}': expected 1 to {}, the vertices so far",
                                            text.substr(0, 32), num_nodes));
  }
  return static_cast<std::uint32_t>(number - 1);
}

}  // namespace

Dataset read_stl(const ByteSource& source, const ReadOptions& options) {
  SurfaceBuilder surface;
  ReadProgress progress(options, source.size());
  const bool has_header = source.size() >= kStlHeader;
  const std::int64_t count = has_header ? num_stl_triangles(source) : 0;
  const std::int64_t size = kStlHeader + count * kStlTriangle;
  // Some programs begin binary files with "solid", too, and some add bytes.
  const bool is_text = lower(source.text(0, 5)) == "solid" && source.size() != size;
  if (is_text) {
    const auto stream = open_stream(source, progress);
    LineReader lines(*stream, source.name());
    read_text_stl(lines, surface);
  } else {
    if (!has_header || source.size() < size) {
      fail_surface(source.name(),
                   fmt::format("is no STL file: neither text that begins with 'solid', nor as long "
                               "as its {} triangles take, {} bytes",
                               count, size));
    }
    read_binary_stl(source, count, progress, surface);
  }
  return std::move(surface).finish(source, "STL", options);
}

Dataset read_obj(const ByteSource& source, const ReadOptions& options) {
  SurfaceBuilder surface;
  ReadProgress progress(options, source.size());
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  std::string_view line;
  std::vector<std::uint32_t> corners;
  while (lines.next(line)) {
    line = trimmed(line);
    const auto says = [&](char what) {
      return line.size() > 1 && line[0] == what && (line[1] == ' ' || line[1] == '\t');
    };
    if (says('v')) surface.add_node(place_in(line, lines));
    if (!says('f') && !says('l')) continue;
    if (line.back() == '\\') fail_surface(lines.where(), "lines that go on (\\) are not read");
    corners.clear();
    for (const std::string_view text : words(line.substr(2)))
      corners.push_back(corner_of(text, surface.num_nodes(), lines));
    if (corners.size() < (says('f') ? 3U : 2U)) {
      fail_surface(lines.where(),
                   fmt::format("a {} of {} corners", says('f') ? "face" : "line", corners.size()));
    }
    if (says('f')) {
      surface.add_face(corners);
    } else {
      surface.add_line(corners);
    }
  }
  return std::move(surface).finish(source, "OBJ", options);
}

}  // namespace ovoid::io
