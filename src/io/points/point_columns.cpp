// SPDX-License-Identifier: Apache-2.0
#include "io/points/point_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "data/names_text.h"
#include "io/core/text_scanner.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using Triple = std::array<std::size_t, 3>;

constexpr std::array<std::string_view, 9> kPositionNames{
    "points", "coordinates", "positions", "position", "coords", "xyz", "pos", "point", "location"};

// The columns whose lower-case names are what `name_of_axis` gives for 0, 1, 2.
template <typename NameOfAxis>
std::optional<Triple> find_triple(const std::vector<PointColumn>& columns,
                                  const std::vector<std::string>& names,
                                  const NameOfAxis& name_of_axis) {
  Triple triple{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = std::find(names.begin(), names.end(), name_of_axis(axis));
    if (found == names.end()) return std::nullopt;
    triple[axis] = static_cast<std::size_t>(found - names.begin());
    if (!columns[triple[axis]].is_number) return std::nullopt;
  }
  return triple;
}

std::optional<Triple> named_positions(const std::vector<PointColumn>& columns) {
  std::vector<std::string> names;
  names.reserve(columns.size());
  for (const PointColumn& column : columns) names.push_back(lower(split_unit(column.name).name));
  const auto letter = [](std::size_t axis) { return std::string(1, "xyz"[axis]); };
  if (const auto found = find_triple(columns, names, letter)) return found;
  for (const std::string_view base : kPositionNames) {
    for (const char between : {':', '_', '.'}) {
      const auto number = [&](std::size_t axis) {
        return fmt::format("{}{}{}", base, between, axis);
      };
      if (const auto found = find_triple(columns, names, number)) return found;
    }
    for (const char* const between : {"_", ":", ".", ""}) {
      const auto name = [&](std::size_t axis) {
        return fmt::format("{}{}{}", base, between, "xyz"[axis]);
      };
      if (const auto found = find_triple(columns, names, name)) return found;
    }
  }
  return std::nullopt;
}

std::optional<Triple> first_three(const std::vector<PointColumn>& columns) {
  Triple triple{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < columns.size() && count < 3; ++i)
    if (columns[i].is_number) triple[count++] = i;
  return count == 3 ? std::optional(triple) : std::nullopt;
}

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
  if (named.name.empty()) named.name = fmt::format("column {}", first + 1);
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
  const char close = text.empty() ? '\0' : text.back();
  const char open = close == ']' ? '[' : close == ')' ? '(' : '\0';
  const auto begin = open == '\0' ? std::string_view::npos : text.rfind(open);
  if (begin == std::string_view::npos || trimmed(text.substr(0, begin)).empty())
    return {std::string(text), ""};
  return {std::string(trimmed(text.substr(0, begin))),
          std::string(trimmed(text.substr(begin + 1, text.size() - begin - 2)))};
}

PointLayout lay_out_points(const std::string& where, const std::vector<PointColumn>& columns,
                           std::vector<std::string>& notes) {
  const bool has_names = std::any_of(columns.begin(), columns.end(), [](const PointColumn& column) {
    return !column.name.empty();
  });
  const auto named = named_positions(columns);
  const auto positions = named ? named : first_three(columns);
  if (!positions) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: {} columns, fewer than three of them numbers: expected positions "
                            "x, y, z",
                            where, columns.size()));
  }
  if (!named && has_names) {
    notes.push_back(fmt::format(
        "{}: no columns are called x, y, z: '{}', '{}' and '{}' are taken for the positions", where,
        columns[(*positions)[0]].name, columns[(*positions)[1]].name,
        columns[(*positions)[2]].name));
  }
  PointLayout layout;
  layout.targets.resize(columns.size());
  layout.arrays.push_back({"positions", split_unit(columns[(*positions)[0]].name).unit, 3});
  for (std::size_t axis = 0; axis < 3; ++axis)
    layout.targets[(*positions)[axis]] = {0, static_cast<int>(axis)};
  std::vector<std::string> text_names;
  for (std::size_t i = 0; i < columns.size();) {
    if (layout.targets[i].array >= 0 || !columns[i].is_number) {
      if (!columns[i].is_number) text_names.push_back(columns[i].name);
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

void PointTable::release(Dataset& dataset) {
  dataset.kind = DatasetKind::kParticles;
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    const PointLayout::Array& array = layout_.arrays[i];
    DataArray made{array.name, ScalarType::kFloat64, array.num_components, num_rows_, array.unit,
                   false,      buffers_[i].release()};
    if (i == 0)
      dataset.positions = std::move(made);
    else
      dataset.arrays.push_back(std::move(made));
  }
}

}  // namespace ovoid::io
