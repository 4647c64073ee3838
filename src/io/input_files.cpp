// SPDX-License-Identifier: Apache-2.0
#include "io/input_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/core/text_scanner.h"
#include "io/dicom/dicom.h"
#include "io/formats.h"
#include "io/images/data_files.h"
#include "io/images/metaimage_header.h"
#include "io/images/nifti.h"
#include "io/images/nrrd_header.h"
#include "io/meshes/mesh_files.h"
#include "io/vtk/vtk_set_files.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

// --- which files --------------------------------------------------------------------------------

// Collects the files of one input.
class InputFiles {
 public:
  explicit InputFiles(const std::string& input) : files_{input} {}

  std::vector<std::string> take() && { return std::move(files_); }

  void add_all(const std::string& path) {
    if (is_folder(path)) {
      for (std::string& file : dicom_files_in(path))
        if (is_dicom_file(file)) files_.push_back(std::move(file));
      return;
    }
    const auto source = open_file(path);
    const std::string start = source->text(0, 512);
    switch (mesh_file_of(*source, start)) {
      case MeshFile::kEnzo:
        return add_enzo(path);
      case MeshFile::kEnSight:
        return add_words(path, *source);
      default:
        break;
    }
    switch (kind_of(start)) {
      case FileKind::kNrrd:
        return add_numbered(path, read_nrrd_header(*source).files);
      case FileKind::kMetaImage:
        return add_numbered(path, read_metaimage_header(*source).files);
      case FileKind::kVtkXml:
        return add_set(*source, 1);
      default:
        break;
    }
    const std::string image = nifti_image_path(path);
    if (image != path && !add(image)) add(image + ".gz");
  }

 private:
  bool add(const std::string& file) {
    if (!is_file(file)) return false;
    files_.push_back(file);
    return true;
  }

  // Up to the first that is not there: a header may claim any number.
  void add_numbered(const std::string& path, const std::optional<DataFiles>& named) {
    const std::int64_t count = named ? named->count : 0;
    for (std::int64_t i = 0; i < count && add(path_beside(path, named->name(i))); ++i) {
    }
  }

  void add_set(const ByteSource& source, int depth) {
    if (!is_vtk_set(vtk_xml_type(source)) || depth > kMaxVtkSetDepth) return;
    for (const VtkSetFile& file : vtk_set_files(source)) {
      if (static_cast<std::int64_t>(files_.size()) > kMaxVtkSetFiles) return;
      if (!add(file.path)) continue;
      const auto inner = open_file(file.path);
      if (kind_of(inner->text(0, 512)) == FileKind::kVtkXml) add_set(*inner, depth + 1);
    }
  }

  // NAME, NAME.hierarchy and what is named in them, which lies beside them whatever folder they
  // say.
  void add_enzo(const std::string& path) {
    constexpr std::string_view kEnding = ".hierarchy";
    const bool is_hierarchy = path.ends_with(kEnding);
    const std::string stem = is_hierarchy ? path.substr(0, path.size() - kEnding.size()) : path;
    add(is_hierarchy ? stem : stem + std::string(kEnding));
    add(stem + ".boundary");
    const auto hierarchy = open_file(stem + std::string(kEnding));
    TextScanner text(*hierarchy, 0, hierarchy->size());
    std::set<std::string> known;
    while (auto line = text.line()) {
      const auto parts = words(*line);
      if (parts.size() != 3 || !parts[0].ends_with("FileName")) continue;
      const std::string name = fs::path(parts[2]).filename().string();
      if (known.insert(name).second) add(path_beside(path, name));
    }
  }

  // Every word of an EnSight case that is the name of a file; asterisks stand for a number.
  void add_words(const std::string& path, const ByteSource& source) {
    TextScanner text(source, 0, source.size());
    std::set<std::string> known;
    while (auto line = text.line()) {
      for (const std::string_view word : words(*line)) {
        std::string name(word);
        std::erase(name, '"');
        if (name.empty() || !known.insert(name).second) continue;
        const std::string whole = path_beside(path, name);
        if (name.find('*') == std::string::npos)
          add(whole);
        else
          add_pattern(whole);
      }
    }
  }

  void add_pattern(const fs::path& pattern) {
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
    std::vector<std::string> found;
    for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
         !error && entry != end; entry.increment(error)) {
      if (fits(entry->path().filename().string()))
        found.push_back((folder / entry->path().filename()).string());
    }
    std::sort(found.begin(), found.end());
    for (const std::string& file : found) add(file);
  }

  std::vector<std::string> files_;
};

// --- where they may lie -------------------------------------------------------------------------

// The real path; empty if there is nothing.
fs::path real_path(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  return error ? fs::path() : real;
}

bool is_below(const fs::path& path, const fs::path& folder) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end() || (std::next(end) == folder.end() && end->empty());
}

// Where the files that an input names may lie.
class AllowedPlaces {
 public:
  AllowedPlaces(const std::string& input, const ReadOptions& options)
      : input_(input), real_input_(real_path(input)) {
    const fs::path named = fs::path(input).parent_path();
    add(is_folder(input) ? real_input_ : real_path(named.empty() ? "." : named));
    add(real_input_.parent_path());
    for (const std::string& folder : real_data_folders(options)) add(folder);
  }

  // The real path. Throws unless it is allowed; empty for what is not there.
  std::string check(const std::string& file) const {
    const fs::path real = real_path(file);
    if (real.empty() || real == real_input_) return real.string();
    if (std::any_of(folders_.begin(), folders_.end(),
                    [&](const fs::path& folder) { return is_below(real, folder); }))
      return real.string();
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: names '{}', which lies outside its folder{}: if it may be read, "
                            "allow that with --data-folder '{}'",
                            input_, file,
                            real == fs::path(file).lexically_normal()
                                ? ""
                                : fmt::format(" (in '{}')", real.parent_path().string()),
                            real.parent_path().string()));
  }

 private:
  void add(fs::path folder) {
    if (!folder.empty()) folders_.push_back(std::move(folder));
  }

  std::string input_;
  fs::path real_input_;
  std::vector<fs::path> folders_;
};

}  // namespace

std::vector<std::string> files_that_may_be_read(const std::vector<std::string>& inputs,
                                                const ReadOptions& options) {
  std::vector<std::string> files;
  for (const std::string& input : inputs) {
    const AllowedPlaces places(input, options);
    const bool is_named = !is_folder(input);  // what lies in a folder, the user named with it
    for (const std::string& file : files_read_for(input)) {
      std::string real = is_named ? places.check(file) : real_path(file).string();
      if (!real.empty()) files.push_back(std::move(real));
    }
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

std::vector<std::string> real_data_folders(const ReadOptions& options) {
  std::vector<std::string> folders;
  for (const std::string& folder : options.data_folders) {
    const fs::path real = real_path(folder);
    if (!is_folder(real))
      throw Error(ErrorCode::kFileNotFound, fmt::format("data folder '{}': is no folder", folder));
    folders.push_back(real.string());
  }
  return folders;
}

Opener opener_of_named_files(const std::string& input, const ReadOptions& options) {
  return [places = AllowedPlaces(input, options)](const std::string& file) {
    places.check(file);
    return open_file(file);
  };
}

}  // namespace ovoid::io

namespace ovoid {

std::vector<std::string> files_read_for(const std::string& path) {
  io::InputFiles files(path);
  try {
    files.add_all(path);
  } catch (const Error&) {
    // It is not for this function to tell.
  }
  return std::move(files).take();
}

}  // namespace ovoid
