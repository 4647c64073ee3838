// SPDX-License-Identifier: Apache-2.0
#include "worker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <iterator>
#include <map>
#include <mutex>
#include <new>
#include <thread>
#include <tuple>
#include <utility>

#include "histogram.h"
#include "make_geometry.h"
#include "make_labels.h"
#include "ovoid/error.h"
#include "priority.h"
#include "projection.h"
#include "session.h"
#include "window.h"

namespace ovoid::viewer {
namespace {

constexpr double kBudgetMs = 25;  // with showing it, 25 pictures per second and more

// Stages whose cost goes with the number of kernels; that of all others with the samples.
bool goes_with_kernels(const std::string& stage) {
  return stage == "plan" || stage == "project and bin";
}

FrameCost cost_of(const FrameProfile& profile) {
  double kernels = 0;
  double all = 0;
  for (const auto& [stage, ms] : profile.stages_ms) {
    all += ms;
    if (goes_with_kernels(stage)) kernels += ms;
  }
  const double share = all > 0 ? kernels / all : 0;
  return {profile.frame_ms * share, profile.frame_ms * (1 - share)};
}

int coarsened(int pixels, int by) { return std::max(1, (pixels + by - 1) / by); }

// What the level's picture is drawn with.
struct Coarse {
  Scene scene;
  RenderOptions options;
};

Coarse at_level(const PictureJob& job, const Level& level) {
  Coarse coarse{job.scene, job.options};
  coarse.options.width = coarsened(job.options.width, level.pixels);
  coarse.options.height = coarsened(job.options.height, level.pixels);
  coarse.options.collect_profile = true;
  // Of two pictures the second may have less to coarsen than the first.
  const int field =
      job.has_coarser() ? std::min(level.field, static_cast<int>(job.extras->coarser.size())) : 0;
  if (level.field > 0) coarse.scene.volumes.front().trail.reset();
  if (field == 0) return coarse;
  Volume& volume = coarse.scene.volumes.front();
  volume.field = job.extras->coarser[static_cast<std::size_t>(field - 1)];
  coarse.options.sampling_distance *= std::exp2(field);
  // Opacities mean what they mean at the full picture.
  volume.look.unit_distance = unit_distance_of(volume.look, job.field());
  return coarse;
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value * 255.0F + 0.5F, 0.0F, 255.0F));
}

void compare(Pictures& pictures) {
  const Image& a = pictures.pictures[0].image;
  const Image& b = pictures.pictures[1].image;
  if (a.width != b.width || a.height != b.height) return;
  pictures.psnr = psnr(a, b);
  Image difference = a;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    const float distance = std::abs(a.rgba[i] - b.rgba[i]);
    difference.rgba[i] = i % 4 == 3 ? 1 : distance * static_cast<float>(kDifferenceGain);
  }
  PictureJob plain = *pictures.pictures[0].job;
  plain.scene.volumes.front().look.mode = Mode::kComposite;
  pictures.difference = to_display(difference, plain, {0, 1});
}

double world_pixel(const PictureJob& job) {
  const Projection projection(job.camera, job.options.width, job.options.height);
  return projection.pixel_size_at(projection.focal_depth());
}

}  // namespace

TransferFunction spread_over_integrals(TransferFunction tf,
                                       const std::pair<double, double>& range) {
  auto [lo, hi] = range;
  if (!(lo < hi)) hi = lo + 1;                      // nothing but zeros
  if (tf.scale == ValueScale::kLog && !(lo > 0)) {  // as `ovoid render` does it
    constexpr double kDecades = 1e-3;
    if (!(hi > 0)) hi = 1;
    lo = kDecades * hi;
  }
  tf.map_range(lo, hi);
  return tf;
}

std::vector<std::uint8_t> to_display(const Image& image, const PictureJob& job,
                                     const std::pair<double, double>& xray_range) {
  const bool is_xray = job.look().mode == Mode::kXray;
  constexpr std::size_t kTable = 1024;
  std::vector<Rgb> table;
  if (is_xray) {
    const TransferFunction tf = spread_over_integrals(job.look().transfer_function, xray_range);
    table.resize(kTable);
    for (std::size_t i = 0; i < kTable; ++i) {
      const double at = static_cast<double>(i) / (kTable - 1);
      table[i] = tf.color_at(xray_range.first + at * (xray_range.second - xray_range.first));
    }
  }
  const std::array<float, 3> back = {static_cast<float>(job.background[0]),
                                     static_cast<float>(job.background[1]),
                                     static_cast<float>(job.background[2])};
  const auto row = static_cast<std::size_t>(image.width) * 4;
  const auto height = static_cast<std::size_t>(image.height);
  std::vector<std::uint8_t> bytes(image.rgba.size());
  for (std::size_t y = 0; y < height; ++y) {
    const float* from = image.rgba.data() + y * row;
    std::uint8_t* to = bytes.data() + (height - 1 - y) * row;
    for (const float* const end = from + row; from != end; from += 4, to += 4) {
      const float through = 1 - from[3];
      std::array<float, 3> color = {from[0], from[1], from[2]};
      if (is_xray && from[3] > 0) {
        const double at = (from[0] - xray_range.first) / (xray_range.second - xray_range.first);
        const Rgb& mapped =
            table[static_cast<std::size_t>(std::lround(std::clamp(at, 0.0, 1.0) * (kTable - 1)))];
        for (std::size_t c = 0; c < 3; ++c) color[c] = static_cast<float>(mapped[c]) * from[3];
      }
      for (std::size_t c = 0; c < 3; ++c) to[2 - c] = to_byte(color[c] + through * back[c]);
      to[3] = 255;
    }
  }
  return bytes;
}

struct Worker::Impl {
  mutable std::mutex mutex;
  std::condition_variable wanted;
  std::optional<Request> pending;
  std::optional<Pictures> finished;
  std::stop_source stop;
  bool is_over = false;
  bool is_drawing = false;
  bool may_be_given_up = false;  // what is drawn is a refinement
  std::optional<Clock::time_point> given_up_at;
  std::vector<double> cancel_times;
  std::thread thread;

  // The thread's own.
  using Key = std::tuple<int, int, int, std::uint64_t>;
  std::map<Key, Renderer> renderers;
  LevelChooser chooser;
  std::shared_ptr<const Shown> measured_of;
  Level moving_level{4, 0};
  std::optional<std::pair<double, double>> last_xray_range;
  std::shared_ptr<const Shown> counted_of;  // whose histogram that is
  cli::Histogram histogram;

  std::vector<FieldSlice> slices_of(const PictureJob& job, const std::stop_token& token);
  Renderer& renderer_for(const RendererSetup& chosen);
  void set_scales(const PictureJob& job);
  Picture draw(const std::shared_ptr<const PictureJob>& job, const Level& level,
               const std::stop_token& token);
  bool draw_all(const Request& request, const Level& level, bool is_final);
  void serve(const Request& request);
  void run();
  bool is_superseded() {
    const std::lock_guard lock(mutex);
    return pending.has_value() || is_over;
  }
};

Renderer& Worker::Impl::renderer_for(const RendererSetup& chosen) {
  RendererSetup setup = chosen;
  // The window keeps the device while another back end draws; the renderer would refuse it.
  if (setup.backend == Backend::kCpu || setup.backend == Backend::kReference) setup.device = -1;
  const Key key{static_cast<int>(setup.backend), setup.threads, setup.device, setup.device_memory};
  const auto known = renderers.find(key);
  if (known != renderers.end()) return known->second;
  constexpr std::size_t kMostKept = 3;  // each keeps threads, or fields on a device
  if (renderers.size() >= kMostKept) renderers.clear();
  return renderers.emplace(key, Renderer(setup)).first->second;
}

void Worker::Impl::set_scales(const PictureJob& job) {
  int coarsest = 0;
  if (job.has_coarser()) coarsest = static_cast<int>(job.extras->coarser.size());
  chooser.set_scales(world_pixel(job), job.shown->field().default_sampling_distance(), coarsest);
}

// What slices' colours span depends on how often values occur, which the loader may not have
// counted yet.
std::vector<FieldSlice> Worker::Impl::slices_of(const PictureJob& job,
                                                const std::stop_token& token) {
  if (job.slices.slices.empty()) return {};
  const bool is_counted = job.extras && job.extras->of == job.shown && job.is_of_shown;
  if (!is_counted && (counted_of != job.shown || !job.is_of_shown)) {
    counted_of.reset();
    histogram = cli::histogram_of(job.field(), token);
    if (job.is_of_shown) counted_of = job.shown;
  }
  std::vector<FieldSlice> slices =
      cli::make_slices(job.slices, job.field(), is_counted ? job.extras->histogram : histogram);
  cli::leave_slices_to_labels(job.scene.labels, slices);
  return slices;
}

Picture Worker::Impl::draw(const std::shared_ptr<const PictureJob>& job, const Level& level,
                           const std::stop_token& token) {
  Picture picture;
  picture.job = job;
  Coarse coarse = at_level(*job, level);
  Renderer& renderer = renderer_for(job->setup);
  RenderHooks hooks;
  hooks.stop = token;
  coarse.scene.slices = slices_of(*job, token);
  Frame frame = renderer.render(coarse.scene, job->camera, coarse.options, hooks);
  picture.image = std::move(frame.image);
  picture.profile = std::move(frame.profile);
  if (job->look().mode == Mode::kXray) {
    // Colours of the last full picture, so that coarse ones do not flicker.
    if (level.is_full() || !last_xray_range)
      last_xray_range = cli::range_of_integrals(picture.image);
    auto [lo, hi] = job->xray_range.value_or(*last_xray_range);
    picture.xray_range = {lo, lo < hi ? hi : lo + 1};  // else there is nothing but zeros
  } else {
    last_xray_range.reset();
  }
  picture.bgra = to_display(picture.image, *job, picture.xray_range);
  return picture;
}

// Whether they were drawn to the end.
bool Worker::Impl::draw_all(const Request& request, const Level& level, bool is_final) {
  Pictures done;
  done.number = request.number;
  done.own = request.own;
  done.level = level;
  done.is_final = is_final;
  std::stop_token token;
  {
    const std::lock_guard lock(mutex);
    stop = {};
    given_up_at.reset();
    token = stop.get_token();
    may_be_given_up = !request.is_moving;
    if (is_over || (may_be_given_up && pending)) return false;
  }
  const cli::Stopwatch since;
  FrameCost cost;
  try {
    for (const auto& job : request.jobs) {
      done.pictures.push_back(draw(job, level, token));
      const FrameCost one = cost_of(done.pictures.back().profile);
      cost.kernels_ms += one.kernels_ms;
      cost.samples_ms += one.samples_ms;
    }
    if (done.pictures.size() == 2) compare(done);
    done.ms = since.ms();
    chooser.measured(level, cost);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) {
      const std::lock_guard lock(mutex);
      if (given_up_at) {
        cancel_times.push_back(
            std::chrono::duration<double, std::milli>(Clock::now() - *given_up_at).count());
      }
      return false;
    }
    done.error = cli::message_line(error.what());
  } catch (const std::bad_alloc&) {
    done.error = "out of memory";
  } catch (const std::exception& error) {
    done.error = cli::message_line(error.what());
  }
  if (!done.error.empty()) {
    done.pictures.clear();
    done.is_final = true;
  }
  const bool is_drawn = done.error.empty();
  {
    const std::lock_guard lock(mutex);
    finished = std::move(done);
  }
  Window::wake();
  return is_drawn;
}

void Worker::Impl::serve(const Request& request) {
  const PictureJob& job = *request.jobs.front();
  set_scales(job);
  if (measured_of != job.shown) {
    // Steps in time cost alike; other data do not.
    if (!measured_of || measured_of->field().num_kernels() != job.shown->field().num_kernels())
      chooser.forget();
    last_xray_range.reset();
    measured_of = job.shown;
  }
  moving_level = chooser.choose(kBudgetMs, moving_level);
  if (chooser.predicted_ms(moving_level) == 0) moving_level = chooser.levels().back();
  if (request.is_moving) {
    draw_all(request, moving_level, false);
    return;
  }
  // What is quick enough to be shown at once, then steps up to the full picture.
  const bool is_quick =
      chooser.predicted_ms(Level{}) > 0 && chooser.predicted_ms(Level{}) < 2 * kBudgetMs;
  std::vector<Level> steps;
  if (!is_quick) {
    steps = chooser.refinement(moving_level);
    if (!moving_level.is_full()) steps.insert(steps.begin(), moving_level);
  } else {
    steps = {Level{}};
  }
  for (const Level& level : steps) {
    if (!draw_all(request, level, level.is_full()) || is_superseded()) return;
  }
}

void Worker::Impl::run() {
  lower_priority();
  std::unique_lock lock(mutex);
  while (!is_over) {
    if (!pending) {
      is_drawing = false;
      wanted.wait(lock);
      continue;
    }
    is_drawing = true;
    const Request request = *std::exchange(pending, std::nullopt);
    lock.unlock();
    serve(request);
    lock.lock();
  }
}

Worker::Worker() : impl_(std::make_unique<Impl>()) {
  impl_->thread = std::thread([this] { impl_->run(); });
}

Worker::~Worker() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->is_over = true;
    impl_->stop.request_stop();
    impl_->wanted.notify_all();
  }
  impl_->thread.join();
}

void Worker::ask(Request request) {
  const std::lock_guard lock(impl_->mutex);
  impl_->pending = std::move(request);
  if (impl_->is_drawing && impl_->may_be_given_up && !impl_->given_up_at) {
    impl_->given_up_at = Clock::now();
    impl_->stop.request_stop();
  }
  impl_->wanted.notify_all();
}

std::vector<double> Worker::take_cancel_times() {
  const std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->cancel_times, {});
}

std::optional<Pictures> Worker::take() {
  const std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->finished, std::nullopt);
}

bool Worker::is_idle() const {
  const std::lock_guard lock(impl_->mutex);
  return !impl_->is_drawing && !impl_->pending && !impl_->finished;
}

}  // namespace ovoid::viewer
