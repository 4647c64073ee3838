// SPDX-License-Identifier: Apache-2.0
// Records become columns piece by piece: a piece of the file is read, and each property is taken
// out of it in a loop of its own that knows both types.
#include "io/points/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "data/names_text.h"
#include "data/scalar_visit.h"
#include "io/core/byte_stream.h"
#include "io/core/number_fields.h"
#include "io/core/numbers.h"
#include "io/core/point_arrays.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/points/ply_header.h"
#include "io/points/point_columns.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A property on its way into an array.
struct PlyColumn {
  std::size_t property = 0;
  std::int64_t offset = 0;  // in a binary record
  ScalarType type = ScalarType::kFloat32;
  ScalarType to_type = ScalarType::kFloat32;
  std::byte* to = nullptr;  // of the first record
  std::size_t stride = 0;   // bytes from record to record
};

[[noreturn]] void fail_ply(const ByteSource& source, const std::string& what,
                           ErrorCode code = ErrorCode::kFileFormat) {
  throw Error(code, fmt::format("{}: {}", source.name(), what));
}

bool has_property(const PlyElement& element, std::string_view name) {
  return std::any_of(element.properties.begin(), element.properties.end(),
                     [&](const PlyProperty& p) { return p.name == name && !p.is_list; });
}

std::size_t find_points(const ByteSource& source, const PlyHeader& header) {
  const auto& elements = header.elements;
  auto found = std::find_if(elements.begin(), elements.end(),
                            [](const PlyElement& e) { return e.name == "vertex"; });
  if (found == elements.end()) {
    found = std::find_if(elements.begin(), elements.end(), [](const PlyElement& e) {
      return has_property(e, "x") && has_property(e, "y") && has_property(e, "z");
    });
  }
  if (found == elements.end()) fail_ply(source, "has no element 'vertex', nor one with x, y and z");
  if (found->properties.empty())
    fail_ply(source, fmt::format("element '{}' has no properties", found->name));
  if (found->count == 0) fail_ply(source, fmt::format("element '{}' is empty", found->name));
  return static_cast<std::size_t>(found - elements.begin());
}

constexpr std::array<std::string_view, 7> kKernelProperties{
    "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"};
constexpr std::array<std::string_view, 7> kKernelColumns{
    "scale:0", "scale:1", "scale:2", "rotation:0", "rotation:1", "rotation:2", "rotation:3"};

bool holds_kernels(const PlyElement& element) {
  return std::all_of(kKernelProperties.begin(), kKernelProperties.end(),
                     [&](std::string_view name) { return has_property(element, name); });
}

// The properties in the order of the arrays that they become: what is drawn by default first, the
// shapes of kernels last.
struct PlyOrder {
  std::vector<PointColumn> columns;
  std::vector<std::size_t> properties;
};

PlyOrder order_properties(const PlyElement& element, bool is_kernels,
                          std::vector<std::string>& left_out) {
  PlyOrder order;
  std::vector<bool> is_taken(element.properties.size(), false);
  const auto take = [&](std::size_t i, std::string_view name) {
    order.columns.push_back({std::string(name)});
    order.properties.push_back(i);
    is_taken[i] = true;
  };
  const auto take_named = [&](std::string_view name, std::string_view as) {
    for (std::size_t i = 0; i < element.properties.size(); ++i)
      if (!is_taken[i] && !element.properties[i].is_list && element.properties[i].name == name)
        take(i, as);
  };
  take_named("value", "value");
  if (is_kernels) take_named("opacity", "opacity");
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    const bool is_shape = std::find(kKernelProperties.begin(), kKernelProperties.end(),
                                    property.name) != kKernelProperties.end() ||
                          property.name == "weight";
    if (property.is_list ||
        (is_kernels && (property.name == "scale" || property.name == "rotation")))
      left_out.push_back(property.name);
    else if (!is_taken[i] && !(is_kernels && is_shape))
      take(i, property.name);
  }
  if (!is_kernels) return order;
  take_named("weight", "weight");
  for (std::size_t i = 0; i < kKernelProperties.size(); ++i)
    take_named(kKernelProperties[i], kKernelColumns[i]);
  return order;
}

// Arrays of the wanted size, and where each property goes.
class PlyArrays {
 public:
  PlyArrays(const PlyElement& element, const PlyOrder& order, const PointLayout& layout,
            const Rows& read_rows)
      : rows(read_rows) {
    for (std::size_t a = 0; a < layout.arrays.size(); ++a) add_array(element, order, layout, a);
    std::vector<std::int64_t> offsets{0};
    for (const PlyProperty& property : element.properties)
      offsets.push_back(offsets.back() + static_cast<std::int64_t>(size_of(property.type)));
    for (std::size_t c = 0; c < order.columns.size(); ++c) {
      const PointLayout::Target target = layout.targets[c];
      const auto a = static_cast<std::size_t>(target.array);
      const std::size_t item = size_of(arrays[a].type);
      columns.push_back({order.properties[c], offsets[order.properties[c]],
                         element.properties[order.properties[c]].type, arrays[a].type,
                         memory[a] + item * static_cast<std::size_t>(target.component),
                         item * static_cast<std::size_t>(arrays[a].num_components)});
    }
  }

  Rows rows;                       // the records that are read
  std::vector<DataArray> arrays;   // the first one is the positions
  std::vector<std::byte*> memory;  // of each
  std::vector<PlyColumn> columns;

 private:
  // Its type is that of its components, float64 where they differ; positions are floats.
  void add_array(const PlyElement& element, const PlyOrder& order, const PointLayout& layout,
                 std::size_t a) {
    std::optional<ScalarType> type;
    for (std::size_t c = 0; c < order.columns.size(); ++c) {
      if (layout.targets[c].array != static_cast<int>(a)) continue;
      const ScalarType own = element.properties[order.properties[c]].type;
      type = !type || *type == own ? own : ScalarType::kFloat64;
    }
    if (a == 0 && !is_floating(*type)) type = ScalarType::kFloat64;
    std::byte* to = nullptr;
    arrays.push_back(new_array({layout.arrays[a].name,
                                *type,
                                layout.arrays[a].num_components,
                                rows.count,
                                layout.arrays[a].unit,
                                false,
                                {}},
                               to));
    memory.push_back(to);
  }
};

// Takes a property out of `count` records; `to` is where that of the first one goes.
void take_column(const PlyColumn& column, const std::byte* records, std::int64_t record_size,
                 std::int64_t count, bool is_swapped, std::byte* to) {
  data::visit_scalar(column.type, [&]<class From>(std::type_identity<From>) {
    const auto copy = [&]<class To>(std::type_identity<To>) {
      const std::byte* from = records + column.offset;
      for (std::int64_t i = 0; i < count; ++i, from += record_size, to += column.stride) {
        From value;
        std::memcpy(&value, from, sizeof(From));
        if (is_swapped) value = swapped(value);
        const auto converted = static_cast<To>(value);
        std::memcpy(to, &converted, sizeof(To));
      }
    };
    if (column.to_type == column.type)
      copy(std::type_identity<From>{});
    else
      copy(std::type_identity<double>{});  // the only other type that arrays get
  });
}

void read_binary_points(const ByteSource& source, const PlyHeader& header,
                        const PlyElement& element, std::int64_t offset, const PlyArrays& arrays,
                        ReadProgress& progress) {
  const std::int64_t record_size = element.row_size();
  const std::int64_t at_a_time = std::max<std::int64_t>(1, (std::int64_t{1} << 20) / record_size);
  const bool is_swapped =
      (header.format == PlyHeader::Format::kBigEndian) != (std::endian::native == std::endian::big);
  const Rows& rows = arrays.rows;
  std::vector<std::byte> piece(
      static_cast<std::size_t>(std::min(at_a_time, rows.count) * record_size));
  for (std::int64_t first = 0; first < rows.count; first += at_a_time) {
    const std::int64_t count = std::min(at_a_time, rows.count - first);
    const auto part = std::span(piece).first(static_cast<std::size_t>(count * record_size));
    source.read(offset + (rows.first + first) * record_size, part);
    for (const PlyColumn& column : arrays.columns) {
      take_column(column, part.data(), record_size, count, is_swapped,
                  column.to + static_cast<std::size_t>(first) * column.stride);
    }
    progress.advance(count * record_size);
  }
}

// Behind the records of an element that has lists.
std::int64_t skip_lists(const ByteSource& source, const PlyHeader& header,
                        const PlyElement& element, std::int64_t offset) {
  TextScanner scanner(source, offset, source.size());
  const auto pass = [&](std::int64_t count) {
    if (count < 0 || count > scanner.num_left())
      fail_ply(source, fmt::format("ends within the lists of element '{}'", element.name));
    scanner.skip(count);
  };
  for (std::int64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      const auto item = static_cast<std::int64_t>(size_of(property.type));
      if (!property.is_list) {
        pass(item);
        continue;
      }
      const std::size_t size = size_of(property.count_type);
      std::string number(scanner.ahead(size));
      pass(static_cast<std::int64_t>(size));
      if ((header.format == PlyHeader::Format::kBigEndian) !=
          (std::endian::native == std::endian::big))
        std::reverse(number.begin(), number.end());
      const std::int64_t count =
          data::visit_scalar(property.count_type, [&]<class T>(std::type_identity<T>) {
            return static_cast<std::int64_t>(
                data::load_scalar<T>(reinterpret_cast<const std::byte*>(number.data()), 0));
          });
      pass(count < 0 ? -1 : count * item);
    }
  }
  return scanner.position();
}

std::int64_t offset_of_points(const ByteSource& source, const PlyHeader& header,
                              std::size_t index) {
  std::int64_t offset = header.data_offset;
  for (std::size_t i = 0; i < index; ++i) {
    const PlyElement& element = header.elements[i];
    if (element.properties.empty()) continue;
    if (element.has_lists()) {
      offset = skip_lists(source, header, element, offset);
      continue;
    }
    if (element.count > (source.size() - offset) / element.row_size())
      fail_ply(source, fmt::format("ends within element '{}'", element.name));
    offset += element.count * element.row_size();
  }
  return offset;
}

// A number of a text into memory of the given type; false if it does not fit.
bool store_number(double value, ScalarType type, std::byte* to) {
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    if constexpr (!std::is_floating_point_v<T>) {
      if (!(value >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
            value <= static_cast<double>(std::numeric_limits<T>::max())))
        return false;
    }
    const auto converted = static_cast<T>(value);
    std::memcpy(to, &converted, sizeof(T));
    return true;
  });
}

void read_text_points(const ByteSource& source, const PlyHeader& header, std::size_t index,
                      const PlyArrays& arrays, ReadProgress& progress) {
  const PlyElement& element = header.elements[index];
  std::int64_t num_passed = header.num_lines;
  for (std::size_t i = 0; i < index; ++i) num_passed += header.elements[i].count;
  const auto stream = open_stream(source, progress);
  LineReader lines(*stream, source.name());
  std::vector<const PlyColumn*> columns(element.properties.size(), nullptr);
  for (const PlyColumn& column : arrays.columns) columns[column.property] = &column;
  std::string_view line;
  for (std::int64_t record = 0; record < element.count;) {
    if (!lines.next(line)) {
      fail_ply(source, fmt::format("ends after {} of {} records of element '{}'", record,
                                   element.count, element.name));
    }
    if (lines.number() <= num_passed || line.find_first_not_of(" \t") == std::string_view::npos)
      continue;
    const std::int64_t row = record++ - arrays.rows.first;
    if (row < 0 || row >= arrays.rows.count) continue;
    FieldReader fields(line, Separator::kBlanks);
    for (std::size_t p = 0; p < columns.size(); ++p) {
      double value = 0;
      if (!fields.number(value) ||
          (columns[p] != nullptr &&
           !store_number(value, columns[p]->to_type,
                         columns[p]->to + static_cast<std::size_t>(row) * columns[p]->stride))) {
        throw Error(ErrorCode::kFileFormat,
                    fmt::format("{}: property '{}' is '{}': expected {}", lines.where(),
                                element.properties[p].name, fields.text().substr(0, 32),
                                name_of(element.properties[p].type)));
      }
    }
  }
}

// Sigmas from their logarithms, in place.
void exponentiate(const DataArray& array, std::byte* values) {
  for (std::int64_t i = 0; i < array.num_tuples * array.num_components; ++i) {
    std::byte* const at = values + static_cast<std::size_t>(i) * size_of(array.type);
    if (array.type == ScalarType::kFloat32) {
      const auto sigma = static_cast<float>(std::exp(double{data::load_scalar<float>(at, 0)}));
      std::memcpy(at, &sigma, sizeof(sigma));
    } else {
      const double sigma = std::exp(data::load_scalar<double>(at, 0));
      std::memcpy(at, &sigma, sizeof(sigma));
    }
  }
}

void note_colors(const ByteSource& source, const PlyElement& element, Dataset& dataset) {
  if (!has_property(element, "f_dc_0")) return;
  dataset.notes.push_back(fmt::format(
      "{}: kernels of 3D Gaussian splatting: their colours (f_dc_*, f_rest_*) are not drawn; "
      "arrays are mapped to colours",
      source.name()));
}

void check_ply_size(const ByteSource& source, const PlyHeader& header, const PlyElement& element,
                    std::int64_t offset) {
  const bool is_text = header.format == PlyHeader::Format::kAscii;
  // A number of a text has a digit and something behind it.
  const std::int64_t row_size =
      is_text ? 2 * static_cast<std::int64_t>(element.properties.size()) : element.row_size();
  const std::int64_t available = source.size() - offset + (is_text ? 1 : 0);
  if (element.count <= available / row_size) return;
  fail_ply(source, fmt::format("element '{}' claims {} records of {} bytes{}: the file has {} "
                               "bytes for them",
                               element.name, element.count, row_size, is_text ? " or more" : "",
                               available));
}

}  // namespace

Dataset read_ply(const ByteSource& source, const ReadOptions& options) {
  const PlyHeader header = read_ply_header(source);
  const std::size_t index = find_points(source, header);
  const PlyElement& element = header.elements[index];
  const bool is_text = header.format == PlyHeader::Format::kAscii;
  if (element.has_lists()) {
    fail_ply(source, fmt::format("element '{}' has lists: expected numbers only", element.name),
             ErrorCode::kUnsupported);
  }
  const std::int64_t offset =
      is_text ? header.data_offset : offset_of_points(source, header, index);
  check_ply_size(source, header, element, offset);
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "PLY";
  dataset.kind = holds_kernels(element) ? DatasetKind::kKernels : DatasetKind::kParticles;
  const bool is_kernels = dataset.kind == DatasetKind::kKernels;
  if (is_kernels) {
    dataset.reconstruction = header.reconstruction;
    dataset.cutoff = header.cutoff;
  }
  std::vector<std::string> left_out;
  const PlyOrder order = order_properties(element, is_kernels, left_out);
  if (!left_out.empty()) {
    dataset.notes.push_back(
        fmt::format("{}: properties left out: {}", source.name(), data::names_text(left_out)));
  }
  const PointLayout layout = lay_out_points(source.name(), order.columns, dataset.notes);
  PlyArrays arrays(element, order, layout, rows_of_share(options.share, element.count));
  ReadProgress progress(options, source.size());
  if (is_text)
    read_text_points(source, header, index, arrays, progress);
  else
    read_binary_points(source, header, element, offset, arrays, progress);
  for (std::size_t a = 1; a < arrays.arrays.size(); ++a) {
    if (is_kernels && arrays.arrays[a].name == "scale")
      exponentiate(arrays.arrays[a], arrays.memory[a]);
    dataset.arrays.push_back(std::move(arrays.arrays[a]));
  }
  dataset.positions = std::move(arrays.arrays[0]);
  set_share(dataset, options.share, element.count);
  if (is_kernels) note_colors(source, element, dataset);
  return dataset;
}

}  // namespace ovoid::io
