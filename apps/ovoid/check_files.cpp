// SPDX-License-Identifier: Apache-2.0
#include "check_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <system_error>

#include "ovoid/error.h"
#include "ovoid/io.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

namespace fs = std::filesystem;

// Whatever they are called, and whether they are there or not.
bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;
  if (fs::equivalent(a, b, ignored)) return true;
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a, ignored), ignored);
  return !whole_a.empty() && whole_a == fs::weakly_canonical(fs::absolute(b, ignored), ignored);
}

// "--output 'v.nhdr': its samples' file 'v.raw'"
std::string named(const OutputFile& output) {
  std::string name = fmt::format("{} '{}':", output.flag, output.given);
  if (output.path != output.given) name += fmt::format(" its samples' file '{}'", output.path);
  return name;
}

void check_writable(const std::string& path) {
  std::error_code ignored;  // what cannot be looked at will be told by the write itself
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored) &&
      !fs::is_regular_file(path, ignored)) {
    // A device or pipe would be replaced by the renamed file.
    throw Error(ErrorCode::kFileWrite, path + ": is no regular file, expected a file to write");
  }
  check_file_path(path);
}

}  // namespace

std::vector<InputFile> volume_inputs(const std::vector<std::string>& paths) {
  std::vector<InputFile> inputs;
  for (const std::string& path : paths) {
    for (const std::string& file : files_read_for(path)) {
      const bool is_given = file == path;
      inputs.push_back({file, is_given ? "an input" : fmt::format("a data file of '{}'", path)});
    }
  }
  return inputs;
}

std::vector<OutputFile> volume_outputs(const std::string& flag, const std::string& path) {
  std::vector<OutputFile> outputs;
  for (const std::string& file : files_written_for(path)) outputs.push_back({flag, path, file});
  return outputs;
}

void check_files(const std::vector<InputFile>& inputs, const std::vector<OutputFile>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const InputFile& input : inputs) {
      if (!is_same_file(outputs[i].path, input.path)) continue;
      throw UsageError(
          fmt::format("{} is {}, expected another file", named(outputs[i]), input.what));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (!is_same_file(outputs[i].path, outputs[j].path)) continue;
      throw UsageError(
          fmt::format("{} is the same file as {}", named(outputs[i]), outputs[j].flag));
    }
  }
  for (const OutputFile& output : outputs) check_writable(output.path);
}

std::string written_files_text() {
  const auto endings = [](DatasetKind kind) {
    return fmt::format("{}", fmt::join(written_endings(kind), ", "));
  };
  return fmt::format("the file: a volume {}; a mesh {}; particles {}; kernels {}",
                     endings(DatasetKind::kLattice), endings(DatasetKind::kMesh),
                     endings(DatasetKind::kParticles), endings(DatasetKind::kKernels));
}

void check_volume_output(const std::string& flag, const std::string& path) {
  try {
    check_dataset_path(path);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnsupported) throw;
    throw UsageError(fmt::format("{} {}", flag, error.what()));
  }
}

}  // namespace ovoid::cli
