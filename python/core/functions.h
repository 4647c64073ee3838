// SPDX-License-Identifier: Apache-2.0
// What the program's other commands do, with data that Python holds.
#pragma once

#include <string>
#include <vector>

#include "flags.h"
#include "ovoid/dataset.h"
#include "source.h"
#include "waiting.h"

namespace ovoid::python {

// The forms of the flags of "render", "fit", "simplify" or "convert". Throws Error for others.
std::vector<cli::FlagForm> forms_of(const std::string& command);

// By flags as on a command line, --output among them; what --report of the command writes, as JSON.
// Throw Error and UsageError.
std::string fit(const Source& source, const cli::Words& words, Work& work);
std::string simplify(const Source& source, const cli::Words& words, Work& work);

// What `ovoid convert` would write.
Dataset convert(const Source& source, const cli::Words& words, Work& work);

}  // namespace ovoid::python
