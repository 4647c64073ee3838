// SPDX-License-Identifier: Apache-2.0
#include "command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "make_fit.h"
#include "make_geometry.h"
#include "ovoid/io.h"
#include "session.h"
#include "settings.h"

namespace ovoid::viewer {
namespace {

using Json = nlohmann::ordered_json;

// In the window's part of a state.
constexpr const char* kOpacities = "surface_opacities";
constexpr const char* kLabelOpacities = "label_opacities";

// The moment, where there are several.
void take_time(const Document& document, cli::DataFlags& data, cli::TrailFlags& trail) {
  const std::vector<double>& times = document.info->times;
  const double now = document.shown->time;
  const auto step = std::find(times.begin(), times.end(), now);
  data.step.reset();
  data.time.reset();
  if (document.info->is_staggered || step == times.end()) {
    data.time = now;
  } else {
    data.step = step - times.begin();
  }
  trail.length.reset();
  if (document.time.blur_length > 0 && document.shown->trail &&
      !document.draws_points(document.view)) {
    trail.length = document.time.blur_length;
    trail.decay = document.time.blur_decay;
  }
}

cli::LookFlags look_of(const Document& document) {
  const Look& look = document.view.look;
  Look file = look;
  if (file.unit_distance == 0 && !file.transfer_function.unit_distance) {
    // Said aloud: a look without one may be taken for that of another program.
    file.unit_distance = default_unit_distance(document.shown->field());
  }
  cli::LookFlags flags;
  flags.file = to_text(file);
  if (look.color_function) {
    Look colors;
    colors.transfer_function = *look.color_function;
    flags.color_file = to_text(colors);
  }
  flags.mode = look.mode;
  if (look.mode == Mode::kIsosurface) {
    flags.isosurfaces = look.isosurfaces;
    if (flags.isosurfaces.empty()) flags.isosurfaces = {{look.isovalue}};
  }
  const bool is_lit = look.mode == Mode::kComposite || look.mode == Mode::kIsosurface;
  if (is_lit && (look.shade || look.shadows > 0)) {
    flags.light = look.light;
    flags.light_direction = look.light_direction;
    flags.further_lights = look.further_lights;
  }
  // There it is that of the integrals.
  if (look.mode == Mode::kXray) flags.range = document.launch->drawing.look.range;
  return flags;
}

// The view's, or else the samples that the data were opened with.
cli::CropFlags told_crop(const View& view, const cli::CropFlags& opened) {
  if (!view.crop) return {opened.samples, {}};
  const bool is_cut = !(view.crop->min().array().isInf() && view.crop->max().array().isInf()).all();
  return {{}, is_cut ? view.crop : std::nullopt};
}

// Of what is seen beside the field.
cli::LabelFlags labels_of(const Document& document) {
  const View& view = document.view;
  if (!document.shows_labels(view)) return {};
  const cli::LabelFlags& opened = document.launch->drawing.labels;
  cli::LabelFlags flags;
  flags.table = opened.table;
  if (view.labels) flags.file = view.labels->file;
  flags.own_surfaces = !view.labels;
  if (view.labels && view.labels->file == opened.file) {
    flags.inside = opened.inside;
    flags.outside = opened.outside;
  }
  tell_label_edits(document.plain_labels(view)->styles, view.label_edits, &flags);
  if (!view.slices.slices.empty()) {
    flags.on_slices = view.slice_labels;
    flags.are_flat = view.are_labels_flat;
  }
  return flags;
}

cli::ChannelFlags channels_of(const Document& document) {
  const View& view = document.view;
  const bool has_channels = document.shows_channels(view);
  cli::ChannelFlags flags;
  if (!has_channels && !document.shows_volumes(view)) return flags;
  const ShownChannels& shown = document.shown->channels;
  if (has_channels && shown.are_primaries()) {
    flags.names = shown.chosen;
    return flags;
  }
  const Mixing usual = has_channels ? Mixing::kAdded : Mixing::kAveraged;
  const bool is_told = view.mixing != usual && view.mixing != Mixing::kColored;
  if (is_told) flags.mixing = view.mixing;
  if (!has_channels) return flags;
  const std::vector<ChannelStyle> styles = document.channels_of(view);
  for (std::size_t i = 0; i < styles.size(); ++i) {
    if (styles[i].is_hidden) continue;
    flags.names.push_back(shown.named[i].name);
    flags.colors.push_back(styles[i].color);
    flags.ranges.emplace_back(styles[i].range.lo, styles[i].range.hi);
  }
  return flags;
}

// Each look as a whole: what is said of one volume must be said of those before it, too.
cli::OverFlags over_of(const Document& document) {
  const View& view = document.view;
  cli::OverFlags flags;
  if (!document.shows_volumes(view)) return flags;
  for (const AddedVolume& added : view.volumes) {
    if (added.is_hidden) continue;
    const VolumeSource& source = added.of->source;
    flags.files.push_back(source.file);
    flags.arrays.push_back(source.array);
    flags.looks.push_back(Json::parse(to_text(document.volume_look(view, added))).dump());
    flags.transforms.push_back(source.transform);
  }
  const auto drop_unsaid = [](std::vector<std::string>& words) {
    while (!words.empty() && words.back().empty()) words.pop_back();
  };
  drop_unsaid(flags.arrays);
  drop_unsaid(flags.transforms);
  return flags;
}

// As flags have it, which is how the map is spread over it.
std::pair<double, double> as_range(const std::pair<double, double>& values) {
  return {values.first, values.first < values.second ? values.second : values.first + 1};
}

cli::GeometryFlags geometry_of(const Document& document, FlagsFor use) {
  const View& view = document.view;
  if (!document.shows_scenery(view)) return {};
  cli::GeometryFlags flags;
  bool has_own_colors = false;
  bool is_see_through = false;
  bool has_arrays = false, has_maps = false, has_ranges = false, has_radii = false;
  for (const AddedSurface& added : view.added) {
    if (added.is_hidden && use == FlagsFor::kCommand) continue;
    has_own_colors |= added.color != cli::usual_surface_color(flags.files.size());
    is_see_through |= added.is_hidden || added.opacity != 1;
    const SurfaceSource& source = added.source;
    has_arrays |= !source.array.empty();
    has_maps |= !source.array.empty() && added.color_map != cli::kUsualAddedMap;
    has_ranges |= !source.array.empty() && added.range.has_value();
    has_radii |= source.radius > 0;
    flags.files.push_back(source.file);
    flags.arrays.push_back(source.array);
    flags.color_maps.push_back(added.color_map);
    flags.ranges.push_back(added.range.value_or(as_range(added.of->values)));
    flags.radii.push_back(source.radius);
    flags.colors.push_back(added.color);
    flags.opacities.push_back(added.is_hidden ? 0 : added.opacity);
  }
  if (!has_own_colors) flags.colors.clear();
  if (!is_see_through) flags.opacities.clear();
  if (!has_arrays) flags.arrays.clear();
  if (!has_maps) flags.color_maps.clear();
  if (!has_ranges) flags.ranges.clear();
  if (!has_radii) flags.radii.clear();
  flags.shows_edges = view.added_edges && !flags.files.empty();
  const cli::GeometryFlags slices = view.slices.slices.empty() ? cli::GeometryFlags() : view.slices;
  flags.slices = slices.slices;
  flags.slice_map = slices.slice_map;
  flags.slice_range = slices.slice_range;
  flags.slice_opacity = slices.slice_opacity;
  flags.shows_empty = slices.shows_empty;
  flags.has_outlines = slices.has_outlines;
  flags.outline_color = slices.outline_color;
  return flags;
}

template <class S>
void erase_all(const cli::Table<S>& table, cli::FlagSet& flags) {
  for (const cli::Setting<S>& setting : table) flags.erase(setting.flag.name);
}

// A solid's kernels are not the data that were opened, and what is for those is not for it.
void drop_data_flags(cli::FlagSet& flags) {
  erase_all(cli::data_settings(), flags);
  erase_all(cli::raw_settings(), flags);
  erase_all(cli::array_settings(), flags);
  erase_all(cli::kernel_settings(), flags);
  erase_all(cli::particle_settings(), flags);
  erase_all(cli::relevant_settings(), flags);
  erase_all(cli::surface_settings(), flags);
}

std::string solid_command(const Document& document) {
  const SolidShape& solid = *document.view.solid;
  return cli::quoted({"ovoid", "make", "solid", "--control", document.control_file()->path,
                      "--array", solid.control->name, "--levels", fmt::format("{}", solid.levels),
                      "--basis", name_of(solid.basis), "-o", "solid.ply"});
}

}  // namespace

cli::ModelFlags model_of(const Document& document) {
  cli::ModelFlags model = document.launch->drawing.model;
  const Shown& shown = *document.shown;
  const auto known = [&](const std::string& name) {
    return document.array_info(name) != nullptr ? name : "";
  };
  model.kernels.is_density = shown.is_density ? std::optional(true) : std::nullopt;
  model.array = shown.is_density ? "" : known(shown.array);
  model.kernels.color_array = shown.color_array == shown.array ? "" : known(shown.color_array);
  // Said only where it is not what would be drawn anyway.
  const ArrayInfo* const array = document.array_info(shown.array);
  const int usual = array != nullptr ? array->usual_component : 0;
  model.component = shown.component == usual ? cli::kUsualComponent : shown.component;
  if (document.shows_channels(document.view)) {
    model.component = cli::kUsualComponent;
    const std::vector<cli::NamedChannel>& named = shown.channels.named;
    // The only one that would be read.
    if (!named.empty() && document.array_info(named[0].name) != nullptr) model.array.clear();
  }
  if (document.label_kernel) model.lattice.kernel = *document.label_kernel;
  return model;
}

cli::CropFlags crop_of(const Document& document) {
  cli::CropFlags crop = document.launch->drawing.crop;
  crop.world = document.view.crop;
  return crop;
}

cli::FlagSet flags_of(const Document& document, Size size, FlagsFor use) {
  const View& view = document.view;
  cli::FlagSet flags = cli::FlagSet::of(document.launch->flags->given());
  if (document.view.solid) drop_data_flags(flags);
  cli::DrawingFlags drawing = document.launch->drawing;
  drawing.options = view.options;
  drawing.options.width = size.width;
  drawing.options.height = size.height;
  drawing.options.clip_planes = view.clip_planes;
  if (view.look.mode != Mode::kComposite)
    drawing.options.classification = RenderOptions().classification;  // no effect, is refused
  drawing.background = view.background;
  cli::tell(cli::picture_settings(), drawing, &flags);
  if (document.has_time() && !document.launch->data.slice.plane) {
    cli::DataFlags data = document.launch->data;
    take_time(document, data, drawing.trail);
    cli::tell(cli::data_settings(), data, &flags, {"time", "step"});
    cli::tell(cli::trail_settings(), drawing.trail, &flags, {"motion-blur"});
  }
  drawing.model = document.view.solid ? cli::ModelFlags() : model_of(document);
  cli::tell(cli::array_settings(), drawing.model, &flags);
  cli::tell(cli::particle_settings(), drawing.model, &flags, {"quantity"});
  if (document.label_kernel) cli::tell(cli::kernel_settings(), drawing.model, &flags, {"kernel"});
  const bool has_channels = document.shows_channels(view);
  const bool has_own_looks = has_channels && !document.shown->channels.are_primaries();
  const cli::LookFlags look = has_own_looks ? document.channel_flags(view) : look_of(document);
  cli::tell(cli::color_settings(), look, &flags);
  cli::tell(cli::light_settings(), look, &flags);
  cli::CameraFlags camera;
  camera.file = to_text(document.camera);
  cli::tell(cli::camera_settings(), camera, &flags);
  cli::tell(cli::crop_settings(), told_crop(view, document.launch->drawing.crop), &flags);
  drawing.plane = document.jobs({1, 1})[document.own_job()]->scene.plane;
  cli::tell(cli::plane_settings(), drawing, &flags);
  drawing.surface = {};
  if (!document.view.solid) drawing.surface.within = document.launch->drawing.surface.within;
  if (document.shown->subject.has_walls && view.look.mode == Mode::kComposite) {
    const bool is_drawn = document.draws_surface(view);
    drawing.surface.opacity = is_drawn ? view.surface.opacity : 0;
    drawing.surface.shows_edges = is_drawn && view.surface.shows_edges;
  }
  cli::tell(cli::surface_settings(), drawing.surface, &flags);
  drawing.points = {};
  if (document.draws_points(view)) drawing.points.size = view.points.size;
  cli::tell(cli::point_settings(), drawing.points, &flags);
  cli::tell(cli::geometry_settings(), geometry_of(document, use), &flags);
  cli::tell(cli::label_settings(), labels_of(document), &flags);
  cli::tell(cli::channel_settings(), channels_of(document), &flags);
  cli::tell(cli::over_settings(), over_of(document), &flags);
  cli::AnnotationFlags marks = document.marks_of(view);
  if (!marks.any()) marks.length_unit.reset();
  cli::tell(cli::mark_settings(), marks, &flags);
  cli::tell(cli::number_settings(), drawing.options, &flags);
  cli::tell(cli::switch_settings(), drawing.options, &flags);
  RendererSetup run = document.setup;
  if (run.backend != Backend::kAuto && run.backend != Backend::kVulkan) run.device = -1;
  cli::tell(cli::run_settings(), run, &flags);
  return flags;
}

bool has_command(const Document& document) {
  return !document.view.solid || document.control_file() != nullptr;
}

std::string command_of(const Document& document, Size size) {
  if (!has_command(document)) return fmt::format("# {}", kNoCommand);
  std::vector<std::string> words = {"ovoid", "render"};
  const cli::Words inputs =
      document.view.solid ? cli::Words{"solid.ply"} : document.launch->data.inputs;
  words.insert(words.end(), inputs.begin(), inputs.end());
  for (const std::string& word : flags_of(document, size).words()) words.push_back(word);
  words.insert(words.end(), {"-o", "picture.png"});
  const std::string first = document.view.solid ? solid_command(document) + " && " : "";
  return first + cli::quoted(words);
}

cli::Words fit_words(const Document& document, const cli::Words& goal, const std::string& output) {
  cli::FitFlags ignored;
  const cli::Flags fit = cli::make_fit_flags(&ignored);
  // A fit of a lattice is of its samples, whatever the kernels they are drawn with.
  const auto is_left_out = [&](const std::string& name) {
    const cli::Table<cli::ModelFlags>& kernels = cli::kernel_settings();
    return document.info->kind == DatasetKind::kLattice &&
           std::any_of(kernels.begin(), kernels.end(),
                       [&](const auto& setting) { return setting.flag.name == name; });
  };
  const cli::FlagSet all = flags_of(document, {1, 1});
  cli::FlagSet kept;
  for (const cli::FlagSet::Flag& flag : all.flags()) {
    if (cli::find_form(fit.forms(), flag.name) != nullptr && !is_left_out(flag.name))
      kept.set(flag.name, flag.value);
  }
  cli::Words words = document.launch->data.inputs;
  for (const std::string& word : kept.words()) words.push_back(word);
  words.insert(words.end(), goal.begin(), goal.end());
  words.insert(words.end(), {"-o", output});
  return words;
}

Json window_state(const Document& document) {
  const TimeState& time = document.time;
  Json window = {{"loops", time.loops},
                 {"interpolated", time.is_interpolated},
                 {"fastest", time.is_fastest},
                 {"rate", time.rate}};
  const std::vector<AddedSurface>& added = document.view.added;
  const auto is_hidden = [](const AddedSurface& surface) { return surface.is_hidden; };
  if (std::any_of(added.begin(), added.end(), is_hidden)) {
    for (const AddedSurface& surface : added) window[kOpacities].push_back(surface.opacity);
  }
  const Json of_labels = hidden_label_opacities(document.view.label_edits);
  if (!of_labels.is_null()) window[kLabelOpacities] = of_labels;
  return window;
}

namespace {

// Of those that are hidden: the others have theirs by a flag.
void take_opacities(const Json& window, std::vector<AddedSurface>& added) {
  if (!window.is_object() || !window.contains(kOpacities)) return;
  const Json& opacities = window[kOpacities];
  if (!opacities.is_array()) return;
  for (std::size_t i = 0; i < std::min(added.size(), opacities.size()); ++i) {
    const double opacity = opacities[i].is_number() ? opacities[i].get<double>() : 0;
    if (added[i].is_hidden && opacity > 0 && opacity <= 1) added[i].opacity = opacity;
  }
}

}  // namespace

void take_window_state(const Json& window, Document& document) {
  const auto take = [&](const char* key, bool* into) {
    if (window.is_object() && window.contains(key) && window[key].is_boolean())
      *into = window[key].get<bool>();
  };
  TimeState& time = document.time;
  take("loops", &time.loops);
  take("interpolated", &time.is_interpolated);
  take("fastest", &time.is_fastest);
  take_opacities(window, document.view.added);
  if (window.is_object() && window.contains(kLabelOpacities))
    take_hidden_label_opacities(window[kLabelOpacities], &document.view.label_edits);
  if (!window.is_object() || !window.contains("rate") || !window["rate"].is_number()) return;
  const double rate = window["rate"].get<double>();
  if (std::isfinite(rate) && rate > 0) time.rate = rate;
}

}  // namespace ovoid::viewer
