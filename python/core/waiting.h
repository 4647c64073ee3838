// SPDX-License-Identifier: Apache-2.0
// Long work: without Python's lock, on a thread of its own, while the thread that called looks for
// Ctrl-C.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

namespace ovoid::python {

// What work and who waits for it tell each other.
struct Work {
  std::stop_token stop;
  std::atomic<double> fraction{0};  // that is done, in [0, 1]
  std::vector<std::string> notes;   // the work's; read when it is done
};

// Does `work` and returns what it told in notes. `on_progress`: None, or called now and then with
// the fraction that is done. Throws what the work throws; what Python's handler of a signal, or
// on_progress, raises, after the work was stopped. To be called with Python's lock.
std::vector<std::string> wait_for(const std::function<void(Work&)>& work,
                                  const pybind11::object& on_progress = pybind11::none());

}  // namespace ovoid::python
