// SPDX-License-Identifier: Apache-2.0
// What a step between steps costs: slices STEPS SIZE. A formula's series in memory, on a Cartesian
// lattice and on D4*, cut at the same times by turns; prints the median milliseconds of each.
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

struct Way {
  const char* name;
  const ovoid::Series* series;
  ovoid::TimeFilter filter;
  std::vector<double> ms;
};

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
  Way ways[] = {{"cc4, linear", &cartesian, ovoid::TimeFilter::kTwoSteps, {}},
                {"D4*, two steps", &staggered, ovoid::TimeFilter::kTwoSteps, {}},
                {"D4*, Gaussian", &staggered, ovoid::TimeFilter::kGaussian, {}},
                {"D4*, exact", &staggered, ovoid::TimeFilter::kExact, {}}};
  constexpr int kRounds = 21;
  for (int round = 0; round < kRounds; ++round) {
    const double time = (0.21 + 0.53 * round / kRounds) * static_cast<double>(steps - 1);
    for (Way& way : ways) {
      ovoid::TimeSliceOptions how;
      how.filter = way.filter;
      const Clock::time_point start = Clock::now();
      const ovoid::Dataset slice = ovoid::slice_at_time(*way.series, time, how);
      const std::chrono::duration<double, std::milli> taken = Clock::now() - start;
      if (round > 0) way.ms.push_back(taken.count());
    }
  }
  fmt::print("| slice | ms | cc4 / this |\n|---|---:|---:|\n");
  double first = 0;
  for (Way& way : ways) {
    std::nth_element(way.ms.begin(),
                     way.ms.begin() + static_cast<std::ptrdiff_t>(way.ms.size() / 2), way.ms.end());
    const double median = way.ms[way.ms.size() / 2];
    if (first == 0) first = median;
    fmt::print("| {} | {:.2f} | {:.2f} |\n", way.name, median, first / median);
  }
}
