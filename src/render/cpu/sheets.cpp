// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/sheets.h"

#include <algorithm>

#include "data/out_of_memory.h"

namespace ovoid::cpu {

SheetRing::SheetRing(const PlaneShape& shape) {
  const std::size_t plane = shape.num_floats();
  constexpr std::size_t kPlanes = 9;  // values, colours, gradient, opacity, variation, light
  const std::size_t count = kSheets * kPlanes * plane;
  memory_ = hwy::AllocateAligned<float>(count);
  if (memory_ == nullptr) data::throw_out_of_memory("the sheets of a tile", count * sizeof(float));
  std::fill_n(memory_.get(), count, 0.0F);
  float* next = memory_.get();
  for (Sheet& sheet : sheets_) {
    sheet.stride = shape.stride;
    for (float** samples :
         {&sheet.values, &sheet.colors, &sheet.gradient[0], &sheet.gradient[1], &sheet.gradient[2],
          &sheet.opacity, &sheet.variation, &sheet.around, &sheet.key}) {
      *samples = next;
      next += plane;
    }
  }
}

}  // namespace ovoid::cpu
