// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/core/atomic_file.h"
#include "io/images/nrrd.h"
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

// Names that stand between an old pair and a new one: "ovoid-0123456789abcdef.raw".
constexpr std::string_view kInterimStart = "ovoid-";
constexpr std::size_t kInterimDigits = 16;

std::string sibling(const std::string& path, const std::string& name) {
  return std::filesystem::path(path).replace_filename(name).string();
}

// The samples of an existing header, should a run that was killed have left them under such a name.
std::vector<std::string> interim_data_of(const std::string& path) {
  std::vector<std::string> found;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return found;
  for (const std::string& file : files_read_for(path)) {
    const std::filesystem::path whole(file);
    const std::string stem = whole.stem().string();
    if (whole.extension() == ".raw" && stem.starts_with(kInterimStart) &&
        stem.size() == kInterimStart.size() + kInterimDigits &&
        std::filesystem::equivalent(file, sibling(path, whole.filename().string()), ignored))
      found.push_back(file);
  }
  return found;
}

void write_header(AtomicFile& header, const std::string& text, const std::string& raw_path) {
  header.write(text);
  header.write(fmt::format("data file: {}\n", std::filesystem::path(raw_path).filename().string()));
}

// Where no samples stand under their last name: they take it, then the header its own.
void place_pair(AtomicFile& raw, const std::string& text, const std::string& path,
                const std::stop_token& stop) {
  const std::string raw_path = nhdr_data_path(path);
  AtomicFile header(path, stop);
  write_header(header, text, raw_path);
  raw.commit_as(raw_path);
  const PublishedFile until_there_is_a_header(raw_path);
  try {
    header.commit();
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(raw_path, ignored);
    throw;
  }
}

// Two files cannot be renamed as one, so one header that is renamed takes the step from old to new:
// it names samples under an interim name, beside which the old ones still stand. Only then, with a
// whole new pair in place, the samples get their usual name as well, and the header that says so.
void replace_pair(AtomicFile& raw, const std::string& text, const std::string& path,
                  const std::stop_token& stop) {
  const std::string raw_path = nhdr_data_path(path);
  const std::string interim =
      sibling(path, fmt::format("{}{}.raw", kInterimStart, random_digits()));
  AtomicFile first(path, stop), last(path, stop);
  write_header(first, text, interim);
  write_header(last, text, raw_path);
  std::error_code ignored;
  {
    const PublishedFile until_there_is_a_header(interim);
    try {
      raw.commit_as(interim);
      first.commit();
    } catch (...) {
      std::filesystem::remove(interim, ignored);
      throw;
    }
  }
  // The new pair is whole; what follows only gives the samples their usual name.
  std::filesystem::remove(raw_path, ignored);
  if (::link(interim.c_str(), raw_path.c_str()) != 0) return;  // a file system without links
  sync_folder_of(raw_path);
  try {
    last.commit();
    std::filesystem::remove(interim, ignored);
  } catch (
      const Error&) {  // NOLINT(bugprone-empty-catch): the header goes on naming the other name
  }
}

}  // namespace

void write_nrrd(const Dataset& dataset, const DataArray& array, const std::string& path,
                const std::stop_token& stop) {
  AtomicFile file(path, stop);
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
  if (std::filesystem::is_symlink(data_path, ignored)) {
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: its samples would replace {}, which is a symbolic link and cannot "
                            "be replaced together with the header: remove it, or choose .nrrd",
                            path, data_path));
  }
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

void write_nhdr(const Dataset& dataset, const DataArray& array, const std::string& path,
                const std::stop_token& stop) {
  check_nhdr_data_path(path);
  const std::string text = header_text(dataset, array);
  const std::string raw_path = nhdr_data_path(path);
  const std::vector<std::string> interim = interim_data_of(path);
  AtomicFile raw(raw_path, stop);
  raw.write(array.bytes.view.data(), array.bytes.view.size());
  std::error_code ignored;
  if (std::filesystem::exists(raw_path, ignored))
    replace_pair(raw, text, path, stop);
  else
    place_pair(raw, text, path, stop);
  for (const std::string& file : interim) std::filesystem::remove(file, ignored);
}

}  // namespace ovoid::io
