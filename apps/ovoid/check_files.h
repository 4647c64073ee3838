// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace ovoid::cli {

// A file that a command reads, and what it is to it: "an input", "the look of --tf".
struct InputFile {
  std::string path;
  std::string what;
};

// A file that a command writes, the flag that asks for it, and the name given there, which is
// another where a header's samples go to a file of their own.
struct OutputFile {
  std::string flag;
  std::string given;
  std::string path;
};

// The files that reading volumes reads, and writing one writes, the detached samples included.
std::vector<InputFile> volume_inputs(const std::vector<std::string>& paths);
std::vector<OutputFile> volume_outputs(const std::string& flag, const std::string& path);

// Throws what keeps the outputs from being written, before the work rather than after it:
// UsageError if one is an input or another output, Error(kFileWrite) if its folder does not exist
// or cannot be written, or if it is no regular file.
void check_files(const std::vector<InputFile>& inputs, const std::vector<OutputFile>& outputs);

// "the file: a volume .nrrd, ...; a mesh .vtu; ...": what a flag may be given that names a dataset
// to write, for its help.
std::string written_files_text();

// Throws UsageError if no format of volumes has the ending, Error(kFileWrite) if the samples of a
// .nhdr would replace a file that is not its own.
void check_volume_output(const std::string& flag, const std::string& path);

}  // namespace ovoid::cli
