// SPDX-License-Identifier: Apache-2.0
// The moments of a trail of kernel sets: docs/numerics.md, "With a trail of kernel sets".
#pragma once

#include <vector>

namespace ovoid::model {

// A moment, and its share of the time.
struct TimeShare {
  double time, share;
};

// What lies between two steps, or what a trail has of it.
struct TrailPart {
  double from, until;    // of the trail
  double first, second;  // the times of the steps
  bool moves = true;     // straight from the one to the other; else each half shows its own step
  double steps = 1;      // so many moments are wanted
};

// How a trail weighs time: what was there `age` ago counts exp(-decay * age / length).
struct TrailWeight {
  double time, length, decay;

  // Over [from, until].
  double integral(double from, double until) const;
  double centroid(double from, double until) const;
};

// The moments of all parts, by time; shares add up to 1. More than `most` are joined.
std::vector<TimeShare> moments_of(const std::vector<TrailPart>& parts, const TrailWeight& weight,
                                  int most);

}  // namespace ovoid::model
