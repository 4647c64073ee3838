// SPDX-License-Identifier: Apache-2.0
#include "io/points/point_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "data/names_text.h"
#include "io/core/text_scanner.h"
#include "io/points/position_columns.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::array<std::string_view, 9> kPositionNames{
    "points", "coordinates", "positions", "position", "coords", "xyz", "pos", "point", "location"};

// "name:2" as "name" and 2; nothing if that is not how it ends.
std::optional<std::pair<std::string, int>> split_component(std::string_view name) {
  const auto colon = name.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  const auto number = parse_integer(name.substr(colon + 1));
  if (!number || *number < 0 || *number > 63) return std::nullopt;
  return std::pair(std::string(name.substr(0, colon)), static_cast<int>(*number));
}

// How many columns from `first` on are the components 0, 1, ... of one name, and free.
std::size_t num_joined(const std::vector<PointColumn>& columns, const PointLayout& layout,
                       std::size_t first) {
  const auto start = split_component(split_unit(columns[first].name).name);
  if (!start || start->second != 0) return 1;
  std::size_t count = 1;
  for (std::size_t i = first + 1; i < columns.size(); ++i, ++count) {
    const std::string name = split_unit(columns[i].name).name;
    const auto next = split_component(name);
    if (!columns[i].is_number || layout.targets[i].array >= 0 || !next ||
        next->first != start->first || next->second != static_cast<int>(count))
      break;
  }
  return count;
}

void add_array(const std::vector<PointColumn>& columns, std::size_t first, std::size_t count,
               PointLayout& layout) {
  NameAndUnit named = split_unit(columns[first].name);
  if (count > 1) named.name = split_component(named.name)->first;
  if (named.name.empty()) {
    // Programs number rows in a first column, and do not name it.
    const bool are_others_named = columns.size() > 1 && !columns[1].name.empty();
    named.name = first == 0 && are_others_named ? "index" : fmt::format("column {}", first + 1);
  }
  for (std::size_t i = 0; i < count; ++i)
    layout.targets[first + i] = {static_cast<int>(layout.arrays.size()), static_cast<int>(i)};
  layout.arrays.push_back({named.name, named.unit, static_cast<int>(count)});
}

}  // namespace

bool is_position_name(std::string_view name) {
  return std::find(kPositionNames.begin(), kPositionNames.end(), lower(name)) !=
         kPositionNames.end();
}

NameAndUnit split_unit(std::string_view text) {
  text = trimmed(text);
  if (const auto at = text.find(" @ "); at != std::string_view::npos && at > 0) {
    NameAndUnit named = split_unit(text.substr(0, at));
    named.name += text.substr(at);
    return named;
  }
  const char close = text.empty() ? '\0' : text.back();
  const char open = close == ']' ? '[' : close == ')' ? '(' : '\0';
  std::size_t begin = text.size();
  for (int depth = 0; open != '\0' && begin-- > 0;) {
    depth += text[begin] == close ? 1 : text[begin] == open ? -1 : 0;
    if (depth == 0) break;
  }
  if (open == '\0' || begin > text.size() || trimmed(text.substr(0, begin)).empty())
    return {std::string(text), ""};
  return {std::string(trimmed(text.substr(0, begin))),
          std::string(trimmed(text.substr(begin + 1, text.size() - begin - 2)))};
}

namespace {

// Which columns of numbers the positions do not need.
void add_arrays(const std::string& where, const std::vector<PointColumn>& columns,
                PointLayout& layout, std::vector<std::string>& notes) {
  std::vector<std::string> text_names, empty_names;
  for (std::size_t i = 0; i < columns.size();) {
    const PointColumn& column = columns[i];
    const bool is_left_out = !column.is_number || (column.is_empty && column.name.empty());
    if (layout.targets[i].array >= 0 || is_left_out) {
      if (!column.is_number)
        text_names.push_back(column.name);
      else if (layout.targets[i].array < 0)
        empty_names.push_back(fmt::format("column {}", i + 1));
      ++i;
      continue;
    }
    const std::size_t count = num_joined(columns, layout, i);
    add_array(columns, i, count, layout);
    i += count;
  }
  if (!text_names.empty()) {
    notes.push_back(
        fmt::format("{}: columns of text are left out: {}", where, data::names_text(text_names)));
  }
  if (!empty_names.empty()) {
    notes.push_back(fmt::format("{}: columns without a name, empty at first, are left out: {}",
                                where, data::names_text(empty_names)));
  }
}

}  // namespace

PointLayout lay_out_points(const std::string& where, const std::vector<PointColumn>& columns,
                           std::vector<std::string>& notes) {
  const PositionColumns positions = find_position_columns(where, columns, notes);
  PointLayout layout;
  layout.targets.resize(columns.size());
  layout.arrays.push_back({"positions", positions.unit, 3});
  layout.is_flat = !positions.columns[2];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!positions.columns[axis]) continue;
    const bool is_turned = axis == 2 && positions.is_depth;
    layout.targets[*positions.columns[axis]] = {0, static_cast<int>(axis), is_turned ? -1.0 : 1.0};
  }
  add_arrays(where, columns, layout, notes);
  return layout;
}

PointTable::PointTable(PointLayout layout)
    : layout_(std::move(layout)), buffers_(layout_.arrays.size()) {}

void PointTable::extend(std::int64_t count) {
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    buffers_[i].extend(
        count * layout_.arrays[i].num_components * static_cast<std::int64_t>(sizeof(double)),
        std::numeric_limits<std::int64_t>::max());
  }
  num_rows_ += count;
}

void PointTable::shrink(std::int64_t count) {
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    buffers_[i].shrink(count * layout_.arrays[i].num_components *
                       static_cast<std::int64_t>(sizeof(double)));
  }
  num_rows_ -= count;
}

PointTable::Slot PointTable::slot(std::size_t column, std::int64_t row) {
  const PointLayout::Target target = layout_.targets[column];
  if (target.array < 0) return {};
  const auto array = static_cast<std::size_t>(target.array);
  const auto stride = static_cast<std::size_t>(layout_.arrays[array].num_components);
  auto* const first = reinterpret_cast<double*>(buffers_[array].bytes().data());
  return {
      first + static_cast<std::size_t>(row) * stride + static_cast<std::size_t>(target.component),
      stride};
}

void PointTable::place(const PointLayout& layout, std::span<double> positions) {
  const bool is_turned = std::any_of(layout.targets.begin(), layout.targets.end(),
                                     [](const auto& target) { return target.factor < 0; });
  if (!layout.is_flat && !is_turned) return;
  for (std::size_t i = 2; i < positions.size(); i += 3)
    positions[i] = layout.is_flat || positions[i] == 0 ? 0.0 : -positions[i];
}

void PointTable::release(Dataset& dataset) {
  dataset.kind = DatasetKind::kParticles;
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    const PointLayout::Array& array = layout_.arrays[i];
    if (i == 0) {
      place(layout_, {reinterpret_cast<double*>(buffers_[0].bytes().data()),
                      3 * static_cast<std::size_t>(num_rows_)});
    }
    DataArray made{array.name, ScalarType::kFloat64, array.num_components, num_rows_, array.unit,
                   false,      buffers_[i].release()};
    if (i == 0)
      dataset.positions = std::move(made);
    else
      dataset.arrays.push_back(std::move(made));
  }
}

}  // namespace ovoid::io
