// SPDX-License-Identifier: Apache-2.0
#include "make_trail.h"

#include <fmt/format.h>

#include <algorithm>

#include "load.h"
#include "make_look.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"
#include "series_survey.h"

namespace ovoid::cli {
namespace {

// How opaque a trail is. Opacities are over a spacing, or two sigmas of kernels, of which fewer lie
// behind each other.
struct Faintness {
  double share;       // of the picture's own opacity
  double of_surface;  // what was within an isosurface
};
constexpr Faintness kFaintLattice{0.25, 0.05};
constexpr Faintness kFaintKernels{0.5, 0.2};

const Faintness& faintness_of(const Field& field) {
  return field.lattice() != nullptr ? kFaintLattice : kFaintKernels;
}

// What the picture shows, but fainter; within an isosurface a haze of its colour, from half-way up
// to the isovalue on.
TransferFunction fainter(const Look& look, const ValueRange& values, const Faintness& than) {
  TransferFunction faint = look.transfer_function;
  if (look.mode == Mode::kIsosurface) {
    const Rgb color = faint.color_at(look.isovalue);
    faint = {};
    faint.colors = {{look.isovalue, color}};
    faint.opacities = {{0.5 * (static_cast<double>(values.lo) + look.isovalue), 0.0},
                       {look.isovalue, than.of_surface}};
    return faint;
  }
  for (OpacityPoint& point : faint.opacities) point.opacity *= than.share;
  if (faint.opacities.empty()) faint.opacities = {{faint.lo(), than.share}};
  return faint;
}

// The height that half of some kernels' places have less than, of a sum.
double usual_height(const KernelField& field) {
  constexpr std::int64_t kMostPlaces = 4096;
  const KernelSource& source = field.source();
  const std::int64_t every = std::max<std::int64_t>(1, source.num_kernels() / kMostPlaces);
  const KernelSampler sampler(field);
  std::vector<double> heights;
  std::int64_t next = 0;
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelBrick& brick = source.brick(b);
    if (next < brick.count) {
      const KernelView view = source.acquire(b, 0.0);
      for (; next < brick.count; next += every) {
        const Vec3 offset(view.center[0][next], view.center[1][next], view.center[2][next]);
        heights.push_back(sampler.at(brick.origin + offset).value);
      }
    }
    next -= brick.count;
  }
  const auto middle = heights.begin() + std::ssize(heights) / 2;
  std::nth_element(heights.begin(), middle, heights.end());
  return *middle;
}

// The values of what is spread over a trail are less than those of what is there. Its look is for
// values that are as many times less, so that both show alike.
void scale_to_trail(const KernelField& now, const KernelField& trail, TransferFunction& tf) {
  if (now.reconstruction() != Reconstruction::kSum) return;
  const double ratio = usual_height(trail) / usual_height(now);
  if (!(ratio > 0) || !std::isfinite(ratio)) return;
  tf.linear_width *= ratio;
  for (OpacityPoint& point : tf.opacities) point.x *= ratio;
  if (now.has_own_color()) return;
  for (ColorPoint& point : tf.colors) point.x *= ratio;
}

TransferFunction function_of(const TrailFlags& flags, const TrailSubject& subject,
                             const Trail& trail, Session& session) {
  const Faintness& faintness = faintness_of(subject.now);
  if (flags.file.empty()) {
    TransferFunction faint = fainter(subject.look, subject.values, faintness);
    if (!trail.moments.empty())
      scale_to_trail(*subject.now.kernels(), trail.moments.front().field, faint);
    return faint;
  }
  TransferFunction tf = look_of_flag("--trail-tf", flags.file, flags.file_name).transfer_function;
  if (tf.opacities.empty()) {
    session.note(source_of_flag("--trail-tf", flags.file) +
                 ": has no opacities, the trail is drawn with a ramp over its span");
    tf.opacities = {{tf.lo(), 0.0}, {tf.hi(), faintness.share}};
  }
  return tf;
}

// The array that is drawn is drawn of all steps; a density is none.
ModelFlags model_of(const Dataset& like, const DrawingFlags& drawing, const Modelled& modelled) {
  ModelFlags model = drawing.model;
  if (!model.kernels.is_density && find_array(like, modelled.array) != nullptr)
    model.array = modelled.array;
  return model;
}

// When the picture of a step is.
double time_of_trail(const DataFlags& data, const Series& series, std::int64_t step) {
  const auto& times = series.times();
  if (data.slice.plane) return std::clamp(data.slice.plane->offset, times.front(), times.back());
  return data.time.value_or(times[static_cast<std::size_t>(step)]);
}

}  // namespace

Trail make_trail(const TrailFlags& flags, const Series& series, double time,
                 const ModelFlags& model, int threads, const TrailSubject& subject,
                 Session& session) {
  if (series.num_steps() < 2) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--motion-blur: '{}' has one step", series.source().name()));
  }
  TrailOptions options;
  options.length = *flags.length;
  options.decay = flags.decay;
  options.threads = threads;
  options.stop = session.stop();
  if (subject.memory_limit) options.memory_limit = *subject.memory_limit / 2;
  Trail trail;
  if (const KernelField* const now = subject.now.kernels()) {
    const std::shared_ptr<const Dataset> like = series.step(series.nearest_step(time));
    const KernelModelOptions kernels = [&] {
      const Quiet quiet(session);
      return kernel_options(*like, model, threads, session);
    }();
    KernelTrail found = kernel_trail_before(series, time, options, kernels, *now);
    session.notes(found.notes);
    trail.moments = std::move(found.moments);
  } else {
    const Dataset dataset = trail_before(series, time, options);
    const Quiet quiet(session);
    trail.field = *make_field(dataset, model, threads, session).field.lattice();
  }
  trail.transfer_function = function_of(flags, subject, trail, session);
  return trail;
}

Bounds3 bounds_of(const Trail& trail) {
  if (trail.moments.empty()) return trail.field.world_bounds();
  Bounds3 bounds;
  for (const KernelMoment& moment : trail.moments) bounds.extend(moment.field.world_bounds());
  return bounds;
}

std::shared_ptr<const Trail> trail_of(const DataFlags& data, const DrawingFlags& drawing,
                                      const Modelled& modelled, std::int64_t step, const Look& look,
                                      Session& session) {
  if (!drawing.trail.length) return nullptr;
  Progress progress("blurring");
  const Series series = open_shown_series(data, session);
  const double time = time_of_trail(data, series, step);
  const ModelFlags model =
      model_of(*series.step(series.nearest_step(time), session.stop()), drawing, modelled);
  return std::make_shared<Trail>(
      make_trail(drawing.trail, series, time, model, drawing.run.threads,
                 {modelled.field, look, modelled.field.value_range(), data.memory_limit}, session));
}

}  // namespace ovoid::cli
