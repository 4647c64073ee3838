// SPDX-License-Identifier: Apache-2.0
#include "document.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "apply_crop.h"
#include "command.h"
#include "make_camera.h"
#include "make_geometry.h"
#include "make_labels.h"
#include "make_over.h"
#include "ovoid/crop.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "projection.h"

namespace ovoid::viewer {
namespace {

constexpr std::size_t kMostSteps = 200;  // of undo

// Modes that put what they see behind each other, and others things among it.
bool is_layered(Mode mode) { return mode == Mode::kComposite || mode == Mode::kIsosurface; }

// Whether the file alone says what was read of it, which is all that `ovoid make solid` takes.
bool is_read_as_control(const Launch& launch) {
  return launch.data.inputs.size() == 1 &&
         launch.flags->first_given(cli::data_settings()).empty() &&
         launch.flags->first_given(cli::raw_settings()).empty();
}

}  // namespace

void Document::take(const Opened& opened) {
  info = opened.info;
  awaits_first_ = true;
  is_reload_ = opened.is_reload && is_open();
  launch = opened.launch;
  opened_surfaces_ = opened.surfaces;
  opened_labels_ = opened.labels;
  opened_volumes_ = opened.volumes;
  extras.reset();
  counted_2d.reset();
  fit.reset();
  control_files.clear();
  time.is_playing = false;
}

void Document::change_views(const std::function<void(View&)>& change) {
  for (std::vector<View>* views : {&past_, &future_})
    std::for_each(views->begin(), views->end(), change);
  change(settled_);
  change(view);
  if (other) change(other->view);
}

void Document::forget_solids() {
  change_views([](View& of) { of.solid.reset(); });
}

void Document::give_up_solid() {
  if (shown && shown->is_of(view.solid)) return;
  view.solid = shown && !shown->is_rough ? shown->solid : std::nullopt;
  count_up();
}

void Document::take(const ShownReady& ready, double aspect) {
  const bool is_first = std::exchange(awaits_first_, false);
  shown = ready.shown;
  if (extras && extras->of != shown) extras.reset();
  if (counted_2d && !(choice_of(*counted_2d->of) == choice_of(*shown))) counted_2d.reset();
  if (is_first) time.now = shown->time;
  if (is_first && is_reload_) forget_solids();
  if (ready.kernel || ready.look) label_kernel = ready.kernel;
  if (is_first && !is_reload_) {
    const cli::DrawingFlags& flags = launch->drawing;
    view = {};
    view.look = *ready.look;
    view.options = flags.options;
    view.options.clip_planes.clear();
    view.clip_planes = flags.options.clip_planes;
    view.marks = flags.annotation;
    if (flags.background) view.background = *flags.background;
    if (flags.crop.world) view.crop = flags.crop.world;
    view.plane = flags.plane;
    view.surface = cli::surface_to_draw(shown->subject, flags);
    view.draws_surface = view.surface.opacity > 0;
    if (!view.draws_surface) view.surface.opacity = 1;  // what a click on it will show
    const std::optional<PointStyle> points = cli::points_to_draw(flags.points);
    view.draws_points = points.has_value();
    if (points) view.points = *points;
    for (std::size_t i = 0; i < opened_surfaces_.size(); ++i) {
      const cli::AddedStyle style = cli::added_style(flags.geometry, i);
      const bool is_hidden = style.opacity == 0;
      view.added.push_back({opened_surfaces_[i]->source, opened_surfaces_[i], style.color,
                            is_hidden ? 1 : style.opacity, is_hidden, style.color_map,
                            style.range});
    }
    opened_surfaces_.clear();
    view.labels = std::exchange(opened_labels_, std::nullopt);
    if (const LabelSurfaces* const labels = plain_labels(view))
      edit_labels(label_edits_of(labels->styles, flags.labels));
    view.slice_labels = flags.labels.on_slices;
    view.are_labels_flat = flags.labels.are_flat;
    for (const auto& volume : std::exchange(opened_volumes_, {})) add_volume(volume);
    view.mixing = flags.channels.mixing.value_or(Mixing::kAveraged);
    take_channels(true);
    view.added_edges = flags.geometry.shows_edges;
    view.slices = flags.geometry;
    setup = flags.run;
    time.blur_length = flags.trail.length.value_or(0);
    time.blur_decay = flags.trail.decay;
    take_window_state(launch->window, *this);
    other.reset();
    compare = CompareMode::kOff;
    const auto drawn = job(view, setup, {1, 1});
    camera = cli::make_camera(flags.camera, camera_subject(*drawn, aspect));
    past_.clear();
    future_.clear();
    settled_ = view;
    is_edited_ = false;
  } else if (ready.look && !is_first) {  // another array
    const Mode mode = view.look.mode;
    view.look = *ready.look;
    if (mode != Mode::kIsosurface) view.look.mode = mode;
    view.solid = shown->solid;
    if (!view.labels) view.label_edits.clear();  // other labels
    take_channels(false);
    is_edited_ = true;
    remember();
  }
  if (ready.look) view.options.gradient = ready.gradient;
  if (ready.look && shown->solid && is_read_as_control(*launch))
    control_files.push_back({shown->solid->control, launch->data.inputs.front()});
  count_up();
}

Bounds3 Document::bounds() const {
  const Bounds3 all = data_bounds();
  if (!view.crop) return all;
  const Bounds3 left(all.min().cwiseMax(view.crop->min()), all.max().cwiseMin(view.crop->max()));
  return left.isEmpty() ? all : left;
}

void Document::reset_camera(double aspect, const std::string& view_name) {
  const bool is_parallel = camera.parallel_projection;
  cli::CameraFlags flags;
  flags.view = view_name;
  const auto drawn = job(view, setup, {1, 1});
  camera = cli::make_camera(flags, camera_subject(*drawn, aspect));
  camera.parallel_projection = is_parallel;
}

bool Document::draws_surface(const View& of) const {
  return of.draws_surface && shown->subject.has_walls && of.look.mode == Mode::kComposite &&
         !of.plane;
}

bool Document::draws_points(const View& of) const {
  return of.draws_points && shown->subject.has_points && of.look.mode == Mode::kComposite &&
         !of.plane;
}

bool Document::has_trail(const View& of) const {
  return shown->trail != nullptr && time.blur_length > 0 && is_layered(of.look.mode) &&
         !draws_points(of);
}

bool Document::shows_scenery(const View& of) const {
  return is_layered(of.look.mode) && !has_trail(of) && !of.plane && !draws_points(of);
}

const LabelSurfaces* Document::plain_labels(const View& of) const {
  if (of.labels) return of.labels->surfaces.get();
  const LabelSurfaces& own = shown->subject.scene.labels;
  return own.map != nullptr ? &own : nullptr;
}

bool Document::shows_labels(const View& of) const {
  return shows_scenery(of) && !shows_channels(of) && plain_labels(of) != nullptr &&
         (of.labels || of.label_surfaces);
}

LabelSurfaces Document::labels_of(const View& of) const {
  if (!shows_labels(of)) return {};
  LabelSurfaces labels = *plain_labels(of);
  labels.styles = edited(std::move(labels.styles), of.label_edits);
  if (of.slice_labels) cli::show_on_slices(labels, *of.slice_labels);
  labels.shows_surfaces = !of.are_labels_flat;
  return labels;
}

void Document::edit_labels(LabelEdits edits) {
  const LabelSurfaces* const plain = plain_labels(view);
  TransferFunction& tf = view.look.transfer_function;
  if (!view.labels && plain != nullptr &&
      shows_labels_by_value(tf, edited(plain->styles, view.label_edits)))
    tf = label_look(edited(plain->styles, edits)).transfer_function;
  view.label_edits = std::move(edits);
  touch();
}

void Document::set_labels(std::optional<LabelsBeside> labels) {
  view.labels = std::move(labels);
  view.label_edits.clear();
  touch();
}

void Document::renew_labels(const LabelsBeside& labels) {
  change_views([&](View& of) {
    if (of.labels && of.labels->file == labels.file) of.labels = labels;
  });
  count_up();
}

Geometry AddedSurface::geometry(bool shows_edges) const {
  Geometry made{of->surface, color, opacity, shows_edges};
  if (!source.array.empty() && of->source.array == source.array)
    made.colors = cli::colors_of_values(color_map, range.value_or(of->values));
  return made;
}

void Document::add_surface(std::shared_ptr<const ReadSurface> surface) {
  const SurfaceSource source = surface->source;
  view.added.push_back({source, std::move(surface), cli::usual_surface_color(view.added.size())});
  touch();
}

void Document::renew_surface(const std::shared_ptr<const ReadSurface>& surface) {
  const auto put = [&](View& of, bool also_others) {
    for (AddedSurface& added : of.added) {
      const bool is_wanted = added.source == surface->source;
      if (is_wanted || (also_others && added.source.file == surface->source.file))
        added.of = surface;
    }
  };
  for (std::vector<View>* views : {&past_, &future_})
    for (View& of : *views) put(of, true);
  put(settled_, true);
  put(view, false);
  if (other) put(other->view, false);
  count_up();
}

std::vector<SurfaceSource> Document::surfaces_to_make() const {
  std::vector<SurfaceSource> sources;
  const auto look_at = [&](const View& of) {
    for (const AddedSurface& added : of.added) {
      if (!added.is_made()) sources.push_back(added.source);
    }
  };
  look_at(view);
  if (other) look_at(other->view);
  return sources;
}

void Document::give_up_surface(const SurfaceSource& source) {
  const auto give_up = [&](View& of) {
    for (AddedSurface& added : of.added) {
      if (added.source == source) added.source = added.of->source;
    }
  };
  give_up(view);
  if (other) give_up(other->view);
  count_up();
}

std::vector<SurfaceSource> Document::surfaces_of(const std::string& file) const {
  std::vector<SurfaceSource> sources;
  const auto look_at = [&](const View& of) {
    for (const AddedSurface& added : of.added) {
      const bool is_new = std::find(sources.begin(), sources.end(), added.source) == sources.end();
      if (added.source.file == file && is_new) sources.push_back(added.source);
    }
  };
  look_at(view);
  if (other) look_at(other->view);
  return sources;
}

cli::CameraSubject Document::camera_subject(const PictureJob& drawn, double aspect) const {
  return {drawn.scene, cli::bounds_with(bounds(), drawn.scene), shown->subject.described.space,
          aspect, drawn.options.clip_planes};
}

const ArrayInfo* Document::array_info(const std::string& name) const {
  if (!info) return nullptr;
  const auto found = std::find_if(info->arrays.begin(), info->arrays.end(),
                                  [&](const ArrayInfo& array) { return array.name == name; });
  return found == info->arrays.end() ? nullptr : &*found;
}

RenderOptions Document::options_of(const View& of, Size size) const {
  RenderOptions options = of.options;
  options.width = size.width;
  options.height = size.height;
  options.clip_planes = of.clip_planes;
  cli::CropFlags crop = launch->drawing.crop;
  crop.world = of.crop;
  if (crop.world && (crop.world->min().array() >= data_bounds().max().array()).any())
    crop.world.reset();
  try {
    cli::apply_crop(crop, shown->field(), &options);
  } catch (const Error&) {
    options.clip_planes = of.clip_planes;  // nothing would be left, so nothing is cut
  }
  return options;
}

std::shared_ptr<PictureJob> Document::job(const View& of, const RendererSetup& on,
                                          Size size) const {
  auto made = std::make_shared<PictureJob>();
  made->shown = shown;
  made->extras = extras;
  made->camera = camera;
  made->options = options_of(of, size);
  made->setup = on;
  Scene& scene = made->scene;
  scene.volumes = {shown->subject.scene.volumes.front()};
  Volume& volume = scene.volumes.front();
  volume.look = of.look;
  if (has_trail(of)) volume.trail = shown->trail;
  if (draws_surface(of)) volume.walls = of.surface;
  if (draws_points(of)) volume.points = of.points;
  if (is_layered(of.look.mode) && !has_trail(of)) scene.plane = of.plane;
  if (shows_scenery(of)) {
    scene.labels = labels_of(of);
    for (const AddedSurface& added : of.added) {
      if (!added.is_hidden) scene.surfaces.push_back(added.geometry(of.added_edges));
    }
    made->slices = of.slices;
  }
  scene.mixing = of.mixing;
  for (Volume& further : volumes_of(of)) scene.volumes.push_back(std::move(further));
  if (shows_channels(of)) {
    put_channels(of, *made);
  } else if (scene.mixing == Mixing::kColored) {  // of what is not shown in this mode
    scene.mixing = Mixing::kAveraged;
  }
  made->background = of.background;
  made->xray_range = launch->drawing.look.range;
  return made;
}

// The view's job, but for what is drawn.
std::shared_ptr<PictureJob> Document::job_of_fit(Size size) const {
  auto made = job(view, setup, size);
  made->shown = fit_has_surface && fit->within ? fit->within : fit->shown;
  made->extras = fit->extras;
  made->is_of_shown = true;
  Scene& scene = made->scene;
  if (!view.labels) scene.labels = {};  // the data's own
  const Volume of_view = scene.volumes.front();
  scene.volumes = {made->shown->subject.scene.volumes.front()};
  Volume& volume = scene.volumes.front();
  volume.look = view.look;
  if (made->shown->subject.has_walls) volume.walls = of_view.walls;
  volume.points = of_view.points;
  for (Volume& further : volumes_of(view)) scene.volumes.push_back(std::move(further));
  // Opacities mean what they mean in the data's picture.
  volume.look.unit_distance = unit_distance_of(volume.look, shown->field());
  return made;
}

std::vector<std::shared_ptr<const PictureJob>> Document::jobs(Size size, int alone) const {
  if (!compares()) return {job(view, setup, size)};
  const bool is_split = compare == CompareMode::kSideBySide;
  const Size each{is_split ? std::max(1, size.width / 2) : size.width, size.height};
  const auto own = job(view, setup, each);
  const auto a = compares_fit() ? own : job(other->view, other->setup, each);
  const auto b = compares_fit() ? job_of_fit(each) : own;
  const double factor = static_cast<double>(alone > 0 ? alone : size.width) / each.width;
  if (is_split) a->camera = b->camera = of_height(camera, factor);
  return {a, b};
}

const ControlFile* Document::control_file() const {
  if (!view.solid) return nullptr;
  const auto found =
      std::find_if(control_files.rbegin(), control_files.rend(),
                   [&](const ControlFile& file) { return file.mesh == view.solid->control; });
  return found == control_files.rend() ? nullptr : &*found;
}

void Document::save_control(const std::string& path) {
  auto stored = std::make_shared<SolidMesh>(*view.solid->control);
  for (double& density : stored->densities) density = static_cast<float>(density);
  write_dataset(make_solid_dataset(*stored), path);
  const auto place = [](const std::string& name) {
    return std::filesystem::absolute(name).lexically_normal();
  };
  std::erase_if(control_files,
                [&](const ControlFile& file) { return place(file.path) == place(path); });
  if (stored->densities != view.solid->control->densities) {
    view.solid->control = std::move(stored);
    touch();
  }
  control_files.push_back({view.solid->control, path});
}

std::string Document::set_vertex(std::size_t vertex, const Vec3& place, double density) {
  if (!view.solid || vertex >= view.solid->control->num_vertices()) return {};
  auto moved = std::make_shared<SolidMesh>(*view.solid->control);
  std::copy_n(place.data(), 3, moved->positions.data() + 3 * vertex);
  moved->densities[vertex] = static_cast<float>(density);  // as a file has it
  try {
    check_solid_mesh(*moved);
  } catch (const Error& error) {
    return error.what();
  }
  view.solid->control = std::move(moved);
  return {};
}

void Document::remember() {
  if (!std::exchange(is_edited_, false)) return;
  past_.push_back(std::exchange(settled_, view));
  if (past_.size() > kMostSteps) past_.erase(past_.begin());
  future_.clear();
}

void Document::undo() {
  if (past_.empty()) return;
  future_.push_back(std::move(settled_));
  settled_ = view = std::move(past_.back());
  past_.pop_back();
  is_edited_ = false;
  count_up();
}

void Document::redo() {
  if (future_.empty()) return;
  past_.push_back(std::move(settled_));
  settled_ = view = std::move(future_.back());
  future_.pop_back();
  is_edited_ = false;
  count_up();
}

}  // namespace ovoid::viewer
