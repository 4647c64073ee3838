// SPDX-License-Identifier: Apache-2.0
//
// Steps -> fields, kept -> their blend at a time, brick by brick as it is drawn.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <utility>

#include "data/lattice/blended_lattice.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid {
namespace {

// For the field of one half, which knows nothing of the shift between the two: of it only the
// samples are taken, and the ranges of those in reach of this kernel.
LatticeKernel kernel_in_half(const LatticeKernel& kernel, double unit_spacing) {
  const double reach = kernel.support_radius() * unit_spacing + 0.5;
  const double sigma = std::max(LatticeKernel::kMinSigma, reach / LatticeKernel::kMaxCutoff);
  return {sigma, reach / sigma};
}

constexpr double kUnitSpacingOfHalves = 0.5 * std::numbers::sqrt2;  // of the two together

}  // namespace

struct SliceFields::Impl {
  Impl(const Series& of, LatticeModelOptions how, const TimeSliceOptions& slice)
      : series(of), model(std::move(how)), options(slice) {}

  const Series& series;
  LatticeModelOptions model;
  TimeSliceOptions options;
  std::map<std::int64_t, LatticeField> fields;  // of the last slice's steps

  // Coefficients of halves are those of their whole, which has to be made; so is what alternates.
  bool takes_volumes() const {
    const bool is_prefiltered =
        !model.relevant && model.prefilter.value_or(
                               !model.kernel || model.kernel->kind == LatticeKernelKind::kBSpline);
    return is_staggered() && (is_prefiltered || options.filter == TimeFilter::kFourSteps);
  }

  bool is_staggered() const { return series.source().kind() == SeriesKind::kStaggered; }

  std::vector<StepWeight> weights(int half, double time) const {
    return is_staggered() ? weights_of_half(series.times(), half, time, options.filter)
                          : weights_of_steps(series.times(), time);
  }

  void keep_only(const std::array<std::vector<StepWeight>, 2>& wanted) {
    std::erase_if(fields, [&](const auto& entry) {
      return std::none_of(wanted.begin(), wanted.end(), [&](const auto& weights) {
        return std::any_of(weights.begin(), weights.end(),
                           [&](const StepWeight& w) { return w.step == entry.first; });
      });
    });
  }

  const LatticeField& field_of(std::int64_t step) {
    const auto kept = fields.find(step);
    if (kept != fields.end()) return kept->second;
    const auto dataset = series.step(step, options.stop);
    LatticeModelOptions how = model;
    // All steps have the first one's kernel.
    if (!fields.empty() && !is_staggered()) how.kernel = fields.begin()->second.kernel();
    if (is_staggered())
      how.kernel = kernel_in_half(model.kernel.value_or(LatticeKernel{}), kUnitSpacingOfHalves);
    return fields.emplace(step, make_lattice_field(*dataset, how, nullptr, options.stop))
        .first->second;
  }
};

SliceFields::SliceFields(const Series& series, LatticeModelOptions model,
                         const TimeSliceOptions& options)
    : impl_(std::make_unique<Impl>(series, std::move(model), options)) {
  if (options.filter == TimeFilter::kExact && impl_->is_staggered())
    throw Error(ErrorCode::kInvalidArgument,
                "filter = exact: sums over space, too; slice_at_time() makes such slices");
}

SliceFields::~SliceFields() = default;
SliceFields::SliceFields(SliceFields&&) noexcept = default;
SliceFields& SliceFields::operator=(SliceFields&&) noexcept = default;

LatticeField SliceFields::at(double time) {
  if (impl_->takes_volumes())
    return make_lattice_field(slice_at_time(impl_->series, time, impl_->options), impl_->model,
                              nullptr, impl_->options.stop);
  const int halves = impl_->is_staggered() ? 2 : 1;
  std::array<std::vector<StepWeight>, 2> weights;
  for (int half = 0; half < halves; ++half)
    weights[static_cast<std::size_t>(half)] = impl_->weights(half, time);
  impl_->keep_only(weights);
  if (halves == 1 && weights[0].size() == 1) return impl_->field_of(weights[0][0].step);

  std::array<std::vector<BlendedLattice::Part>, 2> parts;
  std::array<std::vector<BlendedLattice::Part>, 2> samples;
  bool knows_samples = true;
  for (std::size_t half = 0; half < 2; ++half) {
    for (const auto& [step, weight] : weights[half]) {
      const auto field = std::make_shared<LatticeField>(impl_->field_of(step));
      parts[half].push_back({{field, &field->source()}, weight});
      samples[half].push_back({{field, &field->samples()}, weight});
      knows_samples = knows_samples && field->source().samples() != nullptr;
    }
  }
  // That of an even step, whose samples are at whole indices.
  const LatticeField& first = impl_->field_of(weights[0][0].step);
  LatticeGeometry geometry = first.geometry();
  LatticeKernel kernel = first.kernel();
  if (halves == 2) {
    geometry.kind = LatticeKind::kBodyCentred;
    geometry.dims[2] *= 2;
    kernel = impl_->model.kernel.value_or(LatticeKernel{});
  }
  const double reach = kernel.support_radius() * geometry.unit_spacing();
  std::shared_ptr<const BrickSource> blended_samples;
  if (knows_samples)
    blended_samples = std::make_shared<BlendedLattice>(geometry, std::move(samples), reach);
  return {std::make_shared<BlendedLattice>(geometry, std::move(parts), reach,
                                           std::move(blended_samples)),
          kernel, impl_->model.reconstruction};
}

}  // namespace ovoid
