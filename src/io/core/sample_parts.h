// SPDX-License-Identifier: Apache-2.0
// The samples that a header describes: in one file or several, of one time step or many, of which
// one is read.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "data/shown_step.h"
#include "io/core/byte_source.h"
#include "io/core/decode.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// One file, and where its samples begin.
struct SamplePart {
  const ByteSource* source = nullptr;
  std::int64_t offset = 0;
  std::unique_ptr<ByteSource> owned;  // keeps `source`, unless the header's own file is meant
};

// Files that hold the same number of samples each, one behind the other.
struct SampleParts {
  std::int64_t count = 1;
  Encoding encoding = Encoding::kRaw;
  WantedSamples each;
  std::function<SamplePart(std::int64_t index)> open;
};

// How the steps lie in the samples of all parts together.
struct StepLayout {
  std::int64_t num_steps = 1;
  std::int64_t num_bytes = 0;  // of one step
  ScalarType type = ScalarType::kUInt8;
  int num_components = 1;
  // The components of a sample lie behind each other, or each component has a block of its own with
  // all its steps.
  enum class Order { kInterleaved, kPlanar } order = Order::kInterleaved;
  bool is_big_endian = false;  // not looked at for text
};

struct StepSamples {
  Bytes bytes;                                    // components interleaved, native byte order
  std::shared_ptr<const StoredSamples> stored{};  // instead, where they may stay in their file
  std::int64_t step = 0;
};

// Reads options.step, or the first step whose samples (planar: of the first component) vary, which
// is told in a note; the first if none does. Other steps of raw data are not read. All parts are
// looked at before memory is taken: a missing one is found at once. Where memory does not hold the
// step and options say so, it stays in its file, or goes to a temporary one where it is packed or
// in several files. Peak memory is otherwise the step, twice if it is planar. Throws
// Error(kFileFormat), Error(kInvalidArgument) for a step that is not there.
StepSamples read_step(const SampleParts& parts, const StepLayout& layout,
                      const ReadOptions& options, std::vector<std::string>& notes);

// Headers may claim any number of steps, each of which has a time in memory. Throws
// Error(kUnsupported) naming `where`.
void check_num_steps(const std::string& where, std::int64_t num_steps);

using data::chosen_step_note;

// Throws Error(kInvalidArgument) if there is no such step.
void check_step(const std::string& name, std::int64_t step, std::int64_t num_steps);

}  // namespace ovoid::io
