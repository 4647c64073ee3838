// SPDX-License-Identifier: Apache-2.0
#include "source.h"

#include <algorithm>

#include "load.h"
#include "usage.h"

namespace ovoid::python {
namespace {

void refuse_file_flags(const cli::Flags& flags) {
  for (const cli::GivenFlag& flag : flags.given()) {
    const auto is_it = [&](const auto& row) { return row.flag.name == flag.name; };
    const bool is_of_files =
        std::any_of(cli::data_settings().begin(), cli::data_settings().end(), is_it) ||
        std::any_of(cli::raw_settings().begin(), cli::raw_settings().end(), is_it);
    if (is_of_files && flag.name != "memory-limit")
      throw cli::UsageError("--" + flag.name + ": is for files, these data are in memory");
  }
}

}  // namespace

void parse(const Source& source, const cli::Words& words, cli::Flags& flags, cli::DataFlags& data) {
  cli::Words all = words;
  all.emplace_back("--");
  all.insert(all.end(), source.inputs.begin(), source.inputs.end());
  flags.parse(all);
  if (source.dataset != nullptr) {
    refuse_file_flags(flags);
  } else {
    cli::require_inputs(flags, data);
  }
}

std::shared_ptr<const Dataset> load(const Source& source, const cli::DataFlags& data,
                                    cli::Session& session) {
  if (source.dataset != nullptr) return source.dataset;
  return std::make_shared<const Dataset>(cli::load(data, session));
}

cli::Session session_of(Work& work) {
  return {[&work](const std::string& note) { work.notes.push_back(note); }, work.stop};
}

std::function<void(double)> progress_of(Work& work) {
  return [&work](double fraction) { work.fraction = fraction; };
}

}  // namespace ovoid::python
