// SPDX-License-Identifier: Apache-2.0
// From a lattice to kernels on levels: chosen and fitted by LevelFitter until the goal is reached,
// their weights rounded to a step, and the error taken sample by sample of what will be stored.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <utility>

#include "data/parallel.h"
#include "fit/fit_goal.h"
#include "fit/lattice_noise.h"
#include "fit/lattice_samples.h"
#include "fit/level_fitter.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"
#include "ovoid/lattice_file.h"

namespace ovoid {
namespace {

using fit::LevelFitter;
using fit::psnr_of;
using fit::refuse_fit;

// Of conjugate gradients, whenever kernels came or went.
constexpr int kStepsPerFit = 12;
// Rounds in which kernels that hold little make room for others, a sixth of all; what a PSNR rises
// by in this round and those after it, dB.
constexpr double kGains[] = {1.2, 0.6, 0.4, 0.3, 0.2, 0.1, 0.1};
constexpr std::int64_t kShareThatGoes = 6;
// dB for twice the kernels, for guesses of how many are wanted.
constexpr double kSlope = 4;
// The error of rounded weights, as a share of the mean squared error.
constexpr double kShareOfRounding = 0.02;
// A PSNR may be that much more than was asked for, dB.
constexpr double kSurplus = 0.1;
constexpr int kMostTries = 8;
// What first thresholds are guessed from, as a share of the range.
constexpr double kFirstThreshold = 0.1;
// A bound on the greatest error: where the first kernels are as good as a rms error of that share
// of it; and of the bound, what samples beyond count as missing it while kernels are added, and the
// step of weights.
constexpr double kRmsOfBound = 0.3, kNearBound = 0.8, kStepOfBound = 0.25;
constexpr int kMostRounds = 24, kMostPasses = 200;
// Bytes of memory per sample, of LevelFitter and what is beside it.
constexpr std::size_t kBytesPerSample = 48;
// Noise below half a step of whole numbers, or below that share of the range, is no noise to speak
// of: rounding makes 0.29 steps.
constexpr double kLeastNoiseOfWhole = 0.5, kLeastNoise = 1e-5;
// More kernels than that share of the samples would not make a file smaller.
constexpr double kMostKernels = 0.5;

// Numbers of kernels between one that is too few and one that is too many.
class Bracket {
 public:
  void too_few(std::int64_t count) { low_ = std::max(low_, count); }
  void enough(std::int64_t count) { high_ = std::min(high_, count); }
  // The guess, if it lies between, else the mean of their logarithms.
  std::int64_t next(std::int64_t guess) const {
    if (guess > low_ && guess < high_) return guess;
    if (low_ == 0) return std::max<std::int64_t>(1, high_ / 2);
    if (high_ == kNone) return 2 * low_;
    return std::clamp(
        std::llround(std::sqrt(static_cast<double>(low_) * static_cast<double>(high_))), low_ + 0LL,
        high_ + 0LL);
  }

 private:
  static constexpr std::int64_t kNone = std::int64_t{1} << 40;
  std::int64_t low_ = 0, high_ = kNone;
};

class LatticeFitter {
 public:
  LatticeFitter(const Dataset& dataset, const FitOptions& options, FitReport& report)
      : options_(options),
        report_(report),
        work_{data::resolve_threads(options.threads), options.stop} {
    fit::check_goal(options);
    check_memory(dataset);
    samples_ = fit::read_lattice_samples(
        dataset, {options.model.array, options.model.component, work_.threads, options.stop},
        "levels");
    value_scale_ = std::abs(samples_.scale);
    report_.array = samples_.array;
    report_.range = samples_.greatest - samples_.least;
    if (options.smooth)
      report_.noise =
          fit::noise_of_lattice(samples_.field->samples(), samples_.values, least_noise());
    report_.source_kernels = report_.places = report_.test_places = num_samples(samples_.dims);
    report_.source_psnr = std::numeric_limits<double>::infinity();
    tell(0.05);
  }

  LatticeLevels run() {
    LatticeLevels levels = report_.range > 0 ? reach_goal() : empty();
    report_errors(levels);
    // So far in stored numbers.
    report_.range *= value_scale_;
    report_.noise *= value_scale_;
    report_.greatest_error *= value_scale_;
    for (FitStep& step : report_.steps) step.greatest_error *= value_scale_;
    tell(1);
    return levels;
  }

 private:
  void check_memory(const Dataset& dataset) const {
    const auto count = static_cast<double>(num_samples(dataset.lattice.dims));
    const double bytes = count * static_cast<double>(kBytesPerSample);
    if (options_.memory_limit > 0 && bytes > static_cast<double>(options_.memory_limit)) {
      throw Error(
          ErrorCode::kOutOfMemory,
          fmt::format("a fit of {:.0f} samples takes {:.0f} MiB, more than the limit of {:.3g}",
                      count, bytes / (1 << 20),
                      static_cast<double>(options_.memory_limit) / (1 << 20)));
    }
  }

  void tell(double fraction) {
    told_ = std::max(told_, std::min(fraction, 1.0));
    if (options_.progress) options_.progress(told_);
  }
  // Nearer to the end by a share of what is left.
  void tell_step() { tell(told_ + 0.1 * (0.95 - told_)); }

  // Samples that are there.
  double total() const {
    return static_cast<double>(samples_.values.size()) - static_cast<double>(samples_.num_missing);
  }
  std::int64_t most_kernels() const {
    return std::max<std::int64_t>(1, static_cast<std::int64_t>(kMostKernels * total()));
  }

  LatticeLevels empty() const {
    LatticeLevels levels;
    levels.dims = samples_.dims;
    levels.offset = samples_.background;
    levels.least = samples_.least;
    levels.greatest = samples_.greatest;
    levels.whole = samples_.whole;
    levels.holes = holes();
    return levels;
  }

  // As LatticeLevels has them.
  std::vector<std::uint32_t> holes() const {
    std::vector<std::uint32_t> lengths;
    if (samples_.num_missing == 0) return lengths;
    bool is_hole = false;
    std::uint32_t length = 0;
    for (const float value : samples_.values) {
      if (std::isnan(value) != is_hole) {
        lengths.push_back(std::exchange(length, 0));
        is_hole = !is_hole;
      }
      ++length;
    }
    if (is_hole) lengths.push_back(length);
    return lengths;
  }

  // What the limit leaves for the matrix of kernels that share samples. Its rows are vectors that
  // grow: twice their entries.
  std::size_t most_pairs() const {
    if (options_.memory_limit == 0) return LevelFitter::kMostPairs;
    const std::size_t left = options_.memory_limit - samples_.values.size() * kBytesPerSample;
    return std::min(LevelFitter::kMostPairs, left / (2 * LevelFitter::kBytesPerPair));
  }

  // Less comes of rounding.
  double least_noise() const {
    return samples_.whole ? kLeastNoiseOfWhole : kLeastNoise * report_.range;
  }

  double psnr_of_noise() const {
    if (report_.noise > 0) return psnr_of(report_.range, report_.noise * report_.noise);
    refuse_fit(
        fmt::format("smooth: '{}' has no noise that can be told from what it shows; expected a "
                    "psnr or another goal",
                    report_.array));
  }

  LatticeLevels reach_goal() {
    std::vector<float> above(samples_.values.size());
    for (std::size_t i = 0; i < above.size(); ++i)
      above[i] = static_cast<float>(static_cast<double>(samples_.values[i]) - samples_.background);
    const LevelFitter::Limits limits{static_cast<float>(samples_.least - samples_.background),
                                     static_cast<float>(samples_.greatest - samples_.background)};
    LevelFitter fitter(samples_.dims, std::move(above), limits, work_, most_pairs());
    if (options_.smooth) return reach_psnr(fitter, psnr_of_noise() - kSurplus);
    if (options_.psnr) return reach_psnr(fitter, *options_.psnr);
    if (options_.tolerance) return reach_tolerance(fitter, *options_.tolerance / value_scale_);
    if (options_.relative_tolerance)
      return reach_tolerance(fitter, *options_.relative_tolerance * report_.range);
    if (options_.kernels) return reach_count(fitter, *options_.kernels);
    return reach_bytes(fitter, *options_.bytes);
  }

  // Looks for the threshold of a start() that `measure` says is near enough to `goal`; of
  // thresholds, twice as much changes the measure by about `slope`.
  template <class Measure>
  void start(LevelFitter& fitter, double goal, double slope, double near, const Measure& measure) {
    double threshold = kFirstThreshold * report_.range;
    for (int i = 0; i < kMostTries; ++i) {
      fitter.start(threshold);
      const double miss = goal - measure();
      tell_step();
      if (std::abs(miss) <= near) return;
      threshold *= std::exp2(std::clamp(miss / slope, -3.0, 3.0));
    }
  }

  double psnr_now(LevelFitter& fitter) const {
    return psnr_of(report_.range, fitter.mean_square());
  }

  // So many kernels, of which those that hold little have made room for others.
  void exchange(LevelFitter& fitter, std::int64_t count) {
    fitter.grow(std::max(count / kShareThatGoes, count - fitter.num_kernels()));
    fitter.fit(kStepsPerFit);
    if (fitter.num_kernels() > count) {
      fitter.prune(count);
      fitter.fit(kStepsPerFit);
    }
    note(fitter);
  }

  // So many kernels, without an exchange.
  void set_count(LevelFitter& fitter, std::int64_t count) {
    fitter.prune(count);
    fitter.grow(count - fitter.num_kernels());
    fitter.fit(kStepsPerFit);
    note(fitter);
  }

  void note(LevelFitter& fitter) {
    report_.steps.push_back({fitter.num_kernels(), psnr_now(fitter), greatest(fitter.residual())});
    tell_step();
  }

  LatticeLevels reach_count(LevelFitter& fitter, std::int64_t count) {
    count = std::min(count, most_kernels());
    start(fitter, std::log2(static_cast<double>(count)), -1.2, 0.2,
          [&] { return std::log2(std::max(1.0, static_cast<double>(fitter.num_kernels()))); });
    fitter.prune(count);
    fitter.fit(kStepsPerFit);
    note(fitter);
    for (std::size_t round = 0; round < std::size(kGains); ++round) exchange(fitter, count);
    return rounded(fitter, step_for(fitter));
  }

  std::int64_t times(std::int64_t count, double factor) const {
    return std::clamp<std::int64_t>(std::llround(static_cast<double>(count) * factor), 1,
                                    most_kernels());
  }

  LatticeLevels reach_psnr(LevelFitter& fitter, double psnr) {
    start(fitter, psnr - 3.5, -5, 0.8, [&] { return psnr_now(fitter); });
    fitter.prune(most_kernels());
    fitter.fit(kStepsPerFit);
    note(fitter);
    // What is read is a little worse than what was fitted, since weights are rounded, or a little
    // better, since samples are clamped.
    double gained = 10 * std::log10(1 - kShareOfRounding);
    double slope = kSlope;
    const auto next_count = [&](double to_come) {
      const double aim = psnr + kSurplus / 2 - gained - to_come;
      const double doublings = (aim - psnr_now(fitter)) / slope;
      return times(fitter.num_kernels(), std::exp2(std::clamp(doublings, -1.5, 1.5)));
    };
    for (const double gain : kGains) exchange(fitter, next_count(gain));
    LatticeLevels best;
    Bracket counts;
    FitStep before = report_.steps.back();
    for (int i = 0; i < kMostTries; ++i) {
      LatticeLevels levels = rounded(fitter, step_for(fitter));
      const double reached = error_of(levels).psnr;
      gained = reached - psnr_now(fitter);
      const bool is_hit = reached >= psnr;
      is_hit ? counts.enough(fitter.num_kernels()) : counts.too_few(fitter.num_kernels());
      if (is_hit && (best.levels.empty() || levels.num_kernels() < best.num_kernels()))
        best = std::move(levels);
      if (is_hit && reached < psnr + kSurplus) break;
      if (!is_hit && fitter.num_kernels() >= most_kernels()) break;
      set_count(fitter, std::min(most_kernels(), counts.next(next_count(0))));
      slope = slope_between(before, report_.steps.back());
      before = report_.steps.back();
    }
    if (best.levels.empty()) {
      refuse_fit(fmt::format("psnr = {:g}: half as many kernels as samples reach {:.1f} dB", psnr,
                             psnr_now(fitter)));
    }
    return best;
  }

  // dB for twice the kernels. Near the noise of the data it is small: more kernels hardly help.
  static double slope_between(const FitStep& a, const FitStep& b) {
    const double doublings =
        std::log2(static_cast<double>(b.kernels) / static_cast<double>(a.kernels));
    if (std::abs(doublings) < 0.01) return kSlope;
    return std::clamp((b.psnr - a.psnr) / doublings, kSlope / 16, 2 * kSlope);
  }

  LatticeLevels reach_bytes(LevelFitter& fitter, std::int64_t bytes) {
    const std::int64_t least = lattice_levels_bytes(empty());
    if (bytes < least)
      refuse_fit(fmt::format("bytes = {}: a file without kernels has {}", bytes, least));
    constexpr double kFirstBytes = 2;  // per kernel
    const auto room = static_cast<double>(bytes - least);
    LatticeLevels levels =
        reach_count(fitter, std::max<std::int64_t>(1, std::llround(room / kFirstBytes)));
    LatticeLevels best = empty();
    Bracket counts;
    for (int i = 0; i < kMostTries; ++i) {
      const std::int64_t now = lattice_levels_bytes(levels);
      const bool fits = now <= bytes;
      const double factor = 0.99 * room / std::max(1.0, static_cast<double>(now - least));
      const bool is_close = static_cast<double>(now - least) > 0.98 * room;
      if (fits && levels.num_kernels() > best.num_kernels()) best = levels;
      if (fits && (is_close || fitter.num_kernels() >= most_kernels())) break;
      fits ? counts.too_few(fitter.num_kernels()) : counts.enough(fitter.num_kernels());
      const std::int64_t guess = times(fitter.num_kernels(), std::clamp(factor, 0.1, 4.0));
      set_count(fitter, std::min(most_kernels(), counts.next(guess)));
      levels = rounded(fitter, step_for(fitter));
    }
    return best;
  }

  LatticeLevels reach_tolerance(LevelFitter& fitter, double tolerance) {
    const double psnr = 20 * std::log10(report_.range / (kRmsOfBound * tolerance));
    start(fitter, psnr - 3.5, -5, 0.8, [&] { return psnr_now(fitter); });
    fitter.prune(most_kernels() / 2);  // noise has large errors however many there are
    fitter.fit(kStepsPerFit);
    note(fitter);
    exchange(fitter, fitter.num_kernels());
    for (int round = 0; round < kMostRounds; ++round) {
      if (add_where_error_is(fitter, kNearBound * tolerance) == 0) break;
      if (fitter.num_kernels() > most_kernels()) refuse_tolerance(tolerance);
      fitter.fit(kStepsPerFit);
      note(fitter);
    }
    LatticeLevels levels = rounded(fitter, std::min(step_for(fitter), kStepOfBound * tolerance));
    if (!keep_bound(levels, tolerance)) refuse_tolerance(tolerance);
    return levels;
  }

  [[noreturn]] void refuse_tolerance(double tolerance) const {
    refuse_fit(
        fmt::format("tolerance = {:g}: takes more than half as many kernels as samples, "
                    "which would be more than the lattice itself",
                    tolerance * value_scale_));
  }

  // Kernels at the samples whose error is greater than all their neighbours' and than the bound.
  std::int64_t add_where_error_is(LevelFitter& fitter, double bound) const {
    std::int64_t count = 0;
    visit_peaks(fitter.residual(), bound, [&](std::size_t sample, double) {
      fitter.add_kernel(sample);
      ++count;
    });
    return count;
  }

  template <class Visit>
  void visit_peaks(std::span<const float> error, double bound, const Visit& visit) const {
    const auto [nx, ny, nz] = samples_.dims;
    const std::int64_t strides[] = {1, nx, nx * ny};
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(error.size()); ++i) {
      const float own = std::abs(error[static_cast<std::size_t>(i)]);
      if (static_cast<double>(own) <= bound) continue;
      const Index3 at{i % nx, i / nx % ny, i / (nx * ny)};
      bool is_peak = true;
      for (std::size_t a = 0; a < 3 && is_peak; ++a) {
        // Of equals the first is the peak.
        is_peak = (at[a] == 0 || std::abs(error[static_cast<std::size_t>(i - strides[a])]) < own) &&
                  (at[a] == samples_.dims[a] - 1 ||
                   std::abs(error[static_cast<std::size_t>(i + strides[a])]) <= own);
      }
      if (is_peak) visit(static_cast<std::size_t>(i), error[static_cast<std::size_t>(i)]);
    }
  }

  // Changes single weights of level 0 until no sample's error, as it will be read, is over the
  // bound. False if that does not end.
  bool keep_bound(LatticeLevels& levels, double tolerance) const {
    for (int pass = 0; pass < kMostPasses; ++pass) {
      const std::vector<float> error = errors_of(levels);
      LatticeLevel changes;
      visit_peaks(error, tolerance, [&](std::size_t sample, double miss) {
        const auto change = static_cast<std::int32_t>(std::lround(miss / levels.step));
        changes.nodes.push_back(static_cast<std::uint32_t>(sample));
        changes.weights.push_back(change != 0 ? change : (miss > 0 ? 1 : -1));
      });
      if (changes.nodes.empty()) return greatest(error) <= tolerance;
      levels.levels[0] = merged(levels.levels[0], changes);
    }
    return false;
  }

  static LatticeLevel merged(const LatticeLevel& a, const LatticeLevel& b) {
    LatticeLevel sum;
    std::size_t i = 0, j = 0;
    while (i < a.nodes.size() || j < b.nodes.size()) {
      const bool takes_a = j == b.nodes.size() || (i < a.nodes.size() && a.nodes[i] <= b.nodes[j]);
      const bool takes_b = i == a.nodes.size() || (j < b.nodes.size() && b.nodes[j] <= a.nodes[i]);
      const std::uint32_t node = takes_a ? a.nodes[i] : b.nodes[j];
      const std::int32_t weight = (takes_a ? a.weights[i++] : 0) + (takes_b ? b.weights[j++] : 0);
      if (weight == 0) continue;
      sum.nodes.push_back(node);
      sum.weights.push_back(weight);
    }
    return sum;
  }

  // The step by which rounding adds kShareOfRounding to the squared error.
  double step_for(LevelFitter& fitter) const {
    // Of a kernel of level 0 among samples; of other levels 2^(3 level / 2) of it, and their steps
    // are as much smaller.
    const double norm = std::pow(LatticeLevels::kSigma * std::sqrt(std::acos(-1.0)), 1.5);
    const double each = std::max(fitter.mean_square(), 1e-30) * total() * kShareOfRounding /
                        std::max(1.0, static_cast<double>(fitter.num_kernels()));
    return std::sqrt(12 * each) / norm;
  }

  LatticeLevels rounded(const LevelFitter& fitter, double step) const {
    LatticeLevels levels = empty();
    // No weight is beyond what its number holds.
    double most = 0;
    for (const float weight : fitter.weights())
      most = std::max(most, static_cast<double>(std::abs(weight)));
    const int num_levels = fitter.basis().num_levels();
    levels.step = std::max(step, most * std::exp2(1.5 * num_levels) / (1 << 30));
    for (int l = 0; l < num_levels; ++l) {
      LatticeLevel level;
      const std::size_t begin = fitter.basis().offset(l);
      for (std::size_t node = begin; node < fitter.basis().offset(l + 1); ++node) {
        if (!fitter.is_kernel(node)) continue;
        const auto weight = static_cast<std::int32_t>(
            std::lround(static_cast<double>(fitter.weights()[node]) / levels.step_of(l)));
        if (weight == 0) continue;
        level.nodes.push_back(static_cast<std::uint32_t>(node - begin));
        level.weights.push_back(weight);
      }
      levels.levels.push_back(std::move(level));
    }
    return levels;
  }

  // Samples less what is read back; 0 where they are missing.
  std::vector<float> errors_of(const LatticeLevels& levels) const {
    std::vector<float> errors = samples_of(levels, work_.threads, options_.stop);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const float error = samples_.values[i] - errors[i];
      errors[i] = std::isnan(error) ? 0 : error;
    }
    return errors;
  }

  static double greatest(std::span<const float> errors) {
    return std::transform_reduce(
        errors.begin(), errors.end(), 0.0, [](double a, double b) { return std::max(a, b); },
        [](float error) { return static_cast<double>(std::abs(error)); });
  }

  struct Errors {
    double psnr = 0, psnr_of_nonempty = 0, greatest = 0;
  };
  Errors error_of(const LatticeLevels& levels) const {
    const std::vector<float> errors = errors_of(levels);
    const double empty = samples_.least + 1e-3 * report_.range;
    double square = 0, square_nonempty = 0, nonempty = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const double error = static_cast<double>(errors[i]) * static_cast<double>(errors[i]);
      square += error;
      if (!(static_cast<double>(samples_.values[i]) > empty)) continue;
      square_nonempty += error;
      nonempty += 1;
    }
    return {psnr_of(report_.range, square / total()),
            psnr_of(report_.range, square_nonempty / std::max(1.0, nonempty)), greatest(errors)};
  }

  void report_errors(const LatticeLevels& levels) {
    const Errors errors = error_of(levels);
    report_.kernels = levels.num_kernels();
    report_.bytes = lattice_levels_bytes(levels);
    report_.psnr = errors.psnr;
    report_.psnr_of_nonempty = errors.psnr_of_nonempty;
    report_.greatest_error = errors.greatest;
  }

  const FitOptions& options_;
  FitReport& report_;
  data::LevelWork work_;
  fit::LatticeSamples samples_;
  double value_scale_ = 1;  // of the numbers that are fitted
  double told_ = 0;
};

}  // namespace

LatticeLevels fit_lattice(const Dataset& dataset, const FitOptions& options, FitReport* report) {
  FitReport own;
  FitReport& filled = report != nullptr ? *report : own;
  filled = {};
  try {
    return LatticeFitter(dataset, options, filled).run();
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("'{}': no memory to fit kernels", dataset.source));
  }
}

}  // namespace ovoid
