// SPDX-License-Identifier: Apache-2.0
// What a step between steps costs: slices STEPS SIZE. A formula's series in memory, on a Cartesian
// lattice and on D4*, cut at the same times by turns; prints the median milliseconds of each. Then
// of what comes behind: from a time to its picture, 512 x 512 pixels, by a volume of the slice and
// by blending what is drawn.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "ovoid/ovoid.h"

namespace {

using Clock = std::chrono::steady_clock;

// Steps that are made once.
class HeldSteps final : public ovoid::StepSource {
 public:
  explicit HeldSteps(const std::shared_ptr<const ovoid::StepSource>& from) : from_(from) {
    for (std::int64_t step = 0; step < from->num_steps(); ++step) held_.push_back(from->read(step));
  }
  ovoid::SeriesKind kind() const noexcept override { return from_->kind(); }
  const std::string& name() const noexcept override { return from_->name(); }
  std::int64_t num_steps() const noexcept override { return from_->num_steps(); }
  const std::vector<double>& times() const noexcept override { return from_->times(); }
  bool has_times() const noexcept override { return true; }
  ovoid::Dataset read(std::int64_t step, std::stop_token) const override {
    return held_[static_cast<std::size_t>(step)];
  }

 private:
  std::shared_ptr<const ovoid::StepSource> from_;
  std::vector<ovoid::Dataset> held_;
};

double median(std::vector<double> ms) {
  const auto middle = ms.begin() + static_cast<std::ptrdiff_t>(ms.size() / 2);
  std::nth_element(ms.begin(), middle, ms.end());
  return *middle;
}

template <class Work>
double ms_of(const Work& work) {
  const Clock::time_point start = Clock::now();
  work();
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

constexpr int kRounds = 21;

double time_of(int round, std::int64_t steps) {
  return (0.21 + 0.53 * round / kRounds) * static_cast<double>(steps - 1);
}

struct Way {
  const char* name;
  const ovoid::Series* series;
  ovoid::TimeFilter filter;
  std::vector<double> ms{};
};

void compare_slices(const ovoid::Series& cartesian, const ovoid::Series& staggered,
                    std::int64_t steps) {
  Way ways[] = {{"Cartesian, linear", &cartesian, ovoid::TimeFilter::kTwoSteps},
                {"D4*, four steps", &staggered, ovoid::TimeFilter::kFourSteps},
                {"D4*, two steps", &staggered, ovoid::TimeFilter::kTwoSteps},
                {"D4*, Gaussian", &staggered, ovoid::TimeFilter::kGaussian},
                {"D4*, exact", &staggered, ovoid::TimeFilter::kExact}};
  for (int round = 0; round < kRounds; ++round) {
    for (Way& way : ways) {
      ovoid::TimeSliceOptions how;
      how.filter = way.filter;
      const double ms =
          ms_of([&] { ovoid::slice_at_time(*way.series, time_of(round, steps), how); });
      if (round > 0) way.ms.push_back(ms);
    }
  }
  fmt::print("| slice | ms | Cartesian / this |\n|---|---:|---:|\n");
  for (const Way& way : ways)
    fmt::print("| {} | {:.2f} | {:.2f} |\n", way.name, median(way.ms),
               median(ways[0].ms) / median(way.ms));
}

void compare_pictures(const char* name, const ovoid::Series& series, std::int64_t steps) {
  const ovoid::LatticeField first = ovoid::make_lattice_field(ovoid::slice_at_time(series, 1));
  ovoid::Look look = ovoid::ramp_look(first.value_range());
  const double lo = first.value_range().lo;
  const double hi = first.value_range().hi;
  look.transfer_function.opacities = {{lo + 0.4 * (hi - lo), 0}, {lo + 0.7 * (hi - lo), 0.5}};
  const ovoid::Camera camera = ovoid::default_camera(first.world_bounds());
  ovoid::RenderOptions options;
  options.width = options.height = 512;
  ovoid::Renderer renderer;
  ovoid::SliceFields fields(series, {});
  std::vector<double> by_volume, by_blending;
  for (int round = 0; round < kRounds; ++round) {
    const double time = time_of(round, steps);
    const double volume = ms_of([&] {
      const auto field = ovoid::make_lattice_field(ovoid::slice_at_time(series, time));
      renderer.render({field, look}, camera, options);
    });
    const double blending = ms_of([&] {
      renderer.render({fields.at(time), look}, camera, options);
    });
    if (round == 0) continue;
    by_volume.push_back(volume);
    by_blending.push_back(blending);
  }
  fmt::print("| {} | {:.1f} | {:.1f} | {:.2f} |\n", name, median(by_volume), median(by_blending),
             median(by_volume) / median(by_blending));
}

}  // namespace

int main(int argc, char** argv) {
  const std::int64_t steps = argc > 1 ? std::atoll(argv[1]) : 16;
  const std::int64_t size = argc > 2 ? std::atoll(argv[2]) : 128;
  ovoid::MakeOptions options;
  options.size = {size, size, size};
  options.type = ovoid::ScalarType::kUInt8;
  const auto series = [&](ovoid::SeriesKind kind) {
    return ovoid::Series(
        std::make_shared<HeldSteps>(ovoid::make_sample_steps("tornado", steps, kind, options)));
  };
  const ovoid::Series cartesian = series(ovoid::SeriesKind::kSteps);
  const ovoid::Series staggered = series(ovoid::SeriesKind::kStaggered);
  compare_slices(cartesian, staggered, steps);
  fmt::print(
      "\n| time to picture | volume ms | blended ms | volume / blended |\n"
      "|---|---:|---:|---:|\n");
  compare_pictures("Cartesian", cartesian, steps);
  compare_pictures("D4*", staggered, steps);
}
