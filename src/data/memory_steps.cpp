// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "data/shown_step.h"
#include "data/step_likeness.h"
#include "ovoid/error.h"
#include "ovoid/series.h"

namespace ovoid {
namespace {

using Steps = std::vector<std::shared_ptr<const Dataset>>;

[[noreturn]] void refuse_steps(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

std::optional<double> own_time(const Dataset& dataset) {
  const auto step = static_cast<std::size_t>(std::max<std::int64_t>(dataset.step, 0));
  if (step >= dataset.times.size()) return std::nullopt;
  return dataset.times[step];
}

// Empty unless all say theirs. Writers that know none may state the same in every file.
std::vector<double> own_times(const Steps& steps) {
  std::vector<double> times;
  for (const auto& step : steps) {
    const auto time = own_time(*step);
    if (!time) return {};
    times.push_back(*time);
  }
  const bool is_one =
      std::all_of(times.begin(), times.end(), [&](double time) { return time == times.front(); });
  return is_one && times.size() > 1 ? std::vector<double>() : times;
}

class MemorySteps final : public StepSource {
 public:
  MemorySteps(std::string name, Steps steps, const StepTimes& times)
      : name_(std::move(name)), steps_(std::move(steps)) {
    if (steps_.empty()) refuse_steps(fmt::format("{}: has no steps, expected at least one", name_));
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (steps_[i] == nullptr) refuse_steps(fmt::format("{}: step {}: is null", name_, i));
    times_ = times.values.empty() ? own_times(steps_) : times.values;
    unit_ = times.unit.empty() ? steps_.front()->time_unit : times.unit;
    has_times_ = !times_.empty();
    if (!has_times_) {
      times_.resize(steps_.size());
      std::iota(times_.begin(), times_.end(), 0.0);
    }
    data::check_times(*this);
    if (steps_.size() > 1) check_steps();
  }

  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override {
    return static_cast<std::int64_t>(steps_.size());
  }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return has_times_; }

  Dataset read(std::int64_t step, std::stop_token /*stop*/) const override {
    if (step < 0 || step >= num_steps()) {
      refuse_steps(fmt::format("{}: step {}: expected 0 to {}", name_, step, num_steps() - 1));
    }
    Dataset dataset = *steps_[static_cast<std::size_t>(step)];
    dataset.num_steps = num_steps();
    dataset.step = step;
    dataset.series = SeriesKind::kSteps;
    dataset.times = has_times_ ? times_ : std::vector<double>();
    dataset.time_unit = unit_;
    return dataset;
  }

 private:
  void check_steps() const {
    const data::StepLikeness likeness(*steps_.front(), 0, SeriesKind::kSteps);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      try {
        likeness.check(*steps_[i], static_cast<std::int64_t>(i));
      } catch (const Error& error) {
        refuse_steps(error.what());
      }
      for (const DataArray& array : steps_[i]->arrays) {
        if (array.stored == nullptr) continue;
        throw Error(ErrorCode::kUnsupported,
                    fmt::format("{}: step {}: the samples of array '{}' are in a file, which "
                                "steps in memory cannot; expected the file's name",
                                name_, i, array.name));
      }
    }
  }

  std::string name_;
  Steps steps_;
  std::vector<double> times_;
  std::string unit_;
  bool has_times_ = false;
};

}  // namespace

std::shared_ptr<const StepSource> make_steps(const std::string& name,
                                             std::vector<std::shared_ptr<const Dataset>> steps,
                                             const StepTimes& times) {
  return std::make_shared<MemorySteps>(name, std::move(steps), times);
}

Dataset step_to_show(const StepSource& source, const std::string& array, std::stop_token stop) {
  if (source.num_steps() == 1) return source.read(0, std::move(stop));
  return data::shown_step({}, source.num_steps(), array,
                          [&](std::int64_t step) { return source.read(step, stop); });
}

}  // namespace ovoid
