// SPDX-License-Identifier: Apache-2.0
#include "meter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#ifdef __linux__
#include <unistd.h>
#endif

namespace ovoid::viewer {
namespace {

double steady_ms() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// How old the process is already; replacing its program (exec) leaves that as it is.
double age_at_first_call() {
#ifdef __linux__
  std::ifstream file("/proc/self/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t end_of_name = text.rfind(')');
  if (end_of_name == std::string::npos) return 0;
  std::istringstream fields(text.substr(end_of_name + 1));
  std::string field;
  constexpr int kStartTime = 20;  // the field "starttime" behind the name, in clock ticks
  for (int i = 0; i < kStartTime; ++i) fields >> field;
  timespec up{};
  if (clock_gettime(CLOCK_BOOTTIME, &up) != 0 || !fields) return 0;
  const double ticks = std::strtod(field.c_str(), nullptr);
  const double now_s = static_cast<double>(up.tv_sec) + 1e-9 * static_cast<double>(up.tv_nsec);
  return std::max(0.0, (now_s - ticks / static_cast<double>(sysconf(_SC_CLK_TCK))) * 1000);
#else
  return 0;
#endif
}

nlohmann::ordered_json spread_of(std::vector<double> numbers) {
  if (numbers.empty()) return nullptr;
  std::sort(numbers.begin(), numbers.end());
  const auto quantile = [&](double share) {
    const double at = share * static_cast<double>(numbers.size() - 1);
    return numbers[static_cast<std::size_t>(std::lround(at))];
  };
  return {{"count", numbers.size()},
          {"median", quantile(0.5)},
          {"p99", quantile(0.99)},
          {"max", numbers.back()}};
}

constexpr std::size_t kMostKept = 1'000'000;

void keep(std::vector<double>& numbers, double number) {
  if (numbers.size() < kMostKept) numbers.push_back(number);
}

}  // namespace

double ms_since_start() {
  static const double begin = steady_ms() - age_at_first_call();
  return steady_ms() - begin;
}

Meter::Meter() { begin("start"); }

void Meter::begin(const std::string& name) {
  moving(false);
  sections_.push_back({});
  now().name = name;
  released_ms_ = -1;
}

void Meter::interface_frame(double ms) {
  keep(now().interface_ms, ms);
  last_interface_ms_ = ms;
}

void Meter::changed(std::uint64_t version) { waiting_.push_back({version, steady_ms()}); }

void Meter::picture_shown(std::uint64_t version, bool is_moving, bool is_final, double picture_ms) {
  const double at = steady_ms();
  while (!waiting_.empty() && waiting_.front().version <= version) {
    keep(now().latency_ms, at - waiting_.front().at_ms);
    waiting_.pop_front();
  }
  ++now().pictures;
  keep(now().picture_ms, picture_ms);
  if (is_moving && is_moving_) {
    ++now().pictures_moving;
    if (last_picture_ms_ > moving_since_ms_) keep(now().gap_ms, at - last_picture_ms_);
    recent_.push_back(at);
  }
  last_picture_ms_ = at;
  if (is_final && released_ms_ >= 0) {
    keep(now().settle_ms, at - released_ms_);
    released_ms_ = -1;
  }
  if (first_picture_ms_ < 0) first_picture_ms_ = ms_since_start();
  if (is_final && first_full_ms_ < 0) first_full_ms_ = ms_since_start();
}

void Meter::cancelled(double ms) { keep(now().cancel_ms, ms); }

void Meter::moving(bool is_moving) {
  if (is_moving == is_moving_) return;
  const double at = steady_ms();
  is_moving_ = is_moving;
  if (is_moving) {
    moving_since_ms_ = at;
    released_ms_ = -1;
  } else {
    now().moving_ms += at - moving_since_ms_;
    released_ms_ = at;
    recent_.clear();
  }
}

void Meter::first_frame() {
  if (window_ms_ < 0) window_ms_ = ms_since_start();
}

double Meter::pictures_per_second() const {
  const double since = steady_ms() - 1000;
  const auto first = std::lower_bound(recent_.begin(), recent_.end(), since);
  return static_cast<double>(recent_.end() - first);
}

double Meter::interface_ms() const { return last_interface_ms_; }

nlohmann::ordered_json Meter::report() const {
  nlohmann::ordered_json sections;
  for (const Section& section : sections_) {
    const double seconds = section.moving_ms / 1000;
    sections.push_back(
        {{"name", section.name},
         {"pictures", section.pictures},
         {"moving_s", seconds},
         {"pictures_per_second",
          seconds > 0 ? static_cast<double>(section.pictures_moving) / seconds : 0.0},
         {"interface_ms", spread_of(section.interface_ms)},
         {"input_to_picture_ms", spread_of(section.latency_ms)},
         {"between_pictures_ms", spread_of(section.gap_ms)},
         {"picture_ms", spread_of(section.picture_ms)},
         {"cancel_ms", spread_of(section.cancel_ms)},
         {"release_to_full_ms", spread_of(section.settle_ms)}});
  }
  return {{"window_ms", window_ms_},
          {"first_picture_ms", first_picture_ms_},
          {"first_full_picture_ms", first_full_ms_},
          {"sections", sections}};
}

}  // namespace ovoid::viewer
