// SPDX-License-Identifier: Apache-2.0
#include "fitter.h"

#include <fmt/format.h>

#include <condition_variable>
#include <fstream>
#include <iterator>
#include <mutex>
#include <new>
#include <thread>
#include <utility>

#include "load.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "priority.h"
#include "private_folder.h"
#include "usage.h"
#include "window.h"

namespace ovoid::viewer {
namespace {

// Of a fit the greater part; the rest reads its file and makes it ready to be drawn.
constexpr double kShareOfFit = 0.95;

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) throw Error(ErrorCode::kFileNotFound, fmt::format("'{}': cannot be read", path));
  return bytes;
}

// The fit in `path` as it is drawn: a lattice's by the kernels of the lattice.
std::shared_ptr<const Shown> shown_of_fit(const FitTask& task, const std::string& path,
                                          cli::Session& session) {
  const std::shared_ptr<Launch> launch = parse_launch({path});
  auto dataset = std::make_shared<const Dataset>(cli::load(launch->data, session));
  cli::DrawingFlags drawing = launch->drawing;
  drawing.run = task.setup;
  if (dataset->kind == DatasetKind::kLattice) {
    drawing.model = task.model;
    drawing.model.array.clear();
    drawing.model.component = cli::kUsualComponent;
  } else if (cli::find_array(*dataset, task.of->color_array) != nullptr) {
    drawing.model.kernels.color_array = task.of->color_array;
  }
  return make_shown(std::move(dataset), *launch->flags, drawing, task.of->time, session);
}

// The same, ending at the surface of what it is a fit of; null if that has none.
std::shared_ptr<const Shown> shown_within(const FitTask& task, const Shown& shown,
                                          const cli::Session& session) {
  const cli::Subject& of = task.of->subject;
  const Surface* const boundary = of.boundary();
  if (boundary == nullptr || !boundary->encloses_mesh()) return nullptr;
  auto made = std::make_shared<Shown>(shown);
  made->subject.scene.volumes.front().boundary =
      cli::surface_with_values(*boundary, shown.field(), session);
  made->subject.has_walls = of.has_walls;
  return made;
}

using TellFraction = std::function<void(double fraction)>;

std::shared_ptr<const Fitted> fitted_by(const FitTask& task, const std::stop_token& token,
                                        const TellFraction& tell) {
  auto made = std::make_shared<Fitted>();
  const DatasetKind kind = task.of->dataset->kind;
  made->choice = choice_of(*task.of);
  made->time = task.of->time;
  made->words = task.words;
  cli::Session session([&](const std::string& note) { made->notes.push_back(note); }, token);
  cli::FitFlags flags_of_fit;
  cli::Flags flags = cli::make_fit_flags(&flags_of_fit);
  flags.parse(task.words);
  cli::check_fit_flags(flags_of_fit);
  const PrivateFolder folder;
  const std::string path = folder.file(kind == DatasetKind::kLattice ? "fit.h5" : "fit.ply");
  flags_of_fit.output = path;
  const cli::Stopwatch watch;
  made->report = cli::make_fit(*task.of->dataset, flags, flags_of_fit, session,
                               [&](double fraction) { tell(kShareOfFit * fraction); });
  made->rows = cli::rows_of(made->report, kind, watch.ms() / 1000);
  made->bytes = content_of(path);
  const cli::Quiet quiet(session);
  made->shown = shown_of_fit(task, path, session);
  made->within = shown_within(task, *made->shown, session);
  made->extras = make_extras(made->shown, task.setup.threads, token);
  return made;
}

}  // namespace

struct Fitter::Impl {
  mutable std::mutex mutex;
  std::condition_variable wanted;
  std::optional<FitTask> next;
  std::optional<FitOutcome> outcome;
  std::stop_source stop;  // of what is done now
  FitProgress progress;
  bool is_over = false;
  std::thread thread;

  void tell(double fraction, const std::stop_token& token) {
    constexpr double kStep = 0.01;
    {
      const std::lock_guard lock(mutex);
      if (token.stop_requested() || fraction < progress.fraction + kStep) return;
      progress.fraction = fraction;
    }
    Window::wake();
  }

  FitOutcome serve(const FitTask& task, const std::stop_token& token);
  void run();
};

FitOutcome Fitter::Impl::serve(const FitTask& task, const std::stop_token& token) {
  try {
    return {fitted_by(task, token, [&](double fraction) { tell(fraction, token); }), ""};
  } catch (const std::bad_alloc&) {
    return {nullptr, "out of memory"};
  } catch (const std::exception& error) {
    return {nullptr, cli::message_line(error.what())};
  }
}

void Fitter::Impl::run() {
  lower_priority(kMuchNicer);
  std::unique_lock lock(mutex);
  while (!is_over) {
    if (!next) {
      wanted.wait(lock);
      continue;
    }
    std::optional<FitTask> task = std::exchange(next, std::nullopt);
    stop = {};
    const std::stop_token token = stop.get_token();
    lock.unlock();
    FitOutcome ended = serve(*task, token);
    task.reset();
    lock.lock();
    // Of one that was cancelled nothing is told, and of one that waits more.
    if (token.stop_requested()) continue;
    outcome = std::move(ended);
    progress = {};
    lock.unlock();
    Window::wake();
    lock.lock();
  }
}

Fitter::Fitter() : impl_(std::make_unique<Impl>()) {
  impl_->thread = std::thread([this] { impl_->run(); });
}

Fitter::~Fitter() {
  stop();
  impl_->thread.join();
}

void Fitter::start(FitTask task) {
  const std::lock_guard lock(impl_->mutex);
  impl_->stop.request_stop();
  impl_->next = std::move(task);
  impl_->outcome.reset();
  impl_->progress = {true, 0};
  impl_->wanted.notify_all();
}

void Fitter::cancel() {
  const std::lock_guard lock(impl_->mutex);
  impl_->stop.request_stop();
  impl_->next.reset();
  impl_->outcome.reset();
  impl_->progress = {};
}

void Fitter::stop() {
  cancel();
  const std::lock_guard lock(impl_->mutex);
  impl_->is_over = true;
  impl_->wanted.notify_all();
}

FitProgress Fitter::progress() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->progress;
}

std::optional<FitOutcome> Fitter::take() {
  const std::lock_guard lock(impl_->mutex);
  return std::exchange(impl_->outcome, std::nullopt);
}

}  // namespace ovoid::viewer
