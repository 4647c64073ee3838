// SPDX-License-Identifier: Apache-2.0
#include "data/bookkeeping.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "data/varies.h"

namespace ovoid::data {

bool is_bookkeeping(const DataArray& array) {
  // Exodus readers and writers, VTK's id filters, and what simulations call the owner of a cell.
  constexpr std::array<std::string_view, 21> kNames{
      "GlobalNodeId",      "PedigreeNodeId", "ObjectId",        "GlobalElementId",
      "PedigreeElementId", "GlobalNodeIds",  "GlobalCellIds",   "GlobalPointIds",
      "PointIds",          "CellIds",        "SourceElementId", "SourceElementSide",
      "ElementBlockIds",   "FileId",         "GlobalIds",       "PedigreeIds",
      "ProcessId",         "BlockId",        "BlockIndex",      "node_ids",
      "element_ids"};
  return array.name.starts_with("vtk") ||
         std::find(kNames.begin(), kNames.end(), array.name) != kNames.end();
}

bool is_worth_showing(const Dataset& dataset, const std::string& name) {
  if (!name.empty() || dataset.arrays.empty()) return varies(dataset.array(name));
  const auto begin = dataset.arrays.begin(), end = dataset.arrays.end();
  const bool has_node_array = std::any_of(begin, end, [](const DataArray& array) {
    return !array.is_cell_data && !is_bookkeeping(array);
  });
  return std::any_of(begin, end, [&](const DataArray& array) {
    return !is_bookkeeping(array) && !(has_node_array && array.is_cell_data) && varies(array);
  });
}

}  // namespace ovoid::data
