// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "ovoid/dataset.h"

namespace ovoid::python {

// A dataset that Python holds.
struct Data {
  std::shared_ptr<const Dataset> dataset;
};

}  // namespace ovoid::python
