// SPDX-License-Identifier: Apache-2.0
// Draws a patch of tiles on consecutive sheets. The field of a patch is sampled at nodes (nodes.h).
//
// The work on a sheet has two steps. First the field is reconstructed at the nodes that open and
// relevant pixels need. Then, tile by tile, post-convolution gives the pixels their values, and the
// pixels are classified. Where a pixel shows something, the gradients of the nodes are
// reconstructed and post-convolved too, and the pixel is lit and composited. For x-ray and mean
// pictures the sheets are summed at the nodes, and the sum alone is post-convolved.
//
// Nodes near the lattice's faces and holes have no value, because the field ends there within a
// pixel. A pixel near such a node is reconstructed from the kernels, without nodes.
#if defined(OVOID_RENDER_CPU_PATCH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_PATCH_INL_H_
#undef OVOID_RENDER_CPU_PATCH_INL_H_
#else
#define OVOID_RENDER_CPU_PATCH_INL_H_
#endif

#include "render/cpu/finish-inl.h"
#include "render/cpu/isosurface-inl.h"
#include "render/cpu/node_sheets-inl.h"
#include "render/cpu/post_convolve-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Calls body(number, column, row) for each tile of the patch.
template <class Body>
inline void for_each_tile(const Patch& patch, const Body& body) {
  for (int y = 0; patch.rect.y0 + y * kTileSize < patch.rect.y1; ++y) {
    for (int x = 0; patch.rect.x0 + x * kTileSize < patch.rect.x1; ++x) {
      body(static_cast<std::size_t>(y) * kPatchTiles + static_cast<std::size_t>(x), x, y);
    }
  }
}

// Moves the block to tile (x, y) of the patch.
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

// The first and the last row that has bits.
struct RowSpan {
  int first, last;
};

inline RowSpan rows_with_bits(const RowBits& bits, int rows) {
  RowSpan span{0, rows - 1};
  while (span.first < span.last && bits[span.first] == 0) ++span.first;
  while (span.last > span.first && bits[span.last] == 0) --span.last;
  return span;
}

// The columns of nodes that the pixels of a row need.
HWY_INLINE RowWord node_columns(RowWord pixels, const NodeBand& x) {
  RowWord columns = 0;
  for (RowWord left = pixels; left != 0;) {  // run by run
    const int first = std::countr_zero(left);
    const int last = first + std::countr_one(left >> first) - 1;
    const int from = x.taps[static_cast<std::size_t>(first)];
    const int past = x.taps[static_cast<std::size_t>(last)] + kFilterTaps;
    columns |= (~RowWord{0} >> (64 - past + from)) << from;
    left &= ~RowWord{0} << (last + 1);
  }
  return columns;
}

// Adds the nodes that a tile's pixels need.
inline void add_nodes(const RowBits& pixels, int rows, const NodeBand& x, const NodeBand& y,
                      RowBits& nodes) {
  for (int py = 0; py < rows;) {
    const int tap = y.taps[static_cast<std::size_t>(py)];
    RowWord together = 0;  // of the rows that take the same nodes
    for (; py < rows && y.taps[static_cast<std::size_t>(py)] == tap; ++py) together |= pixels[py];
    if (together == 0) continue;
    const RowWord columns = node_columns(together, x);
    for (int k = 0; k < kFilterTaps; ++k) nodes[tap + k] |= columns;
  }
}

struct PatchBands {
  NodeBand x[kPatchTiles], y[kPatchTiles];
};

inline void set_up_bands(const LatticeFrame& frame, const Block& nodes, const Patch& patch,
                         PatchBands& bands) {
  const auto how = frame.options->post_convolution;
  for (int t = 0; t < kPatchTiles; ++t) {
    const int x = patch.rect.x0 + t * kTileSize;
    const int y = patch.rect.y0 + t * kTileSize;
    if (x < patch.rect.x1)
      bands.x[t] = node_band(how, patch.node_step, x, patch.nodes_x.first - nodes.margin);
    if (y < patch.rect.y1)
      bands.y[t] = node_band(how, patch.node_step, y, patch.nodes_y.first - nodes.margin);
  }
}

// Computes a tile's pixels from a plane of nodes, in the rows from the first to the last that has
// bits.
inline void post_convolve_nodes(const float* nodes, const NodeBand& x, const NodeBand& y,
                                const RowBits& bits, int num_rows, float* pixels) {
  const RowSpan rows = rows_with_bits(bits, num_rows);
  post_convolve<false>(nodes, kPlaneStride, x, y, rows.first, rows.last, kTileSize, pixels,
                       kPlaneStride);
}

// Gives the pixels the region of the lattice that the nodes have loaded, for samples on sheet s, on
// the sheet before it and between the two.
inline void share_region(const LatticeFrame& frame, LatticeWorkspace& work, int s) {
  const Block& nodes = work.nodes.block;
  Block& pixels = work.pixels.block;
  work.pixels.samples = work.nodes.samples;
  work.pixels.presence = work.nodes.presence;
  std::copy_n(nodes.origin, 3, pixels.origin);
  std::copy_n(nodes.region_lo, 3, pixels.region_lo);
  std::copy_n(nodes.region_size, 3, pixels.region_size);
  pixels.row_stride = nodes.row_stride;
  pixels.slice_stride = nodes.slice_stride;
  pixels.sublattice_stride = nodes.sublattice_stride;
  pixels.is_interior = nodes.is_interior;
  pixels.has_missing = nodes.has_missing;
  pixels.uses_four_taps = nodes.uses_four_taps;
  const SampleGrid grid{static_cast<double>(pixels.tile_x), static_cast<double>(pixels.tile_y),
                        1.0};
  const SheetMaps maps = sheet_maps(frame, pixels.first_sheet);
  for (int sheet = std::max(s - 1, 0); sheet <= s; ++sheet)
    set_up_sheet(frame, pixels, grid, sheet, maps,
                 frame.lattice_plan->widening(pixels.first_sheet + sheet));
}

// Computes the gradients of the visible pixels from the gradients of the nodes. The gradients of
// pieces, which lie between sheets, and of pixels without nodes are computed from the kernels.
inline void post_convolve_gradients(const LatticeFrame& frame, LatticeWorkspace& work,
                                    const Patch& patch, int s, const NodeBand& x, const NodeBand& y,
                                    const RowBits& by_themselves) {
  Block& pixels = work.pixels.block;
  Block& nodes = work.nodes.block;
  if (frame.is_preintegrated && !frame.takes_differences) {
    gradient_of_pieces(frame, work.pixels, s, pixels.visible);
    return;
  }
  RowBits wanted;
  clear_bits(wanted);
  if (is_whole(nodes)) {
    add_nodes(pixels.visible, pixels.rows, x, y, wanted);
  } else {
    RowBits others;
    for (int row = 0; row < pixels.rows; ++row)
      others[row] = pixels.visible[row] & ~by_themselves[row];
    add_nodes(others, pixels.rows, x, y, wanted);
  }
  provide_node_gradients(frame, work.nodes, s, patch, wanted);
  for (int a = 0; a < 3; ++a)
    post_convolve_nodes(nodes.gradient[a], x, y, pixels.visible, pixels.rows, pixels.gradient[a]);
  if (is_whole(nodes)) return;
  RowBits own;
  clear_bits(own);
  for (int row = 0; row < pixels.rows; ++row) own[row] = pixels.visible[row] & by_themselves[row];
  gradients_of(frame, work.pixels, s, own);
}

// Keeps the bits of the pixels around which all nodes have values.
inline void keep_whole(const RowBits& defined, const NodeBand& x, const NodeBand& y, int rows,
                       RowBits& bits) {
  constexpr RowWord kAll = (RowWord{1} << kFilterTaps) - 1;
  for (int py = 0; py < rows;) {
    const int tap = y.taps[static_cast<std::size_t>(py)];
    RowWord columns = ~RowWord{0};
    for (int k = 0; k < kFilterTaps; ++k) columns &= defined[tap + k];
    RowWord pixels = 0;
    for (int px = 0; px < kTileSize; ++px) {
      const bool has_all = (columns >> x.taps[static_cast<std::size_t>(px)] & kAll) == kAll;
      pixels |= RowWord{has_all} << px;
    }
    for (; py < rows && y.taps[static_cast<std::size_t>(py)] == tap; ++py) bits[py] &= pixels;
  }
}

// Reconstructs the pixels around which a node has no value from the kernels, on sheet s and, for
// pieces, on sheet s - 1. On entry block.defined names the pixels that need a value, on return the
// pixels that have one. `by_themselves` becomes the reconstructed pixels of sheet s.
inline void complete_pixels(const LatticeFrame& frame, LatticeWorkspace& work, int s,
                            const NodeBand& x, const NodeBand& y, RowBits& by_themselves) {
  Block& block = work.pixels.block;
  const Block& nodes = work.nodes.block;
  RowBits given;
  clear_bits(given);
  std::copy_n(block.defined[s & (kRingSheets - 1)].begin(), block.rows, given.begin());
  // A front end is given only where the piece's own end is.
  for (int sheet = s; sheet >= (frame.has_pieces ? s - 1 : s); --sheet) {
    RowBits& defined = block.defined[sheet & (kRingSheets - 1)];
    keep_whole(nodes.defined[sheet & (kRingSheets - 1)], x, y, block.rows, given);
    RowBits others;
    clear_bits(others);
    for (int row = 0; row < block.rows; ++row) {
      others[row] = defined[row] & ~given[row];
      defined[row] &= given[row];
    }
    work.pixels.stats.samples_reconstructed += count_bits(block, others);
    reconstruct_sheet(frame, work.pixels, sheet, others);
    if (sheet == s) by_themselves = others;
  }
}

// Finds the pixels of a tile that are relevant and open on sheet s. False if there is none.
inline bool take_pixels(const CpuFrame& frame, const LatticeWorkspace& work, std::size_t t, int s,
                        RowBits& bits) {
  const LatticeWorkspace::TileBits& of_tile = work.bits[t];
  if (!of_tile.any_relevant) return false;
  const RowBits& relevant = of_tile.relevant[static_cast<std::size_t>(s)];
  const std::uint32_t* open = work.tiles[t].open;
  const std::uint32_t always = frame.options->stop_opaque ? 0U : ~0U;
  RowWord any = 0;
  for (int y = 0; y < kTileSize; ++y) any |= bits[y] = relevant[y] & (open[y] | always);
  return any != 0;
}

// Finishes one tile on sheet s, whose nodes have been reconstructed. `bits`: the pixels that are
// relevant and open.
inline void finish_patch_tile(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                              std::size_t t, int s, const RowBits& bits, const NodeBand& x,
                              const NodeBand& y, StageClock& clock) {
  Block& block = work.pixels.block;
  work.pixels.tile = &work.tiles[t];
  block.rays = &work.rays[t];
  work.bits[t].any_visible = false;
  for (int sheet = frame.has_pieces ? s - 1 : s; sheet <= s; ++sheet) {
    const int plane = sheet & (kRingSheets - 1);
    post_convolve_nodes(work.nodes.block.values[plane], x, y, bits, block.rows,
                        block.values[plane]);
    block.defined[plane] = bits;
  }
  // A piece whose front end is cut away begins at its sample.
  if (frame.has_pieces && !patch.is_binned_by_tile) {
    const RowBits& kept = work.bits[t].relevant[static_cast<std::size_t>(s) - 1];
    RowBits& before = block.defined[(s - 1) & (kRingSheets - 1)];
    for (int row = 0; row < block.rows; ++row) before[row] &= kept[row];
  }
  const bool has_all = is_whole(work.nodes.block);
  if (frame.has_pieces || !has_all) share_region(frame, work, s);
  RowBits by_themselves;
  if (!has_all) complete_pixels(frame, work, s, x, y, by_themselves);
  clock.lap(kReconstruct);
  if (frame.mode == Mode::kIsosurface) {
    surface_sheet(frame, work.pixels, s);
    clock.lap(kShade);
  } else if (finish_samples(frame, block, work.tiles[t], work.pixels.stats, s,
                            block.defined[s & (kRingSheets - 1)], nullptr, clock, [&] {
                              post_convolve_gradients(frame, work, patch, s, x, y, by_themselves);
                            })) {
    work.bits[t].any_visible = true;
    std::copy_n(block.visible.begin(), kTileSize, work.bits[t].visible.begin());
  }
}

inline void finish_patch_sheet(const LatticeFrame& frame, LatticeWorkspace& work,
                               const Patch& patch, const PatchBands& bands, int s,
                               StageClock& clock) {
  if (frame.takes_differences) work.nodes.block.has_gradient = {};
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    RowBits bits;
    if (!take_pixels(frame, work, t, s, bits)) return;
    place_tile(work.pixels.block, patch, x, y);
    finish_patch_tile(frame, work, patch, t, s, bits, bands.x[x], bands.y[y], clock);
  });
}

struct WantedNodes {
  RowBits values{};
  RowBits gradients{};  // a guess: the nodes of pixels that were visible on the sheet before
};

// Adds the bits beside, above and below those that are set.
inline void add_neighbours(RowBits& bits, int rows) {
  RowWord above = 0;
  for (int row = 0; row < rows; ++row) {
    const RowWord here = bits[row];
    const RowWord below = row + 1 < rows ? bits[row + 1] : 0;
    bits[row] |= here << 1 | here >> 1 | above | below;
    above = here;
  }
}

inline WantedNodes wanted_nodes(const LatticeFrame& frame, const LatticeWorkspace& work,
                                const Patch& patch, const PatchBands& bands, int s) {
  WantedNodes wanted;
  const Block& nodes = work.nodes.block;
  // A piece may also begin on this sheet, and differences need the neighbours on both sides.
  const bool takes_behind = frame.has_pieces || frame.takes_differences;
  const int first = std::max(frame.takes_differences ? s - 1 : s, nodes.front_margin);
  const int last = std::min(takes_behind ? s + 1 : s, nodes.num_sheets - nodes.back_margin - 1);
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    RowBits bits;
    for (int sheet = last; sheet >= first; --sheet) {
      if (take_pixels(frame, work, t, sheet, bits))
        add_nodes(bits, kTileSize, bands.x[x], bands.y[y], wanted.values);
    }
    if (!frame.takes_gradients || takes_behind || !work.bits[t].any_visible) return;
    for (int row = 0; row < kTileSize; ++row) bits[row] &= work.bits[t].visible[row];
    add_nodes(bits, kTileSize, bands.x[x], bands.y[y], wanted.gradients);
  });
  if (frame.takes_differences) add_neighbours(wanted.values, nodes.rows);
  for (int row = 0; row < nodes.rows; ++row) {
    wanted.values[row] &= nodes.active[s][row];
    wanted.gradients[row] &= nodes.active[s][row];
  }
  return wanted;
}

inline void draw_patch_sheets(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                              const PatchBands& bands, StageClock& clock) {
  const Block& nodes = work.nodes.block;
  for (int s = 0; s < nodes.num_sheets; ++s) {
    const WantedNodes wanted = wanted_nodes(frame, work, patch, bands, s);
    if (!has_bits(wanted.values, nodes.rows)) {
      work.nodes.block.defined[s & (kRingSheets - 1)] = {};
    } else {
      reconstruct_nodes(frame, work.nodes, s, wanted.values, wanted.gradients, clock);
    }
    // Differences need the next sheet, so the sheet before this one is finished now.
    const int finished = frame.takes_differences ? s - 1 : s;
    if (finished >= nodes.front_margin)
      finish_patch_sheet(frame, work, patch, bands, finished, clock);
  }
}

// True if the pixels are functions of the sheets' sum: no sample has a shortened path, is left out
// or has no value.
inline bool counts_sums(const LatticeFrame& frame, const Block& nodes, const Patch& patch) {
  return (frame.mode == Mode::kXray || frame.mode == Mode::kMean) && patch.is_binned_by_tile &&
         is_whole(nodes) && !frame.lattice_plan->may_matter;
}

// X-ray and mean: sums the sheets at the nodes, then post-convolves the sum once.
inline void draw_patch_sum(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                           const PatchBands& bands, StageClock& clock) {
  Block& nodes = work.nodes.block;
  std::fill_n(work.node_sums, nodes.rows * kPlaneStride, 0.0F);
  RowBits all{};
  std::copy_n(nodes.active[0].begin(), nodes.rows, all.begin());
  for (int s = 0; s < nodes.num_sheets; ++s) {
    reconstruct_nodes(frame, work.nodes, s, all, {}, clock);
    const float* values = nodes.values[s & (kRingSheets - 1)];
    for (int row = 0; row < nodes.rows; ++row) {
      for (int i = row * kPlaneStride; i < row * kPlaneStride + nodes.columns; ++i)
        work.node_sums[i] += values[i];
    }
  }
  Block& pixels = work.pixels.block;
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    place_tile(pixels, patch, x, y);
    pixels.rays = &work.rays[t];
    RowBits bits{};
    std::fill_n(bits.begin(), pixels.rows, (1U << pixels.columns) - 1U);
    post_convolve_nodes(work.node_sums, bands.x[x], bands.y[y], bits, pixels.rows,
                        pixels.values[0]);
    clock.lap(kReconstruct);
    accumulate_sum(frame, pixels, work.tiles[t], nodes.num_sheets, nodes.sheets[0].depth);
    clock.lap(kComposite);
  });
}

// True if neither a clip plane nor the near plane shortens a sample's path.
inline bool are_paths_whole(const CpuFrame& frame, const Patch& patch) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  return frame.plan->clip_planes.empty() &&
         lattice.depth(patch.first_sheet) - lattice.sampling_distance() > lattice.near_depth();
}

// Decides sheet by sheet for all pixels of a tile together: they are relevant if the tile's place
// on the sheet, or for pieces the place between this sheet and the one before, meets a relevant
// brick. Where bricks are wider than tiles this finds hardly more pixels than bin_pixels() and is
// faster.
inline bool bin_tile(const LatticeFrame& frame, const Block& block, const Block& nodes,
                     LatticeWorkspace::TileBits& bits) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  const std::uint32_t columns = (1U << block.x1) - 1U;
  bool any = false;
  for (int s = nodes.front_margin; s < nodes.num_sheets - nodes.back_margin; ++s) {
    Bounds3 box;
    for (int sheet = frame.has_pieces ? s - 1 : s; sheet <= s; ++sheet) {
      const view::SheetMap map = plan.lattice.index_map(nodes.first_sheet + sheet);
      for (const int x : {0, block.x1 - 1}) {
        for (const int y : {0, block.y1 - 1})
          box.extend(map.at(block.tile_x + x, block.tile_y + y));
      }
    }
    const bool is_relevant = plan.relevance.any_in(box.min(), box.max());
    RowBits& rows = bits.relevant[static_cast<std::size_t>(s)];
    rows = {};
    if (is_relevant) std::fill_n(rows.begin(), block.y1, columns);
    any |= is_relevant;
  }
  return any;
}

// Decides for each pixel. Samples that planes cut away are not relevant.
inline bool bin_pixels(const LatticeFrame& frame, Block& block, const Block& nodes,
                       const Patch& patch, const TileState& tile,
                       LatticeWorkspace::TileBits& bits) {
  block.margin = 0;
  block.front_margin = nodes.front_margin;
  block.back_margin = nodes.back_margin;
  const Part part = part_of(block, patch);
  const Bounds3 box = box_of(frame, block, part, 0);
  const view::LatticePlan& plan = *frame.lattice_plan;
  if (!box.intersects(plan.index_support) || !plan.relevance.any_in(box.min(), box.max()) ||
      is_clipped_away(frame, block, part))
    return false;
  set_up_block(frame, block, part, box);
  if (bin_region(frame, block, tile, box) == 0) return false;
  for (int s = 0; s < block.num_sheets; ++s) {
    RowBits& rows = bits.relevant[static_cast<std::size_t>(s)];
    rows = {};
    std::copy_n(block.relevant[s].begin(), block.rows, rows.begin());
  }
  return true;
}

// Finds the relevant pixels of the patch's tiles. False if there is none.
inline bool bin_patch(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch) {
  Block& block = work.pixels.block;
  bool any = false;
  for_each_tile(patch, [&](std::size_t t, int x, int y) {
    LatticeWorkspace::TileBits& bits = work.bits[t];
    bits.any_relevant = false;
    bits.any_visible = false;
    place_tile(block, patch, x, y);
    const TileState& tile = work.tiles[t];
    if (frame.options->stop_opaque && !tile.any_open(0, 0, block.x1, block.y1)) return;
    bits.any_relevant = patch.is_binned_by_tile
                            ? bin_tile(frame, block, work.nodes.block, bits)
                            : bin_pixels(frame, block, work.nodes.block, patch, tile, bits);
    any |= bits.any_relevant;
  });
  return any;
}

enum class PatchResult { kDrawn, kNothingRelevant, kNeedsPixels, kTooLarge };

// kNeedsPixels: nothing was drawn, and the patch must be drawn without nodes. kTooLarge: nothing
// was drawn, and the patch may be drawn with fewer sheets.
inline PatchResult draw_patch(const LatticeFrame& frame, LatticeWorkspace& work, Patch patch,
                              StageClock& clock) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  Block& nodes = work.nodes.block;
  Block& pixels = work.pixels.block;
  const NodePlace place = place_nodes(frame, nodes, patch);
  if (!plan.relevance.any_in(place.box.min(), place.box.max()))
    return PatchResult::kNothingRelevant;
  set_up_nodes(frame, nodes, patch, place);
  const std::int64_t region =
      num_samples({nodes.region_size[0], nodes.region_size[1], nodes.region_size[2]});
  // Sheets in front of the near plane have no samples.
  const bool has_front = plan.lattice.depth(nodes.first_sheet) > plan.lattice.near_depth();
  if (!has_front) return PatchResult::kNeedsPixels;
  patch.is_binned_by_tile = nodes.is_interior && are_paths_whole(frame, patch);
  if (region > kMaxRegionSamples && patch.last_sheet - patch.first_sheet > 1)
    return PatchResult::kTooLarge;
  if (!bin_patch(frame, work, patch)) return PatchResult::kNothingRelevant;
  clock.lap(kBin);
  const bool are_defined = load_nodes(frame, work.nodes, patch);
  clock.lap(kLoad);
  if (!are_defined) return PatchResult::kNeedsPixels;
  pixels.margin = 0;
  pixels.first_sheet = nodes.first_sheet;
  pixels.num_sheets = nodes.num_sheets;
  for (int s = 0; s < nodes.num_sheets; ++s) {
    pixels.sheets[s].depth = nodes.sheets[s].depth;
    pixels.sheets[s].near_cut = nodes.sheets[s].near_cut;
  }
  PatchBands bands;
  set_up_bands(frame, nodes, patch, bands);
  if (counts_sums(frame, nodes, patch)) {
    draw_patch_sum(frame, work, patch, bands, clock);
  } else {
    draw_patch_sheets(frame, work, patch, bands, clock);
  }
  return PatchResult::kDrawn;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
