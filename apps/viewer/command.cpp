// SPDX-License-Identifier: Apache-2.0
#include "command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "ovoid/io.h"
#include "render_flags.h"
#include "session.h"

namespace ovoid::viewer {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Vec3& v) { return fmt::format("{},{},{}", v.x(), v.y(), v.z()); }

void erase(cli::FlagSet& flags, std::initializer_list<const char*> names) {
  for (const char* const name : names) flags.erase(name);
}

void tell_time(const Document& document, cli::FlagSet& flags) {
  if (!document.has_time() || document.launch->data.slice.plane) return;
  erase(flags, {"time", "step", "motion-blur"});
  const std::vector<double>& times = document.info->times;
  const double now = document.shown->time;
  const auto step = std::find(times.begin(), times.end(), now);
  if (document.info->is_staggered || step == times.end()) {
    flags.set("time", fmt::format("{}", now));
  } else {
    flags.set("step", fmt::format("{}", step - times.begin()));
  }
  if (document.time.blur_length > 0 && document.shown->trail) {
    flags.set("motion-blur",
              fmt::format("{},{}", document.time.blur_length, document.time.blur_decay));
  }
}

void tell_array(const Document& document, cli::FlagSet& flags) {
  const Shown& shown = *document.shown;
  erase(flags, {"array", "color-array", "component"});
  flags.erase("quantity");
  if (shown.is_density) flags.set("quantity", "density");
  if (!shown.is_density && document.array_info(shown.array) != nullptr)
    flags.set("array", shown.array);
  if (shown.color_array != shown.array && document.array_info(shown.color_array) != nullptr)
    flags.set("color-array", shown.color_array);
  if (shown.component != 0) {
    flags.set("component", shown.component == LatticeModelOptions::kMagnitude
                               ? "magnitude"
                               : fmt::format("{}", shown.component));
  }
  if (document.label_kernel) {
    flags.set("kernel", fmt::format("gaussian:{},{}", document.label_kernel->sigma,
                                    document.label_kernel->cutoff));
  }
}

void tell_look(const Document& document, cli::FlagSet& flags) {
  const Look& look = document.view.look;
  erase(flags, {"tf",
                "tf-name",
                "color-tf",
                "preset",
                "colormap",
                "opacity",
                "gradient-opacity",
                "window",
                "log",
                "symlog",
                "below-color",
                "above-color",
                "unit-distance",
                "mode",
                "iso",
                "shade",
                "no-shade",
                "ambient",
                "diffuse",
                "specular",
                "specular-power",
                "light"});
  if (look.mode != Mode::kXray) flags.erase("range");  // there it is that of the integrals
  Look file = look;
  if (file.unit_distance == 0 && !file.transfer_function.unit_distance) {
    // Said aloud: a look without one may be taken for that of another program.
    file.unit_distance = default_unit_distance(document.shown->field());
  }
  flags.set("tf", Json::parse(to_text(file)));
  if (look.color_function) {
    Look colors;
    colors.transfer_function = *look.color_function;
    flags.set("color-tf", Json::parse(to_text(colors)));
  }
  if (look.mode != Mode::kComposite) flags.set("mode", cli::name_of_mode(look.mode));
  if (look.mode == Mode::kIsosurface) flags.set("iso", fmt::format("{}", look.isovalue));
  const bool is_lit = look.mode == Mode::kComposite || look.mode == Mode::kIsosurface;
  if (is_lit && look.shade && look.light_direction)
    flags.set("light", text_of(*look.light_direction));
}

void tell_camera(const Document& document, cli::FlagSet& flags) {
  erase(flags, {"view", "azimuth", "elevation", "roll", "zoom", "projection", "view-angle"});
  flags.set("camera", Json::parse(to_text(document.camera)));
}

void tell_space(const Document& document, cli::FlagSet& flags) {
  const View& view = document.view;
  if (view.crop) {
    const auto end = [](double value) {
      return std::isinf(value) ? std::string() : fmt::format("{}", value);
    };
    const Vec3& lo = view.crop->min();
    const Vec3& hi = view.crop->max();
    erase(flags, {"crop", "crop-world"});
    if (lo.allFinite() || hi.allFinite() || !(lo.array().isInf() && hi.array().isInf()).all()) {
      flags.set("crop-world", fmt::format("{}:{},{}:{},{}:{}", end(lo.x()), end(hi.x()),
                                          end(lo.y()), end(hi.y()), end(lo.z()), end(hi.z())));
    }
  } else {
    flags.erase("crop-world");
  }
  cli::tell_plane(document.scenes({1, 1}).back()->plane, &flags);
}

void tell_marks(const Document& document, cli::FlagSet& flags) {
  const cli::AnnotationFlags& marks = document.view.marks;
  erase(flags, {"colorbar", "axes", "bounding-box", "scale-bar", "length-unit"});
  if (marks.color_bar) flags.set("colorbar", marks.title.empty() ? Json(true) : Json(marks.title));
  if (marks.axes) flags.set("axes", true);
  if (marks.bounding_box) flags.set("bounding-box", true);
  if (marks.scale_bar) flags.set("scale-bar", true);
  if (marks.length_unit && marks.any()) flags.set("length-unit", *marks.length_unit);
}

}  // namespace

cli::CropFlags crop_of(const Document& document) {
  cli::CropFlags crop = document.launch->drawing.crop;
  crop.world = document.view.crop;
  return crop;
}

cli::FlagSet flags_of(const Document& document, Size size) {
  cli::FlagSet flags = cli::FlagSet::of(document.launch->flags->given());
  flags.set("size", fmt::format("{}x{}", size.width, size.height));
  const Rgb& back = document.view.background;
  flags.set("background", fmt::format("{},{},{}", back[0], back[1], back[2]));
  tell_time(document, flags);
  tell_array(document, flags);
  tell_look(document, flags);
  tell_camera(document, flags);
  tell_space(document, flags);
  tell_marks(document, flags);
  RenderOptions options = document.view.options;
  options.clip_planes = document.view.clip_planes;
  if (document.view.look.mode != Mode::kComposite)
    options.classification = Classification::kSampled;  // has no effect there, and is refused
  cli::tell_numbers(options, &flags);
  cli::tell_run(document.setup, &flags);
  return flags;
}

std::string command_of(const Document& document, Size size) {
  std::vector<std::string> words = {"ovoid", "render"};
  for (const std::string& input : document.launch->data.inputs) words.push_back(input);
  for (const std::string& word : flags_of(document, size).words()) words.push_back(word);
  words.insert(words.end(), {"-o", "picture.png"});
  return cli::quoted(words);
}

Json window_state(const Document& document) {
  const TimeState& time = document.time;
  return {{"loops", time.loops},
          {"interpolated", time.is_interpolated},
          {"fastest", time.is_fastest},
          {"rate", time.rate}};
}

void take_window_state(const Json& window, Document& document) {
  const auto take = [&](const char* key, bool* into) {
    if (window.is_object() && window.contains(key) && window[key].is_boolean())
      *into = window[key].get<bool>();
  };
  TimeState& time = document.time;
  take("loops", &time.loops);
  take("interpolated", &time.is_interpolated);
  take("fastest", &time.is_fastest);
  if (!window.is_object() || !window.contains("rate") || !window["rate"].is_number()) return;
  const double rate = window["rate"].get<double>();
  if (std::isfinite(rate) && rate > 0) time.rate = rate;
}

}  // namespace ovoid::viewer
