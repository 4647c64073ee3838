// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "ovoid/error.h"
#include "render/cpu/kernel_renderer.h"
#include "render/cpu/lattice_frame.h"
#include "render/cpu/ticks.h"
#include "render/cpu/tile.h"
#include "render/cpu/tile_output.h"
#include "render/cpu/warp.h"

namespace ovoid::cpu {
namespace {

[[noreturn]] void throw_cancelled() {
  throw Error(ErrorCode::kCancelled, "rendering was cancelled");
}

// Of a frame of lattice sheets, what is done when its base plane is.
constexpr double kShareOfBase = 0.9;

void decide_relevance(view::LatticePlan& plan, Runner& runner) {
  if (!plan.may_matter) {
    plan.relevance.fill_everything();
  } else {
    runner.run(plan.relevance.num_layers(),
               [&](int layer, int) { plan.relevance.fill_layer(layer, plan.may_matter); });
  }
  plan.relevance.finish();
}

bool has_nodes(const LatticeFrame& frame, const view::LatticePlan& plan) {
  return frame.may_have_nodes && plan.sheets.first < plan.sheets.last &&
         plan.node_step(frame.options->post_convolution, plan.sheets.first) > 1.0;
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
                const RenderOptions& options, const view::BasePlane* base, Runner& runner)
      : plan(field, camera, look, options, view::LatticePlan::PieceRelevance::kPieceEnds, base) {
    decide_relevance(plan, runner);
    set_frame(frame, look, options, plan);
    static_cast<LatticeTraits&>(frame) = lattice_traits(field, frame, options);
    frame.lattice = lattice_constants(field, plan, frame);
    frame.lattice_plan = &plan;
    frame.field = &field;
    frame.is_on_lattice = base != nullptr;
    frame.has_rows = base != nullptr && frame.lattice.num_sublattices == 1;
    frame.samples_at_nodes = base == nullptr && has_nodes(frame, plan);
  }
  PreparedField(const PreparedField&) = delete;
  PreparedField& operator=(const PreparedField&) = delete;

  view::LatticePlan plan;
  LatticeFrame frame;
};

// On image sheets, or the base plane's picture: job.options has the size of that.
Frame render_samples(const FrameJob& job, const Machine& machine) {
  const LatticeField& field = *job.field.lattice();
  const RenderOptions& options = job.options;
  const std::stop_token& stop = job.hooks.stop;
  const Clock::time_point start = Clock::now();
  const std::uint64_t start_ticks = read_ticks();
  Runner& runner = *machine.runner;
  Frame out;
  out.profile.backend = "cpu";
  out.profile.simd_target = machine.target.name();
  out.profile.threads = runner.num_workers();
  out.profile.kernels_total = field.num_kernels();
  out.image = empty_image(options);

  std::optional<PreparedField> prepared_trail;
  if (const view::TrailView* trail = job.trail)
    prepared_trail.emplace(*trail->field, job.camera, trail->look, trail->options, nullptr, runner);
  PreparedField prepared(field, job.camera, job.look, options, job.base, runner);
  LatticeFrame& frame = prepared.frame;
  frame.stop = stop;
  if (prepared_trail) frame.trail = &prepared_trail->frame;
  const int edge = field.source().brick_edge();
  out.profile.kernels_drawn =
      std::min(field.num_kernels(), prepared.plan.relevance.num_relevant() * edge * edge * edge *
                                        frame.lattice.num_sublattices);
  const double plan_ms = ms_since(start);

  std::vector<TileRect> tiles =
      tiles_of(options.width, options.height, frame.samples_at_nodes ? kPatchSize : kTileSize);
  if (job.base != nullptr)
    std::erase_if(tiles, [&](const TileRect& tile) { return !is_seen(*job.base, tile); });
  const auto workspaces = make_workspaces<LatticeWorkspace>(runner.num_workers());
  Watch watch(job.hooks, tiles.size());
  runner.run(static_cast<int>(tiles.size()), [&](int task, int worker) {
    if (stop.stop_requested()) return;
    LatticeWorkspace& work = *workspaces[static_cast<std::size_t>(worker)];
    const TileRect& rect = tiles[static_cast<std::size_t>(task)];
    render_patch(machine.target, frame, work, rect);
    finish_patch(frame, job.look, work, rect, out.image);
    watch.tile_done(rect, out.image);
  });
  if (stop.stop_requested()) throw_cancelled();

  out.profile.frame_ms = ms_since(start);
  const double ticks_per_ms =
      static_cast<double>(read_ticks() - start_ticks) / out.profile.frame_ms;
  if (options.collect_profile) {
    out.profile.stages_ms.emplace_back("plan", plan_ms);
    out.profile.multiply_add_peak = machine.multiply_add_peak();
  }
  for (const auto& work : workspaces) {
    for (const WorkerStats* stats : {&work->pixels.stats, &work->nodes.stats, &work->trail.stats})
      add_worker_stats(*stats, options.collect_profile ? ticks_per_ms : 0.0, out.profile);
  }
  return out;
}

// The base plane's picture, then the one that is seen, row by row.
Frame render_lattice_sheets(const FrameJob& job, const Machine& machine) {
  const Clock::time_point start = Clock::now();
  RenderOptions of_base = job.options;
  of_base.width = job.base->width;
  of_base.height = job.base->height;
  RenderHooks hooks;
  hooks.stop = job.hooks.stop;
  if (job.hooks.progress) {
    hooks.progress = [&](double done) { job.hooks.progress(kShareOfBase * done); };
  }
  Frame frame = render_samples(
      {job.field, job.camera, job.look, job.trail, of_base, hooks, job.base}, machine);
  const Clock::time_point warp_start = Clock::now();
  Runner& runner = *machine.runner;
  const BasePicture samples(std::exchange(frame.image, empty_image(job.options)), runner);
  const WarpJob warp_job{*job.base, samples};
  const std::vector<TileRect> strips = strips_of(job.options);
  Watch watch(job.hooks, strips.size(), kShareOfBase);
  const std::stop_token& stop = job.hooks.stop;
  runner.run(static_cast<int>(strips.size()), [&](int task, int) {
    if (stop.stop_requested()) return;
    const TileRect& strip = strips[static_cast<std::size_t>(task)];
    warp(machine.target, warp_job, strip, frame.image);
    watch.tile_done(strip, frame.image);
  });
  if (stop.stop_requested()) throw_cancelled();
  frame.profile.frame_ms = ms_since(start);
  if (job.options.collect_profile)
    frame.profile.stages_ms.emplace_back("warp", runner.num_workers() * ms_since(warp_start));
  return frame;
}

}  // namespace

Frame render(const FrameJob& job, const Machine& machine) {
  if (job.field.kernels() != nullptr) return render_kernel_field(job, machine);
  return job.base != nullptr ? render_lattice_sheets(job, machine) : render_samples(job, machine);
}

}  // namespace ovoid::cpu
