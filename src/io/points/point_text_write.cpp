// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "data/scalar_visit.h"
#include "io/core/atomic_file.h"
#include "io/points/point_text.h"

namespace ovoid::io {
namespace {

// Quoted where it must be; what cannot be quoted becomes a blank.
std::string csv_name(const DataArray& array, std::string name) {
  if (!array.unit.empty()) name += " [" + array.unit + "]";
  for (char& c : name)
    if (c == '"' || static_cast<unsigned char>(c) < ' ') c = ' ';
  return name.find_first_of(",;# ") == std::string::npos ? name : '"' + name + '"';
}

std::string csv_names(const Dataset& dataset) {
  std::vector<std::string> names;
  for (const char axis : {'x', 'y', 'z'})
    names.push_back(csv_name(dataset.positions, std::string(1, axis)));
  for (const DataArray& array : dataset.arrays) {
    for (int i = 0; i < array.num_components; ++i) {
      names.push_back(csv_name(
          array, array.num_components == 1 ? array.name : fmt::format("{}:{}", array.name, i)));
    }
  }
  return fmt::format("{}\n", fmt::join(names, ","));
}

void append_tuple(const DataArray& array, std::int64_t row, std::string& line) {
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    std::array<char, 64> text{};
    for (int i = 0; i < array.num_components; ++i) {
      const T value = data::load_scalar<T>(array.bytes.view.data(), row * array.num_components + i);
      const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
      line.append(text.data(), result.ptr);
      line += ',';
    }
  });
}

}  // namespace

void write_point_text(const Dataset& dataset, const std::string& path,
                      const std::stop_token& stop) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  AtomicFile file(path, stop);
  std::string text = csv_names(dataset);
  for (std::int64_t row = 0; row < dataset.num_positions(); ++row) {
    append_tuple(dataset.positions, row, text);
    for (const DataArray& array : dataset.arrays) append_tuple(array, row, text);
    text.back() = '\n';
    if (text.size() < kPiece) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.commit();
}

}  // namespace ovoid::io
