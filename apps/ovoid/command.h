// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "session.h"

namespace ovoid::cli {

// One subcommand, one file. Each takes the words after its name, and throws UsageError or
// ovoid::Error.
using Words = std::vector<std::string>;

void run_render(const Words& words, Session& session);
void run_animate(const Words& words, Session& session);
void run_info(const Words& words, Session& session);
void run_make(const Words& words, Session& session);
void run_convert(const Words& words, Session& session);
void run_sample(const Words& words, Session& session);
void run_bench(const Words& words, Session& session);

}  // namespace ovoid::cli
