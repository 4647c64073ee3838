// SPDX-License-Identifier: Apache-2.0
#include "source.h"

#include <algorithm>
#include <iterator>

#include "usage.h"

namespace ovoid::python {
namespace {

constexpr const char* kTimeFlags[] = {"step",          "time",         "time-filter",
                                      "hyperslice",    "slice-method", "slice-lattice",
                                      "slice-spacing", "motion-blur"};

bool is_of_time(const std::string& flag) {
  return std::any_of(std::begin(kTimeFlags), std::end(kTimeFlags),
                     [&](const char* name) { return flag == name; });
}

bool is_of_files(const std::string& flag) {
  const auto is_it = [&](const auto& row) { return row.flag.name == flag; };
  return std::any_of(cli::data_settings().begin(), cli::data_settings().end(), is_it) ||
         std::any_of(cli::raw_settings().begin(), cli::raw_settings().end(), is_it);
}

void check_flags_of_memory(const cli::Flags& flags, std::int64_t num_steps) {
  for (const cli::GivenFlag& flag : flags.given()) {
    if (is_of_time(flag.name)) {
      if (num_steps > 1) continue;
      throw cli::UsageError("--" + flag.name +
                            ": is for data in time, these are one step; ovoid.series makes data "
                            "of several");
    }
    if (is_of_files(flag.name) && flag.name != "memory-limit")
      throw cli::UsageError("--" + flag.name + ": is for files, these data are in memory");
  }
}

}  // namespace

void parse(const Source& source, const cli::Words& words, cli::Flags& flags, cli::DataFlags& data) {
  cli::Words all = words;
  all.emplace_back("--");
  all.insert(all.end(), source.inputs.begin(), source.inputs.end());
  flags.parse(all);
  data.steps = source.steps;
  if (source.steps != nullptr) {
    check_flags_of_memory(flags, source.steps->num_steps());
  } else {
    cli::require_inputs(flags, data);
  }
}

cli::Session session_of(Work& work) {
  return {[&work](const std::string& note) { work.notes.push_back(note); }, work.stop};
}

std::function<void(double)> progress_of(Work& work) {
  return [&work](double fraction) { work.fraction = fraction; };
}

}  // namespace ovoid::python
