// SPDX-License-Identifier: Apache-2.0
// ovoid render: data of any kind to a picture.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "annotation_flags.h"
#include "camera_flags.h"
#include "check_files.h"
#include "command.h"
#include "crop_flags.h"
#include "data_flags.h"
#include "dry_run.h"
#include "look_flags.h"
#include "model_flags.h"
#include "ovoid/io.h"
#include "profile.h"
#include "render_flags.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

constexpr int kMaxRepeat = 100'000;

struct RenderFlags {
  std::string output;
  std::optional<std::array<double, 3>> background;
  DataFlags data;
  ModelFlags model;
  LookFlags look;
  CameraFlags camera;
  CropFlags crop;
  AnnotationFlags annotation;
  RenderOptions options;
  RunFlags run;
  int repeat = 0;  // 0: one frame, the one that is written
  bool dry_run = false;
  bool profile = false;
  std::string profile_file;  // empty: a table on standard error
};

void add_picture_flags(Flags& flags, RenderFlags* render) {
  flags.section("picture");
  flags.value("-o,--output", "OUT", "the picture: .png, .exr or .npy",
              [render](const std::string& text) { render->output = text; });
  const RenderOptions& options = render->options;
  flags.value("--size", "WIDTHxHEIGHT",
              fmt::format("pixels (default {}x{})", options.width, options.height),
              [render](const std::string& text) {
                std::tie(render->options.width, render->options.height) =
                    parse_size(text, RenderOptions::kMaxImageSide);
              });
  flags.value("--background", "R,G,B|none",
              "colour behind a PNG, each in [0, 1] (default none: transparent)",
              [render](const std::string& text) {
                if (text == "none") return;
                try {
                  render->background = parse_rgb(text);
                } catch (const BadValue& bad) {
                  throw BadValue(fmt::format("{}, or none", bad.what()));
                }
              });
}

void add_measure_flags(Flags& flags, RenderFlags* render) {
  flags.value("--repeat", "N",
              "time N frames after one to warm up, the camera turned by 0.01 degree each",
              [render](const std::string& text) {
                render->repeat = static_cast<int>(parse_integer(text, 1, kMaxRepeat));
              });
  flags.optional_value("--profile", "[=FILE.json]",
                       "say where the time went, in a table or as JSON",
                       [render](const std::string& text) {
                         render->profile = true;
                         render->profile_file = text;
                       });
  flags.toggle("--dry-run",
               "read the data, tell what the picture will cost, and write nothing; needs no -o",
               &render->dry_run);
  add_switch_flags(flags, &render->options);
}

void add_flags(Flags& flags, RenderFlags* render) {
  add_input_flags(flags, &render->data);
  add_picture_flags(flags, render);
  add_annotation_flags(flags, &render->annotation);
  add_array_flags(flags, &render->model);
  add_look_flags(flags, &render->look);
  add_camera_flags(flags, &render->camera);
  add_crop_flags(flags, &render->crop);
  add_model_flags(flags, &render->model);
  add_number_flags(flags, &render->options);
  add_run_flags(flags, &render->run);
  add_measure_flags(flags, render);
  flags.footer("Which flag wins over another, and what the defaults are: docs/command-line.md.");
}

void check_flags(const Flags& flags, const RenderFlags& render) {
  require_inputs(flags, render.data);
  if (render.output.empty() && !render.dry_run)
    throw UsageError("--output: none given, expected -o OUT.png, .exr or .npy");
  const bool is_png = render.output.empty() || has_ending(render.output, ".png");
  if (!is_png && !has_ending(render.output, ".exr") && !has_ending(render.output, ".npy")) {
    throw UsageError(fmt::format("--output '{}': expected a name that ends in .png, .exr or .npy",
                                 render.output));
  }
  if (render.background && !is_png) {
    throw UsageError(
        fmt::format("--background: '{}' holds no background, only .png does", render.output));
  }
  check_look_flags(flags, render.look);
  check_camera_flags(flags);
  check_crop_flags(flags);
  check_model_flags(flags, render.model);
  if (flags.is_given("--color-array") && render.look.mode == Mode::kXray)
    throw UsageError("--color-array: has no effect with --mode xray, whose colours are integrals");
  check_annotation_flags(flags, render.output);
  std::vector<InputFile> inputs = volume_inputs(render.data.inputs);
  if (!render.look.file.empty()) inputs.push_back({render.look.file, "the look of --tf"});
  if (!render.camera.file.empty()) inputs.push_back({render.camera.file, "the camera of --camera"});
  std::vector<OutputFile> outputs;
  if (!render.output.empty()) outputs.push_back({"--output", render.output, render.output});
  if (!render.profile_file.empty())
    outputs.push_back({"--profile", render.profile_file, render.profile_file});
  check_files(inputs, outputs);
}

// An x-ray's integrals as colours: `tf` spread over the given range, or from 0 to the greatest.
void color_xray(Image& image, const LookFlags& flags, TransferFunction& tf, Session& session) {
  double lo = 0;
  double hi = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    lo = std::min<double>(lo, image.rgba[i]);
    hi = std::max<double>(hi, image.rgba[i]);
  }
  if (flags.range) std::tie(lo, hi) = *flags.range;
  session.note(
      fmt::format("x-ray: colours span the integrals {:g} to {:g} (value x length)", lo, hi));
  if (!(lo < hi)) hi = lo + 1;  // nothing but zeros: the low end's colour
  if (tf.scale == ValueScale::kLog) std::tie(lo, hi) = logarithmic_range(lo, hi, session);
  tf.map_range(lo, hi);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    const Rgb color = tf.color_at(image.rgba[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      image.rgba[i + c] = static_cast<float>(color[c]) * image.rgba[i + 3];
    }
  }
}

// One frame for the picture, and with --repeat N more for the clock.
Image draw(const RenderFlags& render, const Field& field, const Camera& camera, const Look& look,
           RunProfile* profile, Session& session) {
  Renderer renderer(render.run.backend, render.run.threads);
  RenderOptions options = render.options;
  RenderHooks hooks;
  hooks.stop = session.stop();
  // Stage timers only where they disturb no measured time.
  options.collect_profile = render.profile && render.repeat == 0;
  Frame first = [&] {
    Progress progress("drawing");
    hooks.progress = progress.callback();
    return renderer.render(field, camera, look, options, hooks);
  }();
  hooks.progress = nullptr;
  profile->frame = first.profile;
  if (render.repeat == 0) {
    profile->frames_ms = {first.profile.frame_ms};
    return std::move(first.image);
  }
  Progress progress("timing");
  for (int i = 0; i < render.repeat; ++i) {
    Camera turned = camera;
    turned.azimuth(kTurnDegrees * i);
    profile->frames_ms.push_back(
        renderer.render(field, turned, look, options, hooks).profile.frame_ms);
    progress.show((i + 1.0) / render.repeat);
  }
  if (render.profile) {
    options.collect_profile = true;
    profile->frame = renderer.render(field, camera, look, options, hooks).profile;
  }
  return std::move(first.image);
}

bool shows_any(const TransferFunction& tf, const ValueRange& range) {
  if (tf.opacity_at(range.lo) > 0 || tf.opacity_at(range.hi) > 0) return true;
  return std::any_of(tf.opacities.begin(), tf.opacities.end(), [&](const OpacityPoint& point) {
    return range.lo <= point.x && point.x <= range.hi && point.opacity > 0;
  });
}

// A picture without anything in it is seldom what was meant.
void note_if_empty(const Image& image, const Look& look, const ValueRange& range,
                   Session& session) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] > 0) return;
  }
  std::string cause =
      "is all of the data clipped away or out of sight, or too thin for its sheets "
      "(--sampling-distance)?";
  if (look.mode == Mode::kIsosurface && !(range.lo <= look.isovalue && look.isovalue <= range.hi)) {
    cause = fmt::format("--iso {:g} is not among them", look.isovalue);
  } else if (uses_opacity(look.mode) && !shows_any(look.transfer_function, range)) {
    cause = "the look gives them no opacity (--range, --opacity, --tf)";
  }
  session.note(fmt::format("nothing shows: the data's values are {:g} to {:g}; {}", range.lo,
                           range.hi, cause));
}

void tell_times(const RenderFlags& render, const RunProfile& profile, Session& session) {
  if (render.profile && render.profile_file.empty()) fmt::print(stderr, "{}", to_table(profile));
  if (!render.profile_file.empty()) write_text(to_json(profile), render.profile_file);
  if (render.repeat > 0 && !render.profile) {
    const Spread time = spread(profile.frames_ms);
    session.note(fmt::format("frame: {:.2f} ms median of {}, {:.2f} to {:.2f}", time.median,
                             render.repeat, time.min, time.max));
  }
}

}  // namespace

void run_render(const Words& words, Session& session) {
  RenderFlags render;
  Flags flags("render", "INPUT... -o OUT [FLAG...]",
              "Draws a volume, mesh, particles or kernels to a picture and exits; never opens a "
              "window.");
  add_flags(flags, &render);
  if (!flags.parse(words)) return;
  check_flags(flags, render);

  RunProfile profile;
  profile.command = session.command_line();
  profile.width = render.options.width;
  profile.height = render.options.height;
  render.data.array = array_to_read(render.model);
  const Stopwatch loading;
  Dataset dataset = load(render.data, session);
  profile.load_ms = loading.ms();
  const Stopwatch modelling;
  check_kind_flags(flags, dataset);
  if (flags.is_given("--crop") && dataset.kind != DatasetKind::kLattice)
    refuse_kind("--crop", "lattices (--crop-world takes any data)", dataset);
  Modelled modelled = make_field(dataset, render.model, render.run.threads, session);
  const Field& field = modelled.field;
  if (!flags.is_given("--kernel") && may_be_labels(render.look) && holds_labels(field)) {
    session.note(
        "the values look like labels: drawn with narrow kernels and a colour for each "
        "(--kernel, --tf, --colormap with --range for another look)");
    render.model.lattice.kernel = kLabelKernel;
    // Within a sample a narrow kernel's field is flat; only its neighbours know where it ends.
    if (!flags.is_given("--gradient")) render.options.gradient = GradientMethod::kCentral;
    modelled = make_field(dataset, render.model, render.run.threads, session);
  }
  profile.model_ms = modelling.ms();
  Described described = describe(dataset, modelled, render.model.lattice.component);
  const std::string unit = unit_of(dataset, modelled, Role::kOpacity);
  dataset = {};  // the field keeps what it borrows; the rest is memory that the frame can use

  const double aspect = static_cast<double>(profile.width) / profile.height;
  described.box = apply_crop(render.crop, field, &render.options);
  const Camera camera =
      make_camera(render.camera, described.box.world_bounds(), described.space, aspect);
  Look look = make_look(render.look, field, unit, session);
  if (render.dry_run) {
    const DryRun run{
        field, camera, look, render.options, render.run.backend, render.run.threads, render.output};
    fmt::print("{}", predict(run, session));
    return;
  }
  Image image = draw(render, field, camera, look, &profile, session);
  note_if_empty(image, look, field.value_range(), session);
  if (look.mode == Mode::kXray && has_ending(render.output, ".png")) {
    color_xray(image, render.look, look.transfer_function, session);
  }
  session.check_stop();
  const double* const background = render.background ? render.background->data() : nullptr;
  draw_annotations(image, render.annotation, described, camera, look, background);
  write_image(image, render.output, background);
  tell_times(render, profile, session);
}

}  // namespace ovoid::cli
