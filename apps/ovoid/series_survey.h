// SPDX-License-Identifier: Apache-2.0
// What holds for all frames of an animation, so that nothing jumps from one to the next: which step
// the look is made from, the range of values, and the bounds.
#pragma once

#include <cstdint>
#include <vector>

#include "drawing.h"
#include "ovoid/series.h"

namespace ovoid::cli {

// The data at a moment, between steps interpolated, and their field.
Dataset data_at(const Series& series, double time, const DrawingFlags& drawing, Session& session);
Modelled field_at(const Series& series, double time, const DrawingFlags& drawing, Session& session);

struct Survey {
  double look_time = 0;       // whose values span the most; the first of several
  ValueRange values, colors;  // of all steps looked at
  Bounds3 bounds;
  std::int64_t num_steps = 0;  // looked at
};

// The steps to look at: `first`, then all others, or, where those are more than two GiB together,
// some evenly between the first and the last; `first` alone where the flags leave nothing to be
// found out. `dataset`: of `first`.
std::vector<std::int64_t> steps_to_survey(const Series& series, std::int64_t first,
                                          const Dataset& dataset, const LookFlags& look);

// Looks at the data at these times, at least one. Throws what reading and modelling throw.
Survey survey(const Series& series, const std::vector<double>& times, const DrawingFlags& drawing,
              Session& session);

// The look's flags with the range of values that all frames share, where it is the data that say
// it.
LookFlags with_range_of(const Survey& survey, const LookFlags& flags, const Field& field);

// The box of what is drawn in all steps, cut as the flags say.
Box box_of_all(const Survey& survey, const CropFlags& crop, const Field& field,
               RenderOptions* options);

}  // namespace ovoid::cli
