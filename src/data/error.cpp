// SPDX-License-Identifier: Apache-2.0
#include "ovoid/error.h"

namespace ovoid {

const char* name_of(ErrorCode code) noexcept {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return "invalid-argument";
    case ErrorCode::kFileNotFound:
      return "file-not-found";
    case ErrorCode::kFileFormat:
      return "file-format";
    case ErrorCode::kUnsupported:
      return "unsupported";
    case ErrorCode::kFileWrite:
      return "file-write";
    case ErrorCode::kOutOfMemory:
      return "out-of-memory";
    case ErrorCode::kDeviceLost:
      return "device-lost";
    case ErrorCode::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace ovoid
