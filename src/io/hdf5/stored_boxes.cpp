// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5/stored_boxes.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ovoid::io {

StoredBoxes::StoredBoxes(const LatticeBoxes& boxes) {
  const auto list = [&](const auto& number_of) {
    std::vector<std::int64_t> numbers;
    numbers.reserve(boxes.boxes.size());
    for (const LatticeBox& box : boxes.boxes) numbers.push_back(number_of(box));
    return ShortNumbers(numbers);
  };
  lists[0] = list([](const LatticeBox& box) { return box.gap; });
  lists[4] = list([](const LatticeBox& box) { return box.first; });
  for (std::size_t a = 0; a < 3; ++a) {
    lists[1 + a] = list([a](const LatticeBox& box) { return box.size[a]; });
    lists[5 + a] = list([a](const LatticeBox& box) { return box.rise[a]; });
  }
}

}  // namespace ovoid::io
