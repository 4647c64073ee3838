// SPDX-License-Identifier: Apache-2.0
//
// Steps -> band-limited in space and time -> spline coefficients along time, held in memory -> one
// step of the result at a time: four of them blended, then brought to the step's lattice, axis
// after axis.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <utility>

#include "model/lattice/band_limit.h"
#include "model/lattice/convert.h"
#include "model/lattice/even_steps.h"
#include "model/lattice/lattice_samples.h"
#include "model/lattice/lines.h"
#include "model/lattice/spline.h"
#include "model/time/lattice_steps.h"
#include "ovoid/error.h"
#include "ovoid/resample.h"

namespace ovoid {
namespace {

[[noreturn]] void refuse_series(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

class ResampledSeries final : public model::LatticeSteps {
 public:
  ResampledSeries(const Series& series, SeriesKind kind, const SeriesResampleOptions& options)
      : LatticeSteps(kind, series.source().name()), options_(options) {
    if (series.num_steps() < 2)
      refuse_series(fmt::format("{}: has one step, a lattice in time takes two", name()));
    if (series.source().kind() != SeriesKind::kSteps)
      refuse_series(fmt::format("{}: is staggered already", name()));
    model::require_even_steps(series);
    num_input_steps_ = series.num_steps();
    load(series);
    if (options_.lattice.band_limit) limit_band();
    along_time(num_input_steps_, [](std::span<const float> from, std::span<float> to) {
      thread_local std::vector<double> line;
      line.assign(from.begin(), from.end());
      model::to_spline_coefficients(line);
      std::transform(line.begin(), line.end(), to.begin(),
                     [](double c) { return static_cast<float>(c); });
    });
    place_steps(series.times());
  }

 private:
  std::int64_t volume() const { return num_samples(input_.dims); }

  Dataset make(std::int64_t step, const LatticeGeometry& lattice,
               const std::stop_token& stop) const override {
    const auto at = static_cast<std::size_t>(step);
    const model::SplineTaps taps(num_input_steps_, std::span(&places_[at], 1));
    std::vector<float> blend(static_cast<std::size_t>(volume()));
    std::vector<double> weights(static_cast<std::size_t>(num_input_steps_), 0.0);
    taps.add_weights(0, weights);
    for (std::size_t t = 0; t < weights.size(); ++t) {
      if (weights[t] == 0) continue;
      const auto weight = static_cast<float>(weights[t]);
      const float* from = coefficients_.data() + static_cast<std::int64_t>(t) * volume();
      for (std::size_t i = 0; i < blend.size(); ++i) blend[i] += weight * from[i];
    }
    Dataset out;
    out.source = name();
    out.format = "resampled";
    out.space = space_;
    const std::vector<float> values =
        model::at_lattice(blend, input_, lattice, {options_.lattice.threads, stop});
    DataArray array = array_;
    array.num_tuples = num_samples(lattice.dims);
    array.bytes = model::stored_as(array.type, values);
    out.arrays.push_back(std::move(array));
    return out;
  }

  void load(const Series& series) {
    for (std::int64_t step = 0; step < num_input_steps_; ++step) {
      const auto dataset = series.step(step, options_.lattice.stop);
      const DataArray& array = dataset->array(options_.lattice.array);
      if (step == 0) {
        model::require_point_lattice(*dataset, array);
        input_ = dataset->lattice;
        space_ = dataset->space;
        const double bytes = 2.0 * sizeof(float) * static_cast<double>(volume()) *
                             static_cast<double>(num_input_steps_);
        if (bytes > static_cast<double>(options_.memory_limit))
          throw Error(ErrorCode::kOutOfMemory,
                      fmt::format("{}: resampling in time takes {:.1f} GiB, more than the limit of "
                                  "{:.1f} GiB",
                                  name(), bytes / (1 << 30),
                                  static_cast<double>(options_.memory_limit) / (1 << 30)));
        coefficients_.reserve(static_cast<std::size_t>(volume() * num_input_steps_));
      }
      const model::ScalarSamples samples = model::take_component(
          array, {options_.component, false, options_.lattice.threads, options_.lattice.stop});
      if (step == 0) {
        array_ = array;
        array_.bytes = {};
        array_.num_components = 1;
        array_.type = samples.type;
        array_.value_scale = samples.value_scale;
        array_.value_offset = samples.value_offset;
      }
      const std::vector<float> values = model::as_floats(samples, array.num_tuples);
      if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }))
        refuse_series(
            fmt::format("{}: step {} has samples that are missing; resampling in time "
                        "takes none that lack any",
                        name(), step));
      coefficients_.insert(coefficients_.end(), values.begin(), values.end());
      if (options_.lattice.progress)
        options_.lattice.progress(0.5 * static_cast<double>(step + 1) /
                                  static_cast<double>(num_input_steps_));
    }
  }

  // The samples as a volume whose last axis is time.
  void along_time(std::int64_t size, const model::LineTransform& transform) {
    coefficients_ = model::transform_lines(
        coefficients_, {input_.dims[0] * input_.dims[1], input_.dims[2], num_input_steps_}, size,
        transform, {2, options_.lattice.threads, options_.lattice.stop});
  }

  void limit_band() {
    const model::BandLimit limit{0.5 / options_.lattice.spacing, options_.lattice.threads,
                                 options_.lattice.stop};
    model::limit_band_in_time(coefficients_, input_.dims, num_input_steps_, limit);
  }

  void place_steps(const std::vector<double>& input_times) {
    const double spacing = options_.lattice.spacing;
    const double step = kind() == SeriesKind::kStaggered ? spacing / std::numbers::sqrt2 : spacing;
    const auto last = static_cast<double>(num_input_steps_ - 1);
    const auto count = static_cast<std::int64_t>(std::floor(last / step + 1e-9)) + 1;
    const double distance = (input_times.back() - input_times.front()) / last;
    std::vector<double> times;
    for (std::int64_t i = 0; i < count; ++i) {
      places_.push_back(static_cast<double>(i) * step);
      times.push_back(input_times.front() + distance * places_.back());
    }
    set_steps(step_lattice(input_, kind(), spacing), std::move(times));
  }

  SeriesResampleOptions options_;
  std::int64_t num_input_steps_ = 0;
  LatticeGeometry input_;
  Space space_ = Space::kNone;
  DataArray array_;                  // without samples
  std::vector<float> coefficients_;  // [step][z][y][x]
  std::vector<double> places_;       // of the result's steps, in steps of the input
};

}  // namespace

LatticeGeometry step_lattice(const LatticeGeometry& cartesian, SeriesKind kind, double spacing) {
  if (kind == SeriesKind::kSteps) return cartesian_like(cartesian, spacing);
  LatticeGeometry lattice = body_centred_like(cartesian, spacing);
  lattice.dims = lattice.dims_of(0);
  lattice.kind = LatticeKind::kCartesian;
  return lattice;
}

std::shared_ptr<const StepSource> resample_series(const Series& series, SeriesKind kind,
                                                  const SeriesResampleOptions& options) {
  try {
    return std::make_shared<ResampledSeries>(series, kind, options);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("{}: no memory to resample it in time", series.source().name()));
  }
}

}  // namespace ovoid
