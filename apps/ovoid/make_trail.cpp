// SPDX-License-Identifier: Apache-2.0
#include "make_trail.h"

#include <fmt/format.h>

#include <algorithm>

#include "load.h"
#include "make_look.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid::cli {
namespace {

constexpr double kShareOfOpacity = 0.25;    // of the picture's own
constexpr double kOpacityOfSurface = 0.05;  // of what was within a surface

// What the picture shows, but fainter; within an isosurface a haze of its colour, from half-way up
// to the isovalue on.
TransferFunction fainter(const Look& look, const ValueRange& values) {
  TransferFunction faint = look.transfer_function;
  if (look.mode == Mode::kIsosurface) {
    const Rgb color = faint.color_at(look.isovalue);
    faint = {};
    faint.colors = {{look.isovalue, color}};
    faint.opacities = {{0.5 * (static_cast<double>(values.lo) + look.isovalue), 0.0},
                       {look.isovalue, kOpacityOfSurface}};
    return faint;
  }
  for (OpacityPoint& point : faint.opacities) point.opacity *= kShareOfOpacity;
  if (faint.opacities.empty()) faint.opacities = {{faint.lo(), kShareOfOpacity}};
  return faint;
}

TransferFunction function_of(const TrailFlags& flags, const Look& look, const ValueRange& values,
                             Session& session) {
  if (flags.file.empty()) return fainter(look, values);
  TransferFunction tf = look_of_flag("--trail-tf", flags.file, flags.file_name).transfer_function;
  if (tf.opacities.empty()) {
    session.note(source_of_flag("--trail-tf", flags.file) +
                 ": has no opacities, the trail is drawn with a ramp over its span");
    tf.opacities = {{tf.lo(), 0.0}, {tf.hi(), kShareOfOpacity}};
  }
  return tf;
}

}  // namespace

Trail make_trail(const TrailFlags& flags, const Series& series, double time,
                 const ModelFlags& model, int threads, const Look& look, const ValueRange& values,
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
  const Dataset dataset = trail_before(series, time, options);
  const Quiet quiet(session);
  const Modelled modelled = make_field(dataset, model, threads, session);
  return {*modelled.field.lattice(), function_of(flags, look, values, session)};
}

std::optional<Trail> trail_of(const DataFlags& data, const DrawingFlags& drawing,
                              const Modelled& modelled, std::int64_t step, const Look& look,
                              Session& session) {
  if (!drawing.trail.length) return std::nullopt;
  Progress progress("blurring");
  const Series series = open_shown_series(data, session);
  const auto& times = series.times();
  const double time = data.slice.plane
                          ? std::clamp(data.slice.plane->offset, times.front(), times.back())
                          : data.time.value_or(times[static_cast<std::size_t>(step)]);
  ModelFlags model = drawing.model;
  model.array = modelled.array;
  return make_trail(drawing.trail, series, time, model, drawing.run.threads, look,
                    modelled.field.value_range(), session);
}

}  // namespace ovoid::cli
