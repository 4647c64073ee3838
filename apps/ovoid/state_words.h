// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "flags.h"

namespace ovoid::cli {

// The words of a command with those of the state that --state names among them: its flags before
// all others, and its inputs where the words name none. A flag that the words give is left out of
// the state's, and so is what it contradicts and what has no effect without that, so that the words
// win. --state stays, with the file that it names. Words without it, with help asked for, or with
// what parsing refuses anyway come back as they are. Throws what read_state() throws.
Words with_state(const Words& words, const std::vector<FlagForm>& forms);

}  // namespace ovoid::cli
