// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "panels.h"

namespace ovoid::viewer {
bool step_time(Document& document, int steps) {
  const std::vector<double>& times = document.info->times;
  if (times.size() < 2) return false;
  const auto behind = std::upper_bound(times.begin(), times.end(), document.time.now);
  auto at = std::max<std::ptrdiff_t>(behind - times.begin() - 1, 0);
  const bool is_between = times[static_cast<std::size_t>(at)] < document.time.now;
  if (steps < 0 && is_between) ++at;
  const auto last = static_cast<std::ptrdiff_t>(times.size()) - 1;
  at += steps;
  if (document.time.loops) at = (at % (last + 1) + last + 1) % (last + 1);
  document.time.now = times[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(at, 0, last))];
  return true;
}

std::string TimeLabel::format() const {
  std::string format = before + "%.6g";
  for (const char c : after) format.append(c == '%' ? 2 : 1, c);
  return format;
}

TimeLabel time_label(const std::vector<double>& times, const std::string& unit, double time) {
  TimeLabel label;
  if (!unit.empty()) label.after = " " + unit;
  const auto at = std::find(times.begin(), times.end(), time);
  if (at == times.end()) return label;
  bool are_numbers = unit.empty();
  for (std::size_t i = 0; i < times.size(); ++i) are_numbers &= times[i] == static_cast<double>(i);
  const std::size_t last = times.size() - 1;
  if (are_numbers) return {"step ", fmt::format(" of 0 to {}", last)};
  label.after += fmt::format(" (step {} of 0 to {})", at - times.begin(), last);
  return label;
}

void time_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (!document.has_time()) {
    ImGui::TextWrapped(
        "These data have one step. Several files of a series can be opened together.");
    return;
  }
  TimeState& time = document.time;
  const std::vector<double>& times = document.info->times;
  const std::string unit = document.info->time_unit;
  bool is_moved = widgets.slider("time.now", "time", &time.now, times.front(), times.back(),
                                 unit.empty() ? "%.6g" : ("%.6g " + unit).c_str());
  if (widgets.button("time.first", "|<")) {
    time.now = times.front();
    is_moved = true;
  }
  ImGui::SameLine();
  if (widgets.button("time.back", "<")) is_moved |= step_time(document, -1);
  ImGui::SameLine();
  if (widgets.button("time.play", time.is_playing ? "pause" : "play"))
    time.is_playing = !time.is_playing;
  ImGui::SameLine();
  if (widgets.button("time.forward", ">")) is_moved |= step_time(document, 1);
  ImGui::SameLine();
  if (widgets.button("time.last", ">|")) {
    time.now = times.back();
    is_moved = true;
  }
  widgets.checkbox("time.loop", "loop", &time.loops);
  is_moved |= widgets.checkbox("time.interpolate", "between steps, too", &time.is_interpolated);
  widgets.checkbox("time.fastest", "every step, as fast as possible", &time.is_fastest);
  if (!time.is_fastest) {
    const double span = times.back() - times.front();
    widgets.number(
        "time.rate", unit.empty() ? "per second" : (unit + " per s").c_str(), &time.rate,
        {.lo = span * 1e-4, .hi = span * 100, .speed = span / 1000, .is_logarithmic = true});
  }
  bool blurs = time.blur_length > 0;
  if (widgets.checkbox("time.blur", "motion blur", &blurs)) {
    time.blur_length = blurs ? (times.back() - times.front()) / 4 : 0;
    is_moved = true;
  }
  if (blurs) {
    is_moved |= widgets.slider("time.blur.length", "length", &time.blur_length,
                               (times.back() - times.front()) / 1000, times.back() - times.front());
    is_moved |= widgets.slider("time.blur.decay", "decay", &time.blur_decay, 0, 10);
  }
  const TimeLabel shown = time_label(times, unit, document.shown->time);
  widgets.row("shown", fmt::format("{}{:g}{}", shown.before, document.shown->time, shown.after));
  if (panel.status.resident_bytes == 0) {
    if (is_moved) panel.wishes.goes_to_time = true;
    return;
  }
  widgets.row(
      "steps in memory",
      fmt::format("{:.1f} MiB", static_cast<double>(panel.status.resident_bytes) / 1048576));
  if (is_moved) panel.wishes.goes_to_time = true;
}

}  // namespace ovoid::viewer
