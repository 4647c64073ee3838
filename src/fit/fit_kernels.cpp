// SPDX-License-Identifier: Apache-2.0
// From a dataset to fewer kernels. Rounds: the source's kernels lie in clusters, each of which
// makes a kernel; the kernels' values are fitted; clusters are halved where the error is greatest;
// and so on until the goal is reached. What a round costs is in proportion to the places.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "data/kernels/kernel_shape.h"
#include "data/parallel.h"
#include "fit/clusters.h"
#include "fit/fit_goal.h"
#include "fit/fit_judge.h"
#include "fit/fit_places.h"
#include "fit/refine_kernels.h"
#include "fit/source_kernels.h"
#include "ovoid/error.h"
#include "ovoid/fit.h"

namespace ovoid {
namespace {

using fit::Clusters;
using fit::FitPlaces;
using fit::MergedKernels;
using fit::MergeRule;
using fit::Places;
using fit::psnr_of;
using fit::refuse_fit;
using fit::SourceKernels;

// What the first round has: as many, but at least that share of what is wanted.
constexpr std::int64_t kFirstKernels = 8, kFirstShare = 16;
// A round has so many times the kernels of the one before. Of a greater factor, kernels come where
// they are not needed: on the disk's temperature, 2 is 6 dB worse, and 1.15 no better.
constexpr double kGrowth = 1.3;
// Places looked at for each kernel while clusters change.
constexpr std::size_t kPlacesPerCluster = 32, kLeastPlaces = 4096;
// Of conjugate gradients: while clusters change, and of what is kept.
constexpr int kIterations = 8, kLastIterations = 25;
// Kernels of a sum keep the moments of what they stand for.
constexpr double kSpreadOfSums = 1;
// A place whose error exceeds a bound counts that many times more after each fit, and so many times
// more at most. So many fits in a row are tried that bring hardly any kernels.
constexpr double kRise = 1.5, kMostRise = 30;
constexpr int kMostIdle = 8;
constexpr double kHardlyAny = 0.02;
// A bound is kept with a little to spare, for what lies between the places that are looked at.
// After so many searches the bound itself is enough.
constexpr double kBoundBetween = 0.98;
// Under a bound kernels are widened until the sum of weights is so many times what a value needs.
constexpr float kThin = 1.2F;
// Where the search beside the worst places finds more than that, these places are seen from then
// on, and the bound of all that are seen is tightened by a factor, down to a share of the bound.
constexpr double kTighter = 0.97, kTightest = 0.8;
constexpr int kMostSearches = 40, kMostWithin = 8;  // the latter where the bound was kept once
constexpr std::size_t kTestPlaces = 100'000;
// Places that are seen, for each of the source's kernels, and at least.
constexpr std::size_t kMostPlacesPerKernel = 3, kLeastSeen = 1 << 17;
// Places that are looked at for each kernel while they are refined, and in all; kernels of which
// each would have fewer than the least, or that are as good as floats, stay as they are.
constexpr double kPlacesPerKernel = 48, kLeastPerKernel = 20, kMostRefinedPlaces = 1 << 21;
constexpr double kMostRefinedPsnr = 140;
// Of the operator, for a place: 8 bytes for each of the kernels that reach it.
constexpr std::size_t kBytesPerPlace = 400;
// Steps between the last miss and the first hit of a PSNR.
constexpr int kMostHalvings = 4;
// dB by which a PSNR may be more than was asked for before fewer kernels are tried.
constexpr double kCloseEnough = 0.25;
// dB that refining kernels may bring: at first, and at least, whatever it brought before.
constexpr double kFirstGain = 15, kLeastGain = 3;

// Kernels with their values, and what that leaves at the places.
struct Fitted {
  MergedKernels kernels;
  std::vector<std::vector<double>> values;  // of each attribute
  std::vector<double> energies;             // of each kernel: how much it is to blame
  std::vector<double> residuals;            // of the first attribute, at the places looked at
  FitStep step;
};

class Fitter {
 public:
  Fitter(const Dataset& dataset, const FitOptions& options, FitReport& report)
      : options_(options), report_(report) {
    fit::check_goal(options);
    if (options.smooth)
      refuse_fit("smooth: only a lattice tells its noise; expected a psnr or another goal");
    threads_ = data::resolve_threads(options.threads);
    KernelModelOptions model = options.model;
    model.threads = threads_;
    KernelModelReport model_report;
    field_ = make_kernel_field(dataset, model, &model_report, options.stop);
    model.array = model_report.array;
    report_.array = model_report.array;
    report_.notes = model_report.notes;
    source_ = fit::load_source_kernels(field_, threads_, options.stop);
    const ValueRange range = field_.value_range();
    report_.range = static_cast<double>(range.hi) - static_cast<double>(range.lo);
    report_.source_kernels = static_cast<std::int64_t>(source_.count());
    place_maker_ = fit::make_place_maker(
        dataset, field_, source_,
        {model, options.seed, most_places(), kTestPlaces, threads_, options.stop});
    places_ = place_maker_->make();
    judge_.emplace(field_, source_, report_.range, threads_, options_.stop);
    report_.places = static_cast<std::int64_t>(places_.seen.count());
    report_.test_places = static_cast<std::int64_t>(places_.unseen.count());
    rule_.shape = options.shape;
    if (source_.reconstruction == Reconstruction::kSum) rule_.spread = kSpreadOfSums;
    tell(0.1);
  }

  KernelField run() {
    Clusters clusters(source_, threads_);
    const Fitted fitted = reach_goal(clusters);
    report_.greatest_error = look_for_worst(fitted).greatest_but_for_holes;
    KernelField field = field_of(fitted);
    report_.kernels = field.num_kernels();
    report_.bytes = kernel_file_bytes(field, report_.kernels);
    judge_->report(field, places_.unseen, report_);
    tell(1);
    return field;
  }

 private:
  std::size_t most_places() const {
    std::size_t most = std::max(kLeastSeen, kMostPlacesPerKernel * source_.count());
    if (options_.memory_limit == 0) return most;
    most = std::min(most, options_.memory_limit / kBytesPerPlace);
    if (most < source_.count()) {
      throw Error(ErrorCode::kOutOfMemory,
                  fmt::format("a fit of {} kernels takes {} MiB or more, more than the limit of {}",
                              source_.count(), (source_.count() * kBytesPerPlace >> 20) + 1,
                              options_.memory_limit >> 20));
    }
    return most;
  }

  std::int64_t all() const { return static_cast<std::int64_t>(source_.count()); }

  std::int64_t wanted_count() const {
    if (options_.kernels) return std::min(*options_.kernels, all());
    const std::int64_t one = kernel_file_bytes(field_, 1);
    if (*options_.bytes < one)
      refuse_fit(fmt::format("bytes = {}: a file with one kernel has {}", *options_.bytes, one));
    const std::int64_t each = kernel_file_bytes(field_, 2) - one;
    return std::min((*options_.bytes - one) / each + 1, all());
  }

  Fitted reach_goal(Clusters& clusters) {
    if (options_.psnr) return reach_psnr(clusters, *options_.psnr);
    if (options_.tolerance) return reach_tolerance(clusters, *options_.tolerance);
    if (options_.relative_tolerance)
      return reach_tolerance(clusters, *options_.relative_tolerance * report_.range);
    return reach_count(clusters, wanted_count());
  }

  void tell(double fraction) {
    told_ = std::max(told_, fraction);
    if (options_.progress) options_.progress(told_);
  }

  // Nearer to the end by a share of what is left.
  void tell_step() { tell(told_ + 0.1 * (0.95 - told_)); }

  // Clusters of about equal counts, as many as that.
  void start(Clusters& clusters, std::int64_t count) const {
    while (static_cast<std::int64_t>(clusters.list.size()) < count) {
      std::vector<double> sizes(clusters.list.size());
      for (std::size_t c = 0; c < sizes.size(); ++c) sizes[c] = clusters.list[c].count();
      if (halve_greatest(clusters, sizes, count) == 0) break;
    }
  }

  // Halves the clusters with the greatest energies, none without, until there are `count`, or twice
  // as many as before. Returns how many it halved.
  std::size_t halve_greatest(Clusters& clusters, const std::vector<double>& energies,
                             std::int64_t count) const {
    std::vector<std::uint32_t> which;
    for (std::uint32_t c = 0; c < clusters.list.size(); ++c) {
      if (clusters.list[c].count() > 1 && energies[c] > 0) which.push_back(c);
    }
    const auto more = static_cast<std::size_t>(
        std::max<std::int64_t>(0, count - static_cast<std::int64_t>(clusters.list.size())));
    const std::size_t most = std::min(which.size(), more);
    std::partial_sort(which.begin(), which.begin() + static_cast<std::ptrdiff_t>(most), which.end(),
                      [&](std::uint32_t a, std::uint32_t b) {
                        return energies[a] != energies[b] ? energies[a] > energies[b] : a < b;
                      });
    which.resize(most);
    std::sort(which.begin(), which.end());
    clusters.halve(which, options_.stop);
    return most;
  }

  // How carefully a round is done.
  struct Care {
    int iterations = kIterations;
    std::size_t places = 0;
  };
  static constexpr Care kAllPlaces{kLastIterations, std::numeric_limits<std::size_t>::max()};

  static Care care_of_round(const Clusters& clusters) {
    return {kIterations, std::max(kLeastPlaces, kPlacesPerCluster * clusters.list.size())};
  }

  // Fits the values of the clusters' kernels. `blame` turns a residual in units of the range into
  // energy.
  template <class Blame>
  Fitted fit(Clusters& clusters, const Care& care, const Blame& blame) {
    Fitted fitted;
    fitted.kernels = clusters.merged(rule_, options_.stop);
    fitted.values = fitted.kernels.means;
    for (std::size_t a = 0; a < num_fitted(); ++a) {
      for (std::size_t c = 0; c < clusters.list.size(); ++c)
        fitted.values[a][c] += clusters.list[c].excess[a];
    }
    fit_to_places(fitted, care, blame);
    for (std::size_t a = 0; a < num_fitted(); ++a) {
      for (std::size_t c = 0; c < clusters.list.size(); ++c)
        clusters.list[c].excess[a] = fitted.values[a][c] - fitted.kernels.means[a][c];
    }
    return fitted;
  }

  // As well as can be. The step's errors are those of places that no fit saw. `round`: what these
  // clusters came to in a round, if that is known.
  Fitted fit_last(Clusters& clusters, std::optional<Fitted> round = {}) {
    Fitted fitted = fit_closely(clusters, std::move(round));
    const fit::FitJudge::Errors errors = judge_->sum_up(places_.unseen, judged(fitted));
    fitted.step.psnr = psnr_of(report_.range, errors.mean_square);
    fitted.step.greatest_error = errors.greatest;
    report_.steps.back() = fitted.step;
    return fitted;
  }

  Fitted fit_closely(Clusters& clusters, std::optional<Fitted> round) {
    const auto count = static_cast<double>(clusters.list.size());
    const double per_kernel = std::min(kPlacesPerKernel, most_refined_places() / count);
    if (options_.refinements == 0 || per_kernel < kLeastPerKernel) {
      Fitted fitted = fit(clusters, kAllPlaces, energy);
      close_holes(fitted);
      return fitted;
    }
    if (!round) round = fit(clusters, care_of_round(clusters), energy);
    Fitted fitted = std::move(*round);
    if (fitted.step.psnr > kMostRefinedPsnr) return fitted;
    std::vector<double> ranges;
    for (std::size_t a = 0; a < num_fitted(); ++a) ranges.push_back(range_of(a));
    const Places places =
        place_maker_->make_evenly(fitted.kernels.columns(source_.cutoff), per_kernel);
    fit::refine_kernels(
        {places, ranges, source_.reconstruction, source_.cutoff, rule_.shape, options_.refinements,
         deviation() * deviation(), threads_, options_.stop, [&] { tell_step(); }},
        fitted.kernels, fitted.values);
    close_holes(fitted);
    return fitted;
  }

  // What a hole errs by, as a share of the range.
  double deviation() const { return judge_->deviation() / range_of(0); }

  // Widens kernels beside holes. Values stay if that brings the field nearer to the source: a fit
  // of values alone, after kernels were refined, has been 3 dB worse. Else they are fitted again.
  void close_holes(Fitted& fitted) {
    Fitted closed = fitted;
    if (!judge_->close_holes(places_.seen, closed.kernels)) return;
    const auto square = [&](const Fitted& of) {
      return judge_->sum_up(places_.seen, judged(of)).mean_square;
    };
    const double before = square(fitted);
    if (!(square(closed) < before)) fit_to_places(closed, kAllPlaces, energy);
    if (square(closed) < before) fitted = std::move(closed);
  }

  static fit::JudgedKernels judged(const Fitted& fitted) {
    return {fitted.kernels, fitted.values[0]};
  }

  fit::FitJudge::Worst look_for_worst(const Fitted& fitted) const {
    const Places* const all[] = {&places_.seen, &places_.unseen};
    return judge_->look_for_worst(*place_maker_, all, judged(fitted), options_.seed);
  }

  // Rows are there twice while a step is tried.
  double most_refined_places() const {
    if (options_.memory_limit == 0) return kMostRefinedPlaces;
    return std::min(kMostRefinedPlaces,
                    static_cast<double>(options_.memory_limit) / (2.0 * kBytesPerPlace));
  }

  // Of the attributes. What a sum's colour is depends on its values: it stays the mean.
  std::size_t num_fitted() const {
    return source_.reconstruction == Reconstruction::kSum ? 1 : source_.values.size();
  }

  double range_of(std::size_t attribute) const {
    const ValueRange of = attribute == 0 ? field_.value_range() : field_.color_range();
    const double low = static_cast<double>(of.lo), high = static_cast<double>(of.hi);
    if (high > low) return high - low;
    // Of a constant: what it is rounded by counts next to nothing.
    return std::max({std::abs(low), std::abs(high), 1e-30});
  }

  template <class Blame>
  void fit_to_places(Fitted& fitted, const Care& care, const Blame& blame) {
    const std::size_t count = std::min(places_.seen.count(), care.places);
    const std::span<const double> at = std::span(places_.seen.at).first(3 * count);
    const std::span<const double> shares = std::span(places_.seen.shares).first(count);
    const KernelOperator kernels(fitted.kernels.columns(source_.cutoff), source_.reconstruction, at,
                                 threads_, options_.stop);
    const std::vector<double> masses = masses_of(fitted.kernels);
    const std::vector<std::uint32_t> holes = judge_->holes(places_.seen, kernels);
    std::vector<double> energies(count);
    for (std::size_t a = 0; a < num_fitted(); ++a) {
      const std::span<const double> targets = std::span(places_.seen.targets[a]).first(count);
      fit_values(
          kernels,
          {.targets = targets, .shares = shares, .keeps = masses, .iterations = care.iterations},
          fitted.values[a], options_.stop);
      add_residuals(kernels, a, holes, energies, fitted, blame);
    }
    fitted.energies = kernels.splat(energies);
    blame_for_holes(holes, energies, fitted);
    fitted.step.kernels = static_cast<std::int64_t>(fitted.kernels.weights.size());
    report_.steps.push_back(fitted.step);
  }

  // Of a sum, what the kernels' values are multiplied by in its integral.
  std::vector<double> masses_of(const MergedKernels& kernels) const {
    std::vector<double> masses;
    if (source_.reconstruction != Reconstruction::kSum) return masses;
    for (std::size_t i = 0; i < kernels.weights.size(); ++i) masses.push_back(kernels.mass(i));
    return masses;
  }

  template <class Blame>
  void add_residuals(const KernelOperator& kernels, std::size_t attribute,
                     const std::vector<std::uint32_t>& holes, std::vector<double>& energies,
                     Fitted& fitted, const Blame& blame) const {
    const Places& places = places_.seen;
    const double range = range_of(attribute);
    std::vector<double> residuals = kernels.gather(fitted.values[attribute]);
    double square = 0, share = 0, greatest = 0;
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      residuals[k] = kernels.is_defined(k) ? places.targets[attribute][k] - residuals[k] : 0;
      greatest = std::max(greatest, std::abs(residuals[k]));
    }
    // A hole in another attribute errs by the same share of that attribute's range.
    for (const std::uint32_t hole : holes) residuals[hole] = deviation() * range;
    for (std::size_t k = 0; k < residuals.size(); ++k) {
      energies[k] += blame(residuals[k] / range, places.shares[k]);
      square += places.shares[k] * residuals[k] * residuals[k];
      share += places.shares[k];
    }
    if (attribute != 0) return;
    fitted.step.psnr = psnr_of(report_.range, square / share);
    fitted.step.greatest_error = greatest;
    fitted.residuals = std::move(residuals);
  }

  // No kernel reaches a hole, so the nearest one is to blame.
  void blame_for_holes(const std::vector<std::uint32_t>& holes, const std::vector<double>& energies,
                       Fitted& fitted) const {
    if (holes.empty()) return;
    const auto owners = judge_->owners_of_holes(places_.seen, holes, fitted.kernels);
    for (std::size_t i = 0; i < holes.size(); ++i) {
      if (owners[i] != fit::kNoSite) fitted.energies[owners[i]] += energies[holes[i]];
    }
  }

  static double energy(double residual, double share) { return share * residual * residual; }

  Fitted reach_count(Clusters& clusters, std::int64_t count) {
    start(clusters, std::min(count, std::max(kFirstKernels, count / kFirstShare)));
    while (static_cast<std::int64_t>(clusters.list.size()) < count) {
      const Fitted fitted = fit(clusters, care_of_round(clusters), energy);
      if (halve_greatest(clusters, fitted.energies, next_count(clusters, count)) == 0)
        start(clusters, count);  // no error is left: the rest is as good anywhere
      tell(0.1 + 0.5 * static_cast<double>(clusters.list.size()) / static_cast<double>(count));
    }
    return fit_last(clusters);
  }

  static std::int64_t next_count(const Clusters& clusters, std::int64_t most) {
    const auto now = static_cast<double>(clusters.list.size());
    return std::min(most, static_cast<std::int64_t>(std::ceil(now * kGrowth)));
  }

  void tell_growth(const Clusters& clusters) {
    const double grown = std::log(static_cast<double>(clusters.list.size()) / kFirstKernels);
    const double in_all = std::log(static_cast<double>(all()) / kFirstKernels);
    tell(0.1 + 0.8 * std::clamp(grown / std::max(in_all, 1.0), 0.0, 1.0));
  }

  Fitted reach_psnr(Clusters& clusters, double psnr) {
    start(clusters, std::min(all(), kFirstKernels));
    Clusters before = clusters;
    Fitted missed;
    double gain = options_.refinements > 0 ? kFirstGain : 0;
    while (true) {
      Fitted fitted = fit(clusters, care_of_round(clusters), energy);
      const bool is_last = static_cast<std::int64_t>(clusters.list.size()) == all();
      if (fitted.step.psnr + gain >= psnr || is_last) {
        const Fitted last = fit_last(clusters, fitted);
        if (last.step.psnr >= psnr) return fewest(before, missed, last, psnr);
        if (options_.refinements > 0)
          gain = std::max(kLeastGain, last.step.psnr - fitted.step.psnr);
        fitted.step.psnr = last.step.psnr;
      } else {
        fitted.step.psnr += gain;
      }
      before = clusters;
      missed = std::move(fitted);
      if (halve_greatest(clusters, missed.energies, next_count(clusters, all())) == 0) {
        refuse_fit(fmt::format("psnr = {:g}: all {} kernels reach {:.1f} dB", psnr, all(),
                               missed.step.psnr));
      }
      tell_growth(clusters);
    }
  }

  // Between a miss and a hit, PSNR over the logarithm of the number of kernels is about a line.
  Fitted fewest(const Clusters& before, const Fitted& missed, Fitted hit, double psnr) {
    FitStep low = missed.step, high = hit.step;
    for (int i = 0; i < kMostHalvings && high.psnr > psnr + kCloseEnough; ++i) {
      const double part =
          std::clamp((psnr + 0.3 * kCloseEnough - low.psnr) / (high.psnr - low.psnr), 0.1, 0.9);
      const auto count = static_cast<std::int64_t>(
          std::lround(std::exp(std::lerp(std::log(static_cast<double>(low.kernels)),
                                         std::log(static_cast<double>(high.kernels)), part))));
      if (count <= low.kernels || count >= high.kernels) break;
      Clusters clusters = before;
      halve_greatest(clusters, missed.energies, count);
      Fitted between = fit_last(clusters);
      if (between.step.psnr >= psnr) {
        high = between.step;
        hit = std::move(between);
      } else {
        low = between.step;
      }
    }
    return hit;
  }

  Fitted reach_tolerance(Clusters& clusters, double tolerance) {
    start(clusters, std::min(all(), kFirstKernels));
    double inner = tolerance;  // of the places that the fit sees
    double least = std::numeric_limits<double>::infinity();
    std::optional<Fitted> within;  // the bound, with less to spare than is wanted
    int searches = 0;
    // All places count alike, and those beyond the bound more each time: sums of squares alone
    // would leave single large errors.
    even_ = 1 / static_cast<double>(places_.seen.count());
    std::fill(places_.seen.shares.begin(), places_.seen.shares.end(), even_);
    for (int idle = 0; idle <= kMostIdle;) {
      // Energy is what is over the bound, or nearly.
      const double bound = 0.8 * inner;
      const auto excess = [&](double residual, double /*share*/) {
        const double over = std::max(0.0, std::abs(residual) * report_.range - bound);
        return over * over / (report_.range * report_.range);
      };
      Fitted fitted = fit(clusters, care_of_round(clusters), excess);
      if (fitted.step.greatest_error <= tolerance) fitted = fit(clusters, kAllPlaces, excess);
      if (fitted.step.greatest_error <= tolerance) {
        judge_->close_holes(places_.seen, fitted.kernels, kThin);
        const fit::FitJudge::Worst worst = look_for_worst(fitted);
        if (worst.greatest() <= kBoundBetween * tolerance) return fitted;
        if (worst.greatest() <= tolerance) within = fitted;
        least = std::min(least, worst.greatest());
        inner = std::max(kTightest * tolerance, kTighter * inner);
        see_also(worst, bound);
        idle = 0;
        if (++searches >= (within ? kMostWithin : kMostSearches)) break;
        continue;
      }
      raise_shares(fitted, bound);
      const std::size_t before = clusters.list.size();
      halve_greatest(clusters, fitted.energies, next_count(clusters, all()));
      const auto more = static_cast<double>(clusters.list.size() - before);
      idle = more > kHardlyAny * static_cast<double>(before) ? 0 : idle + 1;
      tell_growth(clusters);
    }
    if (within) return std::move(*within);
    const Fitted last = fit(clusters, kAllPlaces, energy);
    least = std::min(least, look_for_worst(last).greatest());
    const std::string left = std::isfinite(least) ? fmt::format("a greatest error of {:g}", least)
                                                  : "places without a value";
    refuse_fit(fmt::format("tolerance = {:g}: {} of {} kernels leave {}, and more would not help",
                           tolerance, clusters.list.size(), all(), left));
  }

  // Puts the worst places first among those that every round looks at.
  void see_also(const fit::FitJudge::Worst& worst, double bound) {
    Places seen;
    seen.targets.resize(places_.seen.targets.size());
    for (std::size_t i = 0; i < worst.errors.size() && worst.errors[i] > bound; ++i)
      seen.append(worst.places, i, even_);
    for (std::size_t i = 0; i < places_.seen.count(); ++i)
      seen.append(places_.seen, i, places_.seen.shares[i]);
    places_.seen = std::move(seen);
  }

  void raise_shares(const Fitted& fitted, double bound) {
    for (std::size_t k = 0; k < fitted.residuals.size(); ++k) {
      if (std::abs(fitted.residuals[k]) > bound)
        places_.seen.shares[k] = std::min(places_.seen.shares[k] * kRise, kMostRise * even_);
    }
  }

  KernelField field_of(const Fitted& fitted) const {
    KernelColumns columns = fitted.kernels.columns(source_.cutoff);
    std::vector<std::vector<float>> values;
    for (const std::vector<double>& column : fitted.values)
      values.emplace_back(column.begin(), column.end());
    for (const std::vector<float>& column : values) columns.values.emplace_back(column);
    columns.attributes = source_.attributes;
    return {make_kernel_source(columns, threads_), source_.reconstruction, 0,
            values.size() > 1 ? 1 : -1};
  }

  const FitOptions& options_;
  FitReport& report_;
  int threads_ = 1;
  double told_ = 0;
  double even_ = 0;  // share of a place among equals
  MergeRule rule_;
  KernelField field_;
  SourceKernels source_;
  std::unique_ptr<fit::PlaceMaker> place_maker_;
  std::optional<fit::FitJudge> judge_;
  FitPlaces places_;
};

}  // namespace

KernelField fit_kernels(const Dataset& dataset, const FitOptions& options, FitReport* report) {
  FitReport own;
  FitReport& filled = report != nullptr ? *report : own;
  filled = {};
  try {
    return Fitter(dataset, options, filled).run();
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("'{}': no memory to fit kernels", dataset.source));
  }
}

}  // namespace ovoid
