// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "flag_set.h"
#include "flags.h"
#include "ovoid/renderer.h"
#include "ovoid/value_plane.h"

namespace ovoid::cli {

// How a frame is computed and on what: the renderer's half of section "numbers", and section
// "running".
void add_number_flags(Flags& flags, RenderOptions* options);
void add_plane_flag(Flags& flags, std::optional<ValuePlane>* plane);
void add_run_flags(Flags& flags, RendererSetup* run);
void add_switch_flags(Flags& flags, RenderOptions* options);  // --no-skip, --no-stop, --no-pack

// The other way round: the flags that say the same, in the place of those that the set has. What is
// at its default takes no flag.
void tell_numbers(const RenderOptions& options, FlagSet* flags);  // the switches, too; not --size
void tell_plane(const std::optional<ValuePlane>& plane, FlagSet* flags);
void tell_run(const RendererSetup& run, FlagSet* flags);

}  // namespace ovoid::cli
