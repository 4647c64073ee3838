// SPDX-License-Identifier: Apache-2.0
// A device's peaks, as JSON: fused multiply-adds per second on registers, and bytes per second read
// and written by copies within its memory. device_peak [DEVICE]
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <exception>

#include "render/vulkan/commands.h"

namespace ovoid::vulkan {
namespace {

constexpr std::uint32_t kFmaPeakWords[] = {
#include "fma_peak.inc"
};
const Shader kFmaPeak{"fma_peak", kFmaPeakWords, 1, 0};

constexpr std::uint32_t kSteps = 4096;
constexpr int kRounds = 5;

// The shortest of some runs, ms.
template <class Record>
double best_ms(Commands& commands, const Record& record) {
  double best = 1e300;
  for (int round = 0; round < kRounds; ++round) {
    commands.stages_ms.clear();
    commands.mark("run");
    record();
    commands.submit_and_wait();
    best = std::min(best, commands.stages_ms["run"]);
  }
  return best;
}

void measure(int index) {
  const std::shared_ptr<Device> device = Device::get(index, {});
  Commands commands(device);
  commands.times = true;
  const bool is_hardware = device->info().is_hardware();
  const std::uint32_t groups = is_hardware ? 16384 : 64;
  const std::uint64_t bytes = std::uint64_t{is_hardware ? 1024U : 64U} << 20U;
  const Buffer sums(device, 4096 * sizeof(float), BufferUse::kDevice);
  const double fma_ms = best_ms(commands, [&] {
    commands.dispatch_bytes(kFmaPeak, {kSteps}, {&sums}, {}, {groups, 1, 1});
  });
  const Buffer from(device, bytes, BufferUse::kDevice);
  const Buffer to(device, bytes, BufferUse::kDevice);
  const double copy_ms = best_ms(commands, [&] { commands.copy(from, 0, to, 0, bytes); });
  const double fmas = 8.0 * kSteps * 256.0 * groups;
  fmt::print(
      "{{\"device\": \"{}\", \"driver\": \"{}\", \"fma_per_second\": {:.4g}, \"bytes_per_second\": "
      "{:.4g}}}\n",
      device->info().name, device->info().driver, fmas / fma_ms * 1e3,
      2.0 * static_cast<double>(bytes) / copy_ms * 1e3);
}

}  // namespace
}  // namespace ovoid::vulkan

int main(int argc, char** argv) {
  try {
    ovoid::vulkan::measure(argc > 1 ? std::atoi(argv[1]) : -1);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "device_peak: {}\n", error.what());
    return 1;
  }
}
