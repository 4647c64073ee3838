// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <filesystem>

#include "io/atomic_file.h"
#include "io/nrrd.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace {

// Header fields are lines: what would end one or start another cannot be written into it.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return text;
}

const char* type_word(ScalarType type) {
  if (type == ScalarType::kFloat32) return "float";
  if (type == ScalarType::kFloat64) return "double";
  return name_of(type);
}

std::string vector_text(const Vec3& v) { return fmt::format("({},{},{})", v[0], v[1], v[2]); }

// All of the header but the data file and the blank line. Doubles are written so that they read
// back to the last bit.
std::string header_text(const Dataset& dataset, const DataArray& array) {
  const LatticeGeometry& lattice = dataset.lattice;
  const bool has_components = array.num_components > 1;
  std::string text =
      "NRRD0005\n# Complete NRRD file format specification at "
      "http://teem.sourceforge.net/nrrd/format.html\n";
  text += fmt::format("content: {}\n", one_line(array.name));
  text += fmt::format("type: {}\ndimension: {}\n", type_word(array.type), has_components ? 4 : 3);
  switch (dataset.space) {
    case Space::kLps:
      text += "space: left-posterior-superior\n";
      break;
    case Space::kRas:
      text += "space: right-anterior-superior\n";
      break;
    case Space::kNone:
      text += "space dimension: 3\n";
      break;
  }
  text += "sizes: ";
  if (has_components) text += fmt::format("{} ", array.num_components);
  text += fmt::format("{}\nspace directions: {}", fmt::join(lattice.dims, " "),
                      has_components ? "none " : "");
  const Mat3 axes = lattice.world_from_index.linear();
  text += fmt::format("{} {} {}\n", vector_text(axes.col(0)), vector_text(axes.col(1)),
                      vector_text(axes.col(2)));
  text += fmt::format("kinds: {}domain domain domain\n", has_components ? "vector " : "");
  text += fmt::format("endian: {}\nencoding: raw\n",
                      std::endian::native == std::endian::little ? "little" : "big");
  text += fmt::format("space origin: {}\n", vector_text(lattice.world_from_index.translation()));
  if (!array.unit.empty()) text += fmt::format("sample units: \"{}\"\n", one_line(array.unit));
  return text;
}

}  // namespace

void write_nrrd(const Dataset& dataset, const DataArray& array, const std::string& path) {
  AtomicFile file(path);
  file.write(header_text(dataset, array) + "\n");
  file.write(array.bytes.view.data(), array.bytes.view.size());
  file.commit();
}

std::string nhdr_data_path(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".raw").string();
}

void check_nhdr_data_path(const std::string& path) {
  const std::string data_path = nhdr_data_path(path);
  std::error_code ignored;  // what cannot be looked at will be told by the write itself
  if (!std::filesystem::exists(data_path, ignored)) return;
  const auto own = files_read_for(path);
  if (std::any_of(own.begin(), own.end(), [&](const std::string& file) {
        return std::filesystem::equivalent(file, data_path, ignored);
      })) {
    return;
  }
  throw Error(ErrorCode::kFileWrite,
              fmt::format("{}: its samples would replace {}, which belongs to something else: "
                          "choose another name, or .nrrd",
                          path, data_path));
}

void write_nhdr(const Dataset& dataset, const DataArray& array, const std::string& path) {
  check_nhdr_data_path(path);
  const std::filesystem::path raw_path = nhdr_data_path(path);
  AtomicFile raw(raw_path.string());
  AtomicFile header(path);
  header.write(header_text(dataset, array) +
               fmt::format("data file: {}\n", raw_path.filename().string()));
  raw.write(array.bytes.view.data(), array.bytes.view.size());
  // The header last: while it stands, what it names is there.
  raw.commit();
  header.commit();
}

}  // namespace ovoid::io
