// SPDX-License-Identifier: Apache-2.0
// A lattice's samples as floats, and what is known of them at once.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/field.h"

namespace ovoid::fit {

// Numbers as they are stored, if they are integers of 1 or 2 bytes (`whole`), else values.
struct LatticeSamples {
  std::string array;
  Index3 dims{};
  std::vector<float> values;  // NaN where missing
  std::int64_t num_missing = 0;
  double least = 0, greatest = 0;  // of those that are not
  double background = 0;           // the value that most of them are near
  bool whole = false;
  std::optional<LatticeField> field;  // of them; is there
  double scale = 1, offset = 0;       // value = number * scale + offset
};

struct SampleChoice {
  std::string array;  // empty: the only one, or the first that varies
  int component = 0;
  int threads = 1;
  std::stop_token stop{};
};

// Of a Cartesian lattice. Throws Error: kInvalidArgument for anything else, or 2^32 samples and
// more, `what` naming what holds no others; what make_lattice_field() throws.
LatticeSamples read_lattice_samples(const Dataset& dataset, const SampleChoice& choice,
                                    const std::string& what);

}  // namespace ovoid::fit
