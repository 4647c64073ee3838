// SPDX-License-Identifier: Apache-2.0
// Stage "post-convolve" of lattices: a patch of tiles x consecutive sheets whose field is sampled
// at nodes (nodes.h). Sheet by sheet: the nodes that open, relevant pixels need; then, tile by
// tile, values for the pixels, classification, and where something shows the nodes' gradients, the
// pixels' from them, light and composition.
//
// Patches that meet the lattice's faces or holes, where a field ends within a pixel, are drawn as
// if there were no nodes.
#if defined(OVOID_RENDER_CPU_PATCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_PATCH_INL_H_
#undef OVOID_RENDER_CPU_PATCH_INL_H_
#else
#define OVOID_RENDER_CPU_PATCH_INL_H_
#endif

#include "render/cpu/block-inl.h"
#include "render/cpu/finish-inl.h"
#include "render/cpu/gradient-inl.h"
#include "render/cpu/load-inl.h"
#include "render/cpu/nodes.h"
#include "render/cpu/reconstruct-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

struct Patch {
  TileRect rect;       // of the picture
  int tile_x, tile_y;  // of its first tile among the workspace's
  std::int64_t first_sheet, last_sheet;
  double pitch;
  NodeSpan nodes_x, nodes_y;
};

// Tiles of the patch, of those of its workspace.
template <class Body>
inline void for_each_tile(const Patch& patch, const Body& body) {
  for (int y = 0; patch.rect.y0 + y * kTileSize < patch.rect.y1; ++y) {
    for (int x = 0; patch.rect.x0 + x * kTileSize < patch.rect.x1; ++x) {
      const int tile = (patch.tile_y + y) * kPatchTiles + patch.tile_x + x;
      body(static_cast<std::size_t>(tile), x, y);
    }
  }
}

// Where tile (x, y) of the patch lies.
inline void place_tile(Block& block, const Patch& patch, int x, int y) {
  block.tile_x = patch.rect.x0 + x * kTileSize;
  block.tile_y = patch.rect.y0 + y * kTileSize;
  block.x0 = block.y0 = 0;
  block.x1 = std::min(patch.rect.x1 - block.tile_x, kTileSize);
  block.y1 = std::min(patch.rect.y1 - block.tile_y, kTileSize);
  block.columns = block.x1;
  block.rows = block.y1;
}

inline Part part_of(const Block& block, const Patch& patch) {
  return {0, 0, block.x1, block.y1, patch.first_sheet, patch.last_sheet};
}

// The nodes as samples of a block, all of them active. Returns their box in index space.
inline Bounds3 set_up_nodes(const CpuFrame& frame, Block& nodes, const Patch& patch) {
  nodes.tile_x = nodes.tile_y = nodes.x0 = nodes.y0 = 0;
  nodes.margin = nodes.front_margin = nodes.back_margin = 0;
  nodes.x1 = nodes.columns = patch.nodes_x.count;
  nodes.y1 = nodes.rows = patch.nodes_y.count;
  const SampleGrid grid{patch.pitch * static_cast<double>(patch.nodes_x.first),
                        patch.pitch * static_cast<double>(patch.nodes_y.first), patch.pitch};
  Bounds3 box;
  for (const std::int64_t sheet : {patch.first_sheet, patch.last_sheet - 1}) {
    const view::SheetMap map = frame.plan->lattice.index_map(sheet);
    for (const int x : {0, nodes.columns - 1}) {
      for (const int y : {0, nodes.rows - 1})
        box.extend(map.at(grid.x + grid.step * x, grid.y + grid.step * y));
    }
  }
  nodes.first_sheet = patch.first_sheet;
  nodes.num_sheets = static_cast<int>(patch.last_sheet - patch.first_sheet);
  set_up_sheets(frame, nodes, grid, box);
  const std::uint32_t all = ~0U >> (32 - nodes.columns);
  for (int s = 0; s < nodes.num_sheets; ++s) {
    for (int y = 0; y < nodes.rows; ++y) nodes.active[s][y] = all;
  }
  bound_region(frame, nodes);
  return box;
}

// Pixels of a tile as the box around them.
struct PixelBox {
  int x0 = 0, x1 = -1, y0 = 0, y1 = -1;  // inclusive
};

inline PixelBox box_of_bits(const RowBits& bits, int rows) {
  PixelBox box;
  std::uint32_t columns = 0;
  for (int y = 0; y < rows; ++y) {
    if (bits[y] == 0) continue;
    if (columns == 0) box.y0 = y;
    box.y1 = y;
    columns |= bits[y];
  }
  if (columns == 0) return box;
  box.x0 = std::countr_zero(columns);
  box.x1 = 31 - std::countl_zero(columns);
  return box;
}

// Adds the nodes from which a tile's pixels take their values.
inline void add_nodes(const RowBits& pixels, int rows, const NodeWeights& x, const NodeWeights& y,
                      RowBits& nodes) {
  for (int py = 0; py < rows; ++py) {
    std::uint32_t columns = 0;
    for (std::uint32_t left = pixels[py]; left != 0;) {  // run by run
      const int first = std::countr_zero(left);
      const int last = first + std::countr_one(left >> first) - 1;
      const int from = x.taps[static_cast<std::size_t>(first)];
      const int past = x.taps[static_cast<std::size_t>(last)] + kNodeTaps;
      columns |= (~0U >> (32 - past + from)) << from;
      left &= ~0U << (last + 1);
    }
    if (columns == 0) continue;
    const auto row = static_cast<std::size_t>(y.taps[static_cast<std::size_t>(py)]);
    for (std::size_t k = 0; k < kNodeTaps; ++k) nodes[row + k] |= columns;
  }
}

// Four rows of nodes, or fewer, along x: kRows of them share the loads of the weights.
template <int kRows>
HWY_INLINE void bring_rows(const float* nodes, const NodeWeights& x, float (*rows)[kTileSize]) {
  for (int c = 0; c < kTileSize; c += group_size()) {
    const int first = x.of_eight[static_cast<std::size_t>(c / 8)].first;
    const int past = x.of_eight[static_cast<std::size_t>((c + group_size() - 1) / 8)].past;
    V sums[kRows];
    for (V& sum : sums) sum = hn::Zero(d);
    for (int k = first; k < past; ++k) {
      const V weight = hn::Load(d, x.weight[k] + c);
      for (int r = 0; r < kRows; ++r)
        sums[r] = hn::MulAdd(hn::Set(d, nodes[r * kPlaneStride + k]), weight, sums[r]);
    }
    for (int r = 0; r < kRows; ++r) hn::Store(sums[r], d, rows[r] + c);
  }
}

// The pixels of a box, of a tile's plane, from the nodes' plane: along the rows of nodes first,
// as a matrix product, then down the columns of pixels.
inline void bring_up(const float* nodes, const NodeWeights& x, const NodeWeights& y,
                     const PixelBox& box, float* pixels) {
  alignas(64) float rows[NodeWeights::kMost][kTileSize];
  const int first = y.taps[static_cast<std::size_t>(box.y0)];
  const int past = y.taps[static_cast<std::size_t>(box.y1)] + kNodeTaps;
  const float* from = nodes + first * kPlaneStride + x.first;
  int row = 0;
  for (; row + 4 <= past - first; row += 4) bring_rows<4>(from + row * kPlaneStride, x, rows + row);
  for (; row < past - first; ++row) bring_rows<1>(from + row * kPlaneStride, x, rows + row);
  for (int py = box.y0; py <= box.y1; ++py) {
    const int tap = y.taps[static_cast<std::size_t>(py)];
    const float(*six)[kTileSize] = rows + (tap - first);
    V weight[kNodeTaps];
    for (int k = 0; k < kNodeTaps; ++k) weight[k] = hn::Set(d, y.weight[tap - y.first + k][py]);
    for (int c = 0; c < kTileSize; c += group_size()) {
      V sum = hn::Mul(weight[0], hn::Load(d, six[0] + c));
      for (int k = 1; k < kNodeTaps; ++k) sum = hn::MulAdd(weight[k], hn::Load(d, six[k] + c), sum);
      hn::StoreU(sum, d, pixels + py * kPlaneStride + c);
    }
  }
}

struct PatchWeights {
  NodeWeights x[kPatchTiles], y[kPatchTiles];
};

inline bool has_bits(const RowBits& bits, int rows) {
  return std::any_of(bits.begin(), bits.begin() + rows, [](std::uint32_t row) { return row != 0; });
}

// The gradients of the visible pixels from the nodes'.
inline void bring_up_gradients(const CpuFrame& frame, LatticeWorkspace& work, int s,
                               const NodeWeights& x, const NodeWeights& y) {
  Block& pixels = work.pixels.block;
  Block& nodes = work.nodes.block;
  RowBits missing{};
  add_nodes(pixels.visible, pixels.rows, x, y, missing);
  for (int row = 0; row < nodes.rows; ++row) missing[row] &= ~nodes.has_gradient[row];
  if (has_bits(missing, nodes.rows)) reconstruct_with_gradients(frame, work.nodes, s, missing);
  const PixelBox box = box_of_bits(pixels.visible, pixels.rows);
  for (int a = 0; a < 3; ++a) bring_up(nodes.gradient[a], x, y, box, pixels.gradient[a]);
}

// One tile's part of sheet s, whose nodes are there. `bits`: the pixels that are looked at.
inline void finish_patch_tile(const CpuFrame& frame, LatticeWorkspace& work, TileState& tile,
                              LatticeWorkspace::TileBits& of_tile, int s, const RowBits& bits,
                              const NodeWeights& x, const NodeWeights& y, StageClock& clock) {
  Block& block = work.pixels.block;
  of_tile.visible = {};
  bring_up(work.nodes.block.values[s & (kRingSheets - 1)], x, y, box_of_bits(bits, block.rows),
           block.values[s & (kRingSheets - 1)]);
  clock.lap(kReconstruct);
  if (finish_samples(frame, block, tile, work.pixels.stats, s, bits, nullptr, clock,
                     [&] { bring_up_gradients(frame, work, s, x, y); }))
    of_tile.visible = block.visible;
}

// Pixels of a tile that are looked at on sheet s.
inline RowBits pixels_now(const CpuFrame& frame, const TileState& tile,
                          const LatticeWorkspace::TileBits& of_tile, int s) {
  RowBits bits{};
  if (!of_tile.any_relevant) return bits;
  for (int y = 0; y < kTileSize; ++y)
    bits[y] =
        of_tile.relevant[static_cast<std::size_t>(s)][y] & (frame.stop_opaque ? tile.open[y] : ~0U);
  return bits;
}

inline void draw_patch_sheet(const CpuFrame& frame, LatticeWorkspace& work, const Patch& patch,
                             const PatchWeights& weights, int s, StageClock& clock) {
  Block& nodes = work.nodes.block;
  RowBits wanted{}, guess{};
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    const RowBits bits = pixels_now(frame, work.tiles[t], work.bits[t], s);
    add_nodes(bits, kTileSize, weights.x[x], weights.y[y], wanted);
    // Where something showed on the sheet before, gradients will be wanted, too.
    RowBits likely{};
    for (int row = 0; row < kTileSize; ++row) likely[row] = bits[row] & work.bits[t].visible[row];
    if (frame.takes_gradients) add_nodes(likely, kTileSize, weights.x[x], weights.y[y], guess);
  });
  if (!has_bits(wanted, nodes.rows)) return;
  nodes.defined[s & (kRingSheets - 1)] = {};
  nodes.has_gradient = {};
  work.pixels.stats.samples_reconstructed += count_bits(nodes, wanted);
  if (has_bits(guess, nodes.rows)) reconstruct_with_gradients(frame, work.nodes, s, guess);
  clock.lap(kGradient);
  for (int row = 0; row < nodes.rows; ++row) wanted[row] &= ~guess[row];
  reconstruct_sheet(frame, work.nodes, s, wanted);
  clock.lap(kReconstruct);
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    const RowBits bits = pixels_now(frame, work.tiles[t], work.bits[t], s);
    if (!has_bits(bits, kTileSize)) return;
    place_tile(work.pixels.block, patch, x, y);
    work.pixels.block.rays = &work.rays[t];
    finish_patch_tile(frame, work, work.tiles[t], work.bits[t], s, bits, weights.x[x], weights.y[y],
                      clock);
  });
}

// No sample's path is cut: neither by planes nor by the near plane.
inline bool has_whole_paths(const CpuFrame& frame, const Patch& patch) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  return frame.plan->clip_planes.empty() &&
         lattice.depth(patch.first_sheet) - lattice.sampling_distance() > lattice.near_depth();
}

// Sheet by sheet: all pixels of a tile if its place on the sheet meets a relevant brick. Where a
// brick is wider than a tile that is hardly more than pixel by pixel, which takes longer.
inline bool bin_tile(const CpuFrame& frame, const Patch& patch, const Block& block,
                     LatticeWorkspace::TileBits& bits) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  const std::uint32_t columns = (1U << block.x1) - 1U;
  bool any = false;
  for (std::int64_t sheet = patch.first_sheet; sheet < patch.last_sheet; ++sheet) {
    const view::SheetMap map = plan.lattice.index_map(sheet);
    Bounds3 box;
    for (const int x : {0, block.x1 - 1}) {
      for (const int y : {0, block.y1 - 1}) box.extend(map.at(block.tile_x + x, block.tile_y + y));
    }
    const bool is_relevant = plan.relevance.any_in(box.min(), box.max());
    RowBits& rows = bits.relevant[static_cast<std::size_t>(sheet - patch.first_sheet)];
    rows = {};
    if (is_relevant) std::fill_n(rows.begin(), block.y1, columns);
    any |= is_relevant;
  }
  return any;
}

// Which pixels of the patch's tiles are relevant.
inline bool bin_patch(const CpuFrame& frame, LatticeWorkspace& work, const Patch& patch) {
  Block& block = work.pixels.block;
  const bool has_all = has_whole_paths(frame, patch);
  bool any = false;
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    LatticeWorkspace::TileBits& bits = work.bits[t];
    bits.any_relevant = false;
    bits.visible = {};
    place_tile(block, patch, x, y);
    const TileState& tile = work.tiles[t];
    if (frame.stop_opaque && !tile.any_open(0, 0, block.x1, block.y1)) return;
    if (has_all) {
      bits.any_relevant = bin_tile(frame, patch, block, bits);
    } else {
      const Part part = part_of(block, patch);
      const Bounds3 box = box_of(frame, block, part, 0);
      set_up_block(frame, block, part, box);
      bits.any_relevant =
          !is_clipped_away(frame, block, part) && bin_region(frame, block, tile, box) > 0;
      for (int s = 0; s < block.num_sheets && bits.any_relevant; ++s) {
        RowBits& rows = bits.relevant[static_cast<std::size_t>(s)];
        rows = {};
        std::copy_n(block.relevant[s].begin(), block.rows, rows.begin());
      }
    }
    any |= bits.any_relevant;
  });
  return any;
}

enum class PatchResult { kDrawn, kNothingRelevant, kNeedsPixels, kTooLarge };

// kNeedsPixels: nothing was drawn, and the patch must be without nodes. kTooLarge: nor was it, but
// with fewer sheets it may be.
inline PatchResult draw_patch(const CpuFrame& frame, LatticeWorkspace& work, const Patch& patch,
                              StageClock& clock) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  Block& nodes = work.nodes.block;
  const Bounds3 box = set_up_nodes(frame, nodes, patch);
  if (!plan.relevance.any_in(box.min(), box.max())) return PatchResult::kNothingRelevant;
  const std::int64_t region =
      num_samples({nodes.region_size[0], nodes.region_size[1], nodes.region_size[2]});
  if (!nodes.is_interior) return PatchResult::kNeedsPixels;
  if (region > kMaxRegionSamples)
    return nodes.num_sheets > 1 ? PatchResult::kTooLarge : PatchResult::kNeedsPixels;
  if (!bin_patch(frame, work, patch)) return PatchResult::kNothingRelevant;
  clock.lap(kBin);
  load_region(frame, work.nodes, false);
  clock.lap(kLoad);
  if (!nodes.uses_four_taps) return PatchResult::kNeedsPixels;
  Block& pixels = work.pixels.block;
  pixels.first_sheet = patch.first_sheet;
  pixels.num_sheets = nodes.num_sheets;
  for (int s = 0; s < nodes.num_sheets; ++s) {
    pixels.sheets[s].depth = nodes.sheets[s].depth;
    pixels.sheets[s].inverse_pitch = nodes.sheets[s].inverse_pitch;
    pixels.sheets[s].near_cut = nodes.sheets[s].near_cut;
  }
  PatchWeights weights;
  for (int t = 0; t < kPatchTiles; ++t) {
    const auto how = frame.post_convolution;
    if (patch.rect.x0 + t * kTileSize < patch.rect.x1)
      weights.x[t] =
          node_weights(how, patch.pitch, patch.rect.x0 + t * kTileSize, patch.nodes_x.first);
    if (patch.rect.y0 + t * kTileSize < patch.rect.y1)
      weights.y[t] =
          node_weights(how, patch.pitch, patch.rect.y0 + t * kTileSize, patch.nodes_y.first);
  }
  for (int s = 0; s < nodes.num_sheets; ++s)
    draw_patch_sheet(frame, work, patch, weights, s, clock);
  return PatchResult::kDrawn;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
