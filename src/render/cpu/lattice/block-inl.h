// SPDX-License-Identifier: Apache-2.0
// Where the samples of a block lie.
#if defined(OVOID_RENDER_CPU_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_BLOCK_INL_H_
#undef OVOID_RENDER_CPU_BLOCK_INL_H_
#else
#define OVOID_RENDER_CPU_BLOCK_INL_H_
#endif

#include "render/cpu/lattice/lattice_block.h"
#include "render/cpu/shade/path-inl.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Index position of a group of samples, relative to the region's origin.
struct Position {
  V x, y, z;
};

HWY_INLINE Position position_of(const SheetInLattice& sheet, int column, int row) {
  const V x = hn::Iota(d, static_cast<float>(column));
  const float y = static_cast<float>(row);
  const auto along = [&](int a) {
    return hn::MulAdd(x, hn::Set(d, sheet.per_x[a]),
                      hn::Set(d, sheet.base[a] + y * sheet.per_y[a]));
  };
  return {along(0), along(1), along(2)};
}

// A part of a tile's work: pixels of the tile x consecutive sheets.
struct Part {
  int x0, y0, x1, y1;
  std::int64_t first_sheet, last_sheet;  // without margins
};

// Index-space box around a part's samples, margins and slabs included.
inline Bounds3 box_of(const CpuFrame& frame, const BlockPlace& place, const Part& part,
                      int margin) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  Bounds3 box;
  for (const std::int64_t sheet :
       {part.first_sheet - place.front_margin, part.last_sheet - 1 + place.back_margin}) {
    const view::SheetMap map = lattice.index_map(sheet);
    for (const int x : {part.x0 - margin, part.x1 - 1 + margin}) {
      for (const int y : {part.y0 - margin, part.y1 - 1 + margin}) {
        box.extend(map.at(place.tile_x + x, place.tile_y + y));
      }
    }
  }
  return box;
}

// True if every sample's slab lies outside one of the half spaces that are drawn.
inline bool is_clipped_away(const CpuFrame& frame, const BlockPlace& place, const Part& part) {
  const view::FramePlan& plan = *frame.plan;
  for (const ClipPlane& plane : plan.drawn_within) {
    double nearest = -1;
    for (const std::int64_t sheet : {part.first_sheet - place.front_margin, part.last_sheet - 1}) {
      const view::ClipMap distance = plan.clip_distance(plane, sheet);
      const view::ClipMap slope = plan.clip_slope(plane);
      for (const int x : {part.x0, part.x1 - 1}) {
        for (const int y : {part.y0, part.y1 - 1}) {
          const double px = place.tile_x + x;
          const double py = place.tile_y + y;
          const double inside = distance.origin + px * distance.per_x + py * distance.per_y;
          const double lean = std::abs(slope.origin + px * slope.per_x + py * slope.per_y);
          nearest = std::max(nearest, inside + 0.5 * lean * plan.lattice.sampling_distance());
        }
      }
    }
    if (nearest < 0) return true;
  }
  return false;
}

// Sheets before a block's own that it needs: front ends of pieces, and neighbours of ends.
inline int sheets_before(const CpuFrame& frame) {
  return frame.is_refined && frame.takes_differences   ? 2
         : frame.takes_differences || frame.has_pieces ? 1
                                                       : 0;
}

// Where a block's samples lie in the picture: sample (0, 0), and pixels from one to the next.
struct SampleGrid {
  double x, y, step;
};

// Positions are affine in the sheet's number, too: every sheet's map is the first one's plus a
// multiple of `step`.
struct SheetMaps {
  view::SheetMap first, step;
};

inline SheetMaps sheet_maps(const CpuFrame& frame, std::int64_t first_sheet) {
  SheetMaps maps{frame.plan->lattice.index_map(first_sheet),
                 frame.plan->lattice.index_map(first_sheet + 1)};
  maps.step.origin -= maps.first.origin;
  maps.step.per_x -= maps.first.per_x;
  maps.step.per_y -= maps.first.per_y;
  return maps;
}

// Sheet s of a block whose origin is set.
inline void set_up_sheet(const CpuFrame& frame, Block& block, const SampleGrid& grid, int s,
                         const SheetMaps& maps, const Vec3& widening) {
  const auto& [first, step] = maps;
  SheetInLattice& sheet = block.sheets[s];
  for (int a = 0; a < 3; ++a) {
    const double per_x = first.per_x[a] + s * step.per_x[a];
    const double per_y = first.per_y[a] + s * step.per_y[a];
    const double base = first.origin[a] + s * step.origin[a] + grid.x * per_x + grid.y * per_y;
    sheet.base[a] = static_cast<float>(base - static_cast<double>(block.region.origin[a]));
    sheet.per_x[a] = static_cast<float>(grid.step * per_x);
    sheet.per_y[a] = static_cast<float>(grid.step * per_y);
    sheet.step[a] =
        static_cast<float>(step.origin[a] + grid.x * step.per_x[a] + grid.y * step.per_y[a]);
    sheet.step_per_x[a] = static_cast<float>(grid.step * step.per_x[a]);
    sheet.step_per_y[a] = static_cast<float>(grid.step * step.per_y[a]);
    sheet.widening[a] = static_cast<float>(widening[a]);
  }
  block.place.sheets[s] = place_of_sheet(*frame.plan, block.place.number_of(s));
}

// The sheets of a block whose first sheet and number of sheets are set.
inline void set_up_sheets(const LatticeFrame& frame, Block& block, const SampleGrid& grid,
                          const Bounds3& box) {
  for (int a = 0; a < 3; ++a)
    block.region.origin[a] = static_cast<std::int64_t>(std::floor(box.min()[a]));
  const view::LatticePlan& plan = *frame.lattice_plan;
  const BlockPlace& place = block.place;
  const SheetMaps maps = sheet_maps(frame, place.first_sheet);
  Vec3 widening = plan.widening(place.first_sheet);
  for (int s = 0; s < place.num_sheets; ++s) {
    if (!frame.is_parallel) widening = plan.widening(place.number_of(s));
    set_up_sheet(frame, block, grid, s, maps, widening);
  }
}

inline void set_up_block(const LatticeFrame& frame, Block& block, const Part& part,
                         const Bounds3& box) {
  BlockPlace& place = block.place;
  place.x0 = part.x0;
  place.y0 = part.y0;
  place.x1 = part.x1;
  place.y1 = part.y1;
  place.columns = part.x1 - part.x0 + 2 * place.margin;
  place.rows = part.y1 - part.y0 + 2 * place.margin;
  place.first_sheet = part.first_sheet - place.front_margin;
  place.num_sheets =
      static_cast<int>(part.last_sheet - part.first_sheet) + place.front_margin + place.back_margin;
  set_up_sheets(frame, block,
                {static_cast<double>(place.tile_x + place.x0 - place.margin),
                 static_cast<double>(place.tile_y + place.y0 - place.margin), 1.0},
                box);
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
