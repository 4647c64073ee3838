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

#include "render/cpu/kernels/post_convolve-inl.h"
#include "render/cpu/lattice/lattice_pieces-inl.h"
#include "render/cpu/lattice/node_sheets-inl.h"
#include "render/cpu/shade/finish-inl.h"
#include "render/cpu/shade/isosurface-inl.h"
#include "render/cpu/ticks.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Tile (x, y) of a patch.
struct PatchTile {
  std::size_t number;
  int x, y;
};

// Calls body(tile) for each tile of the patch.
template <class Body>
inline void for_each_tile(const Patch& patch, const Body& body) {
  for (int y = 0; patch.rect.y0 + y * kTileSize < patch.rect.y1; ++y) {
    for (int x = 0; patch.rect.x0 + x * kTileSize < patch.rect.x1; ++x) {
      body(
          PatchTile{static_cast<std::size_t>(y) * kPatchTiles + static_cast<std::size_t>(x), x, y});
    }
  }
}

// Moves a block to a tile of the patch.
inline void place_tile(const Patch& patch, const PatchTile& tile, BlockPlace& place) {
  place.tile_x = patch.rect.x0 + tile.x * kTileSize;
  place.tile_y = patch.rect.y0 + tile.y * kTileSize;
  place.x0 = place.y0 = 0;
  place.x1 = std::min(patch.rect.x1 - place.tile_x, kTileSize);
  place.y1 = std::min(patch.rect.y1 - place.tile_y, kTileSize);
  place.columns = place.x1;
  place.rows = place.y1;
}

inline Part part_of(const BlockPlace& place, const Patch& patch) {
  return {0, 0, place.x1, place.y1, patch.first_sheet, patch.last_sheet};
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
inline void add_nodes(const RowBits& pixels, int rows, const TileBands& bands, RowBits& nodes) {
  const NodeBand& y = bands.y;
  for (int py = 0; py < rows;) {
    const int tap = y.taps[static_cast<std::size_t>(py)];
    RowWord together = 0;  // of the rows that take the same nodes
    for (; py < rows && y.taps[static_cast<std::size_t>(py)] == tap; ++py) together |= pixels[py];
    if (together == 0) continue;
    const RowWord columns = node_columns(together, bands.x);
    for (int k = 0; k < kFilterTaps; ++k) nodes[tap + k] |= columns;
  }
}

inline void set_up_bands(const LatticeFrame& frame, const Patch& patch, int margin,
                         PatchBands& bands) {
  const auto how = frame.options->post_convolution;
  for (int t = 0; t < kPatchTiles; ++t) {
    const int x = patch.rect.x0 + t * kTileSize;
    const int y = patch.rect.y0 + t * kTileSize;
    if (x < patch.rect.x1)
      bands.x[t] = node_band(how, patch.node_step, x, patch.nodes_x.first - margin);
    if (y < patch.rect.y1)
      bands.y[t] = node_band(how, patch.node_step, y, patch.nodes_y.first - margin);
  }
}

// Computes a tile's pixels from a plane of nodes, in the rows from the first to the last that has
// bits.
inline void post_convolve_nodes(const float* nodes, const TileBands& bands, const RowBits& bits,
                                int num_rows, float* pixels) {
  const RowSpan rows = rows_with_bits(bits, num_rows);
  post_convolve<false>({nodes, kNodePlane.stride}, bands.x, bands.y,
                       {rows.first, rows.last, kTileSize}, {pixels, kTilePlane.stride});
}

// Gives the pixels the region of the lattice that the nodes have loaded, for samples on sheet s, on
// the sheet before it and between the two.
inline void share_region(const LatticeFrame& frame, LatticeWorkspace& work, int s) {
  Block& pixels = work.pixels.block;
  const BlockPlace& place = pixels.place;
  pixels.region = work.nodes.block.region;
  const SampleGrid grid{static_cast<double>(place.tile_x), static_cast<double>(place.tile_y), 1.0};
  const SheetMaps maps = sheet_maps(frame, place.first_sheet);
  for (int sheet = std::max(s - 1, 0); sheet <= s; ++sheet)
    set_up_sheet(frame, pixels, grid, sheet, maps,
                 frame.lattice_plan->widening(place.number_of(sheet)));
}

// Computes the gradients of the visible pixels from the gradients of the nodes. The gradients of
// pixels without nodes are computed from the kernels.
inline void post_convolve_gradients(const LatticeFrame& frame, LatticeWorkspace& work,
                                    const Patch& patch, int s, const TileBands& bands,
                                    const RowBits& visible, const RowBits& by_themselves) {
  const BlockPlace& place = work.pixels.block.place;
  const bool has_all = is_whole(work.nodes.block.region);
  RowBits wanted;
  clear_bits(wanted);
  if (has_all) {
    add_nodes(visible, place.rows, bands, wanted);
  } else {
    RowBits others;
    for (int row = 0; row < place.rows; ++row) others[row] = visible[row] & ~by_themselves[row];
    add_nodes(others, place.rows, bands, wanted);
  }
  provide_node_gradients(frame, work.nodes, s, patch, wanted);
  const Sheet& nodes = work.nodes.ring[place.number_of(s)];
  const Sheet& pixels = work.pixels.ring[place.number_of(s)];
  for (std::size_t a = 0; a < 3; ++a)
    post_convolve_nodes(nodes.gradient[a], bands, visible, place.rows, pixels.gradient[a]);
  if (has_all) return;
  RowBits own;
  clear_bits(own);
  for (int row = 0; row < place.rows; ++row) own[row] = visible[row] & by_themselves[row];
  gradients_of(frame, work.pixels, s, own);
}

// The pixels of a tile that were not made from nodes, on a sheet and on the one before it.
struct OwnPixels {
  RowBits on_sheet, before;
};

// The gradients that a tile's visible samples or pieces take.
inline void provide_pixel_gradients(const LatticeFrame& frame, LatticeWorkspace& work,
                                    const Patch& patch, int s, const TileBands& bands,
                                    const OwnPixels& own) {
  const RowBits& visible = work.pixels.shaded.visible;
  if (frame.is_preintegrated && !frame.takes_differences) {
    gradient_of_pieces(frame, work.pixels, s, visible);
    return;
  }
  if (!frame.is_refined) {
    post_convolve_gradients(frame, work, patch, s, bands, visible, own.on_sheet);
    return;
  }
  const BlockPlace& place = work.pixels.block.place;
  for (const int end : {s - 1, s}) {
    RowBits wanted;
    clear_bits(wanted);
    const RowBits& defined = work.pixels.ring[place.number_of(end)].defined;
    for (int row = 0; row < place.rows; ++row) wanted[row] = visible[row] & defined[row];
    post_convolve_gradients(frame, work, patch, end, bands, wanted,
                            end == s ? own.on_sheet : own.before);
  }
}

// Keeps the bits of the pixels around which all nodes have values.
inline void keep_whole(const RowBits& defined, const TileBands& bands, int rows, RowBits& bits) {
  const auto& [x, y] = bands;
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
// pieces, on sheet s - 1. On entry the sheets' defined bits name the pixels that need a value, on
// return the pixels that have one. `own` becomes the reconstructed pixels.
inline void complete_pixels(const LatticeFrame& frame, LatticeWorkspace& work, int s,
                            const TileBands& bands, OwnPixels& own) {
  const BlockPlace& place = work.pixels.block.place;
  RowBits given;
  clear_bits(given);
  std::copy_n(work.pixels.ring[place.number_of(s)].defined.begin(), place.rows, given.begin());
  // A front end is given only where the piece's own end is.
  for (int sheet = s; sheet >= (frame.has_pieces ? s - 1 : s); --sheet) {
    RowBits& defined = work.pixels.ring[place.number_of(sheet)].defined;
    keep_whole(work.nodes.ring[place.number_of(sheet)].defined, bands, place.rows, given);
    RowBits& others = sheet == s ? own.on_sheet : own.before;
    clear_bits(others);
    for (int row = 0; row < place.rows; ++row) {
      others[row] = defined[row] & ~given[row];
      defined[row] &= given[row];
    }
    work.pixels.stats.samples_reconstructed += count_bits(others, place.rows);
    reconstruct_sheet(frame, work.pixels, sheet, others);
  }
}

// Finds the pixels of a tile that are relevant and open on sheet s. False if there is none.
inline bool take_pixels(const CpuFrame& frame, const LatticeWorkspace& work, std::size_t t, int s,
                        RowBits& bits) {
  const LatticeWorkspace::TileBits& of_tile = work.bits[t];
  if (!of_tile.any_relevant) return false;
  const RowBits& relevant = of_tile.relevant[static_cast<std::size_t>(s)];
  const RowWord* open = work.tiles[t].open;
  const RowWord always = frame.options->stop_opaque ? 0 : ~RowWord{0};
  RowWord any = 0;
  for (int y = 0; y < kTileSize; ++y) any |= bits[y] = relevant[y] & (open[y] | always);
  return any != 0;
}

// Values of a tile's pixels on a sheet, from the nodes, for those named by `bits`. Which of them
// are wanted there becomes the sheet's defined bits.
inline void take_values_from_nodes(LatticeWorkspace& work, const TileBands& bands, int s,
                                   const RowBits& bits, const RowBits& wanted) {
  const BlockPlace& place = work.pixels.block.place;
  Sheet& pixels = work.pixels.ring[place.number_of(s)];
  post_convolve_nodes(work.nodes.ring[place.number_of(s)].values, bands, bits, place.rows,
                      pixels.values);
  for (int row = 0; row < place.rows; ++row) pixels.defined[row] = bits[row] & wanted[row];
  clear_bits(pixels.has_gradient);
  clear_bits(pixels.is_classified);
  clear_bits(pixels.has_light);
}

// Finishes one tile on sheet s, whose nodes have been reconstructed.
inline void finish_patch_tile(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                              const PatchTile& tile, int s, StageClock& clock) {
  const TileBands bands = patch.bands->of_tile(tile.x, tile.y);
  RowBits bits;
  clear_bits(bits);
  if (!take_pixels(frame, work, tile.number, s, bits)) return;
  LatticeWorkspace::TileBits& of_tile = work.bits[tile.number];
  Workspace& own = work.pixels;
  BlockPlace& place = own.block.place;
  place_tile(patch, tile, place);
  own.tile = &work.tiles[tile.number];
  place.rays = &work.rays[tile.number];
  place.limits = frame.limits == nullptr ? nullptr : &work.limits[tile.number];
  of_tile.any_visible = false;
  const auto wanted_on = [&](int sheet) -> const RowBits& {
    return patch.is_binned_by_tile ? bits : of_tile.active[static_cast<std::size_t>(sheet)];
  };
  // A piece whose front end is cut away begins at its sample.
  if (frame.has_pieces) take_values_from_nodes(work, bands, s - 1, bits, wanted_on(s - 1));
  take_values_from_nodes(work, bands, s, bits, wanted_on(s));
  const bool has_all = is_whole(work.nodes.block.region);
  if (frame.has_pieces || !has_all) share_region(frame, work, s);
  OwnPixels own_pixels;
  if (!has_all) complete_pixels(frame, work, s, bands, own_pixels);
  clock.lap(kReconstruct);
  const auto provide_gradients = [&] {
    provide_pixel_gradients(frame, work, patch, s, bands, own_pixels);
  };
  if (frame.mode == Mode::kIsosurface) {
    surface_sheet(frame, own, s);
    clock.lap(kShade);
    return;
  }
  const RowBits& defined = own.ring[place.number_of(s)].defined;
  const bool is_visible =
      frame.is_refined ? finish_pieces(frame, own.in_hand(), s, bits,
                                       LatticePieces{frame, own.block}, clock, provide_gradients)
                       : finish_samples(frame, own.in_hand(), s, defined, clock, provide_gradients);
  if (!is_visible) return;
  of_tile.any_visible = true;
  std::copy_n(own.shaded.visible.begin(), kTileSize, of_tile.visible.begin());
}

inline void finish_patch_sheet(const LatticeFrame& frame, LatticeWorkspace& work,
                               const Patch& patch, int s, StageClock& clock) {
  for_each_tile(
      patch, [&](const PatchTile& tile) { finish_patch_tile(frame, work, patch, tile, s, clock); });
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
                                const Patch& patch, int s) {
  WantedNodes wanted;
  const Block& nodes = work.nodes.block;
  // A piece may also begin on this sheet, and differences need the neighbours on both sides.
  const bool takes_behind = frame.has_pieces || frame.takes_differences;
  const int first = std::max(frame.takes_differences ? s - 1 : s, nodes.place.front_margin);
  const int last =
      std::min(takes_behind ? s + 1 : s, nodes.place.num_sheets - nodes.place.back_margin - 1);
  for_each_tile(patch, [&](const PatchTile& at) {
    RowBits bits;
    for (int sheet = last; sheet >= first; --sheet) {
      if (take_pixels(frame, work, at.number, sheet, bits))
        add_nodes(bits, kTileSize, patch.bands->of_tile(at.x, at.y), wanted.values);
    }
    if (!frame.takes_gradients || takes_behind || !work.bits[at.number].any_visible) return;
    for (int row = 0; row < kTileSize; ++row) bits[row] &= work.bits[at.number].visible[row];
    add_nodes(bits, kTileSize, patch.bands->of_tile(at.x, at.y), wanted.gradients);
  });
  if (frame.takes_differences) add_neighbours(wanted.values, nodes.place.rows);
  for (int row = 0; row < nodes.place.rows; ++row) {
    wanted.values[row] &= nodes.bits.active[s][row];
    wanted.gradients[row] &= nodes.bits.active[s][row];
  }
  return wanted;
}

inline void draw_patch_sheets(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                              StageClock& clock) {
  const Block& nodes = work.nodes.block;
  for (int s = 0; s < nodes.place.num_sheets; ++s) {
    const WantedNodes wanted = wanted_nodes(frame, work, patch, s);
    reconstruct_nodes(frame, work.nodes, s, wanted.values, wanted.gradients, clock);
    // Differences need the next sheet, so the sheet before this one is finished now.
    const int finished = frame.takes_differences ? s - 1 : s;
    if (finished >= nodes.place.front_margin)
      finish_patch_sheet(frame, work, patch, finished, clock);
  }
}

// True if the pixels are functions of the sheets' sum: no sample has a shortened path, is left out
// or has no value.
inline bool counts_sums(const LatticeFrame& frame, const Block& nodes, const Patch& patch) {
  return (frame.mode == Mode::kXray || frame.mode == Mode::kMean) && patch.is_binned_by_tile &&
         is_whole(nodes.region) && !frame.lattice_plan->may_matter;
}

// X-ray and mean: sums the sheets at the nodes, then post-convolves the sum once.
inline void draw_patch_sum(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch,
                           StageClock& clock) {
  const Block& nodes = work.nodes.block;
  const BlockPlace& place = nodes.place;
  std::fill_n(work.node_sums, place.rows * kNodePlane.stride, 0.0F);
  RowBits all{};
  std::copy_n(nodes.bits.active[0].begin(), place.rows, all.begin());
  for (int s = 0; s < place.num_sheets; ++s) {
    reconstruct_nodes(frame, work.nodes, s, all, {}, clock);
    const float* values = work.nodes.ring[place.number_of(s)].values;
    for (int row = 0; row < place.rows; ++row) {
      const int first = row * kNodePlane.stride;
      for (int i = first; i < first + place.columns; ++i) work.node_sums[i] += values[i];
    }
  }
  BlockPlace& pixels = work.pixels.block.place;
  float* const sums = work.pixels.ring[place.first_sheet].values;
  for_each_tile(patch, [&](const PatchTile& at) {
    place_tile(patch, at, pixels);
    pixels.rays = &work.rays[at.number];
    RowBits bits{};
    std::fill_n(bits.begin(), pixels.rows, first_bits(pixels.columns));
    post_convolve_nodes(work.node_sums, patch.bands->of_tile(at.x, at.y), bits, pixels.rows, sums);
    clock.lap(kReconstruct);
    accumulate_sum(frame, pixels, sums, work.tiles[at.number]);
    clock.lap(kComposite);
  });
}

// True if neither depth limits nor a clip plane nor the near plane shorten a sample's path.
inline bool are_paths_whole(const CpuFrame& frame, const Patch& patch) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  return frame.limits == nullptr && frame.plan->clip_planes.empty() &&
         lattice.depth(patch.first_sheet) - lattice.sampling_distance() > lattice.near_depth();
}

// Decides sheet by sheet for all pixels of a tile together: they are relevant if the tile's place
// on the sheet, or for pieces the place between this sheet and the one before, meets a relevant
// brick. Where bricks are wider than tiles this finds hardly more pixels than bin_pixels() and is
// faster.
inline bool bin_tile(const LatticeFrame& frame, const BlockPlace& tile, const BlockPlace& nodes,
                     LatticeWorkspace::TileBits& bits) {
  const view::LatticePlan& plan = *frame.lattice_plan;
  const RowWord columns = first_bits(tile.x1);
  bool any = false;
  for (int s = nodes.front_margin; s < nodes.num_sheets - nodes.back_margin; ++s) {
    Bounds3 box;
    for (int sheet = frame.has_pieces ? s - 1 : s; sheet <= s; ++sheet) {
      const view::SheetMap map = plan.lattice.index_map(nodes.number_of(sheet));
      for (const int x : {0, tile.x1 - 1}) {
        for (const int y : {0, tile.y1 - 1}) box.extend(map.at(tile.tile_x + x, tile.tile_y + y));
      }
    }
    const bool is_relevant = plan.relevance.any_in(box.min(), box.max());
    RowBits& rows = bits.relevant[static_cast<std::size_t>(s)];
    rows = {};
    if (is_relevant) std::fill_n(rows.begin(), tile.y1, columns);
    any |= is_relevant;
  }
  return any;
}

// Decides for each pixel. Samples that planes cut away are not relevant.
inline bool bin_pixels(const LatticeFrame& frame, const Patch& patch, const BlockPlace& nodes,
                       Block& block, TileState& tile, LatticeWorkspace::TileBits& bits) {
  BlockPlace& place = block.place;
  place.margin = 0;
  place.front_margin = nodes.front_margin;
  place.back_margin = nodes.back_margin;
  const Part part = part_of(place, patch);
  const Bounds3 box = box_of(frame, place, part, 0);
  const view::LatticePlan& plan = *frame.lattice_plan;
  if (!box.intersects(plan.index_support) || !plan.relevance.any_in(box.min(), box.max()) ||
      is_clipped_away(frame, place, part))
    return false;
  set_up_block(frame, block, part, box);
  if (!bin_region(frame, block, wanted_of_block(frame, place, tile), box)) return false;
  for (int s = 0; s < place.num_sheets; ++s) {
    RowBits& rows = bits.relevant[static_cast<std::size_t>(s)];
    rows = {};
    std::copy_n(block.bits.relevant[s].begin(), place.rows, rows.begin());
    bits.active[static_cast<std::size_t>(s)] = block.bits.active[s];
  }
  return true;
}

// Finds the relevant pixels of the patch's tiles. False if there is none.
inline bool bin_patch(const LatticeFrame& frame, LatticeWorkspace& work, const Patch& patch) {
  Block& block = work.pixels.block;
  const BlockPlace& place = block.place;
  const BlockPlace& nodes = work.nodes.block.place;
  bool any = false;
  for_each_tile(patch, [&](const PatchTile& at) {
    LatticeWorkspace::TileBits& bits = work.bits[at.number];
    bits.any_relevant = false;
    bits.any_visible = false;
    place_tile(patch, at, block.place);
    block.place.limits = frame.limits == nullptr ? nullptr : &work.limits[at.number];
    TileState& tile = work.tiles[at.number];
    if (frame.options->stop_opaque && !tile.any_open(0, 0, place.x1, place.y1)) return;
    bits.any_relevant = patch.is_binned_by_tile
                            ? bin_tile(frame, place, nodes, bits)
                            : bin_pixels(frame, patch, nodes, block, tile, bits);
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
  BlockPlace& pixels = work.pixels.block.place;
  const NodePlace place = place_nodes(frame, patch, nodes.place);
  if (!plan.relevance.any_in(place.box.min(), place.box.max()))
    return PatchResult::kNothingRelevant;
  set_up_nodes(frame, nodes, patch, place);
  // Sheets in front of the near plane have no samples.
  const bool has_front = plan.lattice.depth(nodes.place.first_sheet) > plan.lattice.near_depth();
  if (!has_front) return PatchResult::kNeedsPixels;
  patch.is_binned_by_tile = nodes.region.is_interior && are_paths_whole(frame, patch);
  if (nodes.region.num_samples() > kMaxRegionSamples && patch.last_sheet - patch.first_sheet > 1)
    return PatchResult::kTooLarge;
  if (!bin_patch(frame, work, patch)) return PatchResult::kNothingRelevant;
  clock.lap(kBin);
  const bool are_defined = load_nodes(frame, work.nodes, patch);
  clock.lap(kLoad);
  if (!are_defined) return PatchResult::kNeedsPixels;
  pixels.margin = 0;
  pixels.first_sheet = nodes.place.first_sheet;
  pixels.num_sheets = nodes.place.num_sheets;
  for (int s = 0; s < pixels.num_sheets; ++s) {
    pixels.sheets[s].depth = nodes.place.sheets[s].depth;
    pixels.sheets[s].near_cut = nodes.place.sheets[s].near_cut;
  }
  PatchBands bands;
  set_up_bands(frame, patch, nodes.place.margin, bands);
  patch.bands = &bands;
  if (counts_sums(frame, nodes, patch)) {
    draw_patch_sum(frame, work, patch, clock);
  } else {
    draw_patch_sheets(frame, work, patch, clock);
  }
  return PatchResult::kDrawn;
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
