// SPDX-License-Identifier: Apache-2.0
// The command line's front door: finds the command, and turns what it throws into one line and an
// exit code.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>

#include "command.h"
#include "console.h"
#include "flags.h"
#include "ovoid/error.h"
#include "session.h"
#include "suggest.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

constexpr const char* kView = "view";

struct Command {
  const char* name;
  const char* synopsis;
  const char* summary;
  void (*run)(const Words& words, Session& session);  // null: run_view(), before there is a session
};

constexpr std::array<Command, 11> kCommands = {{
    {kView, "INPUT...", "look around in data, in a window", nullptr},
    {"render", "INPUT... -o OUT.png", "draw data to a picture", run_render},
    {"composite", "PART... -o OUT.png", "parts of a picture to the picture", run_composite},
    {"animate", "INPUT... -o OUT.mp4", "draw a film or numbered pictures", run_animate},
    {"info", "INPUT...", "what is in a file, and how it would be drawn", run_info},
    {"make", "NAME -o OUT", "sample data by formula", run_make},
    {"convert", "INPUT... -o OUT", "between formats, to a grid or kernels", run_convert},
    {"fit", "INPUT... -o OUT.ply", "fewer kernels for a field, with a stated error", run_fit},
    {"simplify", "INPUT... -o OUT.h5", "runs and boxes for a scan's samples", run_simplify},
    {"sample", "INPUT... --points P -o OUT", "the field and its gradient at points", run_sample},
    {"bench", "[SCENE...]", "time the stages on standard scenes", run_bench},
}};

std::string help() {
  std::string out = "Ovoid draws volumes straight from their points.\n\n";
  for (const Command& command : kCommands) {
    out += fmt::format("  {:40}{}\n", fmt::format("ovoid {} {}", command.name, command.synopsis),
                       command.summary);
  }
  out += fmt::format("  {:40}{}\n", "ovoid INPUT...", "the same as ovoid view INPUT...");
  out += fmt::format("  {:40}{}\n", "ovoid COMMAND --help", "all flags of a command");
  out += fmt::format("  {:40}{}\n", "ovoid --version", "the version");
  return out;
}

// The first word is no command: say what it might have been.
[[noreturn]] void explain_first_word(const std::string& word) {
  std::vector<std::string> names;
  names.reserve(kCommands.size());
  for (const Command& command : kCommands) names.emplace_back(command.name);
  const char* const kind = word.rfind('-', 0) == 0 ? "flag" : "command";
  throw UsageError(
      fmt::format("'{}': unknown {}{} (see ovoid --help)", word, kind, did_you_mean(word, names)));
}

bool is_command(const std::string& word) {
  return std::any_of(kCommands.begin(), kCommands.end(),
                     [&](const Command& command) { return word == command.name; });
}

// The viewer takes signals its own way, so it is started before a session blocks any; and so does
// MPI.
void start_other_if_asked(const Words& words) {
  const bool is_render = !words.empty() && words.front() == "render";
  if (const int processes = processes_by_mpi(); processes > 1 || (processes == 1 && is_render))
    run_with_mpi(words);
  if (words.empty()) return;
  const std::string& first = words.front();
  if (first == kView) run_view({words.begin() + 1, words.end()});
  std::error_code ignored;
  const bool is_word = is_command(first) || first == "help" || first.starts_with('-');
  if (!is_word && std::filesystem::exists(first, ignored)) run_view(words);
}

void run(const Words& words, Session& session) {
  if (words.empty()) throw UsageError("no command given (see ovoid --help)");
  const std::string& first = words.front();
  if (first == "--help" || first == "-h" || first == "help") {
    print_out("{}", help());
    return;
  }
  if (first == kListFlags) {
    for (const Command& command : kCommands)
      print_out("{}\t{}\t{}\n", command.name, command.synopsis, command.summary);
    print_out("--help\t\tcommands\n--version\t\tthe version\n");
    return;
  }
  if (first == "--version") {
    print_out("ovoid {}\n", OVOID_VERSION);
    return;
  }
  for (const Command& command : kCommands) {
    if (first == command.name) return command.run({words.begin() + 1, words.end()}, session);
  }
  explain_first_word(first);
}

int run_guarded(int argc, char** argv) {
  hold_standard_files();
  try {
    const Words words(argv, argv + argc);
    const Words after_name(words.begin() + 1, words.end());
    start_other_if_asked(after_name);
    Session session(words);
    run(after_name, session);
    flush_out();
    return kExitDone;
  } catch (...) {
    const bool is_one_of_many = processes_by_mpi() > 1 && !speaks_for_all();
    const int code = is_one_of_many ? failure_of_exception().exit_code : complain_of_exception();
    std::fflush(stdout);
    // Not return: HDF5 closes at the end once more what it could not close on a full disk, and
    // crashes.
    _exit(code);
  }
}

}  // namespace
}  // namespace ovoid::cli

int main(int argc, char** argv) { return ovoid::cli::run_guarded(argc, argv); }
