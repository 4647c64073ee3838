// SPDX-License-Identifier: Apache-2.0
#include "io/companions.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "io/core/text_scanner.h"
#include "io/images/data_files.h"
#include "io/images/metaimage_header.h"
#include "io/images/nifti.h"
#include "io/images/nrrd_header.h"
#include "io/vtk/vtk_set_files.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;
using Files = std::vector<std::string>;

// False if there is no such file. A device or a pipe is told by who reads it, or refused where it
// lies elsewhere; it is not opened here.
bool add(Files& files, const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (error || !fs::exists(status) || fs::is_directory(status)) return false;
  files.push_back(file);
  return true;
}

// Up to the first that is not there: a header may claim any number.
Files data_files(const ByteSource& header, const std::optional<DataFiles>& named) {
  Files files;
  const std::int64_t count = named ? named->count : 0;
  for (std::int64_t i = 0; i < count && add(files, path_beside(header.name(), named->name(i)));
       ++i) {
  }
  return files;
}

// Asterisks stand for a number.
void add_pattern(Files& files, const fs::path& pattern) {
  const std::string wanted = pattern.filename().string();
  const auto fits = [&](const std::string& name) {
    if (name.size() != wanted.size()) return false;
    for (std::size_t i = 0; i < name.size(); ++i) {
      const bool is_digit = std::isdigit(static_cast<unsigned char>(name[i])) != 0;
      if (wanted[i] == '*' ? !is_digit : wanted[i] != name[i]) return false;
    }
    return true;
  };
  std::error_code error;
  const fs::path folder = pattern.parent_path();
  Files found;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    if (fits(entry->path().filename().string()))
      found.push_back((folder / entry->path().filename()).string());
  }
  std::sort(found.begin(), found.end());
  for (const std::string& file : found) add(files, file);
}

}  // namespace

Files nrrd_companions(const ByteSource& source) {
  return data_files(source, read_nrrd_header(source).files);
}

Files metaimage_companions(const ByteSource& source) {
  return data_files(source, read_metaimage_header(source).files);
}

Files nifti_companions(const ByteSource& source) {
  Files files;
  const std::string image = nifti_image_path(source.name());
  if (image != source.name() && !add(files, image)) add(files, image + ".gz");
  return files;
}

Files vtk_xml_companions(const ByteSource& source) {
  Files files;
  try {
    if (!is_vtk_set(vtk_xml_type(source))) return files;
    for (const VtkSetFile& file : vtk_set_files(source)) add(files, file.path);
  } catch (const Error&) {
    // What is broken is told by who reads it; the files before it belong to the input.
  }
  return files;
}

Files enzo_companions(const ByteSource& source) {
  constexpr std::string_view kEnding = ".hierarchy";
  const std::string& path = source.name();
  const bool is_hierarchy = path.ends_with(kEnding);
  const std::string stem = is_hierarchy ? path.substr(0, path.size() - kEnding.size()) : path;
  Files files;
  add(files, is_hierarchy ? stem : stem + std::string(kEnding));
  add(files, stem + ".boundary");
  const auto hierarchy = open_file(stem + std::string(kEnding));
  TextScanner text(*hierarchy, 0, hierarchy->size());
  std::set<std::string> known;
  while (auto line = text.line()) {
    const auto parts = words(*line);
    if (parts.size() != 3 || !parts[0].ends_with("FileName")) continue;
    const std::string name = fs::path(parts[2]).filename().string();
    if (known.insert(name).second) add(files, path_beside(path, name));
  }
  return files;
}

// Every word of a case that is the name of a file.
Files ensight_companions(const ByteSource& source) {
  Files files;
  TextScanner text(source, 0, source.size());
  std::set<std::string> known;
  while (auto line = text.line()) {
    for (const std::string_view word : words(*line)) {
      std::string name(word);
      std::erase(name, '"');
      if (name.empty() || !known.insert(name).second) continue;
      const std::string whole = path_beside(source.name(), name);
      if (name.find('*') == std::string::npos)
        add(files, whole);
      else
        add_pattern(files, whole);
    }
  }
  return files;
}

}  // namespace ovoid::io
