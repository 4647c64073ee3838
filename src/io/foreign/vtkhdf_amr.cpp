// SPDX-License-Identifier: Apache-2.0
// VTKHDF's adaptive grids: levels of boxes of cells, whose numbers lie one box behind the other.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "data/scalar_visit.h"
#include "io/core/samples.h"
#include "io/foreign/vtkhdf_arrays.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr int kMostLevels = 1000;

// Names of version 2.2 lack a letter.
std::string name_in_steps(const VtkHdfGroup& group, const std::string& name,
                          const std::string& older) {
  return group.has(name) ? name : older;
}

class VtkHdfLevel {
 public:
  VtkHdfLevel(const VtkHdfGroup& group, int level, const Vec3& origin,
              std::optional<VtkHdfGroup> steps, const VtkHdfRead& read)
      : group_(group), level_(level), origin_(origin), steps_(std::move(steps)), read_(read) {}

  void add_grids(std::vector<AmrGrid>& grids) {
    const Hdf5Objects& objects = group_.objects();
    const std::vector<double> spacing = objects.numbers(group_.id(), group_.place(), "Spacing", 3);
    const VtkHdfArray& boxes = group_.needed("AMRBox");
    std::int64_t first = 0, count = boxes.num_rows();
    if (steps_) {
      first = steps_->count_at(name_in_steps(*steps_, "AMRBoxOffsets", "AMRBoxOffset"), read_.step);
      count = steps_->count_at(name_in_steps(*steps_, "NumberOfAMRBoxes", "NumberOfAMRBox"),
                               read_.step);
    }
    const DataArray numbers = boxes.rows(first, count, *read_.progress);
    if (count > 0 && numbers.num_components != 6)
      objects.fail(fmt::format("'{}' has {} numbers a box: expected 6", boxes.place(),
                               numbers.num_components));
    for (std::int64_t box = 0; box < count; ++box)
      add_grid(numbers, box, Vec3(spacing[0], spacing[1], spacing[2]), grids);
  }

 private:
  void add_grid(const DataArray& numbers, std::int64_t box, const Vec3& spacing,
                std::vector<AmrGrid>& grids) {
    LatticePart part;
    std::int64_t num_nodes = 1, num_cells = 1;
    Vec3 first;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto lo = number(numbers, 6 * box + 2 * static_cast<std::int64_t>(axis));
      const auto hi = number(numbers, 6 * box + 2 * static_cast<std::int64_t>(axis) + 1);
      // A box without cells along an axis is flat there.
      const std::int64_t size = hi - lo + 1;
      if (size < 0 || size > kMaxAxisSize - 1)
        group_.objects().fail(
            fmt::format("'{}/AMRBox': box {} goes from {} to {}", group_.place(), box, lo, hi));
      part.lattice.dims[axis] = size + 1;
      first[static_cast<Eigen::Index>(axis)] = static_cast<double>(lo);
    }
    const std::string where = fmt::format("{}: '{}'", group_.objects().name(), group_.place());
    num_nodes = checked_num_bytes(where, part.lattice.dims, ScalarType::kUInt8);
    for (const std::int64_t size : part.lattice.dims)
      num_cells *= std::max<std::int64_t>(1, size - 1);
    part.lattice.world_from_index.linear() = spacing.asDiagonal();
    part.lattice.world_from_index.translation() = origin_ + spacing.cwiseProduct(first);
    add_arrays(part, "PointData", false, nodes_before_, num_nodes);
    add_arrays(part, "CellData", true, cells_before_, num_cells);
    nodes_before_ += num_nodes;
    cells_before_ += num_cells;
    grids.push_back(amr_grid_of_lattice(where, level_, part));
  }

  std::int64_t number(const DataArray& numbers, std::int64_t index) const {
    return data::visit_scalar(numbers.type, [&]<class T>(std::type_identity<T>) {
      const auto value =
          static_cast<double>(data::load_scalar<T>(numbers.bytes.view.data(), index));
      if (!(std::abs(value) <= static_cast<double>(kMaxAxisSize)) || value != std::floor(value))
        group_.objects().fail(
            fmt::format("'{}/AMRBox': {}: expected a whole number", group_.place(), value));
      return static_cast<std::int64_t>(value);
    });
  }

  void add_arrays(LatticePart& part, const char* name, bool is_cell_data, std::int64_t before,
                  std::int64_t count) const {
    std::vector<DataArray> arrays = read_vtkhdf_arrays(
        group_, name, is_cell_data, read_,
        [&](const std::string& array_name, const VtkHdfArray& array) {
          std::int64_t first = before;
          if (steps_) {
            const std::string offsets = name_in_steps(*steps_, fmt::format("{}Offsets", name),
                                                      fmt::format("{}Offset", name));
            const auto group = steps_->group(offsets);
            if (!group)
              group_.objects().fail(fmt::format("'{}/{}' is missing", steps_->place(), offsets));
            first += group->count_at(array_name, read_.step);
          }
          return array.rows(first, count, *read_.progress);
        });
    for (DataArray& array : arrays) part.arrays.push_back(std::move(array));
  }

  const VtkHdfGroup& group_;
  int level_;
  Vec3 origin_;
  std::optional<VtkHdfGroup> steps_;
  const VtkHdfRead& read_;
  std::int64_t nodes_before_ = 0, cells_before_ = 0;
};

}  // namespace

std::vector<AmrGrid> read_vtkhdf_amr(const VtkHdfGroup& group, const VtkHdfSteps& steps,
                                     const VtkHdfRead& read) {
  const std::vector<double> origin =
      group.objects().numbers(group.id(), group.place(), "Origin", 3);
  std::vector<AmrGrid> grids;
  for (int level = 0; level < kMostLevels; ++level) {
    const auto own = group.group(fmt::format("Level{}", level));
    if (!own) break;
    auto own_steps = steps.level(level);
    if (!steps.is_static() && !own_steps) break;
    VtkHdfLevel(*own, level, Vec3(origin[0], origin[1], origin[2]), std::move(own_steps), read)
        .add_grids(grids);
  }
  const auto level = group.group("Level0");
  const auto nodes = level ? level->group("PointData") : std::nullopt;
  if (nodes && !nodes->members().empty()) {
    read.notes->push_back(
        fmt::format("{}: values of nodes are drawn as boxes, by the mean of each cell's corners",
                    group.objects().name()));
  }
  return grids;
}

}  // namespace ovoid::io
#endif
