// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "ovoid/error.h"
#include "render/cpu/frame_tables.h"
#include "render/cpu/ticks.h"
#include "render/cpu/tile.h"
#include "render/cpu/tile_output.h"

namespace ovoid::cpu {
namespace {

void set_kernel(CpuFrame& frame, const LatticeField& field) {
  const LatticeKernel kernel = field.index_kernel();
  const LatticeGeometry& lattice = field.geometry();
  frame.sigma = static_cast<float>(kernel.sigma);
  frame.support = static_cast<float>(kernel.support_radius());
  frame.inverse_variance = 1.0F / (frame.sigma * frame.sigma);
  frame.near_weight = std::exp(-0.5F * frame.inverse_variance);
  frame.far_weight = std::exp(-2.0F * frame.inverse_variance);
  frame.is_sum = field.reconstruction() == Reconstruction::kSum;
  frame.sum_weight = static_cast<float>(
      1.0 / (lattice.density() * std::pow(2 * std::numbers::pi, 1.5) * std::pow(kernel.sigma, 3)));
  frame.num_sublattices = lattice.num_sublattices();
  for (int s = 0; s < frame.num_sublattices; ++s) {
    FrameSublattice& own = frame.sublattices[static_cast<std::size_t>(s)];
    const Index3 dims = lattice.dims_of(s);
    for (std::size_t a = 0; a < 3; ++a) own.dims[a] = static_cast<std::int32_t>(dims[a]);
    own.offset = static_cast<float>(lattice.offset_of(s)[0]);
  }
  frame.value_scale = static_cast<float>(field.source().value_scale());
  frame.value_offset = static_cast<float>(field.source().value_offset());
  const Mat3 gradient = lattice.world_from_index.linear().inverse().transpose();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      frame.world_from_index_gradient[3 * r + c] = static_cast<float>(gradient(r, c));
  }
}

void decide_relevance(view::LatticePlan& plan, Runner& runner) {
  if (!plan.may_matter) {
    plan.relevance.fill_everything();
  } else {
    runner.run(plan.relevance.num_layers(),
               [&](int layer, int) { plan.relevance.fill_layer(layer, plan.may_matter); });
  }
  plan.relevance.finish();
}

constexpr float kLeastCutoff = 3.99F;  // sigmas: less than a thousandth of a kernel is cut off

// kAuto keeps its bound where the field is as smooth as its kernel, and the gradient no difference
// of neighbours, which would be as far apart as nodes.
bool keeps_bound(const CpuFrame& frame) {
  const bool is_smooth =
      !frame.is_sum && frame.sigma >= 0.25F && frame.support >= kLeastCutoff * frame.sigma;
  return is_smooth && !frame.central_gradient;
}

bool has_nodes(const CpuFrame& frame, const view::LatticePlan& plan) {
  if (frame.post_convolution == PostConvolution::kAuto && !keeps_bound(frame)) return false;
  return plan.sheets.first < plan.sheets.last &&
         plan.node_pitch(frame.post_convolution, plan.sheets.first) > 1.0;
}

// The tiles of a patch, or the one tile, become pixels.
void finish_patch(const CpuFrame& frame, const Look& look, const LatticeWorkspace& work,
                  const TileRect& rect, Image& image) {
  for (int y = rect.y0; y < rect.y1; y += kTileSize) {
    for (int x = rect.x0; x < rect.x1; x += kTileSize) {
      const int t = (y - rect.y0) / kTileSize * kPatchTiles + (x - rect.x0) / kTileSize;
      finish_tile(frame, look, work.tiles[static_cast<std::size_t>(t)],
                  {x, y, std::min(x + kTileSize, rect.x1), std::min(y + kTileSize, rect.y1)},
                  image);
    }
  }
}

// One field of a frame, ready to be drawn. Stays where it is: its parts point to each other.
struct PreparedField {
  PreparedField(const LatticeField& field, const Camera& camera, const Look& look,
                const RenderOptions& options, const RenderHooks& hooks, Runner& runner)
      : plan(field, camera, look, options) {
    decide_relevance(plan, runner);
    frame.plan = &plan;
    frame.lattice_plan = &plan;
    frame.field = &field;
    frame.stop = hooks.stop;
    set_kernel(frame, field);
    set_view(frame, plan);
    set_look(frame, field.value_range(), look, plan, tables);
    const bool is_mean = options.slab == Slab::kMean;
    if (is_mean) frame.slab = slab_nodes(field, plan.lattice);
    frame.spread = options.spread;
    const bool takes_differences =
        options.gradient == GradientMethod::kCentral || frame.spread == Spread::kBilinear;
    frame.central_gradient = takes_differences && frame.takes_gradients;
    frame.corrects_gradient = options.gradient != GradientMethod::kExact && !frame.is_sum;
    frame.evaluate = options.evaluate;
    frame.stop_opaque = options.stop_opaque;
    frame.collect_profile = options.collect_profile;
    // Of two sublattices the kernels are narrower, and reach three of the taps.
    const bool fits_taps =
        frame.num_sublattices == 1 ? frame.support == 2.0F : frame.support <= 1.5F;
    frame.has_four_taps =
        fits_taps && frame.sigma >= 0.25F && frame.sigma <= 2.0F && !frame.is_sum && !is_mean;
    frame.post_convolution = options.post_convolution;
    frame.samples_at_nodes = has_nodes(frame, plan);
    frame.takes_pieces = frame.is_preintegrated || frame.mode == Mode::kIsosurface;
  }
  PreparedField(const PreparedField&) = delete;
  PreparedField& operator=(const PreparedField&) = delete;

  view::LatticePlan plan;
  LookTables tables;
  CpuFrame frame;
};

}  // namespace

Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, const Machine& machine,
             const view::Behind* behind) {
  const Clock::time_point start = Clock::now();
  const std::uint64_t start_ticks = read_ticks();
  Runner& runner = *machine.runner;
  Frame out;
  out.profile.backend = "cpu";
  out.profile.simd_target = machine.target.name();
  out.profile.threads = runner.num_workers();
  out.profile.kernels_total = field.num_kernels();
  out.image = empty_image(options);

  RenderOptions own_options = options;
  std::optional<PreparedField> prepared_behind;
  if (behind != nullptr) {
    own_options.post_convolution = PostConvolution::kOff;
    RenderOptions plain = own_options;
    plain.classification = Classification::kSampled;
    prepared_behind.emplace(*behind->field, camera, behind->look, plain, hooks, runner);
  }
  PreparedField prepared(field, camera, look, own_options, hooks, runner);
  CpuFrame& frame = prepared.frame;
  if (prepared_behind) frame.behind = &prepared_behind->frame;
  const int edge = field.source().brick_edge();
  out.profile.kernels_drawn =
      std::min(field.num_kernels(),
               prepared.plan.relevance.num_relevant() * edge * edge * edge * frame.num_sublattices);
  const double plan_ms = ms_since(start);

  const std::vector<TileRect> tiles =
      tiles_of(options.width, options.height, frame.samples_at_nodes ? kPatchSize : kTileSize);
  const auto workspaces = make_workspaces<LatticeWorkspace>(runner.num_workers());
  Watch watch(hooks, tiles.size());
  runner.run(static_cast<int>(tiles.size()), [&](int task, int worker) {
    if (hooks.stop.stop_requested()) return;
    LatticeWorkspace& work = *workspaces[static_cast<std::size_t>(worker)];
    const TileRect& rect = tiles[static_cast<std::size_t>(task)];
    render_patch(machine.target, frame, work, rect);
    finish_patch(frame, look, work, rect, out.image);
    watch.tile_done(rect, out.image);
  });
  if (hooks.stop.stop_requested()) throw Error(ErrorCode::kCancelled, "rendering was cancelled");

  out.profile.frame_ms = ms_since(start);
  const double ticks_per_ms =
      static_cast<double>(read_ticks() - start_ticks) / out.profile.frame_ms;
  if (options.collect_profile) out.profile.stages_ms.emplace_back("plan", plan_ms);
  for (const auto& work : workspaces) {
    for (const WorkerStats* stats : {&work->pixels.stats, &work->nodes.stats, &work->behind.stats})
      add_worker_stats(*stats, options.collect_profile ? ticks_per_ms : 0.0, out.profile);
  }
  return out;
}

}  // namespace ovoid::cpu
