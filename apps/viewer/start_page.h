// SPDX-License-Identifier: Apache-2.0
// What opens data: the desktop's dialog, and what was opened before.
#pragma once

#include "panels.h"

namespace ovoid::viewer {

void browse_button(Panel& panel, const std::string& name, const char* label, Browsing what);

// A list that opens, of what was opened last; nothing where there is none.
void recent_choice(Panel& panel);

// Before anything is open, in the middle of the window's left part; `error`: why nothing is.
void start_page(Panel& panel, const std::string& error, ImVec2 at, ImVec2 size);

}  // namespace ovoid::viewer
