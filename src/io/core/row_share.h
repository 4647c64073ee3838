// SPDX-License-Identifier: Apache-2.0
// Which of a file's rows are read, of everything but lattices (ReadOptions::share).
#pragma once

#include <cstdint>
#include <optional>

#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid::io {

// A run of rows.
struct Rows {
  std::int64_t first = 0;
  std::int64_t count = 0;

  std::int64_t end() const noexcept { return first + count; }
};

// Throws Error(kInvalidArgument) unless 0 <= number < count, or there is none.
void check_share(const std::optional<RowShare>& share);

// The rows that are read of `total`: the share's, or all. Products do not overflow.
Rows rows_of_share(const std::optional<RowShare>& share, std::int64_t total) noexcept;

// Is it of rows: particles, stored kernels, boxes, or the cells of a mesh?
bool has_rows(DatasetKind kind) noexcept;

// Says in a dataset that holds rows_of_share(share, total) that it does; without a share it is
// whole.
void set_share(Dataset& dataset, const std::optional<RowShare>& share, std::int64_t total);

// Copies the share's rows and releases the whole, array by array; nothing of what has no rows or
// was read by shares. Throws Error(kOutOfMemory).
void cut_to_share(Dataset& dataset, const std::optional<RowShare>& share);

}  // namespace ovoid::io
