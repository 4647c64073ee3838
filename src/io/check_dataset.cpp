// SPDX-License-Identifier: Apache-2.0
#include "io/check_dataset.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "io/cell_lattice.h"
#include "io/core/samples.h"
#include "io/hdf5/hdf5_lattice_format.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::kFileFormat, what); }

void check_steps(const Dataset& dataset) {
  if (dataset.num_steps < 1 || dataset.step < 0 || dataset.step >= dataset.num_steps)
    refuse("a step that is not there");
  const auto num_times = static_cast<std::int64_t>(dataset.times.size());
  if (num_times != 0 && num_times != dataset.num_steps)
    refuse(fmt::format("{} times for {} steps", num_times, dataset.num_steps));
  if (dataset.series == SeriesKind::kStaggered && !are_staggered_times(dataset.times))
    refuse("times at uneven distances, of steps that are halves of one lattice in turn");
}

// Samples, or their place in the file.
void check_array(const DataArray& array, std::int64_t num_tuples, const char* places) {
  if (array.num_tuples != num_tuples)
    refuse(fmt::format("{} tuples for {} {}", array.num_tuples, num_tuples, places));
  const std::array factors{static_cast<std::int64_t>(array.num_components), array.num_tuples,
                           static_cast<std::int64_t>(size_of(array.type))};
  const auto num_bytes = checked_product(factors);
  const std::int64_t num_held =
      array.stored ? array.stored->num_bytes() : static_cast<std::int64_t>(array.bytes.view.size());
  if (array.num_components < 1 || num_bytes != num_held)
    refuse(fmt::format("array '{}' of another size than its own", array.name));
  if (array.stored && array.num_components != 1)
    refuse(fmt::format("array '{}' of {} components that stays in its file", array.name,
                       array.num_components));
  if (!std::isfinite(array.value_scale) || array.value_scale == 0 ||
      !std::isfinite(array.value_offset))
    refuse(fmt::format("array '{}' whose numbers stand for s x {:g} + {:g}", array.name,
                       array.value_scale, array.value_offset));
}

void check_points(const DataArray& array, const char* what) {
  if (array.num_components != 3 || !is_floating(array.type) || array.stored)
    refuse(fmt::format("{} that are not three floating-point numbers each", what));
}

void check_lattice(const Dataset& dataset) {
  checked_num_bytes("a lattice", dataset.lattice.dims, ScalarType::kFloat64);
  check_geometry("a lattice", dataset.lattice.world_from_index);
  if (dataset.arrays.empty()) refuse("a lattice without an array");
  for (const DataArray& array : dataset.arrays)
    check_array(array, num_samples(lattice_of(dataset.lattice, array).dims), "samples");
}

void check_cells(const Dataset& dataset) {
  const Cells& cells = dataset.cells;
  if (cells.is_structured()) {
    if (checked_product(cells.dims) != dataset.num_positions())
      refuse(
          fmt::format("{} nodes of a grid of {}", dataset.num_positions(), dims_text(cells.dims)));
  } else if (!cells.types.empty() &&
             (cells.offsets.size() != cells.types.size() + 1 ||
              cells.offsets.back() != static_cast<std::int64_t>(cells.connectivity.size()))) {
    refuse("cells whose nodes are not there");
  }
}

}  // namespace

void check_dataset(const Dataset& dataset) {
  check_steps(dataset);
  if (dataset.kind == DatasetKind::kLattice) return check_lattice(dataset);
  check_points(dataset.positions, "positions");
  check_array(dataset.positions, dataset.num_positions(), "positions");
  if (dataset.kind == DatasetKind::kBoxes) {
    check_points(dataset.box_sizes, "sizes of boxes");
    if (dataset.box_sizes.type != ScalarType::kFloat64)
      refuse("sizes of boxes that are no float64");
    check_array(dataset.box_sizes, dataset.num_positions(), "boxes");
  }
  if (dataset.kind == DatasetKind::kMesh) check_cells(dataset);
  for (const DataArray& array : dataset.arrays) {
    const bool is_of_cells = array.is_cell_data && dataset.kind == DatasetKind::kMesh;
    check_array(array, is_of_cells ? dataset.cells.count() : dataset.num_positions(),
                is_of_cells ? "cells" : "places");
  }
}

}  // namespace ovoid::io
