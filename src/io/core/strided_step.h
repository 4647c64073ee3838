// SPDX-License-Identifier: Apache-2.0
// A time step whose samples are strewn over the files, since the axis of time, or that of
// components, is not where read_step() takes it to be.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/core/sample_parts.h"
#include "ovoid/io.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

// How the samples of all parts together lie, and where those of a step go.
struct StridedLayout {
  struct Axis {
    std::int64_t count = 1;
    std::int64_t to_stride = 0;  // bytes in memory from one sample to the next
    bool is_of_steps = false;    // whose samples are the steps: at most one
  };
  std::vector<Axis> axes;  // fastest first
  ScalarType type = ScalarType::kUInt8;
  int num_components = 1;
  std::int64_t num_steps = 1;
  std::int64_t num_bytes = 0;  // of a step
  bool is_big_endian = false;  // not looked at for text
};

// Reads options.step, or the first of some dozen steps that varies, with a note; the first if none
// of these does. All files are read for each step that is looked at. Peak memory: the step and 4
// MiB; it does not stay in its file. Throws what read_step() does.
StepSamples read_strided_step(const SampleParts& parts, const StridedLayout& layout,
                              const ReadOptions& options, std::vector<std::string>& notes);

}  // namespace ovoid::io
