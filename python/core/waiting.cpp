// SPDX-License-Identifier: Apache-2.0
#include "waiting.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

namespace ovoid::python {
namespace {

namespace py = pybind11;

// A fifth of what Ctrl-C may take.
constexpr std::chrono::milliseconds kLookEvery{20};

// Whether the work is done.
class Done {
 public:
  void set() {
    const std::lock_guard lock(mutex_);
    is_set_ = true;
    changed_.notify_all();
  }
  bool wait_for(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, time, [this] { return is_set_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_set_ = false;
};

// Raises what a signal's handler raises; only Python's main thread runs handlers.
void look_around(const py::object& on_progress, double fraction) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (!on_progress.is_none()) on_progress(fraction);
}

}  // namespace

std::vector<std::string> wait_for(const std::function<void(Work&)>& work,
                                  const py::object& on_progress) {
  std::stop_source stopper;
  Work shared{stopper.get_token(), 0, {}};
  std::exception_ptr failure;
  std::optional<py::error_already_set> raised;
  {
    const py::gil_scoped_release unlocked;
    Done done;
    std::thread worker([&] {
      try {
        work(shared);
      } catch (...) {
        failure = std::current_exception();
      }
      done.set();
    });
    while (!done.wait_for(kLookEvery)) {
      if (raised) continue;
      const py::gil_scoped_acquire locked;
      try {
        look_around(on_progress, shared.fraction);
      } catch (py::error_already_set& error) {
        raised = std::move(error);
        stopper.request_stop();
      }
    }
    worker.join();
  }
  if (raised) throw std::move(*raised);
  if (failure) std::rethrow_exception(failure);
  if (!on_progress.is_none()) on_progress(1.0);
  return std::move(shared.notes);
}

}  // namespace ovoid::python
