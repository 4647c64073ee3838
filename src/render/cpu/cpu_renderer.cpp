// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "render/cpu/kernels/kernel_renderer.h"
#include "render/cpu/lattice/base_refinement.h"
#include "render/cpu/lattice/lattice_frame.h"
#include "render/cpu/lattice/tile.h"
#include "render/cpu/lattice/warp.h"
#include "render/cpu/ticks.h"
#include "render/cpu/tile_output.h"
#include "render/lattice_sheets.h"

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
                std::optional<view::PlaneOfOther> plane,
                std::optional<view::RelevanceMap> relevance, Runner& runner)
      : plan(field, camera, look, options, view::LatticePlan::PieceRelevance::kPieceEnds,
             plane ? &plane->base : nullptr) {
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
    frame.is_on_lattice = plane && plane->is_aligned;
    frame.has_rows = frame.is_on_lattice && frame.lattice.num_sublattices == 1;
    frame.has_only_rows =
        frame.has_rows && frame.mode != Mode::kIsosurface && !frame.is_preintegrated;
    frame.samples_at_nodes = !plane && has_nodes(frame, plan);
  }
  PreparedField(const PreparedField&) = delete;
  PreparedField& operator=(const PreparedField&) = delete;

  view::LatticePlan plan;
  LatticeFrame frame;
};

// What of a picture is drawn, and what is known beforehand.
struct SamplesToDraw {
  const SampleMask* mask = nullptr;  // null: all
  // Of a frame that differs in its pixels alone, and of its further volumes; empty: not known.
  std::vector<view::RelevanceMap> relevance;
};

// The fields of a frame, ready to be drawn.
struct PreparedFrame {
  PreparedFrame(const FrameJob& job, std::vector<view::RelevanceMap> relevance, Runner& runner) {
    const auto known = [&](std::size_t i) {
      return relevance.empty() ? std::nullopt : std::optional(std::move(relevance[i]));
    };
    const auto plane_of = [&](const LatticeField& field) -> std::optional<view::PlaneOfOther> {
      if (job.base == nullptr) return std::nullopt;
      if (job.further.empty()) return view::PlaneOfOther{*job.base, true, 0};
      return view::plane_for(*job.base, field.geometry());
    };
    const LatticeField& field = *job.field.lattice();
    own.emplace(field, job.camera, job.look, job.options, job.light, plane_of(field), known(0),
                runner);
    LatticeFrame& frame = own->frame;
    if (const view::TrailView* trail = job.trail) {
      PreparedField& behind =
          beside.emplace_back(*trail->field, job.camera, trail->look, trail->options, nullptr,
                              std::nullopt, std::nullopt, runner);
      frame.beside.push_back(&behind.frame);
      return;
    }
    for (std::size_t i = 0; i < job.further.size(); ++i) {
      const FurtherVolume& volume = job.further[i];
      beside.emplace_back(volume.field, job.camera, volume.look, job.options, job.light,
                          plane_of(volume.field), known(i + 1), runner);
    }
    if (beside.empty()) return;
    frame.is_mixed = true;
    frame.mixing = job.mixing;
    frame.samples_at_nodes = false;
    // All or none take differences, so that their blocks have the same margins.
    bool takes_differences = frame.takes_differences;
    for (const PreparedField& other : beside)
      takes_differences = takes_differences || other.frame.takes_differences;
    frame.takes_differences = takes_differences;
    for (PreparedField& other : beside) {
      other.frame.takes_differences = takes_differences;
      frame.beside.push_back(&other.frame);
    }
  }

  std::int64_t kernels_drawn() const {
    std::int64_t sum = kernels_drawn(*own);
    if (own->frame.is_mixed) {
      for (const PreparedField& other : beside) sum += kernels_drawn(other);
    }
    return sum;
  }
  // For the next picture of the same frame.
  std::vector<view::RelevanceMap> relevance() && {
    std::vector<view::RelevanceMap> all;
    all.push_back(std::move(own->plan.relevance));
    for (PreparedField& other : beside) all.push_back(std::move(other.plan.relevance));
    return all;
  }

  std::optional<PreparedField> own;
  std::deque<PreparedField> beside;

 private:
  static std::int64_t kernels_drawn(const PreparedField& prepared) {
    const LatticeField& field = *prepared.frame.field;
    const int edge = field.source().brick_edge();
    return std::min(field.num_kernels(), prepared.plan.relevance.num_relevant() * edge * edge *
                                             edge * prepared.frame.lattice.num_sublattices);
  }
};

using Workspaces = std::vector<std::unique_ptr<LatticeWorkspace>>;

// For a frame with what is beside it. Throws Error(kOutOfMemory).
Workspaces workspaces_for(const LatticeFrame& frame, int num_workers) {
  Workspaces workspaces = make_workspaces<LatticeWorkspace>(num_workers);
  if (frame.beside.empty()) return workspaces;
  const std::size_t bytes =
      workspaces.size() * (frame.beside.size() * sizeof(Workspace) + sizeof(MixedSamples));
  data::allocated("the working memory of the threads", bytes, [&] {
    for (const auto& work : workspaces) {
      while (work->beside.size() < frame.beside.size())
        work->beside.push_back(std::make_unique<Workspace>(kTilePlane));
      if (frame.is_mixed) work->mixed = std::make_unique<MixedSamples>();
    }
    return 0;
  });
  return workspaces;
}

// Draws samples into a picture: on image sheets, or of a base plane; job.options has the size of
// that. Returns what bricks are relevant.
std::vector<view::RelevanceMap> draw_samples(const FrameJob& job, const Machine& machine,
                                             SamplesToDraw samples, Image& image,
                                             FrameProfile& profile) {
  const RenderOptions& options = job.options;
  const std::stop_token& stop = job.hooks.stop;
  const Clock::time_point start = Clock::now();
  const std::uint64_t start_ticks = read_ticks();
  Runner& runner = *machine.runner;

  PreparedFrame prepared(job, std::move(samples.relevance), runner);
  LatticeFrame& frame = prepared.own->frame;
  frame.stop = stop;
  profile.kernels_drawn = prepared.kernels_drawn();
  const double plan_ms = ms_since(start);

  std::vector<TileRect> tiles =
      tiles_of(options.width, options.height, frame.samples_at_nodes ? kPatchSize : kTileSize);
  std::erase_if(tiles, [&](const TileRect& tile) {
    return (job.base != nullptr && !is_seen(*job.base, tile)) ||
           (samples.mask != nullptr && samples.mask->is_empty(tile.x0, tile.y0));
  });
  const Workspaces workspaces = workspaces_for(frame, runner.num_workers());
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
    const double per_ms = options.collect_profile ? ticks_per_ms : 0.0;
    for (const WorkerStats* stats : {&work->pixels.stats, &work->nodes.stats})
      add_worker_stats(*stats, per_ms, profile);
    for (const auto& other : work->beside) add_worker_stats(other->stats, per_ms, profile);
  }
  return std::move(prepared).relevance();
}

// Without a picture.
Frame empty_frame(const FrameJob& job, const Machine& machine) {
  Frame frame;
  frame.profile.backend = "cpu";
  frame.profile.simd_target = machine.target.name();
  frame.profile.threads = machine.runner->num_workers();
  frame.profile.kernels_total = job.field.num_kernels();
  for (const FurtherVolume& volume : job.further)
    frame.profile.kernels_total += volume.field.num_kernels();
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

// How many samples of a base plane apart those are that are drawn first.
int first_apart(const FrameJob& job) {
  int n = view::first_samples_apart(*job.base, steepness_of(job), job.look.mode, job.options);
  const auto apart = [&](const LatticeField& field) {
    return view::plane_for(*job.base, field.geometry()).samples_apart;
  };
  for (const FurtherVolume& volume : job.further) {
    const double most = std::max(apart(*job.field.lattice()), apart(volume.field));
    while (n > 1 && n * most > view::kMostSpacings) n /= 2;
  }
  return n;
}

// A base plane's samples.
Image draw_base_plane(const FrameJob& job, const Machine& machine, FrameProfile& profile) {
  int n = first_apart(job);
  // So many times samples are drawn, each time of a plane that is twice as dense.
  const int times = std::countr_zero(static_cast<unsigned>(n)) + 1;
  int number = 0;
  Image picture;
  std::optional<SampleMask> wanted;
  std::vector<view::RelevanceMap> relevance;
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
    relevance =
        draw_samples({job.field, job.camera, job.look, job.trail, options, hooks, job.light, &plane,
                      job.further, job.mixing},
                     machine, {wanted ? &*wanted : nullptr, std::move(relevance)}, image, profile);
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
