// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "data/field_samples.h"
#include "data/lattice/sample_reader.h"
#include "ovoid/field.h"
#include "ovoid/kernel_team.h"

namespace ovoid::data {

// Whole numbers in [0, 65535], as long as there are few.
class FewIntegers {
 public:
  explicit FewIntegers(std::size_t most) : most_(most) {}

  // False once a number does not fit; nothing is added afterwards.
  bool add(float value);
  bool fit() const noexcept { return fit_; }
  // Rising; empty if they do not fit.
  std::vector<int> found() const;

 private:
  std::size_t most_;
  bool fit_ = true;
  std::vector<bool> is_found_ = std::vector<bool>(65536);
  std::size_t count_ = 0;
};

// What is asked of a lattice's samples before a field of them is drawn, by looking at runs of
// layers one after the other: by one process at all, or by several of a team at some each. Results
// do not depend on how layers are divided.
class SampleSurvey {
 public:
  explicit SampleSurvey(const Index3& dims);

  // Layers [first, end), in rising order from call to call.
  void take_samples(SampleReader& reader, std::int64_t first, std::int64_t end);
  void take_rows(SampleReader& reader, std::int64_t first, std::int64_t end);
  void find_integers(SampleReader& reader, std::int64_t first, std::int64_t end);

  // From what each process has found to what all have. All call it.
  void join(KernelTeam& team);

  // What data::take_samples() gives, of the samples taken.
  FieldSamples samples() const;
  // Different values of all samples that were looked at, if they are few integers.
  std::vector<int> few_integers() const { return integers_.found(); }
  // Whether neighbours among the samples taken are mostly equal, and jump where they are not.
  bool has_regions() const;
  // Whether, of the rows taken, values are flat within regions and change between them from one
  // sample to the next, as those of labels do.
  bool has_sharp_regions() const;

 private:
  // Four samples along x, of which the middle two are a pair.
  using Row = std::array<float, 4>;
  struct Counts {
    std::int64_t num_pairs = 0, num_equal = 0, num_jumps = 0;
    bool is_counted = false, are_labels = true, are_few = true;
  };

  double share_of_equals() const;
  double share_of_jumps() const;

  Index3 dims_;
  std::vector<float> values_, on_faces_;
  std::vector<Row> rows_;
  Counts counts_;
  FewIntegers integers_;
};

}  // namespace ovoid::data
