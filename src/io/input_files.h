// SPDX-License-Identifier: Apache-2.0
// The files that an input consists of, and where they may lie: in the input's own folder, or in one
// that the user names (ReadOptions::data_folders). Links are followed first: what counts is where a
// file really is. A path that the user names is always allowed, and so is the folder that it, as
// named, lies in.
#pragma once

#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "ovoid/io.h"

namespace ovoid::io {

// The real paths of all files of these inputs (files_read_for) that are there. Throws
// Error(kUnsupported) that names the input, the file and the flag that would allow it, for one that
// lies elsewhere.
std::vector<std::string> files_that_may_be_read(const std::vector<std::string>& inputs,
                                                const ReadOptions& options);

// The real paths of options.data_folders. Throws Error(kFileNotFound) for one that is no folder.
std::vector<std::string> real_data_folders(const ReadOptions& options);

// Opens the files that the header `input` names; refuses those that lie elsewhere, as above.
Opener opener_of_named_files(const std::string& input, const ReadOptions& options);

}  // namespace ovoid::io
