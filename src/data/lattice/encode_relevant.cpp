// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/encode_relevant.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "data/lattice/relevant_reach.h"
#include "data/lattice/stored_number.h"
#include "data/scalar_visit.h"
#include "ovoid/kernels.h"

namespace ovoid::data {
namespace {

// Those of value > above, as numbers that stand for values.
RelevantValues relevant_numbers(const StoredScalar& scalar, double above) {
  const double number = (above - scalar.offset) / scalar.scale;
  return scalar.scale > 0 ? RelevantValues::above(number) : RelevantValues::below(number);
}

// The number that stands for the least finite value; 0 if none is finite.
double least_number(const StoredScalar& scalar, const Bytes& samples) {
  return visit_scalar(scalar.type, [&]<class T>(std::type_identity<T>) {
    const double sign = scalar.scale > 0 ? 1 : -1;
    const auto count = static_cast<std::int64_t>(samples.view.size() / sizeof(T));
    double least = std::numeric_limits<double>::infinity();
    for (std::int64_t i = 0; i < count; ++i) {
      const auto number = static_cast<double>(load_scalar<T>(samples.view.data(), i));
      if (std::isfinite(number)) least = std::min(least, sign * number);
    }
    return std::isfinite(least) ? sign * least : 0.0;
  });
}

}  // namespace

RelevantRuns encode_relevant(const LatticeGeometry& geometry, const StoredScalar& scalar,
                             const Bytes& samples, const RelevantSamples& relevant,
                             const EncodeOptions& options) {
  const SampleBox box{scalar.type, geometry.dims};
  const RelevantValues values = relevant_numbers(scalar, relevant.above);
  const double background = relevant.background
                                ? (*relevant.background - scalar.offset) / scalar.scale
                                : least_number(scalar, samples);
  if (!relevant.with_reach) return {box, samples.view, values, background, options.stop};
  const double reach = LatticeKernel{}.support_radius() * geometry.unit_spacing();
  const std::vector<std::byte> kept = keep_in_reach(
      geometry, scalar.type, samples, values, background, {reach, options.threads, options.stop});
  const double stored = visit_scalar(scalar.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(stored_number<T>(background));
  });
  return {box, kept, RelevantValues::other_than(stored), background, options.stop};
}

}  // namespace ovoid::data
