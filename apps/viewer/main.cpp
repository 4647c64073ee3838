// SPDX-License-Identifier: Apache-2.0
// `ovoid view`: the window.
#include <fmt/format.h>

#include <cstdio>
#include <new>
#include <string>
#include <vector>

#include "app.h"
#include "meter.h"
#include "ovoid/error.h"
#include "session.h"
#include "usage.h"

namespace {

using ovoid::cli::kExitDone;
using ovoid::cli::kExitFailed;
using ovoid::cli::kExitInterrupted;
using ovoid::cli::kExitUsage;

int complain(const std::string& message, int exit_code) {
  fmt::print(stderr, "ovoid: error: {}\n", ovoid::cli::one_line(message));
  return exit_code;
}

int view(const std::vector<std::string>& words) {
  ovoid::cli::Session session(words);  // Ctrl-C closes the window
  const auto launch = ovoid::viewer::parse_launch({words.begin() + 1, words.end()});
  if (!launch) return kExitDone;
  ovoid::viewer::App app(launch);
  app.run(session.stop());
  return session.stop().stop_requested() ? kExitInterrupted : kExitDone;
}

}  // namespace

int main(int argc, char** argv) {
  ovoid::viewer::ms_since_start();
  try {
    return view({argv, argv + argc});
  } catch (const ovoid::cli::UsageError& error) {
    return complain(error.what(), kExitUsage);
  } catch (const ovoid::Error& error) {
    return complain(error.what(), kExitFailed);
  } catch (const std::bad_alloc&) {
    return complain("out of memory", kExitFailed);
  } catch (const std::exception& error) {
    return complain(fmt::format("unexpected: {}", error.what()), kExitFailed);
  }
}
