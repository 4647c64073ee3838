// SPDX-License-Identifier: Apache-2.0
// Looks as lines of plain numbers: 3D Slicer's .vp, Inviwo's rows of value, opacity and #rrggbb,
// and lists of numbers in rows or one after the other. Told apart by their shape (docs/looks.md,
// "Files").
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "io/core/text_file.h"
#include "io/core/text_scanner.h"
#include "io/looks/look_readers.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace {

// What lists hold at most: far more than any look, and 8 MiB.
constexpr std::size_t kMaxNumbers = std::size_t{1} << 20;

[[noreturn]] void refuse_numbers(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, what);
}

void require_rise(const std::vector<double>& numbers, std::size_t group) {
  if (numbers.empty() || numbers.size() % group != 0) {
    refuse_numbers(fmt::format(
        "has {} numbers: must be {}", numbers.size(),
        group == 4 ? "value,red,green,blue for each point" : "value,opacity for each point"));
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t part = i % group;
    if (part > 0 && !(numbers[i] >= 0.0 && numbers[i] <= 1.0)) {
      refuse_numbers(fmt::format("number {} is {}: {} must be in [0, 1]", i + 1, numbers[i],
                                 group == 4 ? "colours" : "opacities"));
    }
    if (part == 0 && i > 0 && !(numbers[i] >= numbers[i - group])) {
      refuse_numbers(fmt::format("number {} is {}: values must rise, it stands after {}", i + 1,
                                 numbers[i], numbers[i - group]));
    }
  }
}

}  // namespace

std::vector<ColorPoint> colors_from_list(const std::vector<double>& numbers) {
  require_rise(numbers, 4);
  std::vector<ColorPoint> points;
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    points.push_back({numbers[i], {numbers[i + 1], numbers[i + 2], numbers[i + 3]}});
  }
  return points;
}

std::vector<OpacityPoint> opacities_from_list(const std::vector<double>& numbers) {
  require_rise(numbers, 2);
  std::vector<OpacityPoint> points;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    points.push_back({.x = numbers[i], .opacity = numbers[i + 1]});
  }
  return points;
}

namespace io {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

struct Line {
  std::size_t number;  // from 1
  std::string_view text;
};

bool is_comment(std::string_view text) { return text.starts_with('#') || text.starts_with("//"); }

// The next line that is neither blank nor a comment, taken off `rest`; counts in `line.number`.
bool next_line(std::string_view& rest, Line& line) {
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    line.text = trimmed(rest.substr(0, end));
    ++line.number;
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!line.text.empty() && !is_comment(line.text)) return true;
  }
  return false;
}

std::string place_of(const LookFile& file, const Line& line) {
  return fmt::format("{}: line {}", file.path, line.number);
}

// A .vp file has six lines of one number, then lines that begin with the count of what follows.
constexpr int kVpSingles = 6;
constexpr int kVpLines = 9;

bool is_vp(const LookFile& file) {
  std::string_view rest = file.text;
  Line line{};
  for (int i = 0; i < kVpLines; ++i) {
    if (!next_line(rest, line)) return false;
    const bool is_single = line.text.find_first_of(" \t,") == std::string_view::npos;
    if (i < kVpSingles ? !is_single : is_single && line.text != "0") return false;
  }
  return true;
}

Look read_vp(const LookFile& file) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  std::string_view rest = file.text;
  Line line{};
  for (int i = 0; i < kVpLines && next_line(rest, line); ++i) {
    const std::string place = place_of(file, line);
    const auto strength = [&] { return number_in(line.text, 0.0, kNoLimit, place); };
    // Diffuse before ambient. The first line, how samples are interpolated, says nothing here.
    if (i == 0) number_in(line.text, 0.0, 2.0, place);
    if (i == 1) look.shade = number_in(line.text, 0.0, 1.0, place) != 0.0;
    if (i == 2) look.material.diffuse = strength();
    if (i == 3) look.material.ambient = strength();
    if (i == 4) look.material.specular = strength();
    if (i == 5) look.material.specular_power = strength();
    if (i == 6) take_slicer_opacities(tf, line.text, place);
    if (i == 7) take_slicer_gradients(tf, line.text, place);
    if (i == 8) take_slicer_colors(tf, line.text, place);
  }
  return look;
}

Rgb hex_color(std::string_view text, const std::string& place) {
  const auto number = exact_number<std::uint32_t>(text.substr(1), 16);
  if (text.size() != 7 || !number) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: '{}': must be #rrggbb", place, printable(text)));
  }
  const std::uint32_t rgb = *number;
  return {(rgb >> 16 & 0xffU) / 255.0, (rgb >> 8 & 0xffU) / 255.0, (rgb & 0xffU) / 255.0};
}

Look read_rows_with_hex(const LookFile& file) {
  Look look;
  TransferFunction& tf = look.transfer_function;
  std::string_view rest = file.text;
  Line line{};
  while (next_line(rest, line)) {
    const std::string place = place_of(file, line);
    const std::vector<std::string_view> parts = words(line.text);
    if (parts.size() != 3 || !parts[2].starts_with('#')) {
      throw Error(ErrorCode::kFileFormat, place + ": must be a value, an opacity and #rrggbb");
    }
    const double x = number_in(parts[0], -kNoLimit, kNoLimit, place);
    tf.opacities.push_back({.x = x, .opacity = number_in(parts[1], 0.0, 1.0, place)});
    tf.colors.push_back({x, hex_color(parts[2], place)});
  }
  return look;
}

struct Numbers {
  std::vector<double> values;
  std::size_t columns = 0;  // of every line; 0 if they differ or there is one line only
};

Numbers read_numbers(const LookFile& file) {
  Numbers numbers;
  std::string_view rest = file.text;
  Line line{};
  std::size_t num_lines = 0;
  while (next_line(rest, line)) {
    const std::size_t before = numbers.values.size();
    std::string_view text = line.text;
    while (!text.empty()) {
      const auto end = std::min(text.find_first_of(" \t\r\f\v,;"), text.size());
      const std::string_view word = text.substr(0, end);
      if (!word.empty()) {
        if (!parse_real(word)) {
          throw Error(ErrorCode::kFileFormat,
                      fmt::format("{}: '{}' is no number, {}", place_of(file, line),
                                  printable(word), kExpectedLook));
        }
        numbers.values.push_back(*parse_real(word));
      }
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (numbers.values.size() > kMaxNumbers) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: must have at most {} numbers", file.path, kMaxNumbers));
    }
    const std::size_t columns = numbers.values.size() - before;
    numbers.columns = num_lines == 0 || columns == numbers.columns ? columns : 0;
    ++num_lines;
  }
  if (num_lines < 2) numbers.columns = 0;
  return numbers;
}

// value, red, green, blue, opacity in every row.
void take_five_columns(TransferFunction& tf, const std::vector<double>& values) {
  std::vector<double> colors, opacities;
  for (std::size_t i = 0; i < values.size(); i += 5) {
    colors.insert(colors.end(), values.begin() + static_cast<std::ptrdiff_t>(i),
                  values.begin() + static_cast<std::ptrdiff_t>(i + 4));
    opacities.insert(opacities.end(), {values[i], values[i + 4]});
  }
  tf.colors = colors_from_list(colors);
  tf.opacities = opacities_from_list(opacities);
}

Look read_list(const LookFile& file) {
  const Numbers numbers = read_numbers(file);
  const std::vector<double>& values = numbers.values;
  Look look;
  TransferFunction& tf = look.transfer_function;
  const bool may_be_colors = values.size() % 4 == 0 && numbers.columns != 2;
  if (numbers.columns == 5) {
    take_five_columns(tf, values);
  } else if (!may_be_colors) {
    tf.opacities = opacities_from_list(values);
  } else {
    try {
      tf.colors = colors_from_list(values);
    } catch (const Error& as_colors) {
      if (numbers.columns == 4) throw;
      try {
        tf.opacities = opacities_from_list(values);
      } catch (const Error&) {
        throw as_colors;  // the kind that its length suggests
      }
    }
  }
  return look;
}

bool has_hex_colors(const LookFile& file) {
  std::string_view rest = file.text;
  Line line{};
  return next_line(rest, line) && line.text.find('#') != std::string_view::npos;
}

}  // namespace

Look read_text_look(const LookFile& file) {
  if (!file.wanted.empty()) refuse_name(file, {});
  if (is_vp(file)) return read_vp(file);
  if (has_hex_colors(file)) return read_rows_with_hex(file);
  try {
    return read_list(file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument) throw;
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", file.path, error.what()));
  }
}

}  // namespace io
}  // namespace ovoid
