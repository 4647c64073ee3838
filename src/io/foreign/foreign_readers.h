// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/reader/reader_messages.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// Reads with other people's libraries in this process, which may crash, hang or follow what a file
// names: to be called in a sandbox (sandbox.h). request.options may have progress and stop. Throws
// Error; kUnsupported for a format whose library is not in this build.
Dataset read_here(const ReaderRequest& request);

}  // namespace ovoid::io
