// SPDX-License-Identifier: Apache-2.0
//
// Least and greatest sample in reach of every brick.
//
// Input: a linear array, x fastest. Output: one Extent per brick, and a flag per brick if samples
// are missing. The window of a brick is a box of samples and min and max are separable, so each
// axis is reduced on its own, z first: that pass combines whole rows, element by element, which the
// compiler turns into vector minima and maxima; the rows that the later passes see are fewer by the
// brick's edge each time, and only the last one, 1/16 of the array at edge 4, runs along x. A task
// is one layer of bricks in z by kTileBricks brick rows in y; its rows fit the second-level cache
// and are all that a thread holds. Tasks write different bricks and read the array only.
//
// Sublattices are taken one after the other, each into a table of its own; then tables are merged.
#include "data/lattice/brick_ranges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "data/parallel.h"

namespace ovoid::data {

namespace {

// Brick rows per task. 32 rows of edge 4 on a row of 512 uint8 samples, minima and maxima: 136 KiB
// with the margin.
constexpr std::int64_t kTileBricks = 32;

// Samples per task when counting missing ones.
constexpr std::int64_t kCountGrain = std::int64_t{1} << 18;

// Samples first to last, both included, of an axis.
struct Window {
  std::int64_t first;
  std::int64_t last;
  std::int64_t size() const { return last - first + 1; }
};

// The windows of the bricks along one axis; they may be empty.
struct AxisWindows {
  std::int64_t size = 0;        // samples
  std::int64_t num_bricks = 0;  // along the axis
  std::int64_t edge = 0;        // cells per brick
  std::int64_t before = 0;  // samples: ceil(b * edge - R - offset) = b * edge - floor(R + offset)
  std::int64_t behind = 0;  // likewise: floor(R - offset)

  Window of(std::int64_t first_brick, std::int64_t last_brick) const {
    return {std::max<std::int64_t>(first_brick * edge - before, 0),
            std::min((last_brick + 1) * edge + behind, size - 1)};
  }
};

// Beyond the lattice there is nothing to reach, so a huge reach may be cut to its size (and stays
// an integer).
std::int64_t samples_in_reach(double reach, std::int64_t size) {
  return static_cast<std::int64_t>(std::floor(std::min(reach, static_cast<double>(size))));
}

// One sublattice among the samples of all.
template <class T>
struct Sublattice {
  const T* samples;
  Index3 dims;
  std::int64_t stride_z;
  double offset;  // cells, along every axis
};

template <class T>
constexpr Extent<T> kNothing = {std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest()};
// Infinity, so that even the greatest float is less than "nothing".
template <>
constexpr Extent<float> kNothing<float> = {std::numeric_limits<float>::infinity(),
                                           -std::numeric_limits<float>::infinity()};

bool is_missing(float value) { return !(std::abs(value) <= std::numeric_limits<float>::max()); }

// Of all sublattices.
std::int64_t count_missing(const float* samples, std::int64_t count,
                           const BrickTableOptions& options) {
  std::vector<std::int64_t> partial(static_cast<std::size_t>(count / kCountGrain + 1));
  parallel_ranges({count, kCountGrain, options.threads, options.stop},
                  [&](std::int64_t begin, std::int64_t end) {
                    std::int32_t found = 0;
                    for (std::int64_t i = begin; i < end; ++i) {
                      found += static_cast<std::int32_t>(is_missing(samples[i]));
                    }
                    partial[static_cast<std::size_t>(begin / kCountGrain)] = found;
                  });
  return std::accumulate(partial.begin(), partial.end(), std::int64_t{0});
}

// Rows of minima and maxima (and of flags), reused from task to task of one thread.
template <class T>
struct Rows {
  std::vector<T> lo;
  std::vector<T> hi;
  std::vector<std::uint8_t> missing;

  Rows(std::int64_t count, bool with_missing)
      : lo(static_cast<std::size_t>(count)),
        hi(static_cast<std::size_t>(count)),
        missing(with_missing ? static_cast<std::size_t>(count) : 0) {}
};

template <class T>
void merge_row(const T* from_lo, const T* from_hi, T* lo, T* hi, std::int64_t count) {
  for (std::int64_t i = 0; i < count; ++i) {
    lo[i] = from_lo[i] < lo[i] ? from_lo[i] : lo[i];
    hi[i] = from_hi[i] > hi[i] ? from_hi[i] : hi[i];
  }
}

// The same for samples some of which are missing.
void merge_row_of_existing(const float* from, float* lo, float* hi, std::uint8_t* missing,
                           std::int64_t count) {
  constexpr Extent<float> kNone = kNothing<float>;
  for (std::int64_t i = 0; i < count; ++i) {
    const bool exists = !is_missing(from[i]);
    const float as_lo = exists ? from[i] : kNone.lo;
    const float as_hi = exists ? from[i] : kNone.hi;
    lo[i] = as_lo < lo[i] ? as_lo : lo[i];
    hi[i] = as_hi > hi[i] ? as_hi : hi[i];
    missing[i] = static_cast<std::uint8_t>(missing[i] | static_cast<std::uint8_t>(!exists));
  }
}

template <class T>
class TableBuilder {
 public:
  // `num_missing`: samples of all sublattices that are missing.
  TableBuilder(const Sublattice<T>& from, const Index3& num_bricks, std::int64_t num_missing,
               const BrickTableOptions& options)
      : from_(from), options_(options) {
    table_.num_missing = num_missing;
    for (int a = 0; a < 3; ++a) {
      axes_[a] = {from.dims[a], num_bricks[a], options.edge,
                  samples_in_reach(options.reach + from.offset, from.dims[a]),
                  samples_in_reach(options.reach - from.offset, from.dims[a])};
    }
  }

  BrickTable<T> build() {
    const std::int64_t num_tiles = (axes_[1].num_bricks + kTileBricks - 1) / kTileBricks;
    const auto num_bricks =
        static_cast<std::size_t>(axes_[0].num_bricks * axes_[1].num_bricks * axes_[2].num_bricks);
    table_.extents.resize(num_bricks);
    if (has_missing()) table_.missing.resize(num_bricks);

    const std::int64_t num_tasks = num_tiles * axes_[2].num_bricks;
    // A few ranges per thread: buffers are allocated per range, and the last one should not keep
    // the others waiting.
    const std::int64_t grain =
        std::clamp<std::int64_t>(num_tasks / (8 * resolve_threads(options_.threads)), 1, 16);
    parallel_ranges({num_tasks, grain, options_.threads, options_.stop}, [&](std::int64_t begin,
                                                                             std::int64_t end) {
      const std::int64_t max_rows = std::min(
          axes_[1].size, kTileBricks * axes_[1].edge + axes_[1].before + axes_[1].behind + 1);
      Rows<T> tile(max_rows * axes_[0].size, has_missing());
      Rows<T> row(axes_[0].size, has_missing());
      for (std::int64_t task = begin; task < end; ++task) {
        reduce_tile(task / num_tiles, task % num_tiles, tile, row);
      }
    });
    return std::move(table_);
  }

 private:
  bool has_missing() const { return table_.num_missing > 0; }

  // Reduces the rows of layer bz along z into `tile`, those along y into `row`, and that along x
  // into the table.
  void reduce_tile(std::int64_t bz, std::int64_t tile_index, Rows<T>& tile, Rows<T>& row) {
    const std::int64_t by_begin = tile_index * kTileBricks;
    const std::int64_t by_end = std::min(by_begin + kTileBricks, axes_[1].num_bricks);
    const Window y_all = axes_[1].of(by_begin, by_end - 1);
    for (std::int64_t y = y_all.first; y <= y_all.last; ++y) {
      reduce_z(bz, y, tile, (y - y_all.first) * axes_[0].size);
    }
    for (std::int64_t by = by_begin; by < by_end; ++by) {
      const Window window = axes_[1].of(by, by);
      reduce_y(tile, window.first - y_all.first, window.size(), row);
      reduce_x(row, (bz * axes_[1].num_bricks + by) * axes_[0].num_bricks);
    }
  }

  void reduce_z(std::int64_t bz, std::int64_t y, Rows<T>& tile, std::int64_t at) {
    const std::int64_t nx = axes_[0].size;
    const Window window = axes_[2].of(bz, bz);
    T* lo = tile.lo.data() + at;
    T* hi = tile.hi.data() + at;
    std::fill_n(lo, nx, kNothing<T>.lo);
    std::fill_n(hi, nx, kNothing<T>.hi);
    if (has_missing()) std::fill_n(tile.missing.data() + at, nx, std::uint8_t{0});
    for (std::int64_t z = window.first; z <= window.last; ++z) {
      const T* from = from_.samples + z * from_.stride_z + y * nx;
      if constexpr (std::is_same_v<T, float>) {
        if (has_missing()) {
          merge_row_of_existing(from, lo, hi, tile.missing.data() + at, nx);
          continue;
        }
      }
      merge_row(from, from, lo, hi, nx);
    }
  }

  void reduce_y(const Rows<T>& tile, std::int64_t first, std::int64_t count, Rows<T>& row) {
    const std::int64_t nx = axes_[0].size;
    std::fill_n(row.lo.data(), nx, kNothing<T>.lo);
    std::fill_n(row.hi.data(), nx, kNothing<T>.hi);
    for (std::int64_t y = first; y < first + count; ++y) {
      merge_row(tile.lo.data() + y * nx, tile.hi.data() + y * nx, row.lo.data(), row.hi.data(), nx);
    }
    if (!has_missing()) return;
    std::fill_n(row.missing.data(), nx, std::uint8_t{0});
    for (std::int64_t y = first; y < first + count; ++y) {
      const std::uint8_t* from = tile.missing.data() + y * nx;
      for (std::int64_t i = 0; i < nx; ++i) row.missing[i] |= from[i];
    }
  }

  void reduce_x(const Rows<T>& row, std::int64_t at) {
    for (std::int64_t bx = 0; bx < axes_[0].num_bricks; ++bx) {
      const Window window = axes_[0].of(bx, bx);
      Extent<T> extent = kNothing<T>;
      for (std::int64_t i = window.first; i <= window.last; ++i) {
        extent.lo = std::min(extent.lo, row.lo[i]);
        extent.hi = std::max(extent.hi, row.hi[i]);
      }
      table_.extents[at + bx] = extent;
      if (has_missing()) {
        for (std::int64_t i = window.first; i <= window.last; ++i)
          table_.missing[at + bx] |= row.missing[i];
      }
    }
  }

  const Sublattice<T>& from_;
  const BrickTableOptions& options_;
  AxisWindows axes_[3];
  BrickTable<T> table_;
};

template <class T>
void merge_tables(const BrickTable<T>& from, BrickTable<T>& into) {
  for (std::size_t b = 0; b < into.extents.size(); ++b) {
    into.extents[b].lo = std::min(into.extents[b].lo, from.extents[b].lo);
    into.extents[b].hi = std::max(into.extents[b].hi, from.extents[b].hi);
  }
  for (std::size_t b = 0; b < into.missing.size(); ++b) into.missing[b] |= from.missing[b];
}

}  // namespace

template <class T>
BrickTable<T> make_brick_table(const T* samples, const Index3& dims,
                               const BrickTableOptions& options) {
  const LatticeGeometry lattice{.dims = dims, .kind = options.kind};
  const Index3 cells = lattice.cells();
  Index3 num_bricks;
  for (std::size_t a = 0; a < 3; ++a) num_bricks[a] = (cells[a] + options.edge - 1) / options.edge;
  std::int64_t num_missing = 0;
  if constexpr (std::is_same_v<T, float>)
    num_missing = count_missing(samples, num_samples(dims), options);
  const std::int64_t layer = dims[0] * dims[1];
  BrickTable<T> table;
  for (int s = 0; s < lattice.num_sublattices(); ++s) {
    const Sublattice<T> from{samples + s * layer, lattice.dims_of(s),
                             lattice.num_sublattices() * layer, lattice.offset_of(s)[0]};
    BrickTable<T> own = TableBuilder<T>(from, num_bricks, num_missing, options).build();
    if (s == 0) {
      table = std::move(own);
    } else {
      merge_tables(own, table);
    }
  }
  return table;
}

template BrickTable<std::uint8_t> make_brick_table(const std::uint8_t*, const Index3&,
                                                   const BrickTableOptions&);
template BrickTable<std::int8_t> make_brick_table(const std::int8_t*, const Index3&,
                                                  const BrickTableOptions&);
template BrickTable<std::uint16_t> make_brick_table(const std::uint16_t*, const Index3&,
                                                    const BrickTableOptions&);
template BrickTable<std::int16_t> make_brick_table(const std::int16_t*, const Index3&,
                                                   const BrickTableOptions&);
template BrickTable<float> make_brick_table(const float*, const Index3&, const BrickTableOptions&);

}  // namespace ovoid::data
