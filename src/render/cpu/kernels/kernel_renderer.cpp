// SPDX-License-Identifier: Apache-2.0
// A frame of a kernel field: plan, project and bin once, then tiles as independent tasks.
#include "render/cpu/kernels/kernel_renderer.h"

#include <algorithm>
#include <deque>
#include <span>
#include <vector>

#include "ovoid/error.h"
#include "render/cpu/kernels/kernel_tile.h"
#include "render/cpu/kernels/visible_sums.h"
#include "render/cpu/lattice/tile.h"
#include "render/cpu/ticks.h"
#include "render/cpu/tile_output.h"

namespace ovoid::cpu {
namespace {

void draw_tile(const simd::SimdTarget& target, const KernelFrame& frame, const Look& look,
               KernelTileWorkspace& work, const TileRect& rect, Image& image) {
  render_kernel_tile(target, frame, work, rect);
  for (int sub = 0; sub < kSubtiles * kSubtiles; ++sub) {
    const int x = rect.x0 + sub % kSubtiles * kTileSize;
    const int y = rect.y0 + sub / kSubtiles * kTileSize;
    if (x >= rect.x1 || y >= rect.y1) continue;
    finish_tile(frame, look, work.subtiles[static_cast<std::size_t>(sub)].pixels,
                {x, y, std::min(x + kTileSize, rect.x1), std::min(y + kTileSize, rect.y1)}, nullptr,
                image);
  }
}

}  // namespace

std::unique_ptr<LevelBands> level_bands(PostConvolution how) {
  auto bands = std::make_unique<LevelBands>();
  for (std::size_t level = 0; level < bands->size(); ++level) {
    const LevelExtent& fine = kLevelExtents[level];
    const LevelExtent& coarse = kLevelExtents[level + 1];
    for (int x = 0; x < fine.size; ++x) {
      // A quarter before or behind the coarse sample that covers this one.
      const bool is_behind = (fine.lo + x) % 2 != 0;
      const int nearest = half_of(fine.lo + x) - coarse.lo;
      (*bands)[level].set_output(x, how, is_behind ? nearest : nearest - 1,
                                 is_behind ? 0.25 : 0.75);
    }
  }
  return bands;
}

namespace {

// Like levels, by which they are told: what is off works every kernel out by itself. A mean has its
// full value up to the cut of the last kernel and, between, noise from one kernel to the next: of
// steep looks the picture would show which were merged.
Merging merging_for(const KernelField& field, const RenderOptions& options) {
  const bool may_merge = field.reconstruction() == Reconstruction::kSum &&
                         options.post_convolution == PostConvolution::kAuto &&
                         options.evaluate != Evaluate::kGather;
  return may_merge ? Merging::kSmall : Merging::kNone;
}

// Published filters carry kernels beyond their cuts, and a slab's mean may be more than a height.
bool has_bounds(const KernelField& field, const view::KernelPlan& plan) {
  return field.reconstruction() == Reconstruction::kSum && plan.may_matter && plan.overshoot == 0 &&
         !plan.is_mean;
}

// A field of a frame, ready to be drawn. Stays where it is: its parts point to each other.
struct PreparedSet {
  PreparedSet(const KernelField& field, const FrameJob& job, const Look& look,
              const RenderOptions& options, const view::LightVolume* light,
              std::span<const KernelField> beside, Runner& runner)
      : start(Clock::now()), plan(field, job.camera, look, options, beside) {
    plan_ms = ms_since(start);
    binned = bin_splats(field, plan, merging_for(field, options), runner);
    is_visible = has_bounds(field, plan) ? visible_sums(plan, binned, runner) : plan.is_relevant;
    static_cast<KernelTraits&>(frame) = kernel_traits(field, plan, look, options);
    frame.kernel_plan = &plan;
    frame.binned = &binned;
    frame.is_visible = is_visible.data();
    if (frame.max_level > 0) frame.level_bands = level_bands(options.post_convolution);
    set_frame(frame, look, options, plan, light);
    frame.takes_differences = frame.takes_gradients;
    frame.stop = job.hooks.stop;
    bin_ms = ms_since(start) - plan_ms;
  }
  PreparedSet(const PreparedSet&) = delete;
  PreparedSet& operator=(const PreparedSet&) = delete;

  Clock::time_point start;
  view::KernelPlan plan;
  BinnedSplats binned;
  std::vector<std::uint8_t> is_visible;
  KernelFrame frame;
  double plan_ms = 0, bin_ms = 0;
};

// The fields of a frame, ready to be drawn.
struct PreparedSets {
  PreparedSets(const FrameJob& job, Runner& runner) {
    const KernelField& field = *job.field.kernels();
    std::vector<KernelField> all;
    if (job.trail != nullptr) {
      all.push_back(field);
      for (const KernelMoment& moment : job.trail->moments) all.push_back(moment.field);
    }
    KernelFrame& own =
        sets.emplace_back(field, job, job.look, job.options, job.light, all, runner).frame;
    if (job.trail == nullptr) return;
    own.draws_beyond_limits = true;
    for (const KernelMoment& moment : job.trail->moments) {
      const PreparedSet& set = sets.emplace_back(moment.field, job, job.trail->look,
                                                 job.trail->options, nullptr, all, runner);
      own.trail.push_back({&set.frame, static_cast<float>(moment.share)});
    }
  }

  const KernelFrame& frame() const { return sets.front().frame; }
  void tell(bool with_stages, FrameProfile& profile) const {
    double plan_ms = 0, bin_ms = 0;
    for (const PreparedSet& set : sets) {
      profile.kernels_drawn += set.binned.num_kernels;
      plan_ms += set.plan_ms;
      bin_ms += set.bin_ms;
    }
    if (!with_stages) return;
    profile.stages_ms.emplace_back("plan", plan_ms);
    profile.stages_ms.emplace_back("project and bin", bin_ms);
  }

  std::deque<PreparedSet> sets;  // the field's own first
};

using KernelWorkspaces = std::vector<std::unique_ptr<KernelTileWorkspace>>;

// Throws Error(kOutOfMemory).
KernelWorkspaces workspaces_for(const KernelFrame& frame, int num_workers) {
  KernelWorkspaces workspaces = make_workspaces<KernelTileWorkspace>(num_workers);
  if (frame.trail.empty()) return workspaces;
  data::allocated("the working memory of the threads", workspaces.size() * sizeof(TrailWorkspace),
                  [&] {
                    for (const auto& work : workspaces)
                      work->trail = std::make_unique<TrailWorkspace>();
                    return 0;
                  });
  return workspaces;
}

}  // namespace

Frame render_kernel_field(const FrameJob& job, const Machine& machine) {
  const RenderOptions& options = job.options;
  const std::stop_token& stop = job.hooks.stop;
  const Clock::time_point start = Clock::now();
  const std::uint64_t start_ticks = read_ticks();
  Runner& runner = *machine.runner;
  Frame out;
  out.profile.backend = "cpu";
  out.profile.simd_target = machine.target.name();
  out.profile.threads = runner.num_workers();
  out.profile.kernels_total = job.field.num_kernels();
  if (job.trail != nullptr) {
    for (const KernelMoment& moment : job.trail->moments)
      out.profile.kernels_total += moment.field.num_kernels();
  }
  out.image = empty_image(options.width, options.height);

  const PreparedSets sets(job, runner);
  sets.tell(options.collect_profile, out.profile);
  const KernelFrame& frame = sets.frame();
  const std::vector<TileRect> tiles = tiles_of(options.width, options.height, view::kBlockEdge);
  const KernelWorkspaces workspaces = workspaces_for(frame, runner.num_workers());
  Teller teller(job.hooks, std::ssize(tiles));
  runner.run(static_cast<int>(tiles.size()), [&](int task, int worker) {
    if (stop.stop_requested()) return;
    const TileRect& rect = tiles[static_cast<std::size_t>(task)];
    draw_tile(machine.target, frame, job.look, *workspaces[static_cast<std::size_t>(worker)], rect,
              out.image);
    teller.done(told_of(rect, out.image));
  });
  if (stop.stop_requested()) throw Error(ErrorCode::kCancelled, "rendering was cancelled");

  out.profile.frame_ms = ms_since(start);
  const double ticks_per_ms =
      static_cast<double>(read_ticks() - start_ticks) / out.profile.frame_ms;
  const double per_ms = options.collect_profile ? ticks_per_ms : 0.0;
  for (const auto& work : workspaces) {
    add_worker_stats(work->stats, per_ms, out.profile);
    if (work->trail != nullptr) add_worker_stats(work->trail->sums.stats, per_ms, out.profile);
  }
  return out;
}

}  // namespace ovoid::cpu
