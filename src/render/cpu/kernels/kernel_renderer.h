// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_renderer.h"

namespace ovoid::cpu {

// render() of a job whose field is a kernel field.
Frame render_kernel_field(const FrameJob& job, const Machine& machine);

}  // namespace ovoid::cpu
