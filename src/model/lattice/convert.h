// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>

#include "ovoid/dataset.h"

namespace ovoid::model {

// Which scalar of an array's tuples is wanted, and who does the work.
struct ComponentOptions {
  int component = 0;        // LatticeModelOptions::kMagnitude: Euclidean norm
  bool as_float32 = false;  // convert even what a BrickView can show as it is
  int threads = 0;          // 0: one per hardware thread
  std::stop_token stop{};
};

// One scalar per tuple, packed and aligned.
struct ScalarSamples {
  ScalarType type = ScalarType::kFloat32;  // one that a BrickView can show
  Bytes bytes;
  float* writable = nullptr;  // the same memory, if it was made here as float32; else null
  double value_scale = 1.0;   // value = sample * scale + offset: the array's, if its numbers are
  double value_offset = 0.0;  // kept, else applied already
};

// Takes the scalars out of `array`, whose sizes must agree with its bytes. A type that a BrickView
// can show is kept, and borrowed if it is the only component and aligned, else copied; others and
// the magnitude become float32 values, where one beyond float32's range becomes NaN. Throws Error:
// kInvalidArgument for a component that does not exist, kCancelled; std::bad_alloc.
ScalarSamples take_component(const DataArray& array, const ComponentOptions& options);

}  // namespace ovoid::model
