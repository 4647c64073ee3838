// SPDX-License-Identifier: Apache-2.0
// The tables of what is drawn and how. A row reads: flag, form of the value, where that lies, what
// it means, rules.
#include "settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "make_camera.h"
#include "make_labels.h"
#include "make_look.h"
#include "ovoid/error.h"
#include "session.h"
#include "setting_forms.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;
using Found = std::optional<std::string>;

// --- names of values

const Names<Mode> kModes = {{"composite", Mode::kComposite}, {"xray", Mode::kXray},
                            {"maximum", Mode::kMaximum},     {"mip", Mode::kMaximum},
                            {"minimum", Mode::kMinimum},     {"minip", Mode::kMinimum},
                            {"mean", Mode::kMean},           {"isosurface", Mode::kIsosurface}};
const Names<Fit> kFits = {{"visible", Fit::kVisible}, {"box", Fit::kBox}};
const Names<bool> kProjections = {{"perspective", false}, {"parallel", true}};
const Names<Slab> kSlabs = {{"auto", Slab::kAuto}, {"mid", Slab::kMid}, {"mean", Slab::kMean}};
const Names<GradientMethod> kGradients = {{"auto", GradientMethod::kAuto},
                                          {"corrected", GradientMethod::kCorrected},
                                          {"exact", GradientMethod::kExact},
                                          {"central", GradientMethod::kCentral}};
const Names<Classification> kClassifications = {{"sampled", Classification::kSampled},
                                                {"pre-integrated", Classification::kPreintegrated},
                                                {"refined", Classification::kRefined}};
const Names<Evaluate> kEvaluates = {
    {"auto", Evaluate::kAuto}, {"gather", Evaluate::kGather}, {"scatter", Evaluate::kScatter}};
const Names<Sheets> kSheetWays = {
    {"auto", Sheets::kAuto}, {"image", Sheets::kImage}, {"lattice", Sheets::kLattice}};
const Names<PostConvolution> kPostConvolutions = {{"off", PostConvolution::kOff},
                                                  {"bilinear", PostConvolution::kBilinear},
                                                  {"gaussian", PostConvolution::kGaussian},
                                                  {"cubic", PostConvolution::kCubic},
                                                  {"auto", PostConvolution::kAuto}};
const Names<Spread> kSpreads = {{"gaussian", Spread::kGaussian}, {"bilinear", Spread::kBilinear}};
const Names<Backend> kBackends = {{"auto", Backend::kAuto},
                                  {"cpu", Backend::kCpu},
                                  {"vulkan", Backend::kVulkan},
                                  {"reference", Backend::kReference}};
const Names<SheetPrecision> kSheetPrecisions = {{"fp32", SheetPrecision::kSingle},
                                                {"fp16", SheetPrecision::kHalf}};

Names<std::string> named_views() {
  static const std::vector<std::string> all = view_names();
  Names<std::string> names;
  for (const std::string& name : all) names.emplace_back(name.c_str(), name);
  return names;
}

// --- tests of values, for rules

Found is_surface(const std::string& mode) { return if_so(mode == "isosurface", mode); }
Found is_without_opacity(const std::string& mode) {
  return if_so(mode == "xray" || mode == "isosurface", mode);
}
Found is_published_way(const std::string& way) { return if_so(way != "off" && way != "auto", way); }
Found is_color(const std::string& background) {
  return if_so(background != "none" && background != "transparent", background);
}
Found is_float_picture(const std::string& output) {
  return if_so(has_ending(output, ".exr") || has_ending(output, ".npy"), output);
}

// Where a logarithm has no place for values.
Found not_above_0(double value) { return if_so(!(value > 0), fmt::format("{:g}", value)); }
Found range_not_above_0(const std::string& text) { return not_above_0(parse_range(text).first); }
Found window_not_above_0(const std::string& text) { return not_above_0(parse_window(text).first); }
Found opacity_not_above_0(const std::string& text) {
  return not_above_0(parse_opacities(text).front().x);
}
// From 0 to 1 a list is spread as a map is.
Found colors_not_above_0(const std::string& text) {
  if (!is_list_of_colors(text)) return std::nullopt;
  const std::vector<ColorPoint> colors = parse_colors(text);
  if (colors.front().x == 0 && colors.back().x == 1) return std::nullopt;
  return not_above_0(colors.front().x);
}

Rule needs_values_above_0(Test test, std::vector<std::string> unless = {}) {
  Rule rule = not_with("log", "begins at {2}, expected values > 0 with --log", nullptr, test);
  rule.unless = std::move(unless);
  return rule;
}

// The first is the look's own, those after it stand beside it.
void take_light(const std::string& text, LookFlags& look) {
  if (!std::exchange(look.names_lights, true)) {
    std::tie(look.light, look.light_direction) = parse_light(text);
    return;
  }
  if (look.further_lights.size() == Look::kMaxFurtherLights) {
    throw BadValue(
        fmt::format("expected at most {} lights after the first", Look::kMaxFurtherLights));
  }
  look.further_lights.push_back(parse_further_light(text));
}

const Interval kNotNegative = {.lo = 0};
const Interval kShare = {.lo = 0, .hi = 1};

}  // namespace

const Table<LookFlags>& color_settings() {
  using L = LookFlags;
  static const Table<L> all = {
      {"--tf", look_file(), &L::file,
       "a look: ParaView JSON or XML, Slicer .vp.json or .vp, Inviwo .itf, or numbers; values "
       "are absolute; or JSON itself"},
      {"--tf-name", word("NAME"), &L::file_name,
       "which look of a file with several (default: the first)", needs("tf", "needs --tf FILE")},
      {"--color-tf", look_file(), &L::color_file,
       "colours of --color-array alone, as --tf; other flags about colour leave them be"},
      {"--preset", Form<std::string>{"NAME", parse_preset, same}, &L::preset,
       fmt::format("a look made for one kind of data: {}", fmt::join(look_preset_names(), ", ")),
       not_with("tf")},
      {"--colormap", Form<std::string>{"NAME|V,R,G,B,...", parse_color_map, same}, &L::color_map,
       fmt::format("{} (default viridis); NAME_r reverses; or colours at values",
                   fmt::join(color_map_names(), ", ")),
       needs_values_above_0(colors_not_above_0, {"range", "window"})},
      {"--opacity", form("V:A,V:A,...", parse_opacities), &L::opacities,
       "opacity A at value V, per unit distance", needs_values_above_0(opacity_not_above_0),
       not_with("mode", "has no effect with --mode {1}", is_without_opacity)},
      {"--gradient-opacity", form("G:A,G:A,...", parse_gradient_opacities), &L::gradient_opacities,
       "factor A on the opacity where the gradient has length G, value per world length",
       not_with("mode", "has no effect with --mode {1}", is_no_layer)},
      {"--tf2d", look_file(), &L::file_2d,
       "colour and opacity by value and gradient: JSON of regions or a table, or itself, the boxes "
       "of a ParaView state, a PNG picture, or a grid of RGBA",
       not_with("mode", "has no effect with --mode {1}", is_no_layer)},
      {"--tf2d-range",
       {"V,V,G,G", [](L& look, const std::string& text) { look.range_2d = parse_ranges_2d(text); },
        [](const L& look) {
          if (!look.range_2d) return Json();
          const auto& [v, g] = *look.range_2d;
          return Json(fmt::format("{},{},{},{}", v[0], v[1], g[0], g[1]));
        }},
       "of a picture's columns and rows: values from and to, gradients from and to",
       needs("tf2d", "needs --tf2d FILE")},
      {"--range",
       {"LO,HI", [](L& look, const std::string& text) { look.range = parse_range(text); },
        [](const L& look) {
          return look.range && !look.is_window ? Json(text_of(*look.range)) : Json();
        }},
       "spread the colours, and a file's opacities, over these values (default: the data's, or "
       "the file's own)",
       needs_values_above_0(range_not_above_0)},
      {"--window",
       {"W,L",
        [](L& look, const std::string& text) {
          look.range = parse_window(text);
          look.is_window = true;
        },
        [](const L& look) {
          if (!look.range || !look.is_window) return Json();
          const auto [lo, hi] = *look.range;
          return Json(fmt::format("{},{}", hi - lo, lo + (hi - lo) / 2));
        }},
       "as --range L-W/2,L+W/2; colours gray, unless --colormap says others",
       not_with("range tf preset"),
       needs_values_above_0(window_not_above_0)},
      {"--shift", number("V"), &L::shift,
       "move the look's colours and opacities, but those of --opacity, by V towards higher values"},
      {"--log", Toggle(), &L::is_log, "colours and opacity run along the logarithm of the value"},
      {"--symlog", number("W", kPositive), &L::linear_width,
       "along a logarithm on either side of zero, straight for values within W of it",
       not_with("log")},
      {"--below-color", form("COLOR", parse_rgb), &L::below_color,
       "of values below the colours' first: a name, #rrggbb, or R,G,B, each in [0, 1]"},
      {"--above-color", form("COLOR", parse_rgb), &L::above_color,
       "of values above the colours' last"},
      {"--unit-distance", number("D", kPositive), &L::unit_distance,
       "world length over which opacities are meant (default: the file's, or the default "
       "sampling distance)",
       not_with("mode", "has no effect with --mode {1}", is_no_layer)},
  };
  return all;
}

const Table<LookFlags>& light_settings() {
  using L = LookFlags;
  const Material usual;
  const auto material = [](const char* what, double otherwise) {
    return fmt::format("{} (default {:g}, or the look's)", what, otherwise);
  };
  const Rule lit = not_with("mode", "has no effect with --mode {1}, which is not lit", is_unlit);
  const Rule by_flag = not_with("no-shade", "has no effect with {0}");
  Rule unless_shadows = by_flag;
  unless_shadows.unless = {"shadows", "volumetric-scattering-blending"};
  static const Table<L> all = {
      {"--mode", choice(kModes), &L::mode, "(default {})",
       needs("iso", "needs --iso V", nullptr, is_surface)},
      {"--iso", form("V[:COLOR[:A]],...", parse_isosurfaces), &L::isosurfaces,
       "the value of the isosurface; or several, with colours (a name or #rrggbb; empty: the "
       "look's) and opacities A of their own (1)",
       needs("mode", "needs --mode isosurface", is_surface)},
      {"--shade", Toggle(), &L::shade, "light the volume (default, unless the look says no)", lit},
      {"--no-shade", Toggle(), &L::no_shade, "colours as they are", not_with("shade")},
      {"--ambient", number("K", kNotNegative), &L::ambient,
       material("light from everywhere", usual.ambient), lit, by_flag},
      {"--diffuse", number("K", kNotNegative), &L::diffuse,
       material("matt reflection", usual.diffuse), lit, by_flag},
      {"--specular", number("K", kNotNegative), &L::specular,
       material("highlights", usual.specular), lit, by_flag},
      {"--specular-power", number("K", kPositive), &L::specular_power,
       material("their sharpness", usual.specular_power), lit, by_flag},
      {"--light",
       {"studio|headlight|[studio:]X,Y,Z",
        [](L& look, const std::string& text) { take_light(text, look); },
        [](const L& look) {
          Json lights;
          const bool is_usual = look.light == Light::kStudio && !look.light_direction;
          if (is_usual && look.further_lights.empty()) return lights;
          lights.push_back(text_of_light(look.light, look.light_direction));
          for (const FurtherLight& light : look.further_lights) lights.push_back(text_of(light));
          return lights;
        },
        Content::kText, true},
       fmt::format("a key light above left of the camera and a soft one from the eye (default), "
                   "the eye's alone, one towards X,Y,Z (world), or that as the key. Given again: "
                   "X,Y,Z[@I], a further light of intensity I (1), up to {} of them",
                   Look::kMaxFurtherLights),
       lit,
       unless_shadows},
      {"--flat", number("SHARE", kShare), &L::flat_rise,
       "a field that rises by less than this share of the colours' span over a spacing is lit "
       "evenly: "
       "its normals are noise (default: the look's)",
       lit, by_flag},
      {"--occlusion", number("SHARE", kShare), &L::occlusion,
       fmt::format("how dark it gets where much lies around (default {:g}, or the look's; 0 where "
                   "nothing is lit)",
                   kUsualOcclusion),
       lit},
      {"--shadows", number("SHARE", kShare), &L::shadows,
       "how dark it gets behind what the key light, or one towards X,Y,Z, must pass (default 0, or "
       "the look's)",
       lit},
      {"--volumetric-scattering-blending", number("X", {.lo = 0, .hi = 2}), &L::scattering_blending,
       "VTK's word for --shadows, from 0 to 2", lit, not_with("shadows", kGiveOne)},
      {"--scatter", number("SHARE", kShare), &L::scatter,
       "how much light comes back into shadows from the sides (default 0, or the look's)", lit},
  };
  return all;
}

const Table<CameraFlags>& camera_settings() {
  using C = CameraFlags;
  static const Table<C> all = {
      {"--camera", word("FILE|JSON", Content::kCamera), &C::file,
       "a camera in VTK's words, or JSON itself"},
      {"--view", choice(named_views(), "DIRECTION"), &C::view,
       fmt::format("from where: {}; anterior to inferior are for patient data (default: patients "
                   "from the front, flat data from above, others three-quarter)",
                   fmt::join(view_names(), ", ")),
       not_with("camera", "contradicts --camera, which already says from where")},
      {"--azimuth", number("DEG"), &C::azimuth, "turn the camera around the view's up axis"},
      {"--elevation", number("DEG"), &C::elevation, "raise the camera"},
      {"--roll", number("DEG"), &C::roll, "turn the camera about its view axis"},
      {"--fit", choice(kFits), &C::fit,
       "how near: what shows fills the picture, or the whole box, transparent or not, is in sight "
       "(default {})",
       not_with("camera", "contradicts --camera, which already says from where")},
      {"--zoom", number("FACTOR", kPositive), &C::zoom, "above 1 comes nearer"},
      {"--projection", choice(kProjections), &C::parallel_projection, "(default perspective)"},
      {"--view-angle", number("DEG", {0, 180, true, true}), &C::view_angle,
       "vertical opening of the perspective (default 30)"},
  };
  return all;
}

const Table<CropFlags>& crop_settings() {
  using C = CropFlags;
  static const Table<C> all = {
      {"--crop", form("I0:I1,J0:J1,K0:K1", parse_samples), &C::samples,
       "draw only these samples of a lattice, counted from 0, both ends included; empty: all of "
       "that axis",
       for_data({DatasetKind::kLattice}, "lattices (--crop-world takes any data)")},
      {"--crop-world", form("X0:X1,Y0:Y1,Z0:Z1", parse_world), &C::world,
       "draw only what lies in this box, world; empty: no end", not_with("crop", kGiveOne)},
  };
  return all;
}

const Table<AnnotationFlags>& mark_settings() {
  using A = AnnotationFlags;
  const Rule png = {not_with(
      "output", "'{1}' holds the volume's own numbers, marks are drawn into .png and .jpg only",
      is_float_picture)};
  static const Table<A> all = {
      {"--colorbar",
       {"[=TITLE]",
        [](A& marks, const std::string& text) {
          marks.color_bar = true;
          marks.title = text;
        },
        [](const A& marks) {
          if (!marks.color_bar) return Json();
          return marks.title.empty() ? Json(true) : Json(marks.title);
        }},
       "what the colours stand for (default title: the array's name)",
       png},
      {"--axes", Toggle(), &A::axes, "directions of x, y, z, or of the patient", png},
      {"--bounding-box", Toggle(), &A::bounding_box, "edges of the volume and where they lie", png},
      {"--scale-bar", Toggle(), &A::scale_bar, "a round length, true at the focal point", png},
      {"--length-unit", word("NAME"), &A::length_unit,
       "unit of the world's lengths (default: mm for patient data, else none)",
       needs("colorbar axes bounding-box scale-bar",
             "has no effect without --scale-bar, --bounding-box or --colorbar")},
  };
  return all;
}

const Table<TrailFlags>& trail_settings() {
  using T = TrailFlags;
  static const Table<T> all = {
      {"--motion-blur",
       {"L[,DECAY]",
        [](T& trail, const std::string& text) {
          const auto parts = split(text, ',');
          if (parts.size() > 2) throw BadValue("expected L or L,DECAY");
          trail.length = parse_number(parts[0], kPositive);
          if (parts.size() > 1)
            trail.decay = parse_number(parts[1], {.lo = 0, .hi = TrailOptions::kMaxDecay});
        },
        [](const T& trail) {
          return trail.length ? Json(fmt::format("{},{}", *trail.length, trail.decay)) : Json();
        }},
       fmt::format("data in time: behind everything a trail of what was there in the last L units "
                   "of time (with --hyperslice: of E), what was first less by exp(-DECAY) (default "
                   "{})",
                   T{}.decay),
       not_with("mode", "is for --mode composite and isosurface", is_unlit),
       not_with("post-convolution", "is for --post-convolution off and auto", is_published_way)},
      {"--trail-tf", look_file(), &T::file,
       "colours and opacities of the trail, as --tf (default: the picture's, a quarter as opaque; "
       "half as opaque of what is no lattice, and of sums for the lower values of the trail)",
       needs("motion-blur", "has no effect without --motion-blur")},
  };
  return all;
}

const Table<DrawingFlags>& picture_settings() {
  using D = DrawingFlags;
  static const Table<D> all = {
      {"--size",
       {"WIDTHxHEIGHT",
        [](D& drawing, const std::string& text) {
          RenderOptions& options = drawing.options;
          std::tie(options.width, options.height) = parse_size(text, RenderOptions::kMaxImageSide);
        },
        [](const D& drawing) {
          return Json(fmt::format("{}x{}", drawing.options.width, drawing.options.height));
        }},
       fmt::format("pixels (default {}x{})", RenderOptions{}.width, RenderOptions{}.height)},
      {"--background",
       {"COLOR|none",
        [](D& drawing, const std::string& text) {
          if (text == "none" || text == "transparent") {
            drawing.background.reset();
            return;
          }
          try {
            drawing.background = parse_rgb(text);
          } catch (const BadValue& bad) {
            throw BadValue(fmt::format("{}, or none", bad.what()));
          }
        },
        [](const D& drawing) {
          if (!drawing.background) return Json("none");
          return *drawing.background == kBackground ? Json() : Json(text_of(*drawing.background));
        }},
       fmt::format("colour behind a PNG or JPEG: a name, #rrggbb, or R,G,B, each in [0, 1]; none: "
                   "transparent (default {})",
                   text_of(kBackground)),
       not_with("output", "'{1}' holds no background, only .png and .jpg do", is_float_picture,
                is_color)},
  };
  return all;
}

const Table<RenderOptions>& number_settings() {
  using R = RenderOptions;
  static const Table<R> all = {
      {"--sampling-distance", number("D", kPositive), &R::sampling_distance,
       "distance of sheets, world (default: half a lattice's smallest spacing, else twice the "
       "sigma of a narrow kernel; twice as much where nothing is refined)"},
      {"--slab", choice(kSlabs), &R::slab,
       "a sample is the field in the middle of its slab, or its mean there (default {})"},
      {"--gradient", choice(kGradients), &R::gradient,
       "the kernels' derivative, constant on ramps or as it is, or differences of samples "
       "(default {})"},
      {"--classification", choice(kClassifications), &R::classification,
       "colour and opacity of samples, of the piece from the sheet before, or of as many steps of "
       "it as the look needs (default {})",
       not_with("mode", "has no effect with --mode {1}", is_no_layer)},
      {"--sheets", choice(kSheetWays), &R::sheets,
       "sheets of samples parallel to the picture, or to a lattice's planes, which is faster and "
       "then warped to the picture (default {})"},
      {"--evaluate", choice(kEvaluates), &R::evaluate,
       "samples gather kernels, or kernels scatter to samples (default {})"},
      {"--post-convolution", choice(kPostConvolutions), &R::post_convolution,
       "magnified sheets are sampled at nodes, minified lattices and large kernels of a set on "
       "coarser levels; the "
       "three by name are published ways that blur (default {})"},
      {"--sheet-precision", choice(kSheetPrecisions), &R::sheet_precision,
       "of a kernel set's sheets, backend vulkan: fp16 is half the memory, where none would see it "
       "(default {})"},
      {"--spread", choice(kSpreads), &R::spread,
       "samples add to nodes by their kernel, or in the published ways to the four around "
       "(default {})"},
      {"--opaque-at", number("A", {.lo = 0, .hi = 1, .lo_open = true}), &R::opaque_at,
       "a pixel takes no more once its opacity has reached this (default {})"},
      {"--clip",
       {"NX,NY,NZ,D",
        [](R& options, const std::string& text) {
          if (options.clip_planes.size() == R::kMaxClipPlanes)
            throw BadValue(fmt::format("expected at most {} planes", R::kMaxClipPlanes));
          options.clip_planes.push_back(parse_clip(text));
        },
        [](const R& options) {
          Json planes;
          for (const ClipPlane& plane : options.clip_planes) planes.push_back(text_of(plane));
          return planes;
        },
        Content::kText, true},
       "keep points with n.x >= D, world (repeatable)"},
      {"--thick-slice",
       {"NX,NY,NZ,D,T",
        [](R& options, const std::string& text) {
          if (options.clip_planes.size() + 2 > R::kMaxClipPlanes) {
            throw BadValue(fmt::format("expected at most {} clip planes, of which it is two",
                                       R::kMaxClipPlanes));
          }
          for (const ClipPlane& plane : parse_thick_slice(text))
            options.clip_planes.push_back(plane);
        },
        [](const R&) { return Json(); }},  // told as --clip
       "keep points within T / 2 of the plane n.x = D, world: with --mode maximum, minimum, mean "
       "or "
       "xray what a slab of thickness T holds"},
  };
  return all;
}

const Table<DrawingFlags>& plane_settings() {
  using D = DrawingFlags;
  static const Table<D> all = {
      {"--value-plane", form("NX,NY,NZ,D[,shown]", parse_value_plane), &D::plane,
       "an opaque plane n.x = D, world, with the field's own colours; what is before it is cut "
       "away, or shown",
       not_with("mode", "is for --mode composite and isosurface", is_unlit),
       not_with("motion-blur", kGiveOne)},
  };
  return all;
}

namespace {

// "several volumes, lattice sheets"
std::string left_to_cpu() {
  std::string names;
  for (const BackEndFeature& feature : back_end_features()) {
    if (!feature.by_cpu || feature.by_vulkan) continue;
    names += (names.empty() ? "" : ", ") + std::string(feature.name);
  }
  return names;
}

}  // namespace

const Table<RendererSetup>& run_settings() {
  using R = RendererSetup;
  static const Table<R> all = {
      {"--backend", choice(kBackends), &R::backend,
       "what draws (default {}); not by vulkan: " + left_to_cpu()},
      {"--threads", integer("N", 0, 1024), &R::threads, "(default {}: one per hardware thread)"},
      {"--device", integer("N", 0, 1023), &R::device,
       "of the devices that 'ovoid info --devices' lists (default: the first GPU)"},
      {"--device-memory", bytes<std::uint64_t>("SIZE"), &R::device_memory,
       "of the device for data; more is drawn piece by piece (default: most of it)"},
  };
  return all;
}

const Table<RenderOptions>& switch_settings() {
  using R = RenderOptions;
  static const Table<R> all = {
      {"--no-skip", Toggle{false}, &R::skip_irrelevant,
       "reconstruct also what cannot be seen (slower, same picture)"},
      {"--no-stop", Toggle{false}, &R::stop_opaque,
       "work also on what is behind the opaque (slower, same picture)"},
      {"--no-pack", Toggle{false}, &R::pack_sheets,
       "backend vulkan: sum a set's kernels on one sheet at a time (slower, same picture)"},
  };
  return all;
}

void add_drawing_flags(Flags& flags, DrawingFlags* drawing) {
  flags.section("marks in a PNG");
  flags.add(mark_settings(), &drawing->annotation);
  add_array_flags(flags, &drawing->model);
  flags.section("colour and opacity");
  flags.add(color_settings(), &drawing->look);
  flags.refuse("--nan-color");
  flags.section("mode and light");
  flags.add(light_settings(), &drawing->look);
  flags.section("camera");
  flags.add(camera_settings(), &drawing->camera);
  flags.section("part of the data");
  flags.add(crop_settings(), &drawing->crop);
  flags.section("surface");
  flags.add(surface_settings(), &drawing->surface);
  flags.section("points");
  flags.add(point_settings(), &drawing->points);
  flags.section("geometry");
  flags.add(geometry_settings(), &drawing->geometry);
  flags.section("labels");
  flags.add(label_settings(), &drawing->labels);
  flags.section("motion blur");
  flags.add(trail_settings(), &drawing->trail);
  add_kernel_flags(flags, &drawing->model);
  flags.add(relevant_settings(), &drawing->model);
  flags.section("numbers");
  flags.add(number_settings(), &drawing->options);
  flags.add(plane_settings(), drawing);
  flags.section("running");
  flags.add(run_settings(), &drawing->run);
}

void check_json_flags(const DrawingFlags& drawing) {
  try {
    const LookFlags& look = drawing.look;
    if (is_json(look.file)) look_of_flag("--tf", look.file, look.file_name);
    if (is_json(look.color_file)) look_of_flag("--color-tf", look.color_file, {});
    if (is_json(drawing.trail.file)) look_of_flag("--trail-tf", drawing.trail.file, {});
    for (const std::string& own : drawing.over.looks) {
      if (is_json(own)) look_of_flag("--over-tf", own, {});
    }
    if (is_json(drawing.camera.file)) camera_of_flag(drawing.camera.file);
    if (is_json(drawing.labels.table)) table_of_flag(drawing.labels.table);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

const char* name_of_mode(Mode mode) { return name_in(kModes, mode); }

}  // namespace ovoid::cli
