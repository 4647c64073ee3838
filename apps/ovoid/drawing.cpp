// SPDX-License-Identifier: Apache-2.0
#include "drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "make_look.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "values.h"

namespace ovoid::cli {
namespace {

bool shows_any(const TransferFunction& tf, const ValueRange& range) {
  if (tf.opacity_at(range.lo) > 0 || tf.opacity_at(range.hi) > 0) return true;
  return std::any_of(tf.opacities.begin(), tf.opacities.end(), [&](const OpacityPoint& point) {
    return range.lo <= point.x && point.x <= range.hi && point.opacity > 0;
  });
}

}  // namespace

std::vector<InputFile> files_to_read(const DataFlags& data, const DrawingFlags& drawing) {
  std::vector<InputFile> inputs = volume_inputs(data.inputs);
  const auto add = [&](const std::string& value, const char* what) {
    if (!value.empty() && !is_json(value)) inputs.push_back({value, what});
  };
  add(drawing.look.file, "the look of --tf");
  add(drawing.look.color_file, "the colours of --color-tf");
  add(drawing.trail.file, "the look of --trail-tf");
  add(drawing.camera.file, "the camera of --camera");
  return inputs;
}

Subject make_subject(const Dataset& dataset, const Flags& flags, DrawingFlags* drawing,
                     Session& session) {
  check_kind_flags(flags, dataset);
  Subject subject;
  subject.modelled = make_field(dataset, drawing->model, drawing->run.threads, session);
  if (!flags.is_given("kernel") && may_be_labels(drawing->look) &&
      holds_labels(subject.modelled.field)) {
    session.note(
        "the values look like labels: drawn with narrow kernels and a colour for each "
        "(--kernel, --tf, --colormap with --range for another look)");
    drawing->model.lattice.kernel = kLabelKernel;
    // Within a sample a narrow kernel's field is flat; only its neighbours know where it ends.
    if (!flags.is_given("gradient")) drawing->options.gradient = GradientMethod::kCentral;
    subject.modelled = make_field(dataset, drawing->model, drawing->run.threads, session);
  }
  subject.described = describe(dataset, subject.modelled, drawing->model.component);
  subject.unit = unit_of(dataset, subject.modelled, Role::kOpacity);
  return subject;
}

std::pair<double, double> range_of_integrals(const Image& image) {
  double lo = 0;
  double hi = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    lo = std::min<double>(lo, image.rgba[i]);
    hi = std::max<double>(hi, image.rgba[i]);
  }
  return {lo, hi};
}

void spread_over_integrals(TransferFunction& tf, const Image& image, const LookFlags& flags,
                           Session& session) {
  auto [lo, hi] = range_of_integrals(image);
  if (flags.range) std::tie(lo, hi) = *flags.range;
  session.note(
      fmt::format("x-ray: colours span the integrals {:g} to {:g} (value x length)", lo, hi));
  if (!(lo < hi)) hi = lo + 1;  // nothing but zeros: the low end's colour
  if (tf.scale == ValueScale::kLog) std::tie(lo, hi) = logarithmic_range(lo, hi, session);
  tf.map_range(lo, hi);
}

void color_integrals(Image& image, const TransferFunction& tf) {
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    if (image.rgba[i + 3] == 0) continue;
    const Rgb color = tf.color_at(image.rgba[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      image.rgba[i + c] = static_cast<float>(color[c]) * image.rgba[i + 3];
    }
  }
}

Frame draw_frame(Renderer& renderer, const Field& field, const Camera& camera, const Look& look,
                 const Trail* trail, const DrawingFlags& drawing, const RenderOptions& options,
                 const RenderHooks& hooks) {
  if (trail != nullptr) return renderer.render(field, camera, look, *trail, options, hooks);
  if (drawing.plane)
    return render_with_plane(renderer, field, camera, look, *drawing.plane, options, hooks);
  return renderer.render(field, camera, look, options, hooks);
}

bool is_empty(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] > 0) return false;
  }
  return true;
}

std::string cause_of_emptiness(const Look& look, const ValueRange& range) {
  std::string cause =
      "is all of the data clipped away or out of sight, or too thin for its sheets "
      "(--sampling-distance)?";
  if (look.mode == Mode::kIsosurface && !(range.lo <= look.isovalue && look.isovalue <= range.hi)) {
    cause = fmt::format("--iso {:g} is not among them", look.isovalue);
  } else if (uses_opacity(look.mode) && !shows_any(look.transfer_function, range)) {
    cause = "the look gives them no opacity (--range, --opacity, --tf)";
  }
  return fmt::format("the data's values are {:g} to {:g}; {}", range.lo, range.hi, cause);
}

void write_picture(Image& image, const DrawingFlags& drawing, const Described& described,
                   const Camera& camera, const Look& look, const PictureFile& file) {
  draw_annotations(image, drawing.annotation, described, camera, look, drawing.background);
  write_image(image, file.path, drawing.background, {file.stop});
}

}  // namespace ovoid::cli
