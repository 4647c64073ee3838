// SPDX-License-Identifier: Apache-2.0
// In: surfaces, and a lattice. Out: the lattice, grown to hold them, and what they absorb in each
// cell that they pass through.
//
// Along each axis of the lattice 16 rays go through every column of cells, and meet triangles.
// Columns are dealt out in bands: a task collects what the rays of a band cross, puts it in order
// by column, and adds what comes of a column to its cells. The columns of one axis share no cells,
// and axes follow each other, so that the number of threads cannot be seen in the sums.
#include "render/light/surface_extinction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "data/parallel.h"

namespace ovoid {
namespace {

constexpr int kRaysOfColumn = 16;
constexpr std::int64_t kBands = 16;
constexpr std::int64_t rows_of_band(std::int64_t rows) { return (rows + kBands - 1) / kBands; }
// Cells behind each other that are covered as one: a surface across the axis, up to 45 degrees
// from it, passes through at most three of a column.
constexpr std::int64_t kMostCovered = 4;
// Cells around surfaces: they are spread into one, and their light is read two away (kEdgesAway).
constexpr double kRoom = 3;
constexpr double kGoldenShift = 0.6180339887498949;  // its multiples' fractions are spread evenly

// The bands, across each axis, that a triangle lies in; none: the first is behind the last.
struct TriangleBands {
  std::array<std::uint8_t, 3> first{1, 1, 1}, last{0, 0, 0};
};

// A surface in cells' coordinates, in which cell (i, j, k) is the cube from (i, j, k) on.
struct CellSurface {
  const Surface* surface;
  float through;  // of light, through a layer
  std::vector<Vec3> places;
  std::vector<TriangleBands> bands;  // of each triangle

  void find_bands(const Index3& dims, int threads, const std::stop_token& stop) {
    bands.assign(surface->triangles.size(), {});
    constexpr std::int64_t kGrain = 1 << 14;
    data::parallel_ranges({static_cast<std::int64_t>(bands.size()), kGrain, threads, stop},
                          [&](std::int64_t begin, std::int64_t end) {
                            for (std::int64_t i = begin; i < end; ++i) {
                              const auto at = static_cast<std::size_t>(i);
                              if (can_be_met(surface->triangles[at]))
                                bands[at] = bands_of(surface->triangles[at], dims);
                            }
                          });
  }

 private:
  bool can_be_met(const Surface::Triangle& triangle) const {
    return std::all_of(triangle.values.begin(), triangle.values.end(),
                       [](float value) { return !std::isnan(value); }) &&
           std::all_of(triangle.corners.begin(), triangle.corners.end(),
                       [&](std::uint32_t corner) { return places[corner].allFinite(); });
  }

  TriangleBands bands_of(const Surface::Triangle& triangle, const Index3& dims) const {
    TriangleBands out;
    Bounds3 box;
    for (const std::uint32_t corner : triangle.corners) box.extend(places[corner]);
    for (std::size_t a = 0; a < 3; ++a) {
      const int axis = static_cast<int>(a);
      const auto rows = static_cast<double>(dims[a]);
      if (!(box.max()[axis] >= 0 && box.min()[axis] <= rows)) return {};
      const auto band_of = [&](double at) {
        const auto row = static_cast<std::int64_t>(std::clamp(at, 0.0, rows - 1));
        return static_cast<std::uint8_t>(row / rows_of_band(dims[a]));
      };
      out.first[a] = band_of(box.min()[axis]);
      out.last[a] = band_of(box.max()[axis]);
    }
    return out;
  }
};

// Of a cell.
struct CellSums {
  std::array<float, 3> crossings{};  // along each axis: of a ray, on average
  std::array<float, 3> products{};   // of the normals' components there: yz, zx, xy
  float depth = 0;                   // optical, times crossings, over the axes

  float squares() const {
    return crossings[0] * crossings[0] + crossings[1] * crossings[1] + crossings[2] * crossings[2];
  }
};

// A ray of a column meets a surface.
struct Crossing {
  std::uint32_t column;  // of the band
  std::int32_t cell;     // along the axis
  std::uint8_t ray;
  float through;
  float next, other;  // components of the normal along the two other axes; it points forward
};

// The lattice's axes as one walk goes: along rays, from ray to ray of a row, from row to row.
struct WalkAxes {
  int along, next, other;
};
constexpr std::array<WalkAxes, 3> kWalks = {{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}};

class ColumnWalk {
 public:
  ColumnWalk(const std::vector<CellSurface>& surfaces, const Index3& dims, const WalkAxes& axes,
             std::vector<CellSums>& sums)
      : surfaces_(surfaces),
        axes_(axes),
        depth_(dim(dims, axes.along)),
        width_(dim(dims, axes.next)),
        height_(dim(dims, axes.other)),
        rows_of_band_(rows_of_band(height_)),
        sums_(sums) {
    for (std::int64_t row = 0; row < height_ * kRaysOfColumn; ++row) {
      const double turns = static_cast<double>(row) * kGoldenShift;
      shifts_.push_back(turns - std::floor(turns));
    }
    const std::array<std::int64_t, 3> strides{1, dims[0], dims[0] * dims[1]};
    stride_along_ = strides[static_cast<std::size_t>(axes.along)];
    stride_next_ = strides[static_cast<std::size_t>(axes.next)];
    stride_other_ = strides[static_cast<std::size_t>(axes.other)];
  }

  std::int64_t num_bands() const { return (height_ + rows_of_band_ - 1) / rows_of_band_; }

  void add_band(std::int64_t band, const std::stop_token& stop) const {
    const std::int64_t begin = band * rows_of_band_;
    const std::int64_t end = std::min(height_, begin + rows_of_band_);
    std::vector<Crossing> crossings;
    const auto across = static_cast<std::size_t>(axes_.other);
    for (const CellSurface& surface : surfaces_) {
      for (std::size_t i = 0; i < surface.bands.size(); ++i) {
        constexpr std::size_t kBetweenLooks = 1 << 16;
        if (i % kBetweenLooks == 0 && stop.stop_requested()) return;
        const TriangleBands& of = surface.bands[i];
        if (of.first[across] > band || of.last[across] < band) continue;
        const auto& corners = surface.surface->triangles[i].corners;
        cross(
            {&surface.places[corners[0]], &surface.places[corners[1]], &surface.places[corners[2]]},
            surface.through, begin, end, crossings);
      }
    }
    add_columns(begin, end, crossings);
  }

 private:
  static std::int64_t dim(const Index3& dims, int axis) {
    return dims[static_cast<std::size_t>(axis)];
  }

  // A triangle, as rows of rays meet it.
  class Walked {
   public:
    Walked(const std::array<const Vec3*, 3>& corners, const WalkAxes& axes)
        : corners_(corners), axes_(axes) {
      const auto [first, last] = range(axes.other);
      const auto [left, right] = range(axes.next);
      first_ = first;
      last_ = last;
      left_ = left;
      right_ = right;
    }

    double first() const { return first_; }
    double last() const { return last_; }
    double left() const { return left_; }
    double right() const { return right_; }

    // Where a row's part of it begins and ends. Half open, and a side is the same for the triangle
    // beyond, so that a ray between two meets one.
    std::pair<double, double> part_at(double row) const {
      double left = std::numeric_limits<double>::infinity(), right = -left;
      for (std::size_t side = 0; side < 3; ++side) {
        const Vec3* low = corners_[side];
        const Vec3* high = corners_[(side + 1) % 3];
        if ((*low)[axes_.other] > (*high)[axes_.other]) std::swap(low, high);
        const double begin = (*low)[axes_.other], end = (*high)[axes_.other];
        if (!(begin <= row && row < end)) continue;
        const double place = (*low)[axes_.next] + (row - begin) / (end - begin) *
                                                      ((*high)[axes_.next] - (*low)[axes_.next]);
        left = std::min(left, place);
        right = std::max(right, place);
      }
      return {left, right};
    }

    // Along the ray, no further than it reaches. It faces along.
    double place_at(const Vec3& across, double next, double other) const {
      const Vec3& corner = *corners_[0];
      const double slanted = across[axes_.next] * (next - corner[axes_.next]) +
                             across[axes_.other] * (other - corner[axes_.other]);
      const auto [nearest, farthest] = range(axes_.along);
      return std::clamp(corner[axes_.along] - slanted / across[axes_.along], nearest, farthest);
    }

    Vec3 across() const { return (*corners_[1] - *corners_[0]).cross(*corners_[2] - *corners_[0]); }

   private:
    std::pair<double, double> range(int axis) const {
      const double a = (*corners_[0])[axis], b = (*corners_[1])[axis], c = (*corners_[2])[axis];
      return {std::min(a, std::min(b, c)), std::max(a, std::max(b, c))};
    }

    const std::array<const Vec3*, 3>& corners_;
    const WalkAxes& axes_;
    double first_, last_, left_, right_;
  };

  // The least whole number that is not less.
  static std::int64_t up(double number) {
    const auto whole = static_cast<std::int64_t>(number);
    return whole + (static_cast<double>(whole) < number ? 1 : 0);
  }

  void cross(const std::array<const Vec3*, 3>& corners, float through, std::int64_t begin,
             std::int64_t end, std::vector<Crossing>& crossings) const {
    const Walked triangle(corners, axes_);
    const auto row_from = [&](double at) {
      return up(std::clamp(at * kRaysOfColumn - 0.5, static_cast<double>(begin * kRaysOfColumn),
                           static_cast<double>(end * kRaysOfColumn)));
    };
    const auto ray_from = [&](double at) {
      return up(std::clamp(at, 0.0, static_cast<double>(width_)));
    };
    const std::int64_t row_end = row_from(triangle.last());
    for (std::int64_t row = row_from(triangle.first()); row < row_end; ++row) {
      const double shift = shifts_[static_cast<std::size_t>(row)];
      if (ray_from(triangle.left() - shift) >= ray_from(triangle.right() - shift)) continue;
      const double at = (static_cast<double>(row) + 0.5) / kRaysOfColumn;
      const auto [left, right] = triangle.part_at(at);
      const std::int64_t ray_end = ray_from(right - shift);
      for (std::int64_t i = ray_from(left - shift); i < ray_end; ++i)
        meet(triangle, static_cast<double>(i) + shift, at,
             {static_cast<std::uint32_t>((row / kRaysOfColumn - begin) * width_ + i), 0,
              static_cast<std::uint8_t>(row % kRaysOfColumn), through, 0, 0},
             crossings);
    }
  }

  // The ray at that place meets the triangle.
  void meet(const Walked& triangle, double next, double other, Crossing crossing,
            std::vector<Crossing>& crossings) const {
    const Vec3 across = triangle.across();
    const double length = across.norm();
    const double facing = across[axes_.along];
    if (!(length > 0) || facing == 0) return;
    const double place = triangle.place_at(across, next, other);
    if (!(place >= 0 && place < static_cast<double>(depth_))) return;
    const double forward = (facing > 0 ? 1 : -1) / length;
    crossing.cell = static_cast<std::int32_t>(place);
    crossing.next = static_cast<float>(across[axes_.next] * forward);
    crossing.other = static_cast<float>(across[axes_.other] * forward);
    crossings.push_back(crossing);
  }

  void add_columns(std::int64_t begin, std::int64_t end,
                   const std::vector<Crossing>& crossings) const {
    const auto num_columns = static_cast<std::size_t>((end - begin) * width_);
    std::vector<std::size_t> first(num_columns + 1, 0);
    for (const Crossing& crossing : crossings) ++first[crossing.column + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Crossing> ordered(crossings.size());
    std::vector<std::size_t> to(first.begin(), first.end() - 1);
    for (const Crossing& crossing : crossings) ordered[to[crossing.column]++] = crossing;
    Column column(static_cast<std::size_t>(depth_));
    for (std::size_t i = 0; i < num_columns; ++i) {
      if (first[i] == first[i + 1]) continue;
      const auto at = static_cast<std::int64_t>(i);
      column.fill(std::span(ordered).subspan(first[i], first[i + 1] - first[i]));
      add(column, (begin + at / width_) * stride_other_ + at % width_ * stride_next_);
    }
  }

  // What its rays cross, cell by cell.
  struct Column {
    std::vector<float> crossings, depth, next, other;
    std::int64_t lo = 0, hi = 0;  // cells in which something is

    explicit Column(std::size_t count)
        : crossings(count, 0.0F), depth(count, 0.0F), next(count, 0.0F), other(count, 0.0F) {}

    void fill(std::span<Crossing> crossed) {
      std::stable_sort(crossed.begin(), crossed.end(),
                       [](const Crossing& a, const Crossing& b) { return a.cell < b.cell; });
      constexpr float kShare = 1.0F / kRaysOfColumn;
      for (const Crossing& one : crossed) {
        const auto k = static_cast<std::size_t>(one.cell);
        crossings[k] += kShare;
        next[k] += kShare * one.next;
        other[k] += kShare * one.other;
      }
      for (std::size_t i = 0; i < crossed.size();) {
        std::size_t behind = i + 1;
        while (behind < crossed.size() && crossed[behind].cell <= crossed[behind - 1].cell + 2)
          ++behind;
        cover(crossed.subspan(i, behind - i));
        i = behind;
      }
      lo = crossed.front().cell;
      hi = crossed.back().cell + 1;
    }

   private:
    // Cells behind each other, all of which surfaces pass through, a few at a time.
    void cover(std::span<const Crossing> run) {
      const std::int64_t begin = run.front().cell;
      const std::int64_t count = run.back().cell + 1 - begin;
      const std::int64_t parts = (count + kMostCovered - 1) / kMostCovered;
      for (std::int64_t part = 0; part < parts; ++part) {
        const std::int64_t from = begin + count * part / parts;
        const std::int64_t to = begin + count * (part + 1) / parts;
        const auto is_before = [](const Crossing& one, std::int64_t cell) {
          return one.cell < cell;
        };
        cover_part({std::lower_bound(run.begin(), run.end(), from, is_before),
                    std::lower_bound(run.begin(), run.end(), to, is_before)},
                   from, to);
      }
    }

    // What each ray crosses lets light through; what the rays let through together is the part's.
    void cover_part(std::span<const Crossing> part, std::int64_t from, std::int64_t to) {
      std::array<float, kRaysOfColumn> through;
      through.fill(1);
      for (const Crossing& one : part) through[one.ray] *= one.through;
      const double mean = std::accumulate(through.begin(), through.end(), 0.0) / kRaysOfColumn;
      const double all = -std::log(std::max(mean, std::exp(-kOpaqueExtinction)));
      const double of_each = all * kRaysOfColumn / static_cast<double>(part.size());
      for (std::int64_t k = from; k < to; ++k) {
        const auto at = static_cast<std::size_t>(k);
        depth[at] = static_cast<float>(of_each * crossings[at]);
      }
    }
  };

  // Adds to the cells from `first` on, and empties the column.
  void add(Column& column, std::int64_t first) const {
    for (std::int64_t k = column.lo; k < column.hi; ++k) {
      const auto at = static_cast<std::size_t>(k);
      CellSums& sums = sums_[static_cast<std::size_t>(first + k * stride_along_)];
      sums.crossings[static_cast<std::size_t>(axes_.along)] = column.crossings[at];
      sums.depth += column.crossings[at] * column.depth[at];
      // A product of two axes has the place of the third, and is the mean of what both say.
      sums.products[static_cast<std::size_t>(axes_.other)] += 0.5F * column.next[at];
      sums.products[static_cast<std::size_t>(axes_.next)] += 0.5F * column.other[at];
      column.crossings[at] = column.depth[at] = column.next[at] = column.other[at] = 0;
    }
  }

  const std::vector<CellSurface>& surfaces_;
  const WalkAxes axes_;
  const std::int64_t depth_, width_, height_, rows_of_band_;
  std::int64_t stride_along_ = 1, stride_next_ = 1, stride_other_ = 1;
  std::vector<CellSums>& sums_;
  std::vector<double> shifts_;  // of the rays of each row, in cells
};

// What a cell absorbs: as along all axes the same, the depth of a crossing.
struct SpreadSums {
  std::array<float, 3> crossings{}, products{};
  float area = 0, depth = 0;  // of what is crossed, and of that area

  void add(const CellSums& sums, float share) {
    const float squares = sums.squares();
    const float own_area = share * std::sqrt(squares);
    area += own_area;
    depth += own_area * sums.depth / squares;
    for (std::size_t a = 0; a < 3; ++a) {
      crossings[a] += share * sums.crossings[a];
      products[a] += share * sums.products[a];
    }
  }

  CrossedCell crossed_cell(const std::array<std::int32_t, 3>& cell) const {
    CrossedCell out{cell, {}};
    const float each = depth / area;
    for (std::size_t a = 0; a < 3; ++a) {
      out.form[a] = each * each * crossings[a] * crossings[a];
      const float most = each * each * crossings[(a + 1) % 3] * crossings[(a + 2) % 3];
      out.form[3 + a] = std::clamp(each * depth * products[a], -most, most);
    }
    return out;
  }
};

// Half of each cell goes to its neighbours, most along the axes that it is crossed most along, so
// that what lies aslant has no gaps.
std::vector<CrossedCell> spread(const std::vector<CellSums>& sums, const Index3& dims) {
  const std::array<std::int64_t, 3> strides{1, dims[0], dims[0] * dims[1]};
  constexpr std::int32_t kNone = -1;
  constexpr float kLeastShare = 0.005F;  // without which nothing would be seen to be missing
  std::vector<std::int32_t> number(sums.size(), kNone);
  std::vector<SpreadSums> spread_sums;
  const auto add = [&](std::int64_t cell, const CellSums& own, float share) {
    std::int32_t& at = number[static_cast<std::size_t>(cell)];
    if (at == kNone) {
      at = static_cast<std::int32_t>(spread_sums.size());
      spread_sums.emplace_back();
    }
    spread_sums[static_cast<std::size_t>(at)].add(own, share);
  };
  const auto for_cells = [&](const auto& body) {
    std::int64_t cell = 0;
    for (std::int32_t z = 0; z < dims[2]; ++z) {
      for (std::int32_t y = 0; y < dims[1]; ++y) {
        for (std::int32_t x = 0; x < dims[0]; ++x, ++cell) body(cell, std::array{x, y, z});
      }
    }
  };
  for_cells([&](std::int64_t cell, const std::array<std::int32_t, 3>& place) {
    const CellSums& own = sums[static_cast<std::size_t>(cell)];
    if (!(own.depth > 0)) return;
    add(cell, own, 0.5F);
    for (std::size_t a = 0; a < 3; ++a) {
      const float share = 0.25F * own.crossings[a] * own.crossings[a] / own.squares();
      if (share < kLeastShare) continue;
      if (place[a] > 0) add(cell - strides[a], own, share);
      if (place[a] + 1 < dims[a]) add(cell + strides[a], own, share);
    }
  });
  std::vector<CrossedCell> crossed;
  crossed.reserve(spread_sums.size());
  for_cells([&](std::int64_t cell, const std::array<std::int32_t, 3>& place) {
    const std::int32_t at = number[static_cast<std::size_t>(cell)];
    if (at != kNone)
      crossed.push_back(spread_sums[static_cast<std::size_t>(at)].crossed_cell(place));
  });
  return crossed;
}

// In cells, without those whose light nobody asks for.
Bounds3 bounds_of(const std::vector<CellSurface>& surfaces, const Bounds3& most) {
  Bounds3 all;
  for (const CellSurface& surface : surfaces) {
    Bounds3 box;
    for (const Vec3& place : surface.places) {
      if (place.allFinite()) box.extend(place);
    }
    if (box.isEmpty()) continue;
    box = Bounds3(box.min() - Vec3::Constant(kRoom), box.max() + Vec3::Constant(kRoom));
    if (box.intersects(most)) all.extend(box);
  }
  return all;
}

std::int64_t cells_with(const Index3& dims, const GrownSides& sides, std::int64_t most) {
  std::int64_t cells = 1;
  for (std::size_t a = 0; a < 3; ++a)
    cells *= dims[a] + std::min(sides.before[a], most) + std::min(sides.behind[a], most);
  return cells;
}

// How many more cells the surfaces need, and how many of these there can be.
GrownSides sides_for(const std::vector<CellSurface>& surfaces, const Index3& dims) {
  const std::int64_t longest = std::max({dims[0], dims[1], dims[2]});
  std::int64_t most = longest / 2;
  const Vec3 size(static_cast<double>(dims[0]), static_cast<double>(dims[1]),
                  static_cast<double>(dims[2]));
  const Vec3 room = Vec3::Constant(static_cast<double>(most));
  const Bounds3 box = bounds_of(surfaces, Bounds3(-room, size + room));
  GrownSides sides;
  if (box.isEmpty()) return sides;
  const auto needed = [&](double beyond) {
    return static_cast<std::int64_t>(std::clamp(std::ceil(beyond), 0.0, 1.0e6));
  };
  for (std::size_t a = 0; a < 3; ++a) {
    const int axis = static_cast<int>(a);
    sides.before[a] = needed(-box.min()[axis]);
    sides.behind[a] = needed(box.max()[axis] - size[axis]);
  }
  const std::int64_t limit = std::max(kMostCellsWithSurfaces, 2 * dims[0] * dims[1] * dims[2]);
  while (most > 0 && cells_with(dims, sides, most) > limit) --most;
  const auto cut = [](std::int64_t& cells, std::int64_t to) {
    return cells > to ? (cells = to, true) : false;
  };
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t room_of_axis = std::max<std::int64_t>(0, kMostCellsOfAll - dims[a]);
    sides.is_cut_before[a] = cut(sides.before[a], std::min(most, room_of_axis / 2));
    sides.is_cut_behind[a] = cut(sides.behind[a], std::min(most, room_of_axis / 2));
  }
  return sides;
}

std::vector<CellSurface> surfaces_in_cells(std::span<const Geometry> geometry,
                                           const ExtinctionLattice& lattice) {
  const Affine3 cell_from_world = lattice.world_from_cell.inverse();
  std::vector<CellSurface> surfaces;
  for (const Geometry& one : geometry) {
    CellSurface surface{one.surface.get(), static_cast<float>(1 - one.opacity), {}, {}};
    surface.places.reserve(one.surface->places.size());
    for (const Vec3& place : one.surface->places)
      surface.places.push_back(cell_from_world * place + Vec3::Constant(0.5));
    surfaces.push_back(std::move(surface));
  }
  return surfaces;
}

}  // namespace

GrownSides add_surfaces(std::span<const Geometry> geometry, int threads,
                        const std::stop_token& stop, ExtinctionLattice& lattice) {
  std::vector<CellSurface> surfaces = surfaces_in_cells(geometry, lattice);
  const GrownSides sides = sides_for(surfaces, lattice.dims);
  lattice = grown(lattice, sides.before, sides.behind);
  const Vec3 moved(static_cast<double>(sides.before[0]), static_cast<double>(sides.before[1]),
                   static_cast<double>(sides.before[2]));
  for (CellSurface& surface : surfaces) {
    for (Vec3& place : surface.places) place += moved;
  }
  for (CellSurface& surface : surfaces) surface.find_bands(lattice.dims, threads, stop);
  std::vector<CellSums> sums(lattice.extinction.size());
  for (const WalkAxes& axes : kWalks) {
    const ColumnWalk walk(surfaces, lattice.dims, axes, sums);
    data::parallel_ranges({walk.num_bands(), 1, threads, stop},
                          [&](std::int64_t band, std::int64_t) { walk.add_band(band, stop); });
  }
  lattice.crossed = spread(sums, lattice.dims);
  return sides;
}

}  // namespace ovoid
