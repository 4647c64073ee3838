// SPDX-License-Identifier: Apache-2.0
#include "io/vtk/legacy_vtk_write.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <span>
#include <string>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/vtk/image_sections.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Bytes that are turned round at a time.
constexpr std::size_t kSwappedBytes = std::size_t{1} << 20;

const char* legacy_type_name(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return "unsigned_char";
    case ScalarType::kInt8:
      return "signed_char";
    case ScalarType::kUInt16:
      return "unsigned_short";
    case ScalarType::kInt16:
      return "short";
    case ScalarType::kUInt32:
      return "unsigned_int";
    case ScalarType::kInt32:
      return "int";
    case ScalarType::kUInt64:
      return "vtktypeuint64";
    case ScalarType::kInt64:
      return "vtktypeint64";
    case ScalarType::kFloat32:
      return "float";
    case ScalarType::kFloat64:
      return "double";
  }
  return "";
}

// One word of printable ASCII: everything else as % and two digits.
std::string encoded(const std::string& text, const char* what, const std::string& path) {
  std::string word;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code <= ' ' || code > '~' || c == '"' || c == '%')
      word += fmt::format("%{:02X}", code);
    else
      word += c;
  }
  // With "DATA " before it, a line that VTK's reader takes.
  constexpr std::size_t kLongest = TextScanner::kLongestWord - 7;
  if (word.size() > kLongest) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: the {} '{}...' takes {} characters, legacy VTK takes at most {}: "
                            "shorten it, or write .vti",
                            path, what, text.substr(0, 40), word.size(), kLongest));
  }
  return word;
}

// The words for an array's name, and what follows its samples.
struct LegacyName {
  std::string name;
  std::string metadata;
};

LegacyName legacy_name(const DataArray& array, const char* otherwise, const std::string& path) {
  LegacyName result;
  result.name = array.name.empty() ? otherwise : encoded(array.name, "name", path);
  // The format's word for an array that is not there.
  if (result.name == "NULL_ARRAY") result.name = "%4EULL_ARRAY";
  if (!array.unit.empty()) {
    result.metadata =
        fmt::format("METADATA\nINFORMATION 1\nNAME UNITS_LABEL LOCATION vtkDataArray\nDATA {}\n\n",
                    encoded(array.unit, "unit", path));
  }
  return result;
}

void write_samples(AtomicFile& file, const DataArray& array) {
  std::span<const std::byte> left = array.bytes.view;
  std::vector<std::byte> chunk;
  while (!left.empty()) {
    const auto part = left.first(std::min(left.size(), kSwappedBytes));
    chunk.assign(part.begin(), part.end());
    if constexpr (std::endian::native == std::endian::little)
      swap_bytes(chunk, size_of(array.type));
    file.write(chunk.data(), chunk.size());
    left = left.subspan(part.size());
  }
  file.write("\n");
}

void write_section(AtomicFile& file, const ImageSection& chosen, const char* section,
                   const std::string& path) {
  if (chosen.arrays.empty()) return;
  file.write(fmt::format("{} {}\n", section, chosen.arrays.front()->num_tuples));
  std::size_t num_fields = chosen.arrays.size();
  if (chosen.scalars != nullptr) {
    const DataArray& array = *chosen.scalars;
    const LegacyName words = legacy_name(array, "scalars", path);
    file.write(fmt::format("SCALARS {} {}\nLOOKUP_TABLE default\n", words.name,
                           legacy_type_name(array.type)));
    write_samples(file, array);
    file.write(words.metadata);
    --num_fields;
  }
  if (num_fields == 0) return;
  file.write(fmt::format("FIELD FieldData {}\n", num_fields));
  for (const DataArray* const array : chosen.arrays) {
    if (array == chosen.scalars) continue;
    const LegacyName words = legacy_name(*array, "unknown", path);
    file.write(fmt::format("{} {} {} {}\n", words.name, array->num_components, array->num_tuples,
                           legacy_type_name(array->type)));
    write_samples(file, *array);
    file.write(words.metadata);
  }
}

}  // namespace

void write_legacy_vtk(const Dataset& dataset, const std::string& path,
                      const std::stop_token& stop) {
  const Index3& dims = dataset.lattice.dims;
  const ImageSections sections = image_sections(dataset, path);
  const Mat3 axes = dataset.lattice.world_from_index.linear();
  const Vec3 spacing = axes.diagonal();
  if (axes != Mat3(spacing.asDiagonal()) || !(spacing.array() > 0).all()) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: legacy VTK knows no axis directions, the "
                                                     "lattice is rotated or flipped: write .vti",
                                                     path));
  }
  const Vec3 origin = dataset.lattice.world_from_index.translation();
  AtomicFile file(path, stop);
  file.write(
      fmt::format("# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET STRUCTURED_POINTS\n"
                  "DIMENSIONS {} {} {}\nSPACING {} {} {}\nORIGIN {} {} {}\n",
                  dims[0], dims[1], dims[2], spacing[0], spacing[1], spacing[2], origin[0],
                  origin[1], origin[2]));
  write_section(file, sections.of_cells, "CELL_DATA", path);
  write_section(file, sections.of_points, "POINT_DATA", path);
  file.commit();
}

}  // namespace ovoid::io
