// SPDX-License-Identifier: Apache-2.0
#include "loader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <mutex>
#include <new>
#include <string_view>
#include <thread>
#include <utility>

#include "apply_crop.h"
#include "label_edits.h"
#include "make_camera.h"
#include "make_geometry.h"
#include "make_look.h"
#include "make_trail.h"
#include "ovoid/coarse.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/slices.h"
#include "priority.h"
#include "private_folder.h"
#include "surface_files.h"
#include "window.h"

namespace ovoid::viewer {
namespace {

constexpr int kCoarserFields = 2;
constexpr double kSolidBudgetMs = 60;  // of a solid that moves; pictures are drawn meanwhile
// Fewer kernels than this cost nothing worth saving.
constexpr std::int64_t kLeastWorthCoarsening = 20'000;

// A note without the flag that it is about or advises; what it is about can be seen and clicked.
std::string in_a_window(const std::string& note) {
  constexpr std::string_view kAdded = "--add: ";
  if (note.starts_with(kAdded)) return note.substr(kAdded.size());
  for (const char* const advice : {"; choose with --", "; choose one with --", " (--label-"}) {
    const std::size_t at = note.find(advice);
    if (at != std::string::npos) return note.substr(0, at);
  }
  return note;
}

struct OpenTask {
  std::shared_ptr<const Launch> launch;
  bool is_reload = false;
};
struct TimeTask {
  TimeChoice choice;
  Look look;
  bool wants_extras = true;
};

// What was read, and what is drawn of it.
struct Data {
  std::shared_ptr<const Launch> launch;
  cli::DrawingFlags drawing;  // the launch's, with the array that was chosen
  std::shared_ptr<const Dataset> dataset;
  std::optional<Series> series;  // opened when another time is asked for
  std::shared_ptr<const Shown> shown;
  Look first_channel_look;  // of the array, or of the channels, that were chosen last
};

}  // namespace

ArrayChoice choice_of(const Shown& shown) {
  return {shown.array, shown.color_array, shown.component, shown.is_density, shown.channels.chosen};
}

namespace {

// `made` is of `drawing`, whose channels have names by now. What takes long is done here.
void take_channels_of(const cli::DrawingFlags& drawing, Shown& made) {
  if (drawing.channels.names.empty()) return;
  ShownChannels& channels = made.channels;
  channels.chosen = drawing.channels.names;
  channels.named = cli::named_channels(*made.dataset, drawing, made.subject.scene.volumes);
  for (const cli::NamedChannel& channel : channels.named) {
    const bool is_first = channels.usual.empty();
    channels.usual.push_back(is_first ? made.subject.usual_look : cli::UsualLook());
    channels.usual.back().of(Field(channel.field), is_first ? made.subject.unit : "");
  }
}

}  // namespace

std::shared_ptr<Shown> make_shown(std::shared_ptr<const Dataset> dataset, const cli::Flags& flags,
                                  cli::DrawingFlags& drawing, double time, cli::Session& session) {
  auto made = std::make_shared<Shown>();
  // These are the view's.
  drawing.geometry.files.clear();
  drawing.geometry.slices.clear();
  drawing.labels.is_read_apart = true;
  drawing.labels.opacities.clear();
  drawing.labels.colors.clear();
  drawing.over = {};
  made->subject = cli::make_subject(*dataset, flags, &drawing, session);
  made->dataset = std::move(dataset);
  made->time = time;
  made->array = made->subject.modelled.array;
  made->color_array = made->subject.modelled.color_array;
  made->component = made->subject.modelled.component;
  KernelModelOptions options = drawing.model.kernels;
  options.array = drawing.model.array;
  made->is_density = draws_density(*made->dataset, options);
  take_channels_of(drawing, *made);
  return made;
}

std::shared_ptr<const Extras> make_extras(const std::shared_ptr<const Shown>& shown, int threads,
                                          const std::stop_token& stop) {
  auto extras = std::make_shared<Extras>();
  extras->of = shown;
  const Field* finest = &shown->field();
  CoarseOptions options;
  options.threads = threads;
  options.stop = stop;
  extras->coarser.reserve(kCoarserFields);  // `finest` points into it
  while (static_cast<int>(extras->coarser.size()) < kCoarserFields &&
         finest->num_kernels() >= kLeastWorthCoarsening) {
    try {
      extras->coarser.push_back(coarse_field(*finest, options));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnsupported) throw;
      break;  // pixels alone become coarser
    }
    finest = &extras->coarser.back();
  }
  extras->histogram = cli::histogram_of(shown->field(), stop);
  extras->probe = std::make_shared<const FieldProbe>(shown->field());
  return extras;
}

struct Loader::Impl {
  mutable std::mutex mutex;
  std::condition_variable wanted;
  // What waits; the thread takes them in this order.
  std::optional<OpenTask> next_open;
  std::optional<ArrayChoice> next_choice;
  std::deque<BesideTask> next_beside;
  std::optional<TimeTask> next_time;
  std::optional<SolidChoice> next_solid;
  bool wants_extras = false;
  std::shared_ptr<const Shown> next_2d;
  std::shared_ptr<const Shown> asked_2d;  // that was asked for last, and not given up since
  bool is_over = false;
  bool is_working = false;
  std::stop_source stop;        // of what is done now
  std::stop_source stop_extra;  // of what may be done when nothing else waits
  std::vector<LoadReport> reports;
  std::size_t resident_bytes = 0;

  // The thread's own.
  std::optional<Data> data;  // none before anything was read
  SurfaceFiles surface_files;
  std::shared_ptr<const Shown> extras_of;  // for which they were worked out last
  struct {
    int levels = 0;
    double ms = 0;
  } solid_cost;  // of the last one with all its levels
  std::thread thread;

  void report(LoadReport report) {
    {
      const std::lock_guard lock(mutex);
      // Progress that nobody has seen yet is out of date.
      if (std::holds_alternative<LoadProgress>(report) && !reports.empty() &&
          std::holds_alternative<LoadProgress>(reports.back())) {
        reports.back() = std::move(report);
      } else {
        reports.push_back(std::move(report));
      }
    }
    Window::wake();
  }

  cli::Session session(const std::stop_token& token) {
    return cli::Session([this](const std::string& note) { report(Noted{in_a_window(note)}); },
                        token);
  }

  void run();
  void read(const OpenTask& task, const std::stop_token& token);
  void choose(const ArrayChoice& choice, const std::stop_token& token);
  void go_to(const TimeTask& task, const std::stop_token& token);
  int levels_to_leave_out(int levels) const;
  void show_solid(const SolidChoice& task, const std::stop_token& token);
  void read_beside(const BesideTask& task, const std::stop_token& token);
  void work_out_extras(const std::stop_token& token);
  void count_2d(const std::shared_ptr<const Shown>& shown, const std::stop_token& token);
  bool has_work() const {
    return next_open || next_choice || !next_beside.empty() || next_time || next_solid || next_2d ||
           wants_extras;
  }
};

namespace {

// The dataset, and the series where the first step is made of several.
void read_dataset_of(Data& data, cli::Session& session, const ReadOptions& options) {
  const cli::DataFlags& flags = data.launch->data;
  if (flags.slice.plane || flags.time) {
    data.dataset = std::make_shared<Dataset>(cli::load(flags, session));
    return;
  }
  auto read = std::make_shared<Dataset>(read_dataset(flags.inputs, options));
  cli::check_format_flags(flags, *read);
  session.notes(read->notes);
  // Both halves of the lattice.
  if (read->series == SeriesKind::kStaggered && read->num_steps > 1 && !flags.step) {
    data.series.emplace(cli::open_series(flags, session));
    const double time = data.series->times()[static_cast<std::size_t>(read->step)];
    read = std::make_shared<Dataset>(slice_at_time(*data.series, time));
  }
  data.dataset = std::move(read);
}

// The field of the dataset, drawn as `drawing` says.
std::shared_ptr<Shown> shown_of(const Data& data, cli::DrawingFlags& drawing, double time,
                                cli::Session& session) {
  return make_shown(data.dataset, *data.launch->flags, drawing, time, session);
}

std::shared_ptr<const Dataset> read_back(const Dataset& kernels, const std::stop_token& stop) {
  const PrivateFolder folder;
  const std::string path = folder.file("solid.ply");
  write_dataset(kernels, path, {stop});
  return std::make_shared<const Dataset>(read_dataset({path}));
}

// The solid's kernels, as `ovoid render` draws the file of `ovoid make solid`; while it moves with
// so many levels less, and as they are before a file rounds them.
std::shared_ptr<Shown> shown_of_solid(const SolidShape& shape, std::optional<int> left_out,
                                      const RendererSetup& setup, double time,
                                      cli::Session& session) {
  const SolidMesh level =
      subdivide_solid(*shape.control, {.levels = shape.levels - left_out.value_or(0),
                                       .memory_limit = cli::SolidFlags().memory_limit,
                                       .threads = setup.threads,
                                       .stop = session.stop()});
  const KernelField kernels = make_solid_field(
      level, {.basis = shape.basis, .threads = setup.threads, .stop = session.stop()});
  const std::shared_ptr<Launch> plain = parse_launch({cli::kSolidName});
  cli::DrawingFlags drawing = plain->drawing;
  drawing.run = setup;
  const auto dataset = std::make_shared<const Dataset>(make_kernel_dataset(kernels));
  // A file rounds.
  const auto stored = left_out ? dataset : read_back(*dataset, session.stop());
  auto made = make_shown(stored, *plain->flags, drawing, time, session);
  made->dataset = dataset;
  made->solid = shape;
  made->is_rough = left_out.has_value();
  return made;
}

// The same with a look, for an array that is drawn for the first time.
ShownReady first_of_array(Data& data, double time, cli::Session& session) {
  ShownReady ready;
  cli::DrawingFlags drawing = data.drawing;
  auto made = shown_of(data, drawing, time, session);
  ready.look = cli::make_look(drawing.look, made->field(), made->subject.unit, session,
                              made->subject.usual_look);
  data.drawing.channels.names = drawing.channels.names;  // what "all" are, at other times, too
  made->channels.flags = data.drawing.look;
  made->channels.first_look = data.first_channel_look = *ready.look;
  ready.gradient = drawing.options.gradient;
  if (!(drawing.model.lattice.kernel == data.drawing.model.lattice.kernel))
    ready.kernel = drawing.model.lattice.kernel;
  ready.shown = data.shown = std::move(made);
  return ready;
}

}  // namespace

void Loader::Impl::read(const OpenTask& task, const std::stop_token& token) {
  cli::Session own = session(token);
  Data next{task.launch, task.launch->drawing, nullptr, std::nullopt, nullptr};
  const cli::DataFlags& flags = task.launch->data;
  const std::string what = "reading " + title_of(flags);
  report(LoadProgress{what, 0, true});
  ReadOptions options = cli::read_options(flags, own);
  options.progress = [&](double fraction) { report(LoadProgress{what, fraction}); };
  read_dataset_of(next, own, options);
  const auto info = info_of(*next.dataset, flags);
  std::vector<std::shared_ptr<const ReadSurface>> surfaces;
  std::optional<LabelsBeside> labels;
  std::vector<std::shared_ptr<const VolumeBeside>> volumes;
  if (!task.is_reload) {
    volumes = volumes_beside(*next.dataset, next.drawing, own);
    const cli::GeometryFlags& added = next.drawing.geometry;
    for (std::size_t i = 0; i < added.files.size(); ++i) {
      const cli::AddedStyle style = cli::added_style(added, i);
      surfaces.push_back(surface_files.read({added.files[i], style.array, style.radius}, own));
    }
    if (!next.drawing.labels.file.empty())
      labels = labels_beside(next.drawing.labels.file, next.drawing, own);
  }
  report(LoadProgress{"choosing kernels for " + title_of(flags), 1});
  const double time = flags.time.value_or(info->times[static_cast<std::size_t>(info->step)]);
  ShownReady ready = first_of_array(next, time, own);
  // What can be wrong with the flags comes out here, where it keeps nothing from being shown.
  const LabelSurfaces& drawn = labels ? *labels->surfaces : next.shown->subject.scene.labels;
  if (drawn.map != nullptr) label_edits_of(drawn.styles, next.drawing.labels);
  const cli::Subject& subject = next.shown->subject;
  RenderOptions ignored = next.drawing.options;
  const Box box = cli::apply_crop(next.drawing.crop, subject.field(), &ignored);
  cli::CameraFlags camera = next.drawing.camera;
  camera.fit = cli::Fit::kBox;
  cli::make_camera(camera, {subject.scene, box.world_bounds(), subject.described.space, 1.0, {}});
  data = std::move(next);  // what was there before stays if anything went wrong
  report(Opened{info, task.launch, task.is_reload, std::move(surfaces), std::move(labels),
                std::move(volumes)});
  report(std::move(ready));
  const std::lock_guard lock(mutex);
  wants_extras = true;
}

void Loader::Impl::choose(const ArrayChoice& choice, const std::stop_token& token) {
  if (!data) return;
  cli::Session own = session(token);
  report(LoadProgress{"choosing kernels for " + choice.array, 0});
  cli::DrawingFlags& drawing = data->drawing;
  const cli::DrawingFlags before = drawing;
  drawing.model.array = choice.array;
  drawing.model.component = choice.component;
  drawing.model.kernels.is_density = choice.is_density;
  drawing.model.kernels.color_array =
      choice.color_array == choice.array ? std::string() : choice.color_array;
  // Flags about the look were meant for the array that the data were opened with.
  drawing.look = {};
  drawing.channels = {};
  drawing.channels.names = choice.channels;
  if (!choice.channels.empty()) drawing.model.component = cli::kUsualComponent;
  try {
    report(first_of_array(*data, data->shown ? data->shown->time : 0, own));
  } catch (...) {
    drawing = before;
    throw;
  }
  const std::lock_guard lock(mutex);
  wants_extras = true;
}

void Loader::Impl::go_to(const TimeTask& task, const std::stop_token& token) {
  if (!data) return;
  cli::Session own = session(token);
  if (!data->series) data->series.emplace(cli::open_series(data->launch->data, own));
  const Series& series = *data->series;
  const TimeChoice& choice = task.choice;
  double time = choice.time;
  if (choice.is_interpolated || series.source().kind() == SeriesKind::kStaggered) {
    TimeSliceOptions options;
    options.filter = data->launch->data.time_filter;
    options.stop = token;
    data->dataset = std::make_shared<Dataset>(slice_at_time(series, time, options));
    own.notes(data->dataset->notes);
  } else {
    const std::int64_t step = series.nearest_step(time);
    time = series.times()[static_cast<std::size_t>(step)];
    data->dataset = series.step(step, token);
  }
  const cli::Quiet quiet(own);
  cli::DrawingFlags drawing = data->drawing;
  cli::ModelFlags& model = drawing.model;
  // The array by its name: at another time another one might vary first.
  if (data->shown && data->shown->is_density) {
    model.kernels.is_density = true;
  } else if (data->shown) {
    model.array = data->shown->array;
  }
  auto made = shown_of(*data, drawing, time, own);
  made->channels.flags = data->drawing.look;
  made->channels.first_look = data->first_channel_look;
  if (choice.blur_length > 0) {
    cli::TrailFlags trail = data->launch->drawing.trail;
    trail.length = choice.blur_length;
    trail.decay = choice.blur_decay;
    made->trail = std::make_shared<const Trail>(
        cli::make_trail(trail, series, time, model, drawing.run.threads,
                        {made->field(), task.look, made->field().value_range()}, own));
  }
  ShownReady ready;
  ready.shown = data->shown = std::move(made);
  report(std::move(ready));
  const std::lock_guard lock(mutex);
  resident_bytes = series.resident_bytes();
  wants_extras = task.wants_extras;
}

// Of a solid that is to follow the mouse: a level costs eight times the one before.
int Loader::Impl::levels_to_leave_out(int levels) const {
  double ms = solid_cost.ms * std::pow(8.0, levels - solid_cost.levels);
  int left_out = 0;
  for (; left_out < levels && ms > kSolidBudgetMs; ++left_out) ms /= 8;
  return left_out;
}

void Loader::Impl::show_solid(const SolidChoice& task, const std::stop_token& token) {
  if (!data || !data->shown) return;
  cli::Session own = session(token);
  const double time = data->shown->time;
  ShownReady ready;
  if (task.wants_look) report(LoadProgress{"choosing kernels", 0});
  if (!task.shape && task.wants_look) {
    ready = first_of_array(*data, time, own);
  } else if (!task.shape) {
    cli::DrawingFlags drawing = data->drawing;
    ready.shown = data->shown = shown_of(*data, drawing, time, own);
  } else {
    const cli::Quiet quiet(own);
    SolidShape shape = *task.shape;
    if (shape.control == nullptr) {
      shape.control = std::make_shared<const SolidMesh>(
          make_control_mesh(*data->dataset, {.array = data->shown->array}));
    }
    const cli::Stopwatch watch;
    std::optional<int> left_out;
    if (task.is_moving) left_out = levels_to_leave_out(shape.levels);
    auto made = shown_of_solid(shape, left_out, data->drawing.run, time, own);
    if (left_out.value_or(0) == 0) solid_cost = {shape.levels, watch.ms()};
    if (task.wants_look) ready.look = cli::make_look({}, made->field(), made->subject.unit, own);
    ready.shown = data->shown = std::move(made);
  }
  report(std::move(ready));
  const std::lock_guard lock(mutex);
  wants_extras = !task.is_moving;
}

void Loader::Impl::read_beside(const BesideTask& task, const std::stop_token& token) {
  cli::Session own = session(token);
  if (!data) return;
  BesideRead read = viewer::read_beside(
      task, *data->dataset, data->drawing, surface_files, own, [&](const std::string& path) {
        report(LoadProgress{"reading " + std::filesystem::path(path).filename().string(), 0});
      });
  for (std::string& error : read.errors) error = in_a_window(error);
  report(std::move(read));
  const std::lock_guard lock(mutex);
  if (data && extras_of != data->shown) wants_extras = true;  // they had to make room
}

void Loader::Impl::work_out_extras(const std::stop_token& token) {
  if (!data) return;
  report(make_extras(data->shown, data->drawing.run.threads, token));
  extras_of = data->shown;
}

// What it cannot be counted of keeps nothing else from being shown.
void Loader::Impl::count_2d(const std::shared_ptr<const Shown>& shown,
                            const std::stop_token& token) {
  Counted2D counted;
  counted.of = shown;
  try {
    counted.histogram =
        std::make_shared<const cli::Histogram2D>(cli::histogram_2d_of(shown->field(), token));
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) {
      const std::lock_guard lock(mutex);
      if (asked_2d == shown) asked_2d.reset();  // it may be asked for again
      return;
    }
    counted.error = cli::message_line(error.what());
  }
  report(std::move(counted));
}

void Loader::Impl::run() {
  lower_priority();
  std::unique_lock lock(mutex);
  while (!is_over) {
    if (!has_work()) {
      is_working = false;
      wanted.wait(lock);
      continue;
    }
    is_working = true;
    const auto opening = std::exchange(next_open, std::nullopt);
    const auto chosen = opening ? std::nullopt : std::exchange(next_choice, std::nullopt);
    std::optional<BesideTask> beside;
    if (!opening && !chosen && !next_beside.empty()) {
      beside = std::move(next_beside.front());
      next_beside.pop_front();
    }
    const bool is_first_served = opening || chosen || beside;
    const auto gone = is_first_served ? std::nullopt : std::exchange(next_time, std::nullopt);
    const auto solid =
        is_first_served || gone ? std::nullopt : std::exchange(next_solid, std::nullopt);
    const bool is_served = is_first_served || gone || solid;
    const auto counted = is_served ? nullptr : std::exchange(next_2d, nullptr);
    if (!is_served && !counted) wants_extras = false;
    stop = {};
    stop_extra = {};
    const std::stop_token token = stop.get_token();
    const std::stop_token extra_token = stop_extra.get_token();
    lock.unlock();
    std::string message;
    try {
      if (opening) {
        read(*opening, token);
      } else if (chosen) {
        choose(*chosen, token);
      } else if (beside) {
        read_beside(*beside, token);
      } else if (gone) {
        go_to(*gone, token);
      } else if (solid) {
        show_solid(*solid, token);
      } else if (counted) {
        count_2d(counted, extra_token);
      } else {
        work_out_extras(extra_token);
      }
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCancelled) message = cli::message_line(error.what());
    } catch (const std::bad_alloc&) {
      message = "out of memory";
    } catch (const std::exception& error) {
      message = cli::message_line(fmt::format("unexpected: {}", error.what()));
    }
    if (!message.empty()) report(LoadFailed{message, opening.has_value(), solid.has_value()});
    lock.lock();
  }
}

Loader::Loader() : impl_(std::make_unique<Impl>()) {
  impl_->thread = std::thread([this] { impl_->run(); });
}

Loader::~Loader() {
  stop();
  impl_->thread.join();
}

void Loader::stop() {
  const std::lock_guard lock(impl_->mutex);
  impl_->is_over = true;
  impl_->stop.request_stop();
  impl_->stop_extra.request_stop();
  impl_->wanted.notify_all();
}

void Loader::open(std::shared_ptr<const Launch> launch, bool is_reload) {
  const std::lock_guard lock(impl_->mutex);
  impl_->next_open = OpenTask{std::move(launch), is_reload};
  impl_->next_choice.reset();
  impl_->next_beside.clear();
  impl_->next_time.reset();
  impl_->next_solid.reset();
  impl_->wants_extras = false;
  impl_->next_2d.reset();
  impl_->asked_2d.reset();
  impl_->stop.request_stop();
  impl_->stop_extra.request_stop();
  impl_->wanted.notify_all();
}

void Loader::choose(const ArrayChoice& choice) {
  const std::lock_guard lock(impl_->mutex);
  impl_->next_choice = choice;
  impl_->next_solid.reset();
  impl_->stop_extra.request_stop();
  impl_->wanted.notify_all();
}

void Loader::go_to(const TimeChoice& choice, const Look& look, bool wants_extras) {
  const std::lock_guard lock(impl_->mutex);
  impl_->next_time = TimeTask{choice, look, wants_extras};
  impl_->stop_extra.request_stop();
  impl_->wanted.notify_all();
}

void Loader::show_solid(const SolidChoice& choice) {
  const std::lock_guard lock(impl_->mutex);
  impl_->next_solid = choice;
  impl_->stop_extra.request_stop();
  impl_->wanted.notify_all();
}

void Loader::count_2d(std::shared_ptr<const Shown> shown) {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->asked_2d == shown) return;
  impl_->asked_2d = impl_->next_2d = std::move(shown);
  impl_->wanted.notify_all();
}

void Loader::read_beside(BesideTask task) {
  const std::lock_guard lock(impl_->mutex);
  impl_->next_beside.push_back(std::move(task));
  impl_->stop_extra.request_stop();
  impl_->wanted.notify_all();
}

std::vector<LoadReport> Loader::take_reports() {
  const std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->reports, {});
}

bool Loader::is_busy() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->is_working || impl_->has_work() || !impl_->reports.empty();
}

std::size_t Loader::resident_bytes() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->resident_bytes;
}

}  // namespace ovoid::viewer
