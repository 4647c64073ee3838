// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ovoid/dataset.h"
#include "ovoid/series.h"

namespace ovoid::python {

// A dataset that Python holds, or several that are steps of time.
struct Data {
  std::shared_ptr<const Dataset> dataset;             // of several the first
  std::shared_ptr<const StepSource> steps = nullptr;  // null: it is one
};

}  // namespace ovoid::python
