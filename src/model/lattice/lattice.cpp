// SPDX-License-Identifier: Apache-2.0
//
// Dataset -> field, for regular lattices: one kernel per sample, all of one shape.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>

#include "data/field_samples.h"
#include "data/lattice/encode_relevant.h"
#include "data/lattice/merged_range.h"
#include "data/lattice/paged_lattice.h"
#include "data/lattice/resident_lattice.h"
#include "data/lattice/run_lattice.h"
#include "data/parallel.h"
#include "data/validate.h"
#include "model/lattice/coefficients.h"
#include "model/lattice/convert.h"
#include "model/lattice/prefilter.h"
#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid {

namespace {

[[noreturn]] void fail(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

// The lattice of the array's samples. Cells lie between points: one fewer per axis, their centres
// half an index on. Along an axis of a single point the cells are flat, and there is one.
LatticeGeometry sample_geometry(const Dataset& dataset, const DataArray& array) {
  LatticeGeometry geometry = dataset.lattice;
  data::validate_geometry(geometry);
  if (!array.is_cell_data) return geometry;
  Vec3 shift = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    if (geometry.dims[axis] == 1) continue;
    geometry.dims[axis] -= 1;
    shift[axis] = 0.5;
  }
  geometry.world_from_index.translate(shift);
  return geometry;
}

// A dataset may come from anywhere, so its sizes are not believed.
void validate_array(const DataArray& array, const LatticeGeometry& geometry) {
  if (array.num_components < 1) {
    fail(fmt::format("array '{}': {} components, must be >= 1", array.name, array.num_components));
  }
  const std::int64_t expected = num_samples(geometry.dims);
  if (array.num_tuples != expected) {
    fail(fmt::format("array '{}': {} tuples, must be {} for a lattice of {} x {} x {} {}",
                     array.name, array.num_tuples, expected, geometry.dims[0], geometry.dims[1],
                     geometry.dims[2], array.is_cell_data ? "cells" : "samples"));
  }
  if (array.stored != nullptr) return;  // PagedLattice looks for itself
  // Compared by division: a product of what a dataset claims may not fit 64 bits.
  const std::size_t tuple_size =
      size_of(array.type) * static_cast<std::size_t>(array.num_components);
  const std::size_t stored = array.bytes.view.size();
  if (stored % tuple_size != 0 || stored / tuple_size != static_cast<std::size_t>(expected)) {
    fail(fmt::format("array '{}': {} bytes, must be {} tuples of {} bytes", array.name, stored,
                     expected, tuple_size));
  }
}

std::string note_on_missing(const DataArray& array, std::int64_t num_missing) {
  return fmt::format("array '{}': {} of {} samples are not finite{} and are treated as missing",
                     array.name, num_missing, array.num_tuples,
                     array.type == ScalarType::kFloat64 ? " or beyond float32's range" : "");
}

struct TakenSamples {
  const LatticeGeometry& geometry;
  const model::ScalarSamples& samples;
  const DataArray& array;
  int threads;
  std::stop_token stop;
};

// A kernel, and whether the field takes the samples' values at the samples.
struct Interpolation {
  LatticeKernel kernel;
  bool is_prefiltered;
  bool keeps_outliers_apart = false;  // which a prefilter would spread over their axes
};

// A few values, or one, thousands of times as far out as all others reach.
bool has_outliers(const BrickSource& samples, const ValueRange& range) {
  constexpr double kFar = 1e4;
  constexpr double kRest = 0.001;  // on either side
  if (samples.acquire(0, 0, 0, 0.0).type != ScalarType::kFloat32) return false;
  const std::vector<float> values = data::take_samples(samples).values;
  if (values.empty()) return false;
  const auto at = [&](double q) {
    return static_cast<double>(
        values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))]);
  };
  const double rest = at(1 - kRest) - at(kRest);
  return rest > 0 && static_cast<double>(range.hi) - range.lo > kFar * rest;
}

Interpolation interpolation_of(const LatticeModelOptions& options, const BrickSource& samples,
                               const ValueRange& range) {
  const auto with = [&](LatticeKernel kernel) -> Interpolation {
    return {kernel, options.prefilter.value_or(kernel.kind == LatticeKernelKind::kBSpline)};
  };
  if (options.kernel) return with(*options.kernel);
  if (!data::labels_of(samples).empty()) return with(LatticeKernel{});
  // A B-spline alone along two axes has less of its weight at its own sample than a field needs.
  const Index3& dims = samples.geometry().dims;
  if (std::find(dims.begin(), dims.end(), 1) != dims.end()) return with(kCatmullRomKernel);
  if (!options.prefilter && samples.geometry().kind == LatticeKind::kCartesian &&
      has_outliers(samples, range)) {
    Interpolation local = with(kCatmullRomKernel);
    local.keeps_outliers_apart = true;
    return local;
  }
  return with(kBSplineKernel);
}

// Coefficients, and the samples that they were made of.
class PrefilteredLattice final : public ResidentLattice {
 public:
  PrefilteredLattice(const TakenSamples& taken, const model::ScalarSamples& coefficients,
                     std::shared_ptr<const ResidentLattice> samples)
      : ResidentLattice(taken.geometry, coefficients.type, coefficients.bytes,
                        {samples->range_reach(), coefficients.value_scale,
                         coefficients.value_offset, taken.threads, taken.stop}),
        samples_(std::move(samples)) {}

  const BrickSource* samples() const noexcept override { return samples_.get(); }
  std::size_t resident_bytes() const noexcept override {
    return ResidentLattice::resident_bytes() + samples_->resident_bytes();
  }

 private:
  std::shared_ptr<const ResidentLattice> samples_;
};

// The samples' coefficients as a lattice of their own.
std::shared_ptr<const ResidentLattice> coefficients_of(
    const TakenSamples& taken, const std::shared_ptr<const ResidentLattice>& samples,
    const ValueRange& range, const LatticeModelOptions& options, const LatticeKernel& kernel) {
  const model::PrefilterOptions prefilter{
      kernel, options.reconstruction, taken.threads, taken.stop, range, samples->num_missing() > 0};
  const bool is_cartesian = taken.geometry.kind == LatticeKind::kCartesian;
  if (is_cartesian && model::have_few_levels(taken.samples, range)) {
    return std::make_shared<PrefilteredLattice>(
        taken, model::make_coefficients(taken.samples, taken.geometry.dims, prefilter), samples);
  }
  const model::ScalarSamples floats = model::take_component(
      taken.array, {options.component, /*as_float32=*/true, taken.threads, taken.stop});
  const std::span<float> values(floats.writable, static_cast<std::size_t>(taken.array.num_tuples));
  (is_cartesian ? model::prefilter : model::prefilter_body_centred)(values, taken.geometry.dims,
                                                                    prefilter);
  return std::make_shared<PrefilteredLattice>(taken, floats, samples);
}

LatticeField field_of_relevant(const TakenSamples& taken, const LatticeModelOptions& options,
                               LatticeModelReport* report) {
  const model::ScalarSamples& samples = taken.samples;
  data::RelevantRuns runs = data::encode_relevant(
      taken.geometry, {samples.type, samples.value_scale, samples.value_offset}, samples.bytes,
      *options.relevant, {taken.threads, taken.stop});
  const std::int64_t num_relevant = runs.num_relevant();
  const LatticeKernel kernel = options.kernel.value_or(LatticeKernel{});
  const auto lattice = std::make_shared<RunLattice>(
      taken.geometry, std::move(runs),
      ResidentLatticeOptions{kernel.support_radius() * taken.geometry.unit_spacing(),
                             samples.value_scale, samples.value_offset, taken.threads, taken.stop});
  const ValueRange range = data::merged_range(*lattice);
  if (range.is_empty())
    fail(fmt::format("array '{}': none of its {} samples is finite", taken.array.name,
                     taken.array.num_tuples));
  if (report != nullptr) {
    *report = {
        taken.array.name, 0, false, lattice->resident_bytes(), taken.array.bytes.view.size(), {}};
    report->notes.push_back(fmt::format(
        "array '{}': {} of {} samples are relevant ({:.1f} %) and kept, {:.3g} MiB",
        taken.array.name, num_relevant, taken.array.num_tuples,
        100.0 * static_cast<double>(num_relevant) / static_cast<double>(taken.array.num_tuples),
        static_cast<double>(report->resident_bytes) / (1 << 20)));
  }
  return {lattice, kernel, options.reconstruction, range};
}

// Of samples in a file: by a kernel that needs no coefficients of all of them.
LatticeField field_of_stored(const DataArray& array, const LatticeGeometry& geometry,
                             const LatticeModelOptions& options, LatticeModelReport* report,
                             int threads, const std::stop_token& stop) {
  if (options.relevant)
    throw Error(
        ErrorCode::kOutOfMemory,
        fmt::format(
            "array '{}': no memory for its {} samples, of which relevant ones could be kept",
            array.name, array.num_tuples));
  if (options.prefilter.value_or(false) ||
      (options.kernel && options.kernel->kind == LatticeKernelKind::kBSpline))
    throw Error(ErrorCode::kOutOfMemory, fmt::format("array '{}': no memory for coefficients of {} "
                                                     "samples; kernels catmull-rom and gaussian "
                                                     "without prefilter need none",
                                                     array.name, array.num_tuples));
  const LatticeKernel published;
  const auto lattice = std::make_shared<const PagedLattice>(
      geometry, array.type, array.stored,
      ResidentLatticeOptions{options.kernel.value_or(published).support_radius(), array.value_scale,
                             array.value_offset, threads, stop},
      options.team);
  const ValueRange range = data::merged_range(*lattice);
  if (range.is_empty())
    fail(fmt::format("array '{}': none of its {} samples is finite", array.name, array.num_tuples));
  const LatticeKernel kernel = options.kernel                      ? *options.kernel
                               : data::labels_of(*lattice).empty() ? kCatmullRomKernel
                                                                   : published;
  if (report != nullptr) {
    *report = {array.name,
               0,
               false,
               lattice->resident_bytes(),
               static_cast<std::size_t>(array.stored->num_bytes()),
               {}};
    report->notes.push_back(fmt::format(
        "array '{}': {} samples are read from a file when they are needed, as memory is for {:.3g} "
        "GiB of them; kernel {}",
        array.name, array.num_tuples,
        static_cast<double>(array.stored->memory_for_pages()) / (1 << 30), name_of(kernel.kind)));
  }
  return {lattice, kernel, options.reconstruction, range};
}

}  // namespace

LatticeField make_lattice_field(const Dataset& dataset, const LatticeModelOptions& options,
                                LatticeModelReport* report, std::stop_token stop) {
  if (options.kernel) data::validate_kernel(*options.kernel);
  const int threads = data::resolve_threads(options.threads);
  if (dataset.kind != DatasetKind::kLattice) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': is no lattice but {}; make_kernel_field() takes it",
                            dataset.source, name_of(dataset.kind)));
  }
  const DataArray& array = dataset.array(options.array);
  const LatticeGeometry geometry = sample_geometry(dataset, array);
  validate_array(array, geometry);
  const bool asks_for_prefilter = options.prefilter.value_or(
      options.kernel && options.kernel->kind == LatticeKernelKind::kBSpline);
  if (asks_for_prefilter && options.relevant)
    throw Error(ErrorCode::kUnsupported,
                "prefilter: is for fields of all samples, not of relevant ones");
  if (asks_for_prefilter && options.kernel && geometry.kind == LatticeKind::kCartesian)
    model::require_interpolating(*options.kernel);

  try {
    if (array.stored != nullptr)
      return field_of_stored(array, geometry, options, report, threads, stop);
    const model::ScalarSamples samples =
        model::take_component(array, {options.component, /*as_float32=*/false, threads, stop});
    const TakenSamples taken{geometry, samples, array, threads, stop};
    if (options.relevant) return field_of_relevant(taken, options, report);
    // All kernels but Gaussians that somebody names reach as far as the published one.
    const double reach = options.kernel.value_or(LatticeKernel{}).support_radius();
    auto lattice = std::make_shared<const ResidentLattice>(
        geometry, samples.type, samples.bytes,
        ResidentLatticeOptions{reach * geometry.unit_spacing(), samples.value_scale,
                               samples.value_offset, threads, stop});
    if (lattice->num_missing() == array.num_tuples) {
      fail(fmt::format("array '{}': none of its {} samples is finite", array.name,
                       array.num_tuples));
    }
    const std::int64_t num_missing = lattice->num_missing();
    const ValueRange range = data::merged_range(*lattice);
    const auto [kernel, is_prefiltered, keeps_outliers_apart] =
        interpolation_of(options, *lattice, range);
    if (is_prefiltered) lattice = coefficients_of(taken, lattice, range, options, kernel);
    LatticeField field(lattice, kernel, options.reconstruction, range);
    if (report != nullptr) {
      *report = {array.name,
                 num_missing,
                 is_prefiltered,
                 lattice->resident_bytes(),
                 array.bytes.view.size(),
                 {}};
      if (keeps_outliers_apart) {
        report->notes.push_back(
            fmt::format("array '{}': a few values lie thousands of times as far out as all others; "
                        "kernel catmull-rom, lest they spread along their rows",
                        array.name));
      }
      if (report->num_missing > 0) {
        report->notes.push_back(note_on_missing(array, report->num_missing));
      }
    }
    return field;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("array '{}': no memory for a field of {} samples", array.name,
                            array.num_tuples));
  }
}

}  // namespace ovoid
