// SPDX-License-Identifier: Apache-2.0
//
// Dataset -> field, for everything but lattices: checks options, sends the dataset its way, sorts
// what comes back into bricks and reports.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "data/kernels/kernel_shape.h"
#include "data/kernels/kernel_sums.h"
#include "data/kernels/some_kernels.h"
#include "data/parallel.h"
#include "model/particles/kernel_parts.h"
#include "model/team/team_bricks.h"
#include "model/team/team_run.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid {

namespace {

constexpr int kLeastNeighbors = 4, kMostNeighbors = 512;
constexpr int kMostPasses = 100;
constexpr std::int64_t kMostReported = 1 << 16;  // kernels looked at for quantiles
constexpr std::int64_t kMostSums = 4096;         // centres where the sum of weights is taken
// Kernels looked at for these: about what 4096 centres take of particles that lie evenly. Where
// very many kernels reach a centre, fewer centres are taken.
constexpr double kMostTerms = 1 << 24;

void check_options(const KernelModelOptions& options) {
  const auto refuse_option = [](const std::string& message) {
    throw Error(ErrorCode::kInvalidArgument, message);
  };
  if (options.neighbors < kLeastNeighbors || options.neighbors > kMostNeighbors)
    refuse_option(fmt::format("neighbors = {}: must be {} to {}", options.neighbors,
                              kLeastNeighbors, kMostNeighbors));
  if (options.amplitude_passes < 0 || options.amplitude_passes > kMostPasses)
    refuse_option(fmt::format("amplitude_passes = {}: must be 0 to {}", options.amplitude_passes,
                              kMostPasses));
  if (options.cutoff && !(*options.cutoff >= 1 && *options.cutoff <= KernelColumns::kMaxCutoff))
    refuse_option(
        fmt::format("cutoff = {}: must be 1 to {:g}", *options.cutoff, KernelColumns::kMaxCutoff));
  if (options.mass && !(*options.mass > 0 && std::isfinite(*options.mass)))
    refuse_option(fmt::format("mass = {}: must be > 0", *options.mass));
}

model::KernelParts parts_of(const model::ModelRun& run) {
  if (run.dataset.kind != DatasetKind::kLattice &&
      model::total_of(run, run.dataset.num_positions()) < 1)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': has no positions", run.dataset.source));
  switch (run.dataset.kind) {
    case DatasetKind::kMesh:
      return model::mesh_kernels(run);
    case DatasetKind::kBoxes:
      return model::box_kernels(run);
    case DatasetKind::kParticles:
      return model::particle_kernels(run);
    case DatasetKind::kKernels:
      return model::stored_kernels(run);
    case DatasetKind::kLattice:
      break;
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("'{}': is a lattice; make_lattice_field() takes it", run.dataset.source));
}

std::array<double, 5> quantiles(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  std::array<double, 5> result{};
  constexpr std::array<double, 5> kShares = {0, 0.05, 0.5, 0.95, 1};
  for (std::size_t q = 0; q < result.size(); ++q)
    result[q] = numbers[static_cast<std::size_t>(
        std::lround(kShares[q] * static_cast<double>(numbers.size() - 1)))];
  return result;
}

// At how many of the places to take the sum of weights: a few are looked at first, for the kernels
// of the bricks that may reach them.
std::size_t affordable_sums(const KernelSource& source, const std::vector<Vec3>& places) {
  constexpr std::size_t kProbes = 16;
  const std::size_t most = std::min<std::size_t>(places.size(), kMostSums);
  double num_terms = 0;
  for (std::size_t probe = 0; probe < kProbes; ++probe) {
    const Vec3& place = places[probe * places.size() / kProbes];
    for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
      if (source.brick(b).support.contains(place)) num_terms += source.brick(b).count;
    }
  }
  const double per_place = num_terms / kProbes + 1;
  return std::clamp<std::size_t>(static_cast<std::size_t>(kMostTerms / per_place),
                                 std::min(most, kProbes), most);
}

// The places of all that are this process's share of the work.
data::PartOfPlaces part_of(const model::ModelRun& run) {
  return run.team == nullptr ? data::PartOfPlaces{}
                             : data::PartOfPlaces{run.team->number(), run.team->count()};
}

// Sizes of kernels spread over all bricks, and where their sum is wanted.
void report_kernels(const model::ModelRun& run, const KernelField& field,
                    KernelModelReport& report) {
  const KernelSource& source = field.source();
  std::vector<double> spacings, ratios;
  std::vector<Vec3> places;
  data::for_some_kernels(
      source, kMostReported, [&](const KernelBrick& brick, const KernelView& view, std::int32_t i) {
        const auto numbers = data::shape_numbers(view, source.shape(), i);
        const Vec3 axes = data::semi_axes(source.shape(), numbers.data());
        spacings.push_back(2 * std::cbrt(axes[0]) * std::cbrt(axes[1]) * std::cbrt(axes[2]));
        ratios.push_back(axes[2] / axes[0]);
        places.push_back(brick.origin + data::offset_of(view, i));
      });
  report.spacings = quantiles(std::move(spacings));
  report.axis_ratios = quantiles(std::move(ratios));
  if (report.constant_mean != 0 || !report.is_normalized) return;
  const std::size_t every =
      std::max<std::size_t>(1, places.size() / affordable_sums(source, places));
  std::vector<Vec3> looked_at;
  for (std::size_t i = 0; i < places.size(); i += every) looked_at.push_back(places[i]);
  const KernelSampler sampler(field);
  std::vector<double> sums;
  for (const Vec3& place : part_of(run).of(looked_at)) sums.push_back(sampler.at(place).weight);
  double count = 0, mean = 0, square = 0;
  for (const double sum : model::joined(run, std::move(sums))) {
    count += 1;
    mean += sum;
    square += sum * sum;
  }
  report.constant_mean = mean / count;
  report.constant_deviation =
      std::sqrt(std::max(0.0, square / count - report.constant_mean * report.constant_mean));
}

void note_on_counts(const Dataset& dataset, KernelModelReport& report) {
  const char* nouns = "kernels";
  if (dataset.kind == DatasetKind::kMesh)
    nouns = dataset.array(report.array).is_cell_data ? "cells" : "nodes";
  if (dataset.kind == DatasetKind::kBoxes) nouns = "boxes";
  if (dataset.kind == DatasetKind::kParticles) nouns = "particles";
  const auto note = [&](std::int64_t count, const std::string& what) {
    if (count > 0)
      report.notes.push_back(fmt::format("{} of {} {} {}", count, report.num_sites, nouns, what));
  };
  note(report.num_missing,
       fmt::format("without a finite value of '{}' make no kernel", report.array));
  note(report.num_misplaced, "without a finite position make no kernel");
  note(report.num_dangling, "of no cell make no kernel");
  note(report.num_merged, "at the place of another share its kernel");
  if (report.num_degenerate > 0)
    report.notes.push_back(
        fmt::format("{} of {} kernels had no extent along some axis and were given one",
                    report.num_degenerate, report.num_kernels));
}

}  // namespace

namespace {

// A sum is sampled by all processes together.
KernelField field_of(const model::ModelRun& run, std::shared_ptr<const KernelSource> source,
                     Reconstruction reconstruction) {
  const int color = source->attributes().size() > 1 ? 1 : -1;
  if (run.team == nullptr || reconstruction != Reconstruction::kSum)
    return {std::move(source), reconstruction, 0, color};
  KernelSums sums;
  sums.stride = data::stride_of_sums(source->num_kernels());
  sums.values.resize(
      static_cast<std::size_t>(data::count_of_every(source->num_kernels(), sums.stride)));
  const KernelField unsampled(source, sums, 0, color);
  sums.values = model::joined(run, data::sums_at_kernels(unsampled, sums.stride, part_of(run)));
  return {std::move(source), std::move(sums), 0, color};
}

// `source_of(parts)`: their kernels in bricks; the parts are not needed any more.
template <class SourceOf>
KernelField modelled(const model::ModelRun& run, const SourceOf& source_of,
                     KernelModelReport* report) {
  const Dataset& dataset = run.dataset;
  KernelModelReport& own = run.report;
  try {
    model::KernelParts parts = parts_of(run);
    const Reconstruction reconstruction = parts.reconstruction;
    own.is_normalized = reconstruction == Reconstruction::kNormalized;
    auto source = source_of(parts);
    parts = {};
    KernelField field = field_of(run, std::move(source), reconstruction);
    own.num_kernels = field.num_kernels();
    own.resident_bytes = field.source().resident_bytes();
    if (report == nullptr) return field;
    report_kernels(run, field, own);
    note_on_counts(dataset, own);
    *report = std::move(own);
    return field;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("'{}': no memory for the kernels of {} positions", dataset.source,
                            dataset.num_positions()));
  }
}

}  // namespace

KernelField make_kernel_field(const Dataset& dataset, const KernelModelOptions& options,
                              KernelModelReport* report, std::stop_token stop) {
  check_options(options);
  KernelModelReport own;
  const model::ModelRun run = {dataset, options, own, data::resolve_threads(options.threads),
                               std::move(stop)};
  return modelled(
      run,
      [&](const model::KernelParts& parts) {
        return make_kernel_source(model::columns_of(parts), run.threads);
      },
      report);
}

KernelField make_team_field(const Dataset& share, const TeamFieldOptions& options,
                            const std::shared_ptr<KernelTeam>& team, KernelModelReport* report,
                            std::stop_token stop) {
  check_options(options.kernels);
  if (!share.share)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': was read whole, expected a share of it", share.source));
  if (!can_be_shared(options.kernels))
    throw Error(ErrorCode::kUnsupported,
                fmt::format("'{}': kernels drawn out by their neighbours, and those of Voronoi "
                            "cells, are not made of shares",
                            share.source));
  KernelModelReport own;
  const model::ModelRun run = {
      share, options.kernels, own, data::resolve_threads(options.kernels.threads), std::move(stop),
      team,  options.surface};
  return modelled(
      run,
      [&](model::KernelParts& parts) {
        for (std::int64_t* const count :
             {&own.num_sites, &own.num_missing, &own.num_misplaced, &own.num_dangling,
              &own.num_merged, &own.num_copies, &own.num_degenerate})
          *count = model::total_of(run, *count);
        return model::share_in_bricks(run, std::move(parts), options.kept_bytes);
      },
      report);
}

bool can_be_shared(const KernelModelOptions& options) noexcept {
  return !options.anisotropic && options.neighborhood != Neighborhood::kVoronoi;
}

}  // namespace ovoid
