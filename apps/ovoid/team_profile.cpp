// SPDX-License-Identifier: Apache-2.0
#include "team_profile.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "console.h"
#include "ovoid/io.h"
#include "profile.h"

namespace ovoid::cli {
namespace {

// Of the quickest and of the slowest process.
using NamedSpread = std::pair<std::string, Team::Spread>;

std::string stages_line(int processes, const std::vector<NamedSpread>& spreads,
                        const Team::Picture& picture) {
  std::string line = fmt::format("processes: {}", processes);
  for (const auto& [name, spread] : spreads)
    line += fmt::format("; {} {:.0f} to {:.0f}", name, spread.least, spread.greatest);
  return line + fmt::format("; exchange_ms {:.1f}; composite_ms {:.1f}; bytes_sent {}",
                            picture.exchange_ms, picture.composite_ms, picture.bytes);
}

std::string stages_json(int processes, const std::vector<NamedSpread>& spreads,
                        const Team::Picture& picture) {
  nlohmann::ordered_json json{{"processes", processes}};
  for (const auto& [name, spread] : spreads)
    json[name] = {{"least", spread.least}, {"greatest", spread.greatest}};
  json["exchange_ms"] = picture.exchange_ms;
  json["composite_ms"] = picture.composite_ms;
  json["bytes_sent"] = picture.bytes;
  return json.dump(2) + "\n";
}

}  // namespace

void tell_stages(Team& team, const StageTimes& own, const std::optional<Team::Picture>& picture,
                 const std::string& file) {
  std::vector<NamedSpread> spreads;
  const auto add = [&](const char* name, double value) {
    spreads.emplace_back(name, team.spread(value));
  };
  add("load_ms", own.load_ms);
  add("model_ms", own.model_ms);
  add("draw_ms", own.draw_ms);
  add("peak_mib", static_cast<double>(peak_memory_bytes()) / (1 << 20));
  if (!picture) return;
  if (file.empty()) {
    tell(stages_line(team.count(), spreads, *picture) + "\n");
  } else {
    write_file(file, stages_json(team.count(), spreads, *picture));
  }
}

}  // namespace ovoid::cli
