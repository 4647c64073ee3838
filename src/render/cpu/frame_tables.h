// SPDX-License-Identifier: Apache-2.0
// What of a frame is the same for every kind of field: camera, look and light, in the form that the
// stages want.
#pragma once

#include <vector>

#include "render/cpu/frame.h"
#include "render/shared/look_nodes.h"

namespace ovoid::cpu {

// Memory of what a frame's tables point to.
struct LookTables {
  std::vector<float> look, fading, colors;
  IntegralNodes integrals;
};

void set_view(CpuFrame& frame, const view::FramePlan& plan);

// `range`: of the field's values. `tables` must live as long as the frame is drawn.
void set_look(CpuFrame& frame, const ValueRange& range, const Look& look,
              const view::FramePlan& plan, LookTables& tables);

}  // namespace ovoid::cpu
