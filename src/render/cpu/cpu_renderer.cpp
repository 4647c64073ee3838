// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>

#include "ovoid/error.h"
#include "render/cpu/base_refinement.h"
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

// The tiles of a patch, or the one tile, become pixels. `wanted`: the samples of the one tile that
// do, row after row; null: all.
void finish_patch(const CpuFrame& frame, const Look& look, const LatticeWorkspace& work,
                  const TileRect& rect, const RowWord* wanted, Image& image) {
  for (int y = rect.y0; y < rect.y1; y += kTileSize) {
    for (int x = rect.x0; x < rect.x1; x += kTileSize) {
      const int t = (y - rect.y0) / kTileSize * kPatchTiles + (x - rect.x0) / kTileSize;
      finish_tile(frame, look, work.tiles[static_cast<std::size_t>(t)],
                  {x, y, std::min(x + kTileSize, rect.x1), std::min(y + kTileSize, rect.y1)},
                  wanted, image);
    }
  }
}

// One field of a frame, ready to be drawn. Stays where it is: its parts point to each other.
struct PreparedField {
  PreparedField(const LatticeField& field, const Camera& camera, const Look& look,
                const RenderOptions& options, const view::LightVolume* light,
                const view::BasePlane* base, std::optional<view::RelevanceMap> relevance,
                Runner& runner)
      : plan(field, camera, look, options, view::LatticePlan::PieceRelevance::kPieceEnds, base) {
    if (relevance) {
      plan.relevance = std::move(*relevance);
    } else {
      decide_relevance(plan, runner);
    }
    set_frame(frame, look, options, plan, light);
    static_cast<LatticeTraits&>(frame) = lattice_traits(field, frame, options);
    frame.lattice = lattice_constants(field, plan, frame);
    frame.lattice_plan = &plan;
    frame.field = &field;
    frame.is_on_lattice = base != nullptr;
    frame.has_rows = base != nullptr && frame.lattice.num_sublattices == 1;
    frame.has_only_rows =
        frame.has_rows && frame.mode != Mode::kIsosurface && !frame.is_preintegrated;
    frame.samples_at_nodes = base == nullptr && has_nodes(frame, plan);
  }
  PreparedField(const PreparedField&) = delete;
  PreparedField& operator=(const PreparedField&) = delete;

  view::LatticePlan plan;
  LatticeFrame frame;
};

// What of a picture is drawn, and what is known beforehand.
struct SamplesToDraw {
  const SampleMask* mask = nullptr;             // null: all
  std::optional<view::RelevanceMap> relevance;  // of a frame that differs in its pixels alone
};

// Draws samples into a picture: on image sheets, or of a base plane; job.options has the size of
// that. Returns what bricks are relevant.
view::RelevanceMap draw_samples(const FrameJob& job, const Machine& machine, SamplesToDraw samples,
                                Image& image, FrameProfile& profile) {
  const LatticeField& field = *job.field.lattice();
  const RenderOptions& options = job.options;
  const std::stop_token& stop = job.hooks.stop;
  const Clock::time_point start = Clock::now();
  const std::uint64_t start_ticks = read_ticks();
  Runner& runner = *machine.runner;

  std::optional<PreparedField> prepared_trail;
  if (const view::TrailView* trail = job.trail)
    prepared_trail.emplace(*trail->field, job.camera, trail->look, trail->options, nullptr, nullptr,
                           std::nullopt, runner);
  PreparedField prepared(field, job.camera, job.look, options, job.light, job.base,
                         std::move(samples.relevance), runner);
  LatticeFrame& frame = prepared.frame;
  frame.stop = stop;
  if (prepared_trail) frame.trail = &prepared_trail->frame;
  const int edge = field.source().brick_edge();
  profile.kernels_drawn =
      std::min(field.num_kernels(), prepared.plan.relevance.num_relevant() * edge * edge * edge *
                                        frame.lattice.num_sublattices);
  const double plan_ms = ms_since(start);

  std::vector<TileRect> tiles =
      tiles_of(options.width, options.height, frame.samples_at_nodes ? kPatchSize : kTileSize);
  std::erase_if(tiles, [&](const TileRect& tile) {
    return (job.base != nullptr && !is_seen(*job.base, tile)) ||
           (samples.mask != nullptr && samples.mask->is_empty(tile.x0, tile.y0));
  });
  const auto workspaces = make_workspaces<LatticeWorkspace>(runner.num_workers());
  Teller teller(job.hooks, std::ssize(tiles));
  runner.run(static_cast<int>(tiles.size()), [&](int task, int worker) {
    if (stop.stop_requested()) return;
    LatticeWorkspace& work = *workspaces[static_cast<std::size_t>(worker)];
    const TileRect& rect = tiles[static_cast<std::size_t>(task)];
    const RowWord* const wanted =
        samples.mask == nullptr ? nullptr : samples.mask->of_tile(rect.x0, rect.y0);
    render_patch(machine.target, frame, work, rect, wanted);
    finish_patch(frame, job.look, work, rect, wanted, image);
    teller.done(told_of(rect, image));
  });
  if (stop.stop_requested()) throw_cancelled();

  const double ticks_per_ms = static_cast<double>(read_ticks() - start_ticks) / ms_since(start);
  if (options.collect_profile) {
    add_stage(profile, "plan", plan_ms);
    profile.multiply_add_peak = machine.multiply_add_peak();
    profile.bandwidth_peak = machine.bandwidth_peak();
  }
  for (const auto& work : workspaces) {
    for (const WorkerStats* stats : {&work->pixels.stats, &work->nodes.stats, &work->trail.stats})
      add_worker_stats(*stats, options.collect_profile ? ticks_per_ms : 0.0, profile);
  }
  return std::move(prepared.plan.relevance);
}

// Without a picture.
Frame empty_frame(const FrameJob& job, const Machine& machine) {
  Frame frame;
  frame.profile.backend = "cpu";
  frame.profile.simd_target = machine.target.name();
  frame.profile.threads = machine.runner->num_workers();
  frame.profile.kernels_total = job.field.num_kernels();
  return frame;
}

Frame render_image_sheets(const FrameJob& job, const Machine& machine) {
  const Clock::time_point start = Clock::now();
  Frame frame = empty_frame(job, machine);
  frame.image = empty_image(job.options.width, job.options.height);
  draw_samples(job, machine, {}, frame.image, frame.profile);
  frame.profile.frame_ms = ms_since(start);
  return frame;
}

// Hooks that report a part of the progress, from `from` to `to`, and nothing of the picture.
RenderHooks part_of(const RenderHooks& hooks, double from, double to) {
  RenderHooks part;
  part.stop = hooks.stop;
  if (hooks.progress) {
    part.progress = [&hooks, from, to](double done) { hooks.progress(from + (to - from) * done); };
  }
  return part;
}

// A base plane's samples.
Image draw_base_plane(const FrameJob& job, const Machine& machine, FrameProfile& profile) {
  int n = first_samples_apart(*job.base, *job.field.lattice(), job.look, job.options);
  // So many times samples are drawn, each time of a plane that is twice as dense.
  const int times = std::countr_zero(static_cast<unsigned>(n)) + 1;
  int number = 0;
  Image picture;
  std::optional<SampleMask> wanted;
  std::optional<view::RelevanceMap> relevance;
  profile.base_samples = std::int64_t{job.base->width} * job.base->height;
  for (;; n /= 2) {
    const view::BasePlane plane = every_nth_sample(*job.base, n);
    Image image = empty_image(plane.width, plane.height);
    if (number > 0) {
      wanted = interpolate_smooth(picture, job.options.sampling_distance, image, *machine.runner);
    }
    RenderOptions options = job.options;
    options.width = plane.width;
    options.height = plane.height;
    const RenderHooks hooks =
        part_of(job.hooks, kShareOfBase * number / times, kShareOfBase * (number + 1) / times);
    relevance = draw_samples(
        {job.field, job.camera, job.look, job.trail, options, hooks, job.light, &plane}, machine,
        {wanted ? &*wanted : nullptr, std::move(relevance)}, image, profile);
    picture = std::move(image);
    if (n == 1) return picture;
    ++number;
  }
}

// The base plane's picture, then the one that is seen, row by row.
Frame render_lattice_sheets(const FrameJob& job, const Machine& machine) {
  const Clock::time_point start = Clock::now();
  Frame frame = empty_frame(job, machine);
  Runner& runner = *machine.runner;
  const BasePicture samples(draw_base_plane(job, machine, frame.profile), runner);
  frame.image = empty_image(job.options.width, job.options.height);  // now: there were others
  const Clock::time_point warp_start = Clock::now();
  const WarpJob warp_job{*job.base, samples};
  const std::vector<TileRect> strips = strips_of(job.options);
  Teller teller(job.hooks, std::ssize(strips), kShareOfBase);
  const std::stop_token& stop = job.hooks.stop;
  runner.run(static_cast<int>(strips.size()), [&](int task, int) {
    if (stop.stop_requested()) return;
    const TileRect& strip = strips[static_cast<std::size_t>(task)];
    warp(machine.target, warp_job, strip, frame.image);
    teller.done(told_of(strip, frame.image));
  });
  if (stop.stop_requested()) throw_cancelled();
  frame.profile.frame_ms = ms_since(start);
  if (job.options.collect_profile)
    add_stage(frame.profile, "warp", runner.num_workers() * ms_since(warp_start));
  return frame;
}

}  // namespace

Frame render(const FrameJob& job, const Machine& machine) {
  if (job.field.kernels() != nullptr) return render_kernel_field(job, machine);
  return job.base != nullptr ? render_lattice_sheets(job, machine)
                             : render_image_sheets(job, machine);
}

}  // namespace ovoid::cpu
