// SPDX-License-Identifier: Apache-2.0
#include "scene.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "flag_set.h"
#include "load.h"
#include "make_camera.h"
#include "make_look.h"
#include "make_trail.h"
#include "ovoid/coarse.h"
#include "ovoid/encode.h"
#include "ovoid/error.h"
#include "ovoid/look.h"
#include "ovoid/sampler.h"
#include "take_samples.h"
#include "usage.h"

namespace ovoid::python {
namespace {

using cli::DataFlags;
using cli::DrawingFlags;
using cli::Flags;
using cli::Session;
using cli::Words;

template <class S>
bool has_row(const cli::Table<S>& table, const std::string& name) {
  return std::any_of(table.begin(), table.end(),
                     [&](const cli::Setting<S>& setting) { return setting.flag.name == name; });
}

// Whether what was modelled stays the same, whatever the flag says.
bool is_about_view(const std::string& name) {
  return has_row(cli::picture_settings(), name) || has_row(cli::mark_settings(), name) ||
         has_row(cli::color_settings(), name) || has_row(cli::light_settings(), name) ||
         has_row(cli::camera_settings(), name) || has_row(cli::crop_settings(), name) ||
         has_row(cli::point_settings(), name) || has_row(cli::trail_settings(), name) ||
         has_row(cli::number_settings(), name) || has_row(cli::plane_settings(), name) ||
         has_row(cli::switch_settings(), name);
}

// All of them together take a seventh of the field's memory.
constexpr int kMostCoarse = 6;
constexpr std::int64_t kLeastWorthCoarsening = 4096;

std::string text_of(const cli::GivenFlag& flag) {
  std::string text = flag.name;
  for (const std::string& value : flag.values) text += '=' + value;
  return text + '\n';
}

// The flags that modelling looks at: others may change, and the field stays.
std::string model_key_of(const Flags& flags, const DrawingFlags& drawing) {
  std::string key;
  for (const cli::GivenFlag& flag : flags.given()) {
    if (!is_about_view(flag.name)) key += text_of(flag);
  }
  return key +
         fmt::format("labels {} {}", cli::may_be_labels(drawing.look), flags.is_given("gradient"));
}

// From where the flags turn and zoom the camera to where it is.
Camera unturned_camera(const cli::Shot& shot, const DrawingFlags& drawing) {
  const double aspect = static_cast<double>(drawing.options.width) / drawing.options.height;
  const Camera start = cli::start_camera(
      drawing.camera,
      {shot.scene, shot.described.box.world_bounds(), shot.described.space, aspect, {}});
  return cli::unturned_camera(drawing.camera, start, shot.camera);
}

}  // namespace

DrawFlags::DrawFlags(DataFlags* data, DrawingFlags* drawing)
    : Flags("render", "DATA", "Draws data to a picture.") {
  cli::add_input_flags(*this, data);
  add(cli::picture_settings(), drawing);
  cli::add_over_flags(*this, drawing);
  cli::add_drawing_flags(*this, drawing);
  add(cli::switch_settings(), &drawing->options);
}

struct Scene::Request {
  DataFlags data;
  DrawingFlags drawing;
  DrawFlags flags{&data, &drawing};
};

Scene::Scene(Source source) : source_(std::move(source)) {}

Scene::~Scene() {
  // The renderer's threads are not in a process that was forked: nothing could end them.
  if (renderer_ != nullptr && process_ != getpid()) (void)renderer_.release();
}

void Scene::model(Request& request, Session& session) {
  DrawingFlags& drawing = request.drawing;
  const cli::Stopwatch loading;
  request.data.may_stay_in_file = true;
  const Dataset dataset = cli::load(request.data, session);
  load_ms_ = loading.ms();
  const cli::Stopwatch modelling;
  const GradientMethod gradient = drawing.options.gradient;
  subject_ = cli::make_subject(dataset, request.flags, &drawing, session);
  model_ms_ = modelling.ms();
  gradient_of_labels_.reset();
  if (drawing.options.gradient != gradient) gradient_of_labels_ = drawing.options.gradient;
  outline_ = {};
  outline_.source = dataset.source;
  outline_.kind = dataset.kind;
  outline_.step = dataset.step;
  outline_.num_steps = dataset.num_steps;
}

Renderer& Scene::renderer(const Flags& flags, const RendererSetup& setup) {
  std::string key;
  for (const cli::GivenFlag& flag : flags.given()) {
    if (has_row(cli::run_settings(), flag.name)) key += text_of(flag);
  }
  const int process = getpid();
  if (renderer_ != nullptr && process_ != process) (void)renderer_.release();  // as in ~Scene()
  if (renderer_ == nullptr || renderer_key_ != key) {
    renderer_.reset();
    renderer_ = std::make_unique<Renderer>(setup);
    renderer_key_ = key;
    process_ = process;
  }
  return *renderer_;
}

int Scene::coarsen(int coarseness, Work& work) {
  const cli::Stopwatch modelling;
  const auto wanted = static_cast<std::size_t>(std::clamp(coarseness, 0, kMostCoarse));
  coarser_.reserve(kMostCoarse);
  while (coarser_.size() < wanted) {
    const Field& finest = coarser_.empty() ? subject_->modelled.field : coarser_.back();
    if (finest.num_kernels() < kLeastWorthCoarsening) break;
    try {
      coarser_.push_back(coarse_field(finest, {.stop = work.stop}));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnsupported) throw;
      break;  // pixels alone become coarser
    }
    model_ms_ = modelling.ms();
  }
  return static_cast<int>(std::min(wanted, coarser_.size()));
}

// Parses the words and models, unless what was modelled last is the same.
void Scene::take(Request& request, const Asked& asked, Session& session, Work& work) {
  DrawingFlags& drawing = request.drawing;
  session.provide(asked.beside);
  parse(source_, asked.words, request.flags, request.data);
  cli::check_json_flags(drawing);
  cli::take_from_model(&request.data, &drawing.model);

  const std::string key = model_key_of(request.flags, drawing);
  if (!subject_ || key != model_key_ || asked.beside != beside_) {
    coarser_.clear();
    subject_.reset();
    model(request, session);
    model_key_ = key;
    beside_ = asked.beside;
    model_notes_ = work.notes;
  } else {
    cli::check_kind_flags(request.flags, outline_);
    if (gradient_of_labels_) drawing.options.gradient = *gradient_of_labels_;
    load_ms_ = model_ms_ = 0;
    session.notes(model_notes_);
  }
}

const Field& Scene::field(const Asked& asked, Session& session, Work& work) {
  Request request;
  take(request, asked, session, work);
  return subject_->modelled.field;
}

Bounds3 Scene::bounds(const Asked& asked, Work& work) {
  const std::lock_guard lock(mutex_);
  Session session = session_of(work);
  return field(asked, session, work).world_bounds();
}

cli::Histogram Scene::histogram(const Asked& asked, Work& work) {
  const std::lock_guard lock(mutex_);
  Session session = session_of(work);
  return cli::histogram_of(field(asked, session, work), work.stop);
}

Dataset Scene::sample(const Asked& asked, const Dataset& points, Work& work) {
  const std::lock_guard lock(mutex_);
  Session session = session_of(work);
  return cli::take_samples(points, field(asked, session, work), session, progress_of(work));
}

Dataset Scene::resample(const Asked& asked, const LatticeGeometry& lattice, Work& work) {
  const std::lock_guard lock(mutex_);
  Session session = session_of(work);
  ResampleOptions options;
  options.progress = progress_of(work);
  options.stop = work.stop;
  return ovoid::resample(field(asked, session, work), lattice, options);
}

std::shared_ptr<Picture> Scene::draw(const Asked& asked, Manner manner, Work& work) {
  const std::lock_guard lock(mutex_);
  Session session = session_of(work);
  Request request;
  DrawingFlags& drawing = request.drawing;
  take(request, asked, session, work);

  auto picture = std::make_shared<Picture>();
  const Field& field = subject_->modelled.field;
  picture->shot = cli::make_shot(*subject_, &drawing, session);
  cli::Shot& shot = picture->shot;
  Volume& volume = shot.scene.volumes.front();
  volume.trail =
      cli::trail_of(request.data, drawing, subject_->modelled, outline_.step, volume.look, session);
  cli::aim_camera(&shot, drawing);

  RenderOptions options = drawing.options;
  options.collect_profile = manner.with_stages;
  RenderHooks hooks;
  hooks.stop = work.stop;
  hooks.progress = progress_of(work);
  picture->unit_distance = unit_distance_of(volume.look, field);
  const bool is_field_alone = !volume.trail && !volume.boundary && !volume.points &&
                              !shot.scene.plane && shot.scene.volumes.size() == 1;
  const int coarseness = is_field_alone ? coarsen(manner.coarseness, work) : 0;
  options.sampling_distance *= std::exp2(coarseness);
  ovoid::Scene quick;
  if (coarseness > 0) {
    quick = shot.scene;
    quick.volumes.front().field = coarser_[static_cast<std::size_t>(coarseness) - 1];
    // Opacities of a coarse field mean what they mean at the full one.
    quick.volumes.front().look.unit_distance = picture->unit_distance;
  }
  Frame frame = renderer(request.flags, drawing.run)
                    .render(coarseness > 0 ? quick : shot.scene, shot.camera, options, hooks);
  session.check_stop();
  if (!frame.profile.notice.empty()) session.note(frame.profile.notice);
  cli::note_if_empty(frame.image, shot, field.value_range(), session);

  picture->unturned = unturned_camera(shot, drawing);
  picture->values = field.value_range();
  picture->sampling_distance = field.default_sampling_distance();
  picture->num_steps = outline_.num_steps;
  picture->step = outline_.step;
  picture->image = std::move(frame.image);
  if (shot.look().mode == Mode::kXray || drawing.annotation.any()) {
    Image seen = picture->image;
    Look look = shot.look();  // the picture's own keeps its range
    cli::color_for_eyes(seen, look, drawing.look, session);
    cli::draw_annotations(seen, drawing.annotation, shot.described, shot.camera, look,
                          drawing.background);
    picture->for_eyes = std::move(seen);
  }
  picture->profile = {
      load_ms_,       model_ms_, {frame.profile.frame_ms}, frame.profile, options.width,
      options.height, ""};
  picture->flags = cli::FlagSet::of(request.flags.given());
  picture->is_series = source_.steps != nullptr && source_.steps->num_steps() > 1;
  picture->inputs = source_.inputs;
  picture->notes = work.notes;
  picture->pick_words = cli::pick_words(*subject_, shot, drawing.annotation);
  picture->drawing = std::move(drawing);
  return picture;
}

std::string picked(const Picture& picture, int x, int y) {
  const cli::Picker picker(picture.shot, picture.drawing.options);
  const cli::PickWords& words = picture.pick_words;
  nlohmann::ordered_json json = cli::pick_json(picker, picker.at(picture.image, x, y), words);
  json["unit"] = words.unit;
  json["length_unit"] = words.length_unit;
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void save_picture(const Picture& picture, const std::string& path, std::stop_token stop) {
  if (cli::picture_ending(path).empty()) {
    throw cli::UsageError(
        fmt::format("'{}': expected a name that ends in {}", path, cli::kPictureEndings));
  }
  cli::check_background(picture.drawing, path);
  DrawingFlags drawing = picture.drawing;
  drawing.annotation = {};  // they are in the picture already
  Image image = cli::is_for_eyes(path) ? picture.seen() : picture.image;
  cli::write_picture(image, drawing, picture.shot.described, picture.shot.camera,
                     picture.shot.look(), {path, std::move(stop)});
}

std::string encode_picture(const Picture& picture, const std::string& ending, int quality) {
  const std::optional<Rgb>& background = picture.drawing.background;
  if (ending == ".png") return encode_png(picture.seen(), background);
  if (ending != ".jpg" && ending != ".jpeg")
    throw cli::UsageError(fmt::format("'{}': expected .png or .jpg", ending));
  cli::check_background(picture.drawing, ending);
  return encode_jpeg(picture.seen(), background.value_or(Rgb{0, 0, 0}), quality);
}

Dataset read_files(const std::vector<std::string>& inputs, const Words& words, bool may_stay,
                   Work& work) {
  Session session = session_of(work);
  DataFlags data;
  Flags flags("read", "PATH", "Reads data.");
  cli::add_input_flags(flags, &data);
  parse({nullptr, inputs}, words, flags, data);
  data.may_stay_in_file = may_stay;
  return cli::load(data, session);
}

}  // namespace ovoid::python
