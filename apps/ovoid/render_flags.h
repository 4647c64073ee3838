// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "flags.h"
#include "ovoid/renderer.h"

namespace ovoid::cli {

// How a frame is computed and on what: the renderer's half of section "numbers", and section
// "running".
struct RunFlags {
  Backend backend = Backend::kAuto;
  int threads = 0;  // 0: one per hardware thread
};

void add_number_flags(Flags& flags, RenderOptions* options);
void add_run_flags(Flags& flags, RunFlags* run);
void add_switch_flags(Flags& flags, RenderOptions* options);  // --no-skip, --no-stop

}  // namespace ovoid::cli
