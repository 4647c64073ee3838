// SPDX-License-Identifier: Apache-2.0
// Stage "composite": one sheet's samples join the tile's pixels, front to back; a pixel that has
// become opaque is closed.
//
// In:  visible samples with opacity and colour (composite), or defined samples (x-ray, maximum,
// mean). Out: the tile's state.
#if defined(OVOID_RENDER_CPU_COMPOSITE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_COMPOSITE_INL_H_
#undef OVOID_RENDER_CPU_COMPOSITE_INL_H_
#else
#define OVOID_RENDER_CPU_COMPOSITE_INL_H_
#endif

#include "render/cpu/path-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

HWY_INLINE int tile_row(const Block& block, int row) { return block.y0 + row - block.margin; }
HWY_INLINE int tile_column(const Block& block, int column) {
  return block.x0 + column - block.margin;
}

HWY_INLINE void store_masked(M mask, V value, float* to) {
  hn::StoreU(hn::IfThenElse(mask, value, hn::LoadU(d, to)), d, to);
}

inline void composite_sheet(const Block& block, TileState& tile, int s) {
  const V one = hn::Set(d, 1.0F);
  const V half = hn::Set(d, 0.5F);
  for (int y = 0; y < block.rows; ++y) {
    if (block.visible[y] == 0) continue;  // as in all rows of the margin, which the tile lacks
    // Nothing is added behind what is opaque, even if it was worked out.
    std::uint32_t& open = tile.open[tile_row(block, y)];
    for_each_group(
        block.visible[y] & open >> block.x0 << block.margin, block.margin,
        block.columns - block.margin, [&](int column, std::uint32_t lanes) {
          const int from = y * kPlaneStride + column;
          const int to = tile_index(block, column, y);
          const V before = hn::LoadU(d, tile.alpha + to);
          const V share = hn::IfThenElseZero(
              mask_of(lanes),
              hn::Mul(hn::Sub(one, before), hn::LoadU(d, block.sample_alpha + from)));
          const V after = hn::Add(before, share);
          const auto add = [&](float* sum, const float* color) {
            hn::StoreU(hn::MulAdd(share, hn::LoadU(d, color + from), hn::LoadU(d, sum + to)), d,
                       sum + to);
          };
          add(tile.red, block.sample_red);
          add(tile.green, block.sample_green);
          add(tile.blue, block.sample_blue);
          hn::StoreU(after, d, tile.alpha + to);
          store_masked(hn::And(hn::Lt(before, half), hn::Ge(after, half)),
                       hn::Set(d, block.sheets[s].depth), tile.depth + to);
          const M opaque = hn::Ge(after, hn::Set(d, static_cast<float>(RenderOptions::kOpaque)));
          open &= ~((bits_of(opaque) & lanes) << tile_column(block, column));
        });
  }
}

// X-ray, maximum and mean: every defined sample counts.
inline void accumulate_sheet(const CpuFrame& frame, Block& block, TileState& tile, int s,
                             const RowBits& bits) {
  const float* values = block.values[s & (kRingSheets - 1)];
  for (int y = 0; y < block.rows; ++y) {
    for_each_group(
        bits[y], block.margin, block.columns - block.margin, [&](int column, std::uint32_t lanes) {
          const M mask = mask_of(lanes);
          const int to = tile_index(block, column, y);
          std::uint32_t& seen_row = tile.seen[tile_row(block, y)];
          const M seen = mask_of(seen_row >> tile_column(block, column) & group_bits());
          const V value = hn::LoadU(d, values + y * kPlaneStride + column);
          const V depth = hn::Set(d, block.sheets[s].depth);
          const V best = hn::LoadU(d, tile.best + to);
          if (frame.mode == Mode::kMaximum) {
            const M better = hn::And(mask, hn::Gt(value, best));
            store_masked(better, value, tile.best + to);
            store_masked(better, depth, tile.depth + to);
          } else {
            const V length = hn::Mul(hn::Mul(path_fraction(frame, block, s, column, y),
                                             ray_length(frame, block, column, y)),
                                     hn::Set(d, frame.camera.sampling_distance));
            const V sum = hn::IfThenElseZero(seen, best);
            store_masked(mask, hn::MulAdd(value, length, sum), tile.best + to);
            store_masked(mask, hn::Add(length, hn::LoadU(d, tile.path + to)), tile.path + to);
            store_masked(hn::AndNot(seen, mask), depth, tile.depth + to);
          }
          seen_row |= lanes << tile_column(block, column);
        });
  }
}

// X-ray and mean: the sum of `num_sheets` sheets' values at once, all of them defined and their
// paths whole, the first of them at `depth`.
inline void accumulate_sum(const CpuFrame& frame, const Block& block, TileState& tile,
                           int num_sheets, float depth) {
  const std::uint32_t all = (1U << block.columns) - 1U;
  for (int y = 0; y < block.rows; ++y) {
    for_each_group(all, 0, block.columns, [&](int column, std::uint32_t lanes) {
      const M mask = mask_of(lanes);
      const int to = tile_index(block, column, y);
      const M seen = mask_of(tile.seen[y] >> column & group_bits());
      const V length =
          hn::Mul(ray_length(frame, block, column, y), hn::Set(d, frame.camera.sampling_distance));
      const V sum = hn::IfThenElseZero(seen, hn::LoadU(d, tile.best + to));
      const V value = hn::LoadU(d, block.values[0] + y * kPlaneStride + column);
      store_masked(mask, hn::MulAdd(value, length, sum), tile.best + to);
      store_masked(mask,
                   hn::MulAdd(hn::Set(d, static_cast<float>(num_sheets)), length,
                              hn::LoadU(d, tile.path + to)),
                   tile.path + to);
      store_masked(hn::AndNot(seen, mask), hn::Set(d, depth), tile.depth + to);
    });
    tile.seen[y] |= all;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
