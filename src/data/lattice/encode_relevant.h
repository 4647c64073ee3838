// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stop_token>

#include "data/lattice/relevant_runs.h"
#include "ovoid/dataset.h"
#include "ovoid/relevant.h"

namespace ovoid::data {

// What samples are: value = stored number * scale + offset.
struct StoredScalar {
  ScalarType type;
  double scale = 1.0, offset = 0.0;
};

struct EncodeOptions {
  int threads = 0;
  std::stop_token stop{};
};

// The relevant samples of a lattice, as runs. Throws Error: kUnsupported for `with_reach` of types
// that a BrickView cannot show, kCancelled.
RelevantRuns encode_relevant(const LatticeGeometry& geometry, const StoredScalar& scalar,
                             const Bytes& samples, const RelevantSamples& relevant,
                             const EncodeOptions& options);

}  // namespace ovoid::data
