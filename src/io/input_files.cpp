// SPDX-License-Identifier: Apache-2.0
#include "io/input_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <system_error>
#include <utility>

#include "io/core/signatures.h"
#include "io/dicom/dicom.h"
#include "io/formats.h"
#include "io/images/slices.h"
#include "io/points/snapshot_names.h"
#include "io/vtk/vtk_set_files.h"
#include "io/zarr/zarr.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

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

// Sees the name of a file that an input names, before anything is opened. May throw.
using NameCheck = std::function<void(const std::string& file)>;

// The files of an input that names others, which may be inputs that name more.
class CompanionFiles {
 public:
  CompanionFiles(std::vector<std::string>& files, NameCheck check)
      : files_(files), check_(std::move(check)) {}

  void add_those_of(const std::string& path) { add_companions(path, 1); }

 private:
  void add_companions(const std::string& path, int depth) {
    const Format* format = nullptr;
    std::vector<std::string> named;
    try {
      const auto source = open_file(path);
      format = format_by_content(*source);
      if (format == nullptr || format->companions == nullptr) return;
      named = format->companions(*source);
    } catch (const Error&) {
      return;  // it is not for this to tell
    }
    for (const std::string& file : named) {
      check_(file);
      // A set may name itself, or the same set many times.
      if (static_cast<std::int64_t>(files_.size()) > kMaxVtkSetFiles) return;
      files_.push_back(file);
      const bool may_name_more = format->names_inputs && depth < kMaxVtkSetDepth;
      if (may_name_more && known_.insert(file).second) add_companions(file, depth + 1);
    }
  }

  std::vector<std::string>& files_;
  NameCheck check_;
  std::set<std::string> known_;
};

// files_read_for(); `check` sees what the input names.
std::vector<std::string> files_of_input(const std::string& path, const NameCheck& check) {
  std::vector<std::string> files{path};
  const auto add = [&](const std::vector<std::string>& more) {
    files.insert(files.end(), more.begin(), more.end());
  };
  try {
    if (const std::string description = zarr_description_of(path); description != path) {
      files.push_back(description);
      return files;
    }
    if (is_folder(path)) {
      if (is_slice_folder(path)) {
        add(slice_files_in(path));
        return files;
      }
      add(dicom_files_in(path));
      std::erase_if(files,
                    [&](const std::string& file) { return file != path && !is_dicom_file(file); });
      return files;
    }
  } catch (const Error&) {
    return files;  // it is not for this function to tell
  }
  CompanionFiles(files, check).add_those_of(path);
  return files;
}

// Does the input list the files of its snapshot, of which each would list the same?
bool are_siblings_listed(const std::string& input) {
  std::error_code ignored;
  return snapshot_part(input) && fs::is_regular_file(input, ignored) &&
         is_hdf5(open_file(input)->text(0, 8));
}

}  // namespace

std::vector<std::string> files_that_may_be_read(const std::vector<std::string>& inputs,
                                                const ReadOptions& options) {
  std::vector<std::string> files;
  std::set<std::string> known;  // parts of snapshots are each other's companions: listed once
  for (const std::string& input : inputs) {
    if (!known.insert(input).second) continue;
    const AllowedPlaces places(input, options);
    const bool lists_siblings = are_siblings_listed(input);
    const bool is_named = !is_folder(input);  // what lies in a folder, the user named with it
    const auto check = [&](const std::string& file) { places.check(file); };
    for (const std::string& file : files_of_input(input, check)) {
      if (lists_siblings) known.insert(file);
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
  return io::files_of_input(path, [](const std::string&) {});
}

}  // namespace ovoid
