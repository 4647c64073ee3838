// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5/stored_boxes.h"

#include <vector>

namespace ovoid::io {

ShortNumbers list_of(const LatticeBoxes& boxes, const BoxNumber& number) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(boxes.boxes.size());
  for (const LatticeBox& box : boxes.boxes) numbers.push_back(number.of(box));
  return ShortNumbers(numbers);
}

}  // namespace ovoid::io
