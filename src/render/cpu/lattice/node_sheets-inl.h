// SPDX-License-Identifier: Apache-2.0
// The field at the nodes of a patch: their place among the sheets, values and gradients.
//
// Nodes are the samples of a Block, so that all ways to reconstruct serve them too; and one more,
// the published bilinear spread, by which samples of the lattice are shared among four nodes.
#if defined(OVOID_RENDER_CPU_NODE_SHEETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_NODE_SHEETS_INL_H_
#undef OVOID_RENDER_CPU_NODE_SHEETS_INL_H_
#else
#define OVOID_RENDER_CPU_NODE_SHEETS_INL_H_
#endif

#include "render/cpu/lattice/bin-inl.h"
#include "render/cpu/lattice/block-inl.h"
#include "render/cpu/lattice/gradient-inl.h"
#include "render/cpu/lattice/load-inl.h"
#include "render/cpu/lattice/nodes.h"
#include "render/cpu/lattice/reconstruct-inl.h"
#include "render/cpu/lattice/splat-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

struct Patch {
  TileRect rect;  // of the picture
  std::int64_t first_sheet, last_sheet;
  double node_step;
  NodeSpan nodes_x, nodes_y;
  bool is_binned_by_tile;   // not pixel by pixel: nothing is cut away, all of it is inside
  const PatchBands* bands;  // once it has nodes
};

inline bool has_bits(const RowBits& bits, int rows) {
  return std::any_of(bits.begin(), bits.begin() + rows, [](RowWord row) { return row != 0; });
}

// Inline, and not by a string instruction, which takes longer to start.
HWY_INLINE void clear_bits(RowBits& bits) {
  for (std::size_t i = 0; i < 2 * bits.size(); i += static_cast<std::size_t>(group_size()))
    hn::StoreU(hn::Zero(di), di, reinterpret_cast<std::int32_t*>(bits.data()) + i);
}

// The bilinear spread on one layer of sheets.
struct SpreadShape {
  Vec3 along;          // index space: one sampling distance along the view axis
  double half_height;  // of a sample's reach along the view axis, sampling distances
  double sigma;        // likewise
  Vec3 reach;          // of a node, index space
};

inline SpreadShape spread_shape(const LatticeFrame& frame, const Patch& patch) {
  const view::ViewLattice& lattice = frame.plan->lattice;
  const Mat3 axes = frame.field->geometry().world_from_index.linear();
  const double sigma = static_cast<double>(frame.lattice.sigma) *
                       (axes.transpose() * lattice.view_axis()).norm() /
                       lattice.sampling_distance();
  SpreadShape shape;
  shape.along = axes.inverse() * lattice.view_axis() * lattice.sampling_distance();
  shape.sigma = sigma;
  shape.half_height = sigma * static_cast<double>(frame.lattice.support / frame.lattice.sigma);
  const view::SheetMap map = lattice.index_map(patch.last_sheet - 1);
  shape.reach = patch.node_step * (map.per_x.cwiseAbs() + map.per_y.cwiseAbs()) +
                shape.half_height * shape.along.cwiseAbs();
  return shape;
}

// Where all kernels of an endless lattice exist that reach the samples of a sheet.
inline Support whole_support(const LatticeFrame& frame, const Region& region,
                             const SheetInLattice& sheet) {
  Support support;
  for (int a = 0; a < 3; ++a) {
    const float slab = frame.lattice.num_slab_points > 1 ? 0.5F * std::abs(sheet.step[a]) : 0.0F;
    const float reach = frame.lattice.support * sheet.widening[a] + slab;
    const auto first = static_cast<float>(-region.origin[a]);
    float lo = first;
    float hi = std::numeric_limits<float>::max();
    for (int s = 0; s < frame.lattice.num_sublattices; ++s) {
      const auto& [dims, offset] = frame.lattice.sublattices[s];
      lo = std::max(lo, first + offset);
      hi = std::min(hi, first + offset + static_cast<float>(dims[a] - 1));
    }
    support.lo[a] = hn::Set(d, lo + reach);
    support.hi[a] = hn::Set(d, hi - reach);
  }
  support.holds_block = false;
  return support;
}

// Nodes that no kernel reaches are not active; nor are, if the bound is to be kept, those near a
// face, where the field has kinks.
inline void drop_outside(const LatticeFrame& frame, Block& nodes, const Bounds3& box) {
  const bool keeps_bound = frame.nodes_keep_bound;
  for (int s = 0; s < nodes.place.num_sheets; ++s) {
    const Support support = keeps_bound ? whole_support(frame, nodes.region, nodes.sheets[s])
                                        : support_of(frame, nodes, box);
    for (int y = 0; y < nodes.place.rows; ++y) {
      RowWord inside = 0;
      for (int column = 0; column < nodes.place.columns; column += group_size())
        inside |= RowWord{bits_of(support(position_of(nodes.sheets[s], column, y)))} << column;
      nodes.bits.active[s][y] &= inside;
    }
  }
}

// Where nodes lie in the picture and, all sheets together, in index space.
struct NodePlace {
  SampleGrid grid;
  Bounds3 box;
};

// The nodes as samples of a block; with neighbours all around where differences are taken.
inline NodePlace place_nodes(const LatticeFrame& frame, const Patch& patch, BlockPlace& nodes) {
  const int margin = frame.takes_differences ? 1 : 0;
  nodes.margin = nodes.back_margin = margin;
  nodes.front_margin = sheets_before(frame);
  nodes.tile_x = nodes.tile_y = nodes.x0 = nodes.y0 = 0;
  nodes.x1 = patch.nodes_x.count;
  nodes.y1 = patch.nodes_y.count;
  nodes.columns = nodes.x1 + 2 * margin;
  nodes.rows = nodes.y1 + 2 * margin;
  nodes.first_sheet = patch.first_sheet - nodes.front_margin;
  nodes.num_sheets = static_cast<int>(patch.last_sheet - patch.first_sheet) + nodes.front_margin +
                     nodes.back_margin;
  const double x0 = patch.node_step * static_cast<double>(patch.nodes_x.first - margin);
  const double y0 = patch.node_step * static_cast<double>(patch.nodes_y.first - margin);
  NodePlace place{{x0, y0, patch.node_step}, {}};
  for (const std::int64_t sheet : {nodes.first_sheet, nodes.number_of(nodes.num_sheets - 1)}) {
    const view::SheetMap map = frame.plan->lattice.index_map(sheet);
    for (const int x : {0, nodes.columns - 1}) {
      for (const int y : {0, nodes.rows - 1})
        place.box.extend(map.at(x0 + patch.node_step * x, y0 + patch.node_step * y));
    }
  }
  return place;
}

// Their sheets and region; all of them active that a kernel reaches.
inline void set_up_nodes(const LatticeFrame& frame, Block& nodes, const Patch& patch,
                         const NodePlace& place) {
  set_up_sheets(frame, nodes, place.grid, place.box);
  const RowWord all = ~RowWord{0} >> (64 - nodes.place.columns);
  for (int s = 0; s < nodes.place.num_sheets; ++s) {
    nodes.place.sheets[s].inverse_pitch /= static_cast<float>(patch.node_step);
    for (int y = 0; y < nodes.place.rows; ++y) nodes.bits.active[s][y] = all;
  }
  const bool spreads = frame.options->spread == Spread::kBilinear;
  bound_region(frame, nodes, spreads ? spread_shape(frame, patch).reach : Vec3::Zero());
  if (!nodes.region.is_interior) drop_outside(frame, nodes, place.box);
}

// All nodes have values.
inline bool is_whole(const Region& region) { return region.is_interior && !region.has_missing; }

// A sample among its four nodes of one sheet.
HWY_INLINE void spread_sample(const SampleBox& nodes, const SplatPlane& plane,
                              const PlacedKernel& kernel, float sigma, const SplatSums& sums) {
  const float* const center = kernel.center;
  const float from_base[3] = {center[0] - plane.base[0], center[1] - plane.base[1],
                              center[2] - plane.base[2]};
  const float along = product_with(plane.inverse[2], from_base);
  if (std::abs(along) > plane.half_extent[2]) return;
  const float weight = std::exp(-0.5F * along * along / (sigma * sigma));
  const float x = product_with(plane.inverse[0], from_base);
  const float y = product_with(plane.inverse[1], from_base);
  const int column = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  for (int j = std::max(row, nodes.y0); j <= std::min(row + 1, nodes.y1); ++j) {
    for (int i = std::max(column, nodes.x0); i <= std::min(column + 1, nodes.x1); ++i) {
      const float share = weight * (1 - std::abs(x - static_cast<float>(i))) *
                          (1 - std::abs(y - static_cast<float>(j)));
      sums.numerator[j * kPlaneStride + i] += share * kernel.value;
      sums.denominator[j * kPlaneStride + i] += share;
    }
  }
}

inline void spread_region(const LatticeFrame& frame, Workspace& nodes, const Patch& patch) {
  const SpreadShape shape = spread_shape(frame, patch);
  const Block& block = nodes.block;
  const SampleBox all{0, 0, block.place.columns - 1, block.place.rows - 1};
  for (int s = 0; s < block.place.num_sheets; ++s) {
    const SplatSums sums = splat_sums(nodes, s);
    clear_splat_planes(sums);
    const SheetInLattice& sheet = block.sheets[s];
    SplatPlane plane{};
    Mat3 columns;
    for (int a = 0; a < 3; ++a) {
      plane.base[a] = sheet.base[a];
      columns.row(a) << static_cast<double>(sheet.per_x[a]), static_cast<double>(sheet.per_y[a]),
          shape.along[a];
    }
    const Mat3 inverse = columns.inverse();
    for (int r = 0; r < 3; ++r) {
      for (int a = 0; a < 3; ++a) plane.inverse[r][a] = static_cast<float>(inverse(r, a));
    }
    plane.half_extent[2] = static_cast<float>(shape.half_height);
    for_each_kernel(frame, block.region, plane, [&](const float* center, float value) {
      spread_sample(all, plane, {center, value, 1.0F}, static_cast<float>(shape.sigma), sums);
    });
  }
}

inline bool scatters_to_nodes(const LatticeFrame& frame) {
  return frame.options->spread == Spread::kBilinear || should_scatter(frame);
}

// Loads the lattice's samples around the nodes. False if pixels cannot stand in for nodes without
// value.
inline bool load_nodes(const LatticeFrame& frame, Workspace& nodes, const Patch& patch) {
  Block& block = nodes.block;
  load_region(frame, nodes, scatters_to_nodes(frame));
  if (block.region.has_missing && frame.nodes_keep_bound) return false;
  const bool takes_all = frame.takes_differences || frame.options->spread == Spread::kBilinear;
  if (takes_all && !is_whole(block.region)) return false;
  if (!scatters_to_nodes(frame)) return true;
  reserve_splat_planes(nodes);
  if (frame.options->spread == Spread::kGaussian) return true;
  spread_region(frame, nodes, patch);
  for (int s = 0; s < block.place.num_sheets; ++s) {
    for (int y = 0; y < block.place.rows; ++y) {
      const float* weights = splat_sums(nodes, s).denominator + y * kPlaneStride;
      if (!std::all_of(weights, weights + block.place.columns, [](float w) { return w > 0; }))
        return false;
    }
  }
  return true;
}

// Nodes without value count as zero: filters read them for pixels that do not take it.
inline void clear_undefined(Sheet& sheet, const RowBits& wanted, int rows) {
  for (int row = 0; row < rows; ++row) {
    RowWord left = wanted[row] & ~sheet.defined[row];
    sheet.has_gradient[row] |= left;
    for (; left != 0; left &= left - 1) {
      const int at = sheet.at(std::countr_zero(left), row);
      sheet.values[at] = 0;
      for (float* g : sheet.gradient) g[at] = 0;
    }
  }
}

// Values of the wanted nodes; with their gradients where `guess` says that those will be wanted.
inline void reconstruct_nodes(const LatticeFrame& frame, Workspace& nodes, int s,
                              const RowBits& wanted, const RowBits& guess, StageClock& clock) {
  const Block& block = nodes.block;
  const int rows = block.place.rows;
  Sheet& sheet = nodes.ring[block.place.number_of(s)];
  sheet.clear();
  if (!has_bits(wanted, rows)) return;
  nodes.stats.samples_reconstructed += count_bits(wanted, rows);
  if (scatters_to_nodes(frame)) {
    if (frame.options->spread == Spread::kGaussian) splat_sheet(frame, nodes, s, wanted);
    read_splat_sheet(frame, nodes, s, wanted);
  } else {
    RowBits others = wanted;
    if (block.region.uses_four_taps && has_bits(guess, rows)) {
      reconstruct_with_gradients(frame, nodes, s, guess);
      clock.lap(kGradient);
      for (int row = 0; row < rows; ++row) others[row] &= ~guess[row];
    }
    reconstruct_sheet(frame, nodes, s, others);
  }
  if (!is_whole(block.region)) clear_undefined(sheet, wanted, rows);
  clock.lap(kReconstruct);
}

// Where the margin's nodes, which are there, are the neighbours.
inline void difference_nodes(const LatticeFrame& frame, Workspace& nodes, int s, const Patch& patch,
                             const RowBits& bits) {
  const BlockPlace& place = nodes.block.place;
  Sheet& sheet = nodes.ring[place.number_of(s)];
  const auto node_step = static_cast<float>(patch.node_step);
  const auto left = static_cast<float>(patch.nodes_x.first - place.margin);
  const auto top = static_cast<float>(patch.nodes_y.first - place.margin);
  for (int y = 0; y < place.rows; ++y) {
    nodes.stats.gradients += std::popcount(bits[y]);
    for_each_group(
        bits[y], place.margin, place.columns - place.margin, [&](int column, std::uint32_t lanes) {
          const SampleGroup group{s, column, y, lanes};
          const V x =
              hn::Mul(hn::Set(d, node_step), hn::Iota(d, left + static_cast<float>(column)));
          store_gradient(sheet, group,
                         central_difference_at(frame, place, nodes.ring, group,
                                               {x, node_step * (top + static_cast<float>(y))}));
        });
  }
}

// Gradients of the nodes in `bits` that have none yet.
inline void provide_node_gradients(const LatticeFrame& frame, Workspace& nodes, int s,
                                   const Patch& patch, const RowBits& bits) {
  const BlockPlace& place = nodes.block.place;
  const RowBits& has_gradient = nodes.ring[place.number_of(s)].has_gradient;
  RowBits missing;
  for (int row = 0; row < place.rows; ++row) missing[row] = bits[row] & ~has_gradient[row];
  if (!has_bits(missing, place.rows)) return;
  if (frame.takes_differences) {
    difference_nodes(frame, nodes, s, patch, missing);
  } else {
    gradients_of(frame, nodes, s, missing);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
