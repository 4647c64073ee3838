// SPDX-License-Identifier: Apache-2.0
// A frame of the reference back end: rows of pixels, handed to plain threads. Rows share nothing
// but the picture they are written to, so the number of threads cannot be seen in it.
#include "render/reference/reference_renderer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "data/validate.h"
#include "ovoid/error.h"
#include "render/reference/field_evaluator.h"
#include "render/reference/kernel_tracer.h"
#include "render/reference/lattice_tracer.h"
#include "render/reference/warp.h"
#include "render/teller.h"

namespace ovoid::reference {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

Image empty_image(const RenderOptions& options) {
  Image image;
  image.width = options.width;
  image.height = options.height;
  const std::size_t pixels =
      static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
  try {
    image.rgba.assign(4 * pixels, 0.0F);
    image.depth.assign(pixels, std::numeric_limits<float>::infinity());
    image.front_depth = image.depth;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, "width x height = " + std::to_string(options.width) +
                                             " x " + std::to_string(options.height) +
                                             ": no memory for the picture");
  }
  return image;
}

// The tracer of the rows [y0, y1).
using TracerOfRows = std::function<std::shared_ptr<const PixelTracer>(int y0, int y1)>;

// Draws the rows of one picture with several threads, some rows with one tracer.
class RowPainter {
 public:
  RowPainter(TracerOfRows tracer, int rows_each, const RenderHooks& hooks, Image& image)
      : tracer_(std::move(tracer)),
        rows_each_(rows_each),
        hooks_(hooks),
        image_(image),
        teller_(hooks, image.height) {}

  // With as many threads as the system grants; `threads` is then that many. Throws
  // Error(kCancelled), and what a hook throws.
  TraceCounts paint(int& threads) {
    {
      std::vector<std::jthread> helpers;
      helpers.reserve(static_cast<std::size_t>(threads));
      try {
        while (static_cast<int>(helpers.size()) + 1 < threads)
          helpers.emplace_back([this] { work(); });
      } catch (const std::system_error&) {
        threads = static_cast<int>(helpers.size()) + 1;
      }
      work();
    }
    if (failure_) std::rethrow_exception(failure_);
    if (num_done_ < image_.height) {
      throw Error(ErrorCode::kCancelled, "rendering was cancelled");
    }
    return counts_;
  }

 private:
  void work() noexcept {
    try {
      TraceCounts counts;
      for (int y0 = next_row_.fetch_add(rows_each_); y0 < image_.height;
           y0 = next_row_.fetch_add(rows_each_)) {
        const int y1 = std::min(y0 + rows_each_, image_.height);
        if (hooks_.stop.stop_requested() || has_failed_) return;
        const std::shared_ptr<const PixelTracer> tracer = tracer_(y0, y1);
        for (int y = y0; y < y1; ++y) {
          if (!paint_row(*tracer, y, counts)) return;
          ++num_done_;
          teller_.done({0, y, image_.width, y + 1, &image_});
        }
      }
      const std::lock_guard lock(mutex_);
      counts_.samples += counts.samples;
      counts_.visible += counts.visible;
      counts_.gradients += counts.gradients;
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
      has_failed_ = true;
    }
  }

  // False if it was told to stop before the row was complete.
  bool paint_row(const PixelTracer& tracer, int y, TraceCounts& counts) {
    for (int x = 0; x < image_.width; ++x) {
      if (hooks_.stop.stop_requested() || has_failed_) return false;
      const Pixel pixel = tracer.trace(x, y, counts);
      const std::size_t position =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
          static_cast<std::size_t>(x);
      for (std::size_t c = 0; c < 4; ++c) {
        image_.rgba[4 * position + c] = static_cast<float>(pixel.rgba[c]);
      }
      image_.depth[position] = static_cast<float>(pixel.depth);
      image_.front_depth[position] = static_cast<float>(pixel.front_depth);
    }
    return true;
  }

  TracerOfRows tracer_;
  int rows_each_;
  const RenderHooks& hooks_;
  Image& image_;
  std::atomic<int> next_row_ = 0;
  std::atomic<bool> has_failed_ = false;
  std::atomic<int> num_done_ = 0;  // rows
  Teller teller_;
  std::mutex mutex_;  // guards the rest
  TraceCounts counts_;
  std::exception_ptr failure_;
};

int checked_threads(int threads, const RenderOptions& options) {
  if (threads < 0) {
    throw Error(ErrorCode::kInvalidArgument,
                "threads = " + std::to_string(threads) + ": must be >= 0");
  }
  if (threads == 0) threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return std::min(threads, options.height);
}

void count(const TraceCounts& counts, FrameProfile& profile) {
  profile.samples_reconstructed = counts.samples;
  profile.samples_shaded = counts.visible;
  profile.gradients = counts.gradients;
}

}  // namespace

namespace {

// A field and who draws along its rays.
struct TracedField {
  TracedField(const LatticeField& field, const FrameJob& job, const Look& look,
              const RenderOptions& options, const BesideTracer& beside,
              const view::LightVolume* light)
      : evaluator(field),
        tracer(field, evaluator, job.camera, look, options, beside, job.base, light) {}
  TracedField(const TracedField&) = delete;
  TracedField& operator=(const TracedField&) = delete;

  FieldEvaluator evaluator;
  LatticeTracer tracer;
};

// On image sheets, or the picture on a base plane, whose size job.options has.
Frame render_samples(const FrameJob& job, int threads) {
  const auto& [field, camera, look, trail, options, hooks, light, base, further, mixing] = job;
  data::require_field(field);
  camera.validate();
  look.validate();
  options.validate();
  threads = checked_threads(threads, options);

  const Clock::time_point start = Clock::now();
  Frame frame;
  frame.image = empty_image(options);
  BesideTracer beside;
  std::optional<TracedField> behind;
  if (trail != nullptr) {
    behind.emplace(*trail->field, job, trail->look, trail->options, BesideTracer{}, nullptr);
    beside.trail = &behind->tracer;
  }
  beside.mixing = mixing;
  std::deque<TracedField> mixed;
  for (const FurtherVolume& volume : further) {
    mixed.emplace_back(volume.field, job, volume.look, options, BesideTracer{}, light);
    beside.further.push_back(&mixed.back().tracer);
  }
  const auto own =
      std::make_shared<const TracedField>(*field.lattice(), job, look, options, beside, light);
  const double copy_ms = milliseconds_since(start);

  const Clock::time_point trace_start = Clock::now();
  std::shared_ptr<const PixelTracer> tracer(own, &own->tracer);
  const TraceCounts counts =
      RowPainter([&](int, int) -> std::shared_ptr<const PixelTracer> { return tracer; }, 1, hooks,
                 frame.image)
          .paint(threads);

  FrameProfile& profile = frame.profile;
  profile.backend = "reference";
  profile.threads = threads;
  profile.frame_ms = milliseconds_since(start);
  if (options.collect_profile) {
    profile.stages_ms = {{"copy", copy_ms}, {"trace", threads * milliseconds_since(trace_start)}};
  }
  profile.kernels_total = field.num_kernels();
  profile.kernels_drawn = own->evaluator.num_existing();
  count(counts, profile);
  return frame;
}

// The kernels of a field of a frame, and the sheets that they reach.
struct ViewedSet {
  ViewedSet(const KernelField& of, const ViewRays& view)
      : field(of),
        kernels(view_kernels(of, view)),
        sheets(sheets_reached(kernels, view, of.source().cutoff())) {}

  const KernelField& field;
  std::vector<ViewedKernel> kernels;
  SheetRange sheets;
};

// The trail of some rows; null where there is none.
std::unique_ptr<const KernelTrailTracer> trail_of_rows(const view::TrailView* trail,
                                                       const std::deque<ViewedSet>& moments,
                                                       const ViewRays& view,
                                                       const KernelPlanes::Rows& rows,
                                                       const KernelPlanes::Way& way) {
  if (trail == nullptr) return nullptr;
  std::vector<KernelTrailTracer::Moment> parts;
  SheetRange all = moments.front().sheets;
  for (std::size_t m = 0; m < moments.size(); ++m) {
    const ViewedSet& set = moments[m];
    parts.push_back({KernelPlanes(set.field, set.kernels, view, set.sheets, rows, way),
                     trail->moments[m].share});
    all = {std::min(all.first, set.sheets.first), std::max(all.last, set.sheets.last)};
  }
  return std::make_unique<const KernelTrailTracer>(moments.front().field, std::move(parts), view,
                                                   all, trail->look, trail->options);
}

// Of some rows.
struct TracedSet {
  std::unique_ptr<const KernelTrailTracer> trail;
  std::optional<KernelTracer> own;
};

Frame render_kernels(const FrameJob& job, int threads) {
  const RenderOptions& options = job.options;
  const KernelField& field = *job.field.kernels();
  job.camera.validate();
  job.look.validate();
  options.validate();
  threads = checked_threads(threads, options);
  const Clock::time_point start = Clock::now();
  Frame frame;
  frame.image = empty_image(options);
  FrameProfile& profile = frame.profile;
  profile.kernels_total = field.num_kernels();
  const ViewRays view(field, job.camera, options);
  const ViewedSet own(field, view);
  std::deque<ViewedSet> moments;
  if (job.trail != nullptr) {
    for (const KernelMoment& moment : job.trail->moments) {
      moments.emplace_back(moment.field, view);
      profile.kernels_total += moment.field.num_kernels();
    }
  }
  const KernelPlanes::Way way{
      options.slab == Slab::kMean || (options.slab == Slab::kAuto && job.look.mode == Mode::kXray),
      options.post_convolution};
  constexpr int kRowsEach = 8;
  const auto tracer = [&](int y0, int y1) {
    const KernelPlanes::Rows rows{y0, y1, options.width};
    auto traced = std::make_shared<TracedSet>();
    traced->trail = trail_of_rows(job.trail, moments, view, rows, way);
    BesideTracer beside;
    beside.trail = traced->trail.get();
    traced->own.emplace(field, KernelPlanes(field, own.kernels, view, own.sheets, rows, way), view,
                        own.sheets, job.look, options, beside, job.light);
    return std::shared_ptr<const PixelTracer>(traced, &*traced->own);
  };
  const TraceCounts counts = RowPainter(tracer, kRowsEach, job.hooks, frame.image).paint(threads);
  profile.backend = "reference";
  profile.threads = threads;
  profile.frame_ms = milliseconds_since(start);
  if (options.collect_profile) profile.stages_ms = {{"trace", threads * profile.frame_ms}};
  profile.kernels_drawn = profile.kernels_total;
  count(counts, profile);
  return frame;
}

}  // namespace

Frame render(const FrameJob& job, int threads) {
  if (job.field.kernels() != nullptr) return render_kernels(job, threads);
  if (job.base == nullptr) return render_samples(job, threads);
  const RenderOptions& options = job.options;
  const RenderHooks& hooks = job.hooks;
  RenderOptions of_base = options;
  of_base.width = job.base->width;
  of_base.height = job.base->height;
  RenderHooks of_samples;
  of_samples.stop = hooks.stop;
  of_samples.progress = hooks.progress;
  Frame frame = render_samples({job.field, job.camera, job.look, job.trail, of_base, of_samples,
                                job.light, job.base, job.further, job.mixing},
                               threads);
  frame.image = warped(*job.base, frame.image, options);
  for (int y = 0; y < options.height; ++y) {
    if (hooks.stop.stop_requested()) throw Error(ErrorCode::kCancelled, "rendering was cancelled");
    if (hooks.tile_done) hooks.tile_done({0, y, options.width, y + 1, &frame.image});
  }
  return frame;
}

Frame render(const LatticeField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, int threads) {
  return render({field, camera, look, nullptr, options, hooks}, threads);
}

Frame render(const KernelField& field, const Camera& camera, const Look& look,
             const RenderOptions& options, const RenderHooks& hooks, int threads,
             const view::LightVolume* light) {
  return render({field, camera, look, nullptr, options, hooks, light}, threads);
}

}  // namespace ovoid::reference
