// SPDX-License-Identifier: Apache-2.0
#include "profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>

namespace ovoid::cli {

using Json = nlohmann::ordered_json;

Quartiles quartiles(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const auto at = [&values](double fraction) {
    const double place = fraction * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return std::lerp(values[below], values[above], place - std::floor(place));
  };
  return {at(0), at(0.25), at(0.5), at(0.75), at(1)};
}

namespace {

// A row of the system's table about this process, which is in KiB; 0 if there is none.
std::int64_t status_bytes(const char* name) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != name) continue;
    std::int64_t kibibytes = 0;
    status >> kibibytes;
    return kibibytes * 1024;
  }
  return 0;
}

}  // namespace

Json counts_json(const FrameProfile& frame) {
  Json json;
  json["kernels"] = {{"total", frame.kernels_total}, {"drawn", frame.kernels_drawn}};
  json["samples"] = {{"reconstructed", frame.samples_reconstructed},
                     {"shaded", frame.samples_shaded},
                     {"gradients", frame.gradients}};
  json["multiply_adds"] = {{"done", frame.multiply_adds}, {"peak", frame.multiply_add_peak}};
  json["bytes_loaded"] = {{"done", frame.bytes_loaded}, {"peak", frame.bandwidth_peak}};
  json["blocks"] = {{"total", frame.blocks_total}, {"drawn", frame.blocks_drawn}};
  json["blocks"]["skipped"] = {{"empty", frame.blocks_skipped_empty},
                               {"irrelevant", frame.blocks_skipped_irrelevant},
                               {"opaque", frame.blocks_skipped_opaque}};
  return json;
}

Json stages_json(const FrameProfile& frame) {
  Json stages = Json::object();
  for (const auto& [stage, ms] : frame.stages_ms) stages[stage] = ms;
  return stages;
}

std::string to_json(const RunProfile& profile) {
  const Quartiles frame = quartiles(profile.frames_ms);
  Json json;
  json["load_ms"] = profile.load_ms;
  json["model_ms"] = profile.model_ms;
  json["frame_ms"] = {{"median", frame.median}, {"min", frame.min}, {"max", frame.max}};
  json["stages_ms"] = stages_json(profile.frame);
  json.update(counts_json(profile.frame));
  json["peak_memory_bytes"] = peak_memory_bytes();
  json["backend"] = profile.frame.backend;
  json["device"] = profile.frame.device;
  json["bytes_uploaded"] = profile.frame.bytes_uploaded;
  json["simd_target"] = profile.frame.simd_target;
  json["threads"] = profile.frame.threads;
  json["size"] = {profile.width, profile.height};
  json["command"] = profile.command;
  // A command line may hold any bytes; JSON is UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

double ms_of(const FrameProfile& frame, std::initializer_list<std::string_view> stages) {
  double ms = 0;
  for (const auto& [stage, stage_ms] : frame.stages_ms) {
    if (std::find(stages.begin(), stages.end(), stage) != stages.end()) ms += stage_ms;
  }
  return ms;
}

// Of the stages that do them.
std::string multiply_adds_text(const FrameProfile& frame) {
  const double ms = ms_of(frame, {"reconstruct", "gradient"});
  const double rate = ms > 0 ? frame.multiply_adds / ms * 1e3 : 0;
  return fmt::format("{:.3g}, {:.3g} per second in reconstruct and gradient, {:.0f} % of the peak",
                     frame.multiply_adds, rate, 100 * rate / frame.multiply_add_peak);
}

std::string bytes_loaded_text(const FrameProfile& frame) {
  const double ms = ms_of(frame, {"load"});
  const double rate = ms > 0 ? frame.bytes_loaded / ms * 1e3 : 0;
  return fmt::format("{}, {} per second, {:.0f} % of memory's", readable_bytes(frame.bytes_loaded),
                     readable_bytes(rate), 100 * rate / frame.bandwidth_peak);
}

std::string to_table(const RunProfile& profile) {
  const FrameProfile& frame = profile.frame;
  const Quartiles time = quartiles(profile.frames_ms);
  std::string out;
  const auto row = [&out](const std::string& name, const std::string& value) {
    out += fmt::format("  {:<24}{}\n", name, value);
  };
  const auto ms = [](double value) { return fmt::format("{:.2f} ms", value); };
  std::string target = frame.simd_target.empty() ? "" : ", " + frame.simd_target;
  target += frame.device.empty()
                ? fmt::format(", {} thread{}", frame.threads, frame.threads == 1 ? "" : "s")
                : ", " + frame.device;
  out +=
      fmt::format("{}{}, {} x {} pixels\n", frame.backend, target, profile.width, profile.height);
  row("load", ms(profile.load_ms));
  row("model", ms(profile.model_ms));
  if (profile.frames_ms.size() == 1) {
    row("frame", ms(time.median));
  } else {
    row("frame", fmt::format("{} median of {}, {:.2f} to {:.2f}", ms(time.median),
                             profile.frames_ms.size(), time.min, time.max));
  }
  for (const auto& [stage, stage_ms] : frame.stages_ms) row("  " + stage, ms(stage_ms));
  row("kernels", fmt::format("{} drawn of {}", frame.kernels_drawn, frame.kernels_total));
  row("samples", fmt::format("{} reconstructed, {} shaded, {} gradients",
                             frame.samples_reconstructed, frame.samples_shaded, frame.gradients));
  if (frame.multiply_adds > 0 && frame.multiply_add_peak > 0)
    row("multiply-adds", multiply_adds_text(frame));
  if (frame.bytes_loaded > 0 && frame.bandwidth_peak > 0)
    row("samples read", bytes_loaded_text(frame));
  if (frame.blocks_total > 0) {
    row("blocks", fmt::format("{} drawn of {}", frame.blocks_drawn, frame.blocks_total));
    row("  skipped", fmt::format("{} empty, {} irrelevant, {} opaque", frame.blocks_skipped_empty,
                                 frame.blocks_skipped_irrelevant, frame.blocks_skipped_opaque));
  }
  if (!frame.device.empty())
    row("sent to the device", readable_bytes(static_cast<double>(frame.bytes_uploaded)));
  row("peak memory", readable_bytes(static_cast<double>(peak_memory_bytes())));
  return out;
}

// VmHWM rather than getrusage(): the latter starts at the peak of the process that called exec().
std::int64_t peak_memory_bytes() { return status_bytes("VmHWM:"); }

std::int64_t resident_memory_bytes() { return status_bytes("VmRSS:"); }

std::string readable_bytes(double bytes) {
  constexpr const char* kUnits[] = {"bytes", "KiB", "MiB", "GiB", "TiB"};
  std::size_t unit = 0;
  while (bytes >= 1024 && unit + 1 < std::size(kUnits)) {
    bytes /= 1024;
    ++unit;
  }
  return fmt::format("{:.{}f} {}", bytes, unit == 0 ? 0 : 1, kUnits[unit]);
}

}  // namespace ovoid::cli
