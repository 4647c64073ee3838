// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

#include "ovoid/export.h"

namespace OVOID_API ovoid {

// What kind of thing went wrong; each code is provoked by a test.
enum class ErrorCode {
  kInvalidArgument,  // a value outside its documented range (the message names argument, value and
                     // what was expected)
  kFileNotFound,     // a path that does not exist or cannot be opened for reading
  kFileFormat,       // a file that contradicts itself, is truncated, or is not what its header says
  kUnsupported,  // a well-formed request for something this build or this format version cannot do
  kFileWrite,    // an output that cannot be created or written (nothing is left behind)
  kOutOfMemory,  // an allocation that failed or would pass the caller's memory limit
  kDeviceLost,   // the graphics device stopped working; the next picture starts it anew
  kCancelled,    // the caller's stop token was triggered before the work was done
};

// The one exception of the library, thrown from public entry points only. `what()` is one line
// without a full stop that names the argument, file or array, its value, and what was expected:
// "radii[17] = -0.2: must be > 0".
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

// The lower-case name of a code ("invalid-argument"), for logs and tests.
const char* name_of(ErrorCode code) noexcept;

}  // namespace ovoid
