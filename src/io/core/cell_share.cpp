// SPDX-License-Identifier: Apache-2.0
#include "io/core/cell_share.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "data/cell_builder.h"
#include "io/core/point_arrays.h"
#include "io/core/row_share.h"

namespace ovoid::io {
namespace {

// Which rows of an array are taken: those listed.
DataArray take_listed(const DataArray& array, std::span<const std::uint32_t> rows) {
  DataArray description = array;
  description.num_tuples = std::ssize(rows);
  std::byte* to = nullptr;
  DataArray taken = new_array(std::move(description), to);
  const std::size_t row_size = size_of(array.type) * static_cast<std::size_t>(array.num_components);
  for (const std::size_t row : rows) {
    std::memcpy(to, array.bytes.view.data() + row * row_size, row_size);
    to += row_size;
  }
  return taken;
}

std::vector<std::uint32_t> run_of(const Rows& rows) {
  std::vector<std::uint32_t> run(static_cast<std::size_t>(rows.count));
  std::iota(run.begin(), run.end(), static_cast<std::uint32_t>(rows.first));
  return run;
}

void take_tuples(Dataset& dataset, std::span<const std::uint32_t> nodes,
                 std::span<const std::uint32_t> cells) {
  dataset.positions = take_listed(dataset.positions, nodes);
  for (DataArray& array : dataset.arrays)
    array = take_listed(array, array.is_cell_data ? cells : nodes);
  dataset.share->nodes = std::vector<std::uint64_t>(nodes.begin(), nodes.end());
}

// Along the last axis that has cells.
void cut_grid(Dataset& dataset, const RowShare& share) {
  Index3& dims = dataset.cells.dims;
  std::size_t axis = 2;
  while (axis > 0 && dims[axis] == 1) --axis;
  std::int64_t nodes_in_layer = 1, cells_in_layer = 1;
  for (std::size_t a = 0; a < axis; ++a) {
    nodes_in_layer *= dims[a];
    cells_in_layer *= std::max<std::int64_t>(dims[a] - 1, 1);
  }
  const std::int64_t num_layers = std::max<std::int64_t>(dims[axis] - 1, 1);
  const Rows layers = rows_of_share(share, num_layers);
  const bool is_flat = dims[axis] == 1;  // one vertex
  const std::int64_t num_layers_of_nodes = layers.count == 0 ? 0 : layers.count + (is_flat ? 0 : 1);
  dataset.share = DatasetShare{layers.first * cells_in_layer, num_layers * cells_in_layer};
  take_tuples(dataset,
              run_of({layers.first * nodes_in_layer, num_layers_of_nodes * nodes_in_layer}),
              run_of({layers.first * cells_in_layer, layers.count * cells_in_layer}));
  dims[axis] = num_layers_of_nodes;
  if (layers.count == 0) dataset.cells = {};
}

void cut_list(Dataset& dataset, const RowShare& share) {
  const Cells& whole = dataset.cells;
  const Rows rows = rows_of_share(share, whole.count());
  const auto first = static_cast<std::size_t>(rows.first);
  const auto end = static_cast<std::size_t>(rows.end());
  // Nodes of no cell of all are shared out by themselves.
  const auto num_nodes = static_cast<std::size_t>(dataset.num_positions());
  std::vector<bool> is_wanted(num_nodes, false);
  const Rows own = rows_of_share(share, dataset.num_positions());
  for (std::int64_t node = own.first; node < own.end(); ++node)
    is_wanted[static_cast<std::size_t>(node)] = true;
  for (const std::uint32_t node : whole.connectivity) is_wanted[node] = false;
  const auto begin_of = [&](std::size_t cell) {
    return static_cast<std::size_t>(whole.offsets[cell]);
  };
  const std::span<const std::uint32_t> mine =
      rows.count == 0
          ? std::span<const std::uint32_t>{}
          : whole.connectivity.view().subspan(begin_of(first), begin_of(end) - begin_of(first));
  for (const std::uint32_t node : mine) is_wanted[node] = true;
  std::vector<std::uint32_t> nodes;
  std::vector<std::uint32_t> number_of(num_nodes);
  for (std::uint32_t node = 0; node < num_nodes; ++node) {
    if (!is_wanted[node]) continue;
    number_of[node] = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(node);
  }
  data::CellBuilder cells;
  for (std::size_t c = first; c < end; ++c) {
    for (std::size_t i = begin_of(c); i < begin_of(c + 1); ++i)
      cells.connectivity.push_back(number_of[whole.connectivity[i]]);
    cells.end_cell(whole.types[c]);
  }
  dataset.share = DatasetShare{rows.first, whole.count()};
  dataset.cells = rows.count == 0 ? Cells{} : std::move(cells).finish();
  take_tuples(dataset, nodes, run_of(rows));
}

}  // namespace

void cut_cells_to_share(Dataset& dataset, const RowShare& share) {
  if (dataset.cells.is_structured()) {
    cut_grid(dataset, share);
  } else {
    cut_list(dataset, share);
  }
}

}  // namespace ovoid::io
