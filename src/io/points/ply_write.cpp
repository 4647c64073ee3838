// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "data/scalar_visit.h"
#include "io/core/atomic_file.h"
#include "io/core/samples.h"
#include "io/points/ply.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// A component of an array on its way into a record.
struct PlyOutput {
  std::string name;
  const DataArray* array = nullptr;
  int component = 0;
  bool is_logarithm = false;  // of the values

  // PLY has no integers of 8 bytes.
  ScalarType type() const { return size_of(array->type) == 8 ? ScalarType::kFloat64 : array->type; }
};

const char* ply_type_name(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return "uchar";
    case ScalarType::kInt8:
      return "char";
    case ScalarType::kUInt16:
      return "ushort";
    case ScalarType::kInt16:
      return "short";
    case ScalarType::kUInt32:
      return "uint";
    case ScalarType::kInt32:
      return "int";
    case ScalarType::kFloat32:
      return "float";
    default:
      return "double";
  }
}

void add_components(const DataArray& array, std::string_view prefix, bool is_logarithm,
                    std::vector<PlyOutput>& outputs) {
  for (int i = 0; i < array.num_components; ++i)
    outputs.push_back({fmt::format("{}{}", prefix, i), &array, i, is_logarithm});
}

// Names have no blanks in PLY.
std::string ply_name(const DataArray& array) {
  std::string name = array.name.empty() ? "array" : array.name;
  for (char& c : name) c = static_cast<unsigned char>(c) <= ' ' ? '_' : c;
  return name;
}

std::vector<PlyOutput> ply_outputs(const Dataset& dataset) {
  std::vector<PlyOutput> outputs;
  outputs.reserve(3 + dataset.arrays.size());
  for (int axis = 0; axis < 3; ++axis)
    outputs.push_back({std::string(1, "xyz"[axis]), &dataset.positions, axis});
  const bool is_kernels = dataset.kind == DatasetKind::kKernels;
  for (const DataArray& array : dataset.arrays) {
    const std::string name = ply_name(array);
    if (is_kernels && name == "scale")
      add_components(array, "scale_", true, outputs);
    else if (is_kernels && name == "rotation")
      add_components(array, "rot_", false, outputs);
    else if (array.num_components > 1)
      add_components(array, name + ":", false, outputs);
    else
      outputs.push_back({name, &array, 0});
  }
  std::set<std::string> names;
  for (const PlyOutput& output : outputs) {
    if (names.insert(output.name).second) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("array '{}': PLY has a property '{}' already: rename it",
                            output.array->name, output.name));
  }
  return outputs;
}

void put_column(const PlyOutput& output, std::int64_t first, std::int64_t count, std::byte* to,
                std::size_t record_size) {
  const DataArray& array = *output.array;
  const auto store = [&](auto value) {
    auto bytes = std::bit_cast<std::array<std::byte, sizeof(value)>>(value);
    if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
    std::memcpy(to, bytes.data(), bytes.size());
    to += record_size;
  };
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    for (std::int64_t i = first; i < first + count; ++i) {
      const auto value = data::load_scalar<T>(array.bytes.view.data(),
                                              i * array.num_components + output.component);
      if constexpr (std::is_floating_point_v<T>) {
        if (output.is_logarithm && !(value > 0)) {
          throw Error(ErrorCode::kInvalidArgument,
                      fmt::format("{}[{}] = {}: must be > 0", array.name, i, value));
        }
        store(output.is_logarithm ? static_cast<T>(std::log(double{value})) : value);
      } else if constexpr (sizeof(T) == 8) {
        store(static_cast<double>(value));
      } else {
        store(value);
      }
    }
  });
}

std::string ply_header_text(const Dataset& dataset, const std::vector<PlyOutput>& outputs) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment written by ovoid\n";
  if (dataset.reconstruction)
    header += fmt::format("comment ovoid reconstruction {}\n", name_of(*dataset.reconstruction));
  if (dataset.cutoff) header += fmt::format("comment ovoid cutoff {}\n", *dataset.cutoff);
  header += fmt::format("element vertex {}\n", dataset.num_positions());
  for (const PlyOutput& output : outputs)
    header += fmt::format("property {} {}\n", ply_type_name(output.type()), output.name);
  return header + "end_header\n";
}

void check_shapes(const Dataset& dataset) {
  if (dataset.kind != DatasetKind::kKernels) return;
  for (const auto& [name, components] : {std::pair{"scale", 3}, {"rotation", 4}}) {
    const DataArray& array = dataset.array(name);
    if (array.num_components == components && is_floating(array.type)) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("array '{}': has {} components of {}: expected {} floats", name,
                            array.num_components, name_of(array.type), components));
  }
}

}  // namespace

void write_ply(const Dataset& dataset, const std::string& path, const std::stop_token& stop) {
  check_shapes(dataset);
  const std::vector<PlyOutput> outputs = ply_outputs(dataset);
  std::size_t record_size = 0;
  for (const PlyOutput& output : outputs) record_size += size_of(output.type());
  AtomicFile file(path, stop);
  file.write(ply_header_text(dataset, outputs));
  const auto at_a_time = static_cast<std::int64_t>((std::size_t{1} << 20) / record_size + 1);
  std::vector<std::byte> piece(static_cast<std::size_t>(at_a_time) * record_size);
  for (std::int64_t first = 0; first < dataset.num_positions(); first += at_a_time) {
    const std::int64_t count = std::min(at_a_time, dataset.num_positions() - first);
    std::byte* to = piece.data();
    for (const PlyOutput& output : outputs) {
      put_column(output, first, count, to, record_size);
      to += size_of(output.type());
    }
    file.write(piece.data(), static_cast<std::size_t>(count) * record_size);
  }
  file.commit();
}

}  // namespace ovoid::io
