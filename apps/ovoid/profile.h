// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "ovoid/renderer.h"

namespace ovoid::cli {

// Everything `--profile` tells about one run.
struct RunProfile {
  double load_ms = 0;
  double model_ms = 0;
  std::vector<double> frames_ms;  // the timed frames, at least one
  FrameProfile frame;             // counts and stage times of one frame
  int width = 0;
  int height = 0;
  std::string command;
};

// The camera turns by so much from each timed frame to the next, so that nothing can be kept
// between them.
inline constexpr double kTurnDegrees = 0.01;

// Quartiles of measurements, by linear interpolation between the sorted values.
struct Quartiles {
  double min = 0;
  double q1 = 0;
  double median = 0;
  double q3 = 0;
  double max = 0;
};
Quartiles quartiles(std::vector<double> values);  // at least one value

std::string to_json(const RunProfile& profile);   // the members of docs/command-line.md
std::string to_table(const RunProfile& profile);  // for people

// The parts that `ovoid bench` writes too.
nlohmann::ordered_json counts_json(const FrameProfile& frame);  // kernels, samples, blocks
nlohmann::ordered_json stages_json(const FrameProfile& frame);

// The greatest resident memory of this process so far, bytes; 0 if the system does not tell.
std::int64_t peak_memory_bytes();

// Its resident memory now.
std::int64_t resident_memory_bytes();

// "4.2 MiB"
std::string readable_bytes(double bytes);

}  // namespace ovoid::cli
