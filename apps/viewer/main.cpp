// SPDX-License-Identifier: Apache-2.0
// `ovoid view`: the window.
#include <chrono>
#include <string>
#include <vector>

#include "app.h"
#include "console.h"
#include "meter.h"
#include "session.h"
#include "usage.h"

namespace {

int view(const std::vector<std::string>& words) {
  // Ctrl-C closes the window, and what is under way in it is waited for.
  constexpr std::chrono::seconds kGrace{1};
  ovoid::cli::Session session(words, kGrace);
  const auto launch = ovoid::viewer::parse_launch({words.begin() + 1, words.end()});
  if (!launch) {
    ovoid::cli::flush_out();
    return ovoid::cli::kExitDone;
  }
  ovoid::viewer::App app(launch);
  app.run(session.stop());
  ovoid::cli::flush_out();
  return session.stop().stop_requested() ? ovoid::cli::Interrupt::exit_code()
                                         : ovoid::cli::kExitDone;
}

}  // namespace

int main(int argc, char** argv) {
  ovoid::viewer::ms_since_start();
  ovoid::cli::hold_standard_files();
  try {
    return view({argv, argv + argc});
  } catch (...) {
    return ovoid::cli::complain_of_exception();
  }
}
