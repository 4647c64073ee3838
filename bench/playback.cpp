// SPDX-License-Identifier: Apache-2.0
// Playing a series: playback RESIDENT LOOPS INPUT... Its steps, of which at most RESIDENT are in
// memory, are drawn from the first to the last, 512 x 512 pixels; then in random order, each time
// from a new `Series`, as somebody would who opens it and goes to a time; then read LOOPS times
// over, where memory is looked at.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "ovoid/ovoid.h"

namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double pages = 0;
  file >> pages >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

double quantile(std::vector<double> values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

std::size_t bytes_of(const ovoid::Dataset& dataset) {
  std::size_t bytes = 0;
  for (const ovoid::DataArray& array : dataset.arrays) bytes += array.bytes.view.size();
  return bytes;
}

struct Picture {
  ovoid::Look look;
  ovoid::Camera camera;
  ovoid::RenderOptions options;
  ovoid::Renderer renderer;

  explicit Picture(const ovoid::LatticeField& field)
      : look(ovoid::default_look(field)), camera(ovoid::default_camera(field.world_bounds())) {
    options.width = options.height = 512;
  }
  void draw(const ovoid::Series& series, double time) {
    const ovoid::LatticeField field = ovoid::make_lattice_field(ovoid::slice_at_time(series, time));
    renderer.render({field, look}, camera, options);
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: playback RESIDENT LOOPS INPUT...\n");
    return 2;
  }
  const std::int64_t resident = std::atoll(argv[1]);
  const std::int64_t loops = std::atoll(argv[2]);
  const auto source = ovoid::open_steps(std::vector<std::string>(argv + 3, argv + argc));
  const std::size_t step_bytes = bytes_of(source->read(source->num_steps() / 2));
  ovoid::SeriesOptions limits;
  limits.memory_limit = static_cast<std::size_t>(resident) * step_bytes;
  const std::vector<double>& times = source->times();
  Picture picture(ovoid::make_lattice_field(source->read(source->num_steps() / 2)));

  const ovoid::Series series(source, limits);
  for (const double time : times) picture.draw(series, time);  // the page cache, and the allocator
  std::int64_t most = 0;
  Clock::time_point start = Clock::now();
  for (const double time : times) {
    picture.draw(series, time);
    most = std::max(most, series.num_resident());
  }
  const double whole = ms_since(start);
  fmt::print("{} steps of {:.2f} MiB, at most {} resident: {:.1f} frames/s\n", times.size(),
             static_cast<double>(step_bytes) / (1 << 20), most,
             1000.0 * static_cast<double>(times.size()) / whole);

  std::mt19937 random(1);
  std::vector<double> seeks;
  for (int i = 0; i < 101; ++i) {
    const double part = std::uniform_real_distribution<double>(0, 1)(random);
    start = Clock::now();
    const ovoid::Series opened(source, limits);
    picture.draw(opened, times.front() + part * (times.back() - times.front()));
    seeks.push_back(ms_since(start));
  }
  fmt::print("a time between steps, to its picture: {:.0f} ms median, {:.0f} ms at most\n",
             quantile(seeks, 0.5), quantile(seeks, 1));

  fmt::print("loops, each of all steps:");
  for (std::int64_t loop = 0; loop <= loops; ++loop) {
    for (std::int64_t step = 0; step < series.num_steps(); ++step) series.step(step);
    if (loop % std::max<std::int64_t>(1, loops / 5) == 0)
      fmt::print(" {}: {:.1f} MiB", loop, resident_mib());
  }
  fmt::print("\n");
}
