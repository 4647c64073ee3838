// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ovoid::cli {

// For when nobody can be told any more but by ending the job.
[[noreturn]] void end_job(const std::string& message);

}  // namespace ovoid::cli
