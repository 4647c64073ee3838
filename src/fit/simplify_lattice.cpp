// SPDX-License-Identifier: Apache-2.0
// From a lattice to boxes that rise evenly, layers by layers, and the error of what will be read.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <new>
#include <utility>

#include "data/parallel.h"
#include "fit/even_boxes.h"
#include "fit/fit_goal.h"
#include "fit/lattice_samples.h"
#include "ovoid/error.h"
#include "ovoid/simplify.h"

namespace ovoid {
namespace {

using fit::BoxesOfLayers;
using fit::BoxRules;
using fit::LatticeSamples;
using fit::psnr_of;
using fit::refuse_fit;
using fit::SampleState;

constexpr double kDefaultTolerance = 0.01;  // of the range
// Numbers of a box are rounded to that share of what a box may err by.
constexpr double kStepOfError = 0.25;
// Boxes end at every so many layers, so that threads share the work and results do not depend on
// how many there are.
constexpr std::int64_t kLayers = 32;
constexpr double kShareOfSearch = 0.9;  // of the time; the rest is that of the errors

void check_options(const SimplifyOptions& options) {
  if (options.tolerance && options.relative_tolerance)
    refuse_fit("tolerance, relative_tolerance: both given, expected one");
  if (options.tolerance && !(*options.tolerance >= 0 && std::isfinite(*options.tolerance)))
    refuse_fit(fmt::format("tolerance = {}: must be >= 0", *options.tolerance));
  if (options.relative_tolerance &&
      !(*options.relative_tolerance >= 0 && *options.relative_tolerance <= 1))
    refuse_fit(
        fmt::format("relative_tolerance = {}: must be in [0, 1]", *options.relative_tolerance));
  if (!(options.rms_share > 0 && options.rms_share <= 1))
    refuse_fit(fmt::format("rms_share = {}: must be in (0, 1]", options.rms_share));
  if (options.relevant_above && !std::isfinite(*options.relevant_above))
    refuse_fit(fmt::format("relevant_above = {}: must be finite", *options.relevant_above));
  if (options.search == RunSearch::kFewest && options.primitives == Primitives::kBoxes)
    refuse_fit("search: the fewest runs are found, not the fewest boxes");
}

class LatticeSimplifier {
 public:
  LatticeSimplifier(const Dataset& dataset, const SimplifyOptions& options, SimplifyReport& report)
      : options_(options), report_(report), threads_(data::resolve_threads(options.threads)) {
    check_options(options);
    samples_ = fit::read_lattice_samples(
        dataset, {options.array, options.component, threads_, options.stop}, "boxes");
    report_.array = samples_.array;
    report_.samples = num_samples(samples_.dims);
    set_rules();
    set_head();
    set_states();
  }

  LatticeBoxes run() {
    find_boxes();
    report_errors();
    return std::move(boxes_);
  }

 private:
  double range() const { return samples_.greatest - samples_.least; }

  // In the samples' own numbers.
  void set_rules() {
    rules_.primitives = options_.primitives;
    rules_.search = options_.search;
    rules_.tolerance = options_.tolerance
                           ? *options_.tolerance / std::abs(samples_.scale)
                           : options_.relative_tolerance.value_or(kDefaultTolerance) * range();
    rules_.rms = options_.rms_share * rules_.tolerance;
    if (samples_.whole) return;
    const double least = SimplifyOptions::kLeastTolerance * range();
    rules_.tolerance = std::max(rules_.tolerance, least);
    rules_.rms = std::max(rules_.rms, least);
  }

  void set_head() {
    boxes_.dims = samples_.dims;
    boxes_.least = samples_.least;
    boxes_.greatest = samples_.greatest;
    boxes_.whole = samples_.whole;
    const double least_value = samples_.scale < 0 ? samples_.greatest : samples_.least;
    boxes_.background = options_.relevant_above ? least_value : samples_.background;
    const double step = kStepOfError * rules_.rms;
    if (samples_.whole) {
      boxes_.background = std::nearbyint(boxes_.background);
      boxes_.step = std::max(1.0, std::floor(step));
    } else {
      boxes_.background = static_cast<double>(static_cast<float>(boxes_.background));
      boxes_.step = step > 0 ? step : 1;
    }
  }

  void set_states() {
    const double above =
        options_.relevant_above ? (*options_.relevant_above - samples_.offset) / samples_.scale : 0;
    const bool falls = samples_.scale < 0;
    states_.resize(samples_.values.size());
    data::parallel_ranges(
        {static_cast<std::int64_t>(states_.size()), 1 << 20, threads_, options_.stop},
        [&](std::int64_t begin, std::int64_t end) {
          for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
            const auto value = static_cast<double>(samples_.values[i]);
            const bool is_dropped =
                options_.relevant_above && (falls ? value >= above : value <= above);
            states_[i] = is_dropped ? SampleState::kDropped
                         : std::abs(value - boxes_.background) <= rules_.tolerance
                             ? SampleState::kFree
                             : SampleState::kOpen;
          }
        });
    report_.relevant = std::count(states_.begin(), states_.end(), SampleState::kOpen);
  }

  void find_boxes() {
    const std::int64_t layers = samples_.dims[2];
    std::vector<BoxesOfLayers> parts(static_cast<std::size_t>((layers + kLayers - 1) / kLayers));
    std::mutex mutex;
    std::size_t num_done = 0;
    data::parallel_ranges({static_cast<std::int64_t>(parts.size()), 1, threads_, options_.stop},
                          [&](std::int64_t part, std::int64_t) {
                            const std::int64_t begin = part * kLayers;
                            parts[static_cast<std::size_t>(part)] = fit::find_even_boxes(
                                samples_, boxes_, rules_, begin, std::min(begin + kLayers, layers),
                                states_, options_.stop);
                            const std::lock_guard lock(mutex);
                            ++num_done;
                            if (options_.progress)
                              options_.progress(kShareOfSearch * static_cast<double>(num_done) /
                                                static_cast<double>(parts.size()));
                          });
    std::size_t count = 0;
    for (const BoxesOfLayers& part : parts) count += part.boxes.size();
    boxes_.boxes.reserve(count);
    std::int64_t gap = 0;
    for (BoxesOfLayers& part : parts) {
      if (!part.boxes.empty()) part.boxes.front().gap += std::exchange(gap, 0);
      gap += part.gap_behind;
      boxes_.boxes.insert(boxes_.boxes.end(), part.boxes.begin(), part.boxes.end());
      part = {};
    }
  }

  void report_errors() {
    const std::vector<float> read = samples_of(boxes_, options_.stop);
    double square = 0, greatest = 0, count = 0;
    for (std::size_t i = 0; i < read.size(); ++i) {
      const float value = samples_.values[i];
      if (value != value || states_[i] == SampleState::kDropped) continue;
      const double error = static_cast<double>(read[i]) - static_cast<double>(value);
      greatest = std::max(greatest, std::abs(error));
      square += error * error;
      count += 1;
    }
    const double scale = std::abs(samples_.scale);
    report_.primitives = static_cast<std::int64_t>(boxes_.boxes.size());
    report_.range = scale * range();
    report_.tolerance = scale * rules_.tolerance;
    report_.greatest_error = scale * greatest;
    report_.psnr = psnr_of(range(), square / std::max(1.0, count));
    if (options_.progress) options_.progress(1);
  }

  const SimplifyOptions& options_;
  SimplifyReport& report_;
  int threads_;
  LatticeSamples samples_;
  LatticeBoxes boxes_;
  BoxRules rules_;
  std::vector<SampleState> states_;
};

}  // namespace

LatticeBoxes simplify_lattice(const Dataset& dataset, const SimplifyOptions& options,
                              SimplifyReport* report) {
  SimplifyReport own;
  SimplifyReport& filled = report != nullptr ? *report : own;
  filled = {};
  try {
    return LatticeSimplifier(dataset, options, filled).run();
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("'{}': no memory to simplify it", dataset.source));
  }
}

}  // namespace ovoid
