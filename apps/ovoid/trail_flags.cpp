// SPDX-License-Identifier: Apache-2.0
#include "trail_flags.h"

#include <fmt/format.h>

#include <vector>

#include "look_flags.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"
#include "usage.h"
#include "values.h"

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

void add_trail_flags(Flags& flags, TrailFlags* trail) {
  flags.section("motion blur");
  flags.value("--motion-blur", "L[,DECAY]",
              fmt::format("lattices in time: behind everything a trail of what was there in the "
                          "last L units of time, what was first less by exp(-DECAY) (default {})",
                          trail->decay),
              [trail](const std::string& text) {
                const bool has_decay = text.find(',') != std::string::npos;
                const auto parts = split(text, ',');
                if (parts.size() > 2) throw BadValue("expected L or L,DECAY");
                trail->length = parse_number(parts[0], {.lo = 0, .lo_open = true});
                if (has_decay)
                  trail->decay = parse_number(parts[1], {.lo = 0, .hi = TrailOptions::kMaxDecay});
              });
  flags.value("--trail-tf", "FILE|JSON",
              "colours and opacities of the trail, as --tf (default: the picture's, a quarter as "
              "opaque)",
              [trail](const std::string& text) { trail->file = text; });
}

void check_trail_flags(const Flags& flags, const TrailFlags& trail, Mode mode,
                       PostConvolution post_convolution) {
  if (!trail.length) {
    if (flags.is_given("--trail-tf"))
      throw UsageError("--trail-tf: has no effect without --motion-blur");
    return;
  }
  check_look_of_flag("--trail-tf", trail.file, trail.file_name);
  if (mode != Mode::kComposite && mode != Mode::kIsosurface)
    throw UsageError("--motion-blur: is for --mode composite and isosurface");
  if (is_published(post_convolution))
    throw UsageError("--motion-blur: is for --post-convolution off and auto");
  if (flags.is_given("--hyperslice"))
    throw UsageError("--motion-blur: contradicts --hyperslice, which has no time before it");
}

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

}  // namespace ovoid::cli
