// SPDX-License-Identifier: Apache-2.0
// For tests: DICOM slices of series in time.
#pragma once

#include <fmt/format.h>

#include <string>

#include "io/dicom/test_dicom.h"

namespace ovoid::io {

// Slice `place` of the volume at `time`, 3 mm above the one before; its samples are from
// 100 time + 10 place + 1 on. No times, and no instance number.
inline TestSlice slice_in_time(int time, int place) {
  TestSlice slice;
  slice.sop = fmt::format("1.2.3.{}.{}", time + 1, place + 1);
  slice.instance.clear();
  slice.position = fmt::format("-10\\20\\{}", 3 * place);
  slice.slope = "1";
  slice.intercept = "0";
  const DicomElements e(syntax_of(slice.uid));
  for (int k = 1; k <= slice.rows * slice.columns; ++k)
    slice.pixels += e.word(static_cast<std::uint16_t>(100 * time + 10 * place + k));
  return slice;
}

// Numbers as the bytes of a value.
inline std::string double_bytes(double value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

}  // namespace ovoid::io
