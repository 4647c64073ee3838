// SPDX-License-Identifier: Apache-2.0
// Samples of any field, for a look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "data/field_samples.h"
#include "data/kernels/some_kernels.h"
#include "ovoid/field.h"
#include "ovoid/kernel_field.h"

namespace ovoid::view {

using data::FieldSamples;
using data::quantile;

// Runs `body(brick, view, i, value)` with the field's value at the centre of about `most` kernels
// (under twice as many): their own, or of a sum the sums that it knows, of however many.
template <class Body>
void for_values_at_kernels(const KernelField& field, std::int64_t most, const Body& body) {
  const KernelSource& source = field.source();
  const KernelSums* const sums = field.sums();
  const auto attribute = static_cast<std::size_t>(field.attribute());
  std::size_t next = 0;
  data::for_every_kernel(
      source, sums != nullptr ? sums->stride : data::stride_for(source.num_kernels(), most),
      [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        body(brick, view, i, sums != nullptr ? sums->values[next++] : view.value[attribute][i]);
      });
}

// Of a lattice: data::take_samples() of its samples. Of a kernel set: the kernels' own values, the
// more often the larger they are (by the root of the volume: between what space shows and what the
// data are about); where kernels are summed, the sums that are known. No faces.
FieldSamples take_samples(const KernelField& field);

}  // namespace ovoid::view
