// SPDX-License-Identifier: Apache-2.0
// Kernels of many processes, sorted into bricks. All count their kernels in the cells of an octree,
// add up the counts, and cut the tree as far as these tell: the same tree for each of them. What is
// below a cell is cut by the process that gets its kernels.
#include "model/team/team_bricks.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "data/kernels/kernel_bricks.h"
#include "data/kernels/kernel_shape.h"
#include "data/kernels/letters.h"
#include "data/kernels/resident_kernels.h"
#include "data/kernels/team_source.h"
#include "model/team/team_run.h"
#include "ovoid/kernel_team.h"

namespace ovoid::model {
namespace {

using data::KernelGroup;

// Of all kernels of some size: a size class of theirs, or a cell of the octree that its curve
// follows.
struct Cell {
  std::int32_t size_class = 0;
  float least_sigma = std::numeric_limits<float>::infinity();
  std::uint64_t key = 0;  // of a cell: the first on the curve
  std::int64_t count = 0;
  Bounds3 centers;

  std::pair<std::int32_t, std::uint64_t> place() const { return {size_class, key}; }
  void add(const Cell& other) {
    least_sigma = std::min(least_sigma, other.least_sigma);
    count += other.count;
    centers.extend(other.centers);
  }
};

// Cells at one place as one, in the order of the curve.
std::vector<Cell> merged(std::vector<Cell> cells) {
  std::stable_sort(cells.begin(), cells.end(),
                   [](const Cell& a, const Cell& b) { return a.place() < b.place(); });
  std::vector<Cell> out;
  for (const Cell& cell : cells) {
    if (!out.empty() && out.back().place() == cell.place()) {
      out.back().add(cell);
    } else {
      out.push_back(cell);
    }
  }
  return out;
}

// Kernels that are cut into bricks together: of the cells [first, last).
struct Unit {
  KernelGroup::Kind kind;
  std::size_t first, last;
  std::int64_t count;
  data::MortonCube cube;
  int process = 0;
};

// Cuts the cells of one class, as far as they tell.
class CellCutter {
 public:
  CellCutter(std::span<const Cell> cells, const data::MortonCube& cube, std::vector<Unit>& units)
      : cells_(cells), cube_(cube), units_(units) {}

  std::uint64_t key(std::size_t i) const { return cells_[i].key; }
  bool fits(std::size_t begin, std::size_t end) const {
    const Cell all = sum_of(begin, end);
    return data::fits_a_brick(all.count, all.centers, all.least_sigma);
  }
  void add_brick(std::size_t begin, std::size_t end) { add(KernelGroup::Kind::kBrick, begin, end); }
  void cut_below(std::size_t begin, std::size_t end) { add(KernelGroup::Kind::kNode, begin, end); }

 private:
  Cell sum_of(std::size_t begin, std::size_t end) const {
    Cell all;
    for (std::size_t i = begin; i < end; ++i) {
      all.add(cells_[i]);
      if (all.count > KernelBrick::kMaxBrickKernels) break;  // more is not asked for
    }
    return all;
  }
  void add(KernelGroup::Kind kind, std::size_t begin, std::size_t end) {
    std::int64_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += cells_[i].count;
    units_.push_back({kind, begin, end, count, cube_});
  }

  std::span<const Cell> cells_;
  const data::MortonCube& cube_;
  std::vector<Unit>& units_;
};

class BrickSharing {
 public:
  BrickSharing(const ModelRun& run, KernelParts parts)
      : run_(run), parts_(std::move(parts)), num_all_(total_of(run, num_own())) {
    make_alike();
    for (std::size_t i = 0; i < parts_.count(); ++i) {
      const Vec3 axes = data::semi_axes(parts_.shape, parts_.shapes.data() + num_shapes() * i);
      extents_.push_back({static_cast<float>(axes[0]), static_cast<float>(axes[2])});
    }
    find_classes();
    find_cells();
    cut_cells();
    assign_units();
  }

  std::shared_ptr<const KernelSource> make(std::int64_t kept_bytes) {
    data::TeamSet set{parts_.shape, parts_.profile, parts_.cutoff, parts_.attributes};
    receive(run_.team->exchange(letters()));
    std::shared_ptr<const KernelSource> own;
    if (!has_weights_) parts_.weights = {shared_weight_};
    if (parts_.count() > 0) own = data::resident_kernels(columns_of(parts_), groups_, run_.threads);
    parts_ = {};
    return data::make_team_source(std::move(set), std::move(own), run_.team, kept_bytes);
  }

 private:
  std::int64_t num_own() const { return static_cast<std::int64_t>(parts_.count()); }
  std::size_t num_shapes() const {
    return static_cast<std::size_t>(num_shape_numbers(parts_.shape));
  }

  // A column that holds one number for all does so in all processes, or in none.
  void make_alike() {
    const std::size_t count = parts_.count();
    const bool has_own = parts_.weights.size() != 1;
    has_weights_ = least_of(run_, count > 0 && (has_own || count == 1) ? -1 : 0) < 0;
    shared_weight_ = parts_.weights.empty() ? 0.0F : parts_.weights[0];
    shared_weight_ = greatest_of(run_, shared_weight_);  // who has no kernels may have none
    if (has_weights_ && !has_own) parts_.weights.assign(count, float{parts_.weights[0]});
    if (parts_.shapes.size() == num_shapes() && count > 1) {
      const std::vector<float> one = std::move(parts_.shapes);
      parts_.shapes.clear();
      for (std::size_t i = 0; i < count; ++i)
        parts_.shapes.insert(parts_.shapes.end(), one.begin(), one.end());
    }
    for (std::size_t a = 0; a < parts_.ranges.size(); ++a)
      parts_.attributes[a].range = parts_.ranges[a];
  }

  void find_classes() {
    std::map<std::int32_t, Cell> own;
    for (std::size_t i = 0; i < parts_.count(); ++i) add_to(own[class_of(i)], i, 0);
    std::vector<Cell> list;
    list.reserve(own.size());
    for (const auto& [size_class, cell] : own) list.push_back(cell);
    classes_ = merged(joined(run_, std::move(list)));
    for (const Cell& one : classes_) {
      const auto cube = data::MortonCube::around(one.centers);
      cubes_.push_back(one.count > 1 ? cube : std::nullopt);
    }
  }

  std::int32_t class_of(std::size_t i) const { return data::size_class(extents_[i].greatest); }

  void add_to(Cell& cell, std::size_t i, std::uint64_t key) const {
    Cell one;
    one.least_sigma = extents_[i].least;
    one.count = 1;
    one.centers.extend(parts_.center(i));
    cell.add(one);
    cell.size_class = class_of(i);
    cell.key = key;
  }

  std::size_t number_of_class(std::int32_t size_class) const {
    return static_cast<std::size_t>(
        std::lower_bound(classes_.begin(), classes_.end(), size_class,
                         [](const Cell& a, std::int32_t b) { return a.size_class < b; }) -
        classes_.begin());
  }

  // The first key of a kernel's cell. Without a curve there is one cell.
  std::uint64_t cell_key(std::size_t i) const {
    const std::optional<data::MortonCube>& cube = cubes_[number_of_class(class_of(i))];
    return cube ? cube->key_of(parts_.center(i)) >> below_cells_ << below_cells_ : 0;
  }

  void find_cells() {
    // Cells of some thousand kernels, where these lie evenly.
    constexpr std::int64_t kCellKernels = 2048;
    constexpr int kMostLevels = 7;
    int levels = 1;
    while (levels < kMostLevels && num_all_ >> (3 * levels) > kCellKernels) ++levels;
    below_cells_ = data::kKeyBits - 3 * levels;
    std::map<std::pair<std::int32_t, std::uint64_t>, Cell> own;
    for (std::size_t i = 0; i < parts_.count(); ++i) {
      const std::uint64_t key = cell_key(i);
      add_to(own[{class_of(i), key}], i, key);
    }
    std::vector<Cell> list;
    list.reserve(own.size());
    for (const auto& [place, cell] : own) list.push_back(cell);
    cells_ = merged(joined(run_, std::move(list)));
  }

  void cut_cells() {
    std::size_t begin = 0;
    for (std::size_t c = 0; c < classes_.size(); ++c) {
      std::size_t end = begin;
      while (end < cells_.size() && cells_[end].size_class == classes_[c].size_class) ++end;
      if (cubes_[c]) {
        CellCutter cutter(cells_, *cubes_[c], units_);
        data::NodeCutter(cutter, below_cells_).cut(begin, end, data::kKeyBits);
      } else {
        units_.push_back({KernelGroup::Kind::kClass, begin, end, classes_[c].count, {}});
      }
      begin = end;
    }
  }

  // About as many kernels for each process.
  void assign_units() {
    std::int64_t before = 0;
    unit_of_cell_.resize(cells_.size());
    for (std::size_t u = 0; u < units_.size(); ++u) {
      Unit& unit = units_[u];
      const auto middle = static_cast<double>(before) + 0.5 * static_cast<double>(unit.count);
      unit.process =
          std::min(static_cast<int>(middle * run_.team->count() / static_cast<double>(num_all_)),
                   run_.team->count() - 1);
      before += unit.count;
      std::fill(unit_of_cell_.begin() + static_cast<std::ptrdiff_t>(unit.first),
                unit_of_cell_.begin() + static_cast<std::ptrdiff_t>(unit.last), u);
    }
  }

  std::size_t unit_of(std::size_t i) const {
    const std::pair place(class_of(i), cell_key(i));
    const auto cell = std::lower_bound(cells_.begin(), cells_.end(), place,
                                       [](const Cell& a, const auto& b) { return a.place() < b; });
    return unit_of_cell_[static_cast<std::size_t>(cell - cells_.begin())];
  }

  // Calls visit(column, width) for each column that has numbers for each kernel.
  template <class Visit>
  void for_each_column(const Visit& visit) {
    visit(parts_.centers, std::size_t{3});
    visit(parts_.shapes, num_shapes());
    if (has_weights_) visit(parts_.weights, std::size_t{1});
    for (std::vector<float>& column : parts_.values) visit(column, std::size_t{1});
  }

  // Kernels by process. Each column goes as soon as it is written.
  KernelTeam::Letters letters() {
    const auto num_processes = static_cast<std::size_t>(run_.team->count());
    data::RowLists lists(num_processes);
    data::RowLists units(num_processes);
    for (std::size_t i = 0; i < parts_.count(); ++i) {
      const std::size_t unit = unit_of(i);
      const auto process = static_cast<std::size_t>(units_[unit].process);
      lists[process].push_back(static_cast<std::uint32_t>(i));
      units[process].push_back(static_cast<std::uint32_t>(unit));
    }
    extents_ = {};
    KernelTeam::Letters letters = data::letters_of(lists, kernel_bytes());
    for (std::size_t p = 0; p < num_processes; ++p)
      data::append(letters[p], std::span<const std::uint32_t>(units[p]));
    units = {};
    for_each_column(
        [&](auto& column, std::size_t width) { data::append_rows(letters, lists, width, column); });
    return letters;
  }

  // On their way, with the number of the unit.
  std::size_t kernel_bytes() {
    std::size_t bytes = sizeof(std::uint32_t);
    for_each_column(
        [&](const auto& column, std::size_t width) { bytes += width * sizeof(column[0]); });
    return bytes;
  }

  void receive(KernelTeam::Letters received) {
    std::size_t num_kernels = 0;
    for (const data::Letter& letter : received) num_kernels += letter.size() / kernel_bytes();
    std::vector<std::uint32_t> units;
    units.reserve(num_kernels);
    for_each_column([&](auto& column, std::size_t width) { column.reserve(width * num_kernels); });
    for (data::Letter& letter : received) {
      const std::size_t count = letter.size() / kernel_bytes();
      data::LetterReader reader(letter);
      reader.take(count, units);
      for_each_column([&](auto& column, std::size_t width) { reader.take(width * count, column); });
      letter = {};
    }
    // Unit by unit.
    std::vector<std::uint32_t> order(units.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return units[a] < units[b]; });
    for_each_column([&](auto& column, std::size_t width) {
      using Column = std::remove_cvref_t<decltype(column)>;
      Column sorted;
      sorted.reserve(column.size());
      for (const std::size_t i : order) {
        for (std::size_t c = 0; c < width; ++c) sorted.push_back(column[width * i + c]);
      }
      column = std::move(sorted);
    });
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
      const Unit& unit = units_[units[order[begin]]];
      end = begin + static_cast<std::size_t>(unit.count);
      groups_.push_back({unit.kind, begin, end, unit.cube, below_cells_});
    }
  }

  const ModelRun& run_;
  KernelParts parts_;
  std::int64_t num_all_;
  bool has_weights_ = false;
  float shared_weight_ = 0;
  std::vector<data::KernelExtent> extents_;
  std::vector<Cell> classes_;
  std::vector<std::optional<data::MortonCube>> cubes_;  // of the classes; none: no curve
  int below_cells_ = 0;                                 // bits of keys that tell places in a cell
  std::vector<Cell> cells_;
  std::vector<Unit> units_;
  std::vector<std::size_t> unit_of_cell_;
  std::vector<KernelGroup> groups_;
};

}  // namespace

std::shared_ptr<const KernelSource> share_in_bricks(const ModelRun& run, KernelParts parts,
                                                    std::int64_t kept_bytes) {
  return BrickSharing(run, std::move(parts)).make(kept_bytes);
}

}  // namespace ovoid::model
