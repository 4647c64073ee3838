// SPDX-License-Identifier: Apache-2.0
// Samples of any field, for a look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "data/field_samples.h"
#include "data/kernel_shape.h"
#include "ovoid/field.h"
#include "ovoid/kernel_field.h"

namespace ovoid::view {

using data::FieldSamples;
using data::quantile;

// The field at the centre of kernels: where they are summed the sum, else their own value. The
// field outlives it.
class ValuesAtKernels {
 public:
  explicit ValuesAtKernels(const KernelField& field) : field_(field) {
    if (field.reconstruction() == Reconstruction::kSum) sampler_.emplace(field);
  }
  double at(const KernelBrick& brick, const KernelView& view, std::int32_t i) {
    if (sampler_) return sampler_->at(brick.origin + data::offset_of(view, i)).value;
    return view.value[static_cast<std::size_t>(field_.attribute())][i];
  }

 private:
  const KernelField& field_;
  std::optional<KernelSampler> sampler_;
};

// Of a lattice: data::take_samples() of its samples. Of a kernel set: the kernels' own values, the
// more often the larger they are (by the root of the volume: between what space shows and what the
// data are about); where kernels are summed, the field at the centres of some thousands. No faces.
FieldSamples take_samples(const KernelField& field);

}  // namespace ovoid::view
