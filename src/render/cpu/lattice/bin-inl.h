// SPDX-License-Identifier: Apache-2.0
// Stage "bin": which samples of a block can show, and which box of the lattice they reach.
//
// In:  the block's sheets and pixels, the open pixels, the relevance bits (one per brick of 4^3
// samples). Out: row bits per sheet (active, relevant), the region. For a lattice positions are
// implicit, so binning runs from the samples: each looks up the bit of the brick it lies in, a
// group of neighbouring pixels at a time. The bits of 256^3 samples are 32 KiB, so the look-up hits
// the L1 cache.
#if defined(OVOID_RENDER_CPU_BIN_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_BIN_INL_H_
#undef OVOID_RENDER_CPU_BIN_INL_H_
#else
#define OVOID_RENDER_CPU_BIN_INL_H_
#endif

#include "render/cpu/lattice/block-inl.h"
#include "render/cpu/shade/limits-inl.h"
#include "render/cpu/shade/path-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Bit of the brick that each position lies in; positions beyond the lattice belong to the outermost
// bricks. Positions within rounding of a brick's face may be given either brick: ranges cover both.
struct BrickLookup {
  // `order`: of positions; the map has its own.
  BrickLookup(const view::RelevanceMap& map, const std::uint32_t* bits, const std::int64_t* origin,
              const view::AxisOrder& order)
      : words(reinterpret_cast<const std::int32_t*>(bits)),
        words_per_row(map.words_per_row()),
        rows_per_layer(static_cast<std::int32_t>(map.num_bricks()[1])),
        bricks_per_sample(std::ldexp(1.0F, -map.brick_shift())) {
    for (int i = 0; i < 3; ++i) {
      const int a = order[static_cast<std::size_t>(i)];
      own[a] = i;
      origin_bricks[a] = static_cast<float>(origin[i]) * bricks_per_sample;
      last[a] = static_cast<float>(map.num_bricks()[static_cast<std::size_t>(a)] - 1);
    }
  }

  // Numbers of bricks along an axis of the map, as whole floats.
  HWY_INLINE V brick_of(int a, V position) const {
    const V b = hn::MulAdd(position, hn::Set(d, bricks_per_sample), hn::Set(d, origin_bricks[a]));
    return hn::Min(hn::Max(hn::Floor(b), hn::Zero(d)), hn::Set(d, last[a]));
  }
  int brick_at(int a, float position) const {
    const float b = position * bricks_per_sample + origin_bricks[a];
    return static_cast<int>(std::clamp(b, 0.0F, last[a]));
  }
  bool is_relevant(const int (&brick)[3]) const {
    const std::int32_t row = brick[2] * rows_per_layer + brick[1];
    return (static_cast<std::uint32_t>(words[row * words_per_row + (brick[0] >> 5)]) >>
                (brick[0] & 31) &
            1U) != 0;
  }

  HWY_INLINE M operator()(const Position& u) const {
    const V place[3] = {u.x, u.y, u.z};
    const auto brick = [&](int a) { return nearest_integer(brick_of(a, place[own[a]])); };
    const VI bx = brick(0);
    const VI row = hn::Add(hn::Mul(brick(2), hn::Set(di, rows_per_layer)), brick(1));
    const VI word = hn::Add(hn::Mul(row, hn::Set(di, words_per_row)), hn::ShiftRight<5>(bx));
    // Shifted so that the brick's bit is the sign.
    const VI to_sign = hn::Sub(hn::Set(di, 31), hn::And(bx, hn::Set(di, 31)));
    const VI bits = hn::Shl(hn::GatherIndex(di, words, word), to_sign);
    return hn::RebindMask(d, hn::Lt(bits, hn::Zero(di)));
  }

  const std::int32_t* words;
  std::int32_t words_per_row, rows_per_layer;
  float bricks_per_sample;
  float origin_bricks[3], last[3];
  int own[3];  // where positions have the map's axes
};

// Bits of the samples of one row that lie where the field can be defined / that also lie in a
// relevant brick and have a path.
struct RowMasks {
  RowWord inside = 0;
  RowWord relevant = 0;
};

// Where the field can be defined, relative to the region's origin; nothing to test if the whole
// block lies inside.
struct Support {
  V lo[3], hi[3];
  float first[3], last[3];  // the same
  bool holds_block;

  bool holds(int axis, float place) const { return first[axis] <= place && place <= last[axis]; }

  HWY_INLINE M holds_along(int axis, V places) const {
    return hn::And(hn::Ge(places, lo[axis]), hn::Le(places, hi[axis]));
  }

  HWY_INLINE M operator()(const Position& u) const {
    return hn::And(holds_along(0, u.x), hn::And(holds_along(1, u.y), holds_along(2, u.z)));
  }
};

// What a block's samples are looked up in.
struct SampleLookup {
  BrickLookup bricks;
  Support support;
};

// True if a part of some sample's path on sheet s is cut off.
inline bool cuts_paths(const CpuFrame& frame, const BlockPlace& place, int s) {
  return !frame.plan->clip_planes.empty() || place.sheets[s].near_cut > -0.5F;
}

HWY_INLINE RowMasks bin_row(const CpuFrame& frame, const Block& block, int s, int row,
                            const SampleLookup& lookup, RowWord columns) {
  RowMasks masks;
  for (int column = 0; column < block.place.columns; column += group_size()) {
    if (lanes_at(columns, column) == 0) continue;
    const Position u = position_of(block.sheets[s], column, row);
    std::uint32_t inside = group_bits();
    if (!lookup.support.holds_block) {
      inside = bits_of(lookup.support(u));
      if (inside == 0) continue;
    }
    std::uint32_t relevant = bits_of(lookup.bricks(u)) & inside;
    if (relevant != 0 && cuts_paths(frame, block.place, s)) {
      relevant &= frame.is_refined ? with_pieces_by_planes(frame, block.place, s, column, row)
                                   : with_path_by_planes(frame, block.place, s, column, row);
    }
    masks.inside |= RowWord{inside} << column;
    masks.relevant |= RowWord{relevant} << column;
  }
  const RowWord row_mask = first_bits(block.place.columns);
  masks.inside &= row_mask;
  masks.relevant &= row_mask;
  return masks;
}

// The bricks that a lattice sheet's columns lie in, in the frame's order, and which columns each
// has.
struct BricksOfColumns {
  static constexpr int kMost = static_cast<int>(kTileSize * view::kMostSpacings) / 4 + 3;

  int first, count;
  RowWord columns[kMost];
};

// Brick edges are powers of two from 4 on.
inline BricksOfColumns bricks_of_columns(const SheetInLattice& sheet, const BrickLookup& bricks,
                                         int axis) {
  alignas(64) float brick[kTileSize];
  for (int x = 0; x < kTileSize; x += group_size()) {
    const V at = hn::MulAdd(hn::Iota(d, static_cast<float>(x)), hn::Set(d, sheet.per_x[0]),
                            hn::Set(d, sheet.base[0]));
    hn::Store(bricks.brick_of(axis, at), d, brick + x);
  }
  BricksOfColumns out{};
  out.first = static_cast<int>(brick[0]);
  out.count =
      std::min(static_cast<int>(brick[kTileSize - 1]) - out.first + 1, BricksOfColumns::kMost);
  for (int x = 0; x < kTileSize; x += group_size()) {
    const V own = hn::Load(d, brick + x);
    for (int i = 0; i < out.count; ++i) {
      const M is_own = hn::Eq(own, hn::Set(d, static_cast<float>(out.first + i)));
      out.columns[i] |= RowWord{bits_of(is_own)} << x;
    }
  }
  return out;
}

// Which bricks of a layer are relevant, around a block of lattice sheets: sheet after sheet lies in
// the same layer.
class BrickLayer {
 public:
  // Of the layer, the bricks from columns.first on in the row; bit i is brick columns.first + i.
  std::uint32_t row_of(const BrickLookup& bricks, const view::AxisOrder& order, int layer, int row,
                       const BricksOfColumns& columns) {
    if (layer != layer_) {
      layer_ = layer;
      known_.fill(false);
      first_column_ = columns.first - kBefore;
      first_row_ = row - kBefore;
    }
    // Sheets lie askew, behind each other a little to the side.
    const int shift = columns.first - first_column_;
    const int at = row - first_row_;
    if (shift < 0 || shift + columns.count > kColumns || at < 0 || at >= kRows)
      return bits_from(bricks, order, layer, row, columns.first, columns.count);
    const auto own = static_cast<std::size_t>(at);
    if (!known_[own]) {
      rows_[own] = bits_from(bricks, order, layer, row, first_column_, kColumns);
      known_[own] = true;
    }
    return rows_[own] >> shift;
  }

 private:
  static constexpr int kBefore = 2;
  static constexpr int kColumns = BricksOfColumns::kMost + 2 * kBefore;
  static constexpr int kRows = kColumns;

  static std::uint32_t bits_from(const BrickLookup& bricks, const view::AxisOrder& order, int layer,
                                 int row, int first, int count) {
    int place[3];
    place[order[1]] = row;
    place[order[2]] = layer;
    std::uint32_t bits = 0;
    for (int i = 0; i < count; ++i) {
      place[order[0]] = std::clamp(first + i, 0, static_cast<int>(bricks.last[order[0]]));
      bits |= static_cast<std::uint32_t>(bricks.is_relevant(place)) << i;
    }
    return bits;
  }

  int layer_ = -1;
  int first_column_ = 0, first_row_ = 0;
  std::array<std::uint32_t, kRows> rows_;
  std::array<bool, kRows> known_;
};

// The samples of lattice sheet s, of which `open` are worth the work: a row lies in one row of
// bricks, and so do most of those beside it. All kTileSize rows are set. Returns whether any sample
// is relevant.
inline bool bin_lattice_sheet(const LatticeFrame& frame, const Block& block, int s,
                              const SampleLookup& lookup, const RowBits& open, BrickLayer& layer,
                              RowBits& inside, RowBits& relevant) {
  const SheetInLattice& sheet = block.sheets[s];
  const view::AxisOrder& order = frame.lattice_plan->order;
  const BrickLookup& bricks = lookup.bricks;
  const bool is_cut = cuts_paths(frame, block.place, s);
  const BricksOfColumns columns = bricks_of_columns(sheet, bricks, order[0]);
  const int layer_number = bricks.brick_at(order[2], sheet.base[2]);
  RowWord within = first_bits(block.place.columns);
  if (!lookup.support.holds_block) {
    if (!lookup.support.holds(2, sheet.base[2])) within = 0;
    for (int x = 0; x < kTileSize; x += group_size()) {
      const V at = hn::MulAdd(hn::Iota(d, static_cast<float>(x)), hn::Set(d, sheet.per_x[0]),
                              hn::Set(d, sheet.base[0]));
      const std::uint32_t outside = ~bits_of(lookup.support.holds_along(0, at)) & group_bits();
      within &= ~(RowWord{outside} << x);
    }
  }
  RowWord any = 0;
  RowWord found = 0;
  int own_row = -1;
  for (int y = 0; y < block.place.rows; ++y) {
    const float at = sheet.base[1] + static_cast<float>(y) * sheet.per_y[1];
    const bool is_inside = lookup.support.holds_block || lookup.support.holds(1, at);
    inside[y] = is_inside ? within : 0;
    const RowWord wanted = inside[y] & open[y];
    relevant[y] = 0;
    if (wanted == 0) continue;
    if (is_cut) {  // every sample has a path of its own
      relevant[y] = bin_row(frame, block, s, y, lookup, ~RowWord{0}).relevant & wanted;
      any |= relevant[y];
      continue;
    }
    const int row = bricks.brick_at(order[1], at);
    if (row != own_row) {
      own_row = row;
      found = 0;
      std::uint32_t bits = layer.row_of(bricks, order, layer_number, row, columns);
      bits &= (1U << columns.count) - 1;
      for (; bits != 0; bits &= bits - 1) found |= columns.columns[std::countr_zero(bits)];
    }
    relevant[y] = found & wanted;
    any |= relevant[y];
  }
  for (int y = block.place.rows; y < kTileSize; ++y) inside[y] = relevant[y] = 0;
  return any != 0;
}

// Central differences also need the six neighbours of every relevant sample.
inline void dilate_active(const RowBits* relevant, const RowBits* inside, Block& block) {
  for (int s = 0; s < block.place.num_sheets; ++s) {
    for (int y = 0; y < block.place.rows; ++y) {
      RowWord bits = relevant[s][y];
      bits |= bits << 1 | bits >> 1;
      if (y > 0) bits |= relevant[s][y - 1];
      if (y + 1 < block.place.rows) bits |= relevant[s][y + 1];
      if (s > 0) bits |= relevant[s - 1][y];
      if (s + 1 < block.place.num_sheets) bits |= relevant[s + 1][y];
      block.bits.active[s][y] = bits & inside[s][y];
    }
  }
}

// From relevant samples to relevant pieces: a piece is relevant if one of its ends is. `ends`
// becomes the samples at the ends of the block's own pieces.
template <class Rows>
inline void find_pieces(Block& block, Rows rows, RowBits* ends) {
  const BlockPlace& place = block.place;
  RowBits* const relevant = block.bits.relevant;
  const int first = place.front_margin;
  const int last = place.num_sheets - place.back_margin - 1;
  for (int s = place.num_sheets - 1; s >= 0; --s) {
    const bool is_own = first <= s && s <= last;
    for (int y = 0; y < rows; ++y)
      relevant[s][y] = is_own ? relevant[s][y] | relevant[s - 1][y] : 0;
  }
  for (int s = 0; s < place.num_sheets; ++s) {
    for (int y = 0; y < rows; ++y)
      ends[s][y] = relevant[s][y] | (s < last ? relevant[s + 1][y] : 0);
  }
}

// The box of samples that active samples reach, by the kernels' support or farther. Positions are
// affine along a row, so its first and last active sample bound it.
inline void bound_region(const LatticeFrame& frame, Block& block,
                         const Vec3& least_reach = Vec3::Zero()) {
  float lo[3] = {1e30F, 1e30F, 1e30F};
  float hi[3] = {-1e30F, -1e30F, -1e30F};
  const bool reads_four_taps = frame.has_four_taps && frame.options->evaluate != Evaluate::kScatter;
  const auto extend = [&](const SheetInLattice& sheet, int x, int y) {
    for (int a = 0; a < 3; ++a) {
      const float u = sheet.base[a] + static_cast<float>(y) * sheet.per_y[a] +
                      static_cast<float>(x) * sheet.per_x[a];
      float reach =
          std::max(frame.lattice.support * sheet.widening[a], static_cast<float>(least_reach[a]));
      if (reads_four_taps) reach = std::max(reach, 2.0F);
      if (frame.lattice.num_slab_points > 1) {
        reach += 0.5F * std::abs(sheet.step[a] + static_cast<float>(x) * sheet.step_per_x[a] +
                                 static_cast<float>(y) * sheet.step_per_y[a]);
      }
      lo[a] = std::min(lo[a], u - reach);
      hi[a] = std::max(hi[a], u + reach);
    }
  };
  for (int s = 0; s < block.place.num_sheets; ++s) {
    RowWord any = 0;
    int first = -1;
    int last = 0;
    for (int y = 0; y < block.place.rows; ++y) {
      const RowWord bits = block.bits.active[s][y];
      if (bits == 0) continue;
      if (!frame.is_on_lattice) {
        extend(block.sheets[s], std::countr_zero(bits), y);
        extend(block.sheets[s], 63 - std::countl_zero(bits), y);
      }
      any |= bits;
      if (first < 0) first = y;
      last = y;
    }
    if (!frame.is_on_lattice || any == 0) continue;
    // Rows and columns are the lattice's own.
    extend(block.sheets[s], std::countr_zero(any), first);
    extend(block.sheets[s], 63 - std::countl_zero(any), last);
  }
  block.region.is_interior = true;
  for (int a = 0; a < 3; ++a) {
    // A hundredth of a sample of slack for rounding; what lies farther outside the lattice is cut
    // off. Samples of all sublattices have the same numbers.
    std::int64_t first = std::numeric_limits<std::int64_t>::max();
    std::int64_t last = std::numeric_limits<std::int64_t>::min();
    const std::int64_t lattice_first = -block.region.origin[a];
    std::int64_t lattice_last = lattice_first;
    for (int s = 0; s < frame.lattice.num_sublattices; ++s) {
      const auto& [dims, offset] = frame.lattice.sublattices[s];
      const auto own_first = static_cast<std::int64_t>(std::floor(lo[a] - offset - 0.01F));
      const auto own_last = static_cast<std::int64_t>(std::ceil(hi[a] - offset + 0.01F));
      const std::int64_t own_end = lattice_first + dims[a] - 1;
      if (own_first < lattice_first || own_last > own_end) block.region.is_interior = false;
      first = std::min(first, own_first);
      last = std::max(last, own_last);
      lattice_last = std::max(lattice_last, own_end);
    }
    // At least one sample of the lattice stays in it: `sum` is binned to where no kernel reaches.
    first = std::clamp(first, lattice_first - kRegionBeyond, lattice_last);
    last = std::clamp(last, lattice_first, lattice_last + kRegionBeyond);
    block.region.lo[a] = static_cast<int>(first);
    block.region.size[a] = static_cast<int>(last - first + 1);
  }
}

// Columns of a block that can hold relevant samples, by groups of four sheets and four rows: one
// look-up for 4 x 4 x 4 samples in the map that includes neighbours. Only valid while no sample is
// farther from its group's middle than a brick's edge.
using CellColumns = std::array<std::array<RowWord, kTileSize / 4>, (kMaxSheets + 3) / 4>;

inline bool cells_fit_bricks(const LatticeFrame& frame, const Block& block) {
  const auto edge = static_cast<float>(1 << frame.lattice_plan->relevance.brick_shift());
  for (const int s : {0, block.place.num_sheets - 1}) {
    const SheetInLattice& sheet = block.sheets[s];
    for (int a = 0; a < 3; ++a) {
      const float step = std::abs(sheet.step[a]) + kTileSize * (std::abs(sheet.step_per_x[a]) +
                                                                std::abs(sheet.step_per_y[a]));
      const float reach = 1.5F * (std::abs(sheet.per_x[a]) + std::abs(sheet.per_y[a]) + step);
      if (reach > 0.99F * edge) return false;
    }
  }
  return true;
}

inline CellColumns bin_cells(const Block& block, const BrickLookup& neighbours) {
  CellColumns columns{};
  for (int cz = 0; 4 * cz < block.place.num_sheets; ++cz) {
    const int s = std::min(4 * cz + 1, block.place.num_sheets - 1);
    const SheetInLattice& near = block.sheets[s];
    const SheetInLattice& far = block.sheets[std::min(s + 1, block.place.num_sheets - 1)];
    for (int cy = 0; 4 * cy < block.place.rows; ++cy) {
      std::uint32_t cells = 0;
      for (int first = 0; first < kTileSize / 4; first += group_size()) {
        const V x =
            hn::MulAdd(hn::Iota(d, static_cast<float>(first)), hn::Set(d, 4.0F), hn::Set(d, 1.5F));
        const auto middle = [&](int a) {
          const float y = 4.0F * static_cast<float>(cy) + 1.5F;
          const float base =
              0.5F * (near.base[a] + far.base[a]) + y * 0.5F * (near.per_y[a] + far.per_y[a]);
          return hn::MulAdd(x, hn::Set(d, 0.5F * (near.per_x[a] + far.per_x[a])), hn::Set(d, base));
        };
        cells |= bits_of(neighbours({middle(0), middle(1), middle(2)})) << first;
      }
      for (int cx = 0; cx < kTileSize / 4; ++cx) {
        if ((cells >> cx & 1U) != 0) columns[cz][cy] |= RowWord{0xF} << (4 * cx);
      }
    }
  }
  return columns;
}

// Of a block without wide kernels no sample may lie where only wider ones reach: four taps there
// are beyond its region.
inline Support support_of(const LatticeFrame& frame, const Block& block, const Bounds3& box) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  const Bounds3& defined = block.widens_kernels() ? plan.index_support : plan.narrow_support;
  Support support;
  for (int a = 0; a < 3; ++a) {
    // Rounding slack; the reconstruct stage decides exactly.
    const auto origin = static_cast<double>(block.region.origin[a]);
    support.first[a] = static_cast<float>(defined.min()[a] - origin - 1e-3);
    support.last[a] = static_cast<float>(defined.max()[a] - origin + 1e-3);
    support.lo[a] = hn::Set(d, support.first[a]);
    support.hi[a] = hn::Set(d, support.last[a]);
  }
  support.holds_block = defined.contains(box);
  return support;
}

// Samples of a plane's row that are worth the work, as bits of the plane: those of pixels that
// still take samples, or all.
inline RowWord open_samples(const CpuFrame& frame, const BlockPlace& place, const TileState& tile,
                            int row) {
  const int y = place.y0 + row - place.margin;
  if (y < place.y0 || y >= place.y1) return 0;
  const RowWord pixels = first_bits(place.x1 - place.x0);
  const RowWord open = frame.options->stop_opaque ? tile.open[y] >> place.x0 : ~RowWord{0};
  return (open & pixels) << place.margin;
}

// Samples of a block that are worth the work on any of its sheets.
inline RowBits wanted_of_block(const CpuFrame& frame, const BlockPlace& place, TileState& tile) {
  RowBits wanted{};
  for (int y = 0; y < place.rows; ++y) wanted[y] = open_samples(frame, place, tile, y);
  if (place.limits == nullptr) return wanted;
  const float sheet = frame.camera.sampling_distance;
  return reached_by_spans(frame, place, wanted, place.sheets[0].depth - sheet,
                          place.sheets[place.num_sheets - 1].depth + sheet, tile);
}

// True if samples of sheet s are classified in this block, or looked at as front ends: the front
// sheet, though the block before has classified it.
inline bool is_needed(const CpuFrame& frame, const BlockPlace& place, int s) {
  const bool is_margin = s < place.front_margin || s >= place.num_sheets - place.back_margin;
  return !is_margin || frame.mode == Mode::kIsosurface ||
         (frame.is_preintegrated && s < place.front_margin) ||
         (frame.is_refined && s == place.front_margin - 1);
}

// From the block's relevant samples to its active ones. `rows`: a number, or a constant.
template <class Rows>
inline void find_active(const LatticeFrame& frame, const RowBits* inside, Rows rows, Block& block) {
  RowBits ends[kMaxSheets];
  if (frame.is_refined) find_pieces(block, rows, ends);
  const RowBits* const wanted = frame.is_refined ? ends : block.bits.relevant;
  if (block.place.margin > 0) return dilate_active(wanted, inside, block);
  for (int s = 0; s < block.place.num_sheets; ++s) {
    for (int y = 0; y < rows; ++y) block.bits.active[s][y] = wanted[s][y] & inside[s][y];
  }
}

// `box` holds all samples of the block, in index space. Returns whether any sample is relevant, of
// those that are wanted; active bits and region are only valid if one is.
inline bool bin_region(const LatticeFrame& frame, Block& block, const RowBits& wanted,
                       const Bounds3& box) {
  if (count_bits(wanted, block.place.rows) == 0) return false;
  RowBits inside[kMaxSheets];
  const BlockPlace& place = block.place;
  const view::RelevanceMap& map = frame.lattice_plan->relevance;
  const view::AxisOrder& order = frame.lattice_plan->order;
  const SampleLookup lookup{BrickLookup(map, map.words(), block.region.origin, order),
                            support_of(frame, block, box)};
  if (frame.is_on_lattice) {
    const RowBits none{};
    BrickLayer layer;
    bool is_any = false;
    for (int s = 0; s < place.num_sheets; ++s) {
      is_any |=
          bin_lattice_sheet(frame, block, s, lookup, is_needed(frame, place, s) ? wanted : none,
                            layer, inside[s], block.bits.relevant[s]);
    }
    if (!is_any) return false;
    find_active(frame, inside, std::integral_constant<int, kTileSize>(), block);
    bound_region(frame, block);
    return true;
  }
  // Differences need every sample's surroundings; then all samples are looked up.
  const bool has_cells = place.margin == 0 && cells_fit_bricks(frame, block);
  const CellColumns cells =
      has_cells
          ? bin_cells(block, BrickLookup(map, map.neighbour_words(), block.region.origin, order))
          : CellColumns{};
  RowWord any = 0;
  for (int s = 0; s < place.num_sheets; ++s) {
    const bool is_wanted = is_needed(frame, place, s);
    for (int y = 0; y < place.rows; ++y) {
      const RowWord columns = has_cells ? cells[s / 4][y / 4] : ~RowWord{0};
      const RowMasks masks = bin_row(frame, block, s, y, lookup, columns);
      inside[s][y] = masks.inside;
      block.bits.relevant[s][y] = is_wanted ? masks.relevant & wanted[y] : 0;
      any |= block.bits.relevant[s][y];
    }
  }
  if (any == 0) return false;
  find_active(frame, inside, place.rows, block);
  bound_region(frame, block);
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
