// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/rise_samples.h"

#include <algorithm>
#include <new>
#include <optional>

#include "data/lattice/paged_lattice.h"
#include "data/lattice/sample_reader.h"
#include "data/lattice/shared_layers.h"
#include "data/out_of_memory.h"

namespace ovoid::data {
namespace {

// Reads samples with what is around them.
class RiseReader {
 public:
  explicit RiseReader(const BrickSource& source)
      : reader_(source), layers_(source.geometry().num_sublattices()) {
    // Axes that are oblique to each other are taken for upright ones: rises are compared with each
    // other, and directions with directions of the same axes.
    const Vec3 lengths = source.geometry().world_from_index.linear().colwise().norm().transpose();
    per_spacing_ = lengths.minCoeff() * lengths.cwiseInverse();
  }

  // None if a sample is missing.
  std::optional<RiseSample> at(const Index3& index) {
    const float value = reader_.at(index);
    // Copied: of samples in this view alone. To acquire others for each sample would unpack or read
    // bricks again and again.
    const BrickView view = reader_.view();
    const Around narrow = around(view, index, 1);
    const Around wide = around(view, index, 3);
    if (std::isnan(value) || !narrow.gradient.allFinite() || !wide.gradient.allFinite())
      return std::nullopt;
    RiseSample sample;
    sample.value = value;
    sample.around = static_cast<float>((value + narrow.sum) / 7);
    sample.gradient = narrow.gradient.cast<float>();
    const double lengths = narrow.gradient.norm() * wide.gradient.norm();
    if (lengths > 0)
      sample.agreement = static_cast<float>(narrow.gradient.dot(wide.gradient) / lengths);
    return sample;
  }

 private:
  struct Around {
    Vec3 gradient = Vec3::Zero();  // not finite if a sample is missing
    double sum = 0;                // of the six neighbours
  };
  Around around(const BrickView& view, const Index3& index, std::int64_t reach) {
    Around around;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t step = a == 2 ? layers_ : 1;
      const std::int64_t room_before = (index[a] - view.lo[a]) / step;
      const std::int64_t room_behind = (view.hi[a] - 1 - index[a]) / step;
      Index3 before = index;
      Index3 behind = index;
      before[a] -= step * std::min(reach, room_before);
      behind[a] += step * std::min(reach, room_behind);
      const double first = reader_.at(before);
      const double last = reader_.at(behind);
      around.sum += first + last;
      if (before[a] == behind[a]) continue;
      const auto axis = static_cast<int>(a);
      around.gradient[axis] = (last - first) * per_spacing_[axis] * static_cast<double>(step) /
                              static_cast<double>(behind[a] - before[a]);
    }
    return around;
  }

  SampleReader reader_;
  const std::int64_t layers_;  // from a sample to the next of its sublattice
  Vec3 per_spacing_;
};

}  // namespace

std::vector<RiseSample> take_rises(const BrickSource& source) {
  const auto* const paged = dynamic_cast<const PagedLattice*>(&source);
  return paged != nullptr ? paged->rises() : find_rises(source);
}

std::vector<RiseSample> find_rises(const BrickSource& source) try {
  const Index3& dims = source.geometry().dims;
  RiseReader reader(source);
  std::vector<RiseSample> samples;
  const std::int64_t every = (num_samples(dims) + kWantedRises - 1) / kWantedRises;
  const SharedLayers layers = shared_layers(source);
  visit_some({0, 0, layers.first}, {dims[0], dims[1], layers.end}, std::max<std::int64_t>(1, every),
             [&](const Index3& index) {
               if (const auto sample = reader.at(index)) samples.push_back(*sample);
             });
  return layers.of_all(std::move(samples));
} catch (const std::bad_alloc&) {
  throw_out_of_memory("samples of the field's slopes", kWantedRises * sizeof(RiseSample));
}

}  // namespace ovoid::data
