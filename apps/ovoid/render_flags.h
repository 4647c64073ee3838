// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flags.h"
#include "ovoid/renderer.h"

namespace ovoid::cli {

// How a frame is computed and on what: the renderer's half of section "numbers", and section
// "running".
void add_number_flags(Flags& flags, RenderOptions* options);
void add_run_flags(Flags& flags, RendererSetup* run);
void add_switch_flags(Flags& flags, RenderOptions* options);  // --no-skip, --no-stop, --no-pack

}  // namespace ovoid::cli
