// SPDX-License-Identifier: Apache-2.0
#include "io/core/row_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "io/core/cell_share.h"
#include "io/core/point_arrays.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Where the run of that number begins: floor(total * number / count).
std::int64_t first_row(std::int64_t total, std::int64_t number, std::int64_t count) noexcept {
  return total / count * number + total % count * number / count;
}

DataArray take_rows(const DataArray& array, const Rows& rows) {
  DataArray description = array;
  description.num_tuples = rows.count;
  std::byte* to = nullptr;
  DataArray taken = new_array(std::move(description), to);
  const std::size_t row_size = size_of(array.type) * static_cast<std::size_t>(array.num_components);
  const auto from = array.bytes.view.subspan(static_cast<std::size_t>(rows.first) * row_size,
                                             static_cast<std::size_t>(rows.count) * row_size);
  std::copy(from.begin(), from.end(), to);
  return taken;
}

}  // namespace

void check_share(const std::optional<RowShare>& share) {
  if (!share || (share->number >= 0 && share->number < share->count)) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("share: number {} of {}: expected 0 <= number < count", share->number,
                          share->count));
}

Rows rows_of_share(const std::optional<RowShare>& share, std::int64_t total) noexcept {
  if (!share) return {0, total};
  const std::int64_t first = first_row(total, share->number, share->count);
  return {first, first_row(total, std::int64_t{share->number} + 1, share->count) - first};
}

bool has_rows(DatasetKind kind) noexcept { return kind != DatasetKind::kLattice; }

void set_share(Dataset& dataset, const std::optional<RowShare>& share, std::int64_t total) {
  if (share) dataset.share = DatasetShare{rows_of_share(share, total).first, total};
}

void cut_to_share(Dataset& dataset, const std::optional<RowShare>& share) {
  if (!share || dataset.share || !has_rows(dataset.kind)) return;
  if (dataset.kind == DatasetKind::kMesh) return cut_cells_to_share(dataset, *share);
  const std::int64_t total = dataset.num_positions();
  const Rows rows = rows_of_share(share, total);
  dataset.positions = take_rows(dataset.positions, rows);
  if (dataset.kind == DatasetKind::kBoxes) dataset.box_sizes = take_rows(dataset.box_sizes, rows);
  for (DataArray& array : dataset.arrays) array = take_rows(array, rows);
  set_share(dataset, share, total);
}

}  // namespace ovoid::io
