// SPDX-License-Identifier: Apache-2.0
//
// Dataset -> field, for regular lattices: one kernel per sample, all of one shape.
#include <fmt/format.h>

#include <memory>
#include <new>

#include "data/encode_relevant.h"
#include "data/merged_range.h"
#include "data/parallel.h"
#include "data/resident_lattice.h"
#include "data/run_lattice.h"
#include "data/validate.h"
#include "model/convert.h"
#include "model/prefilter.h"
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

LatticeField field_of_relevant(const TakenSamples& taken, const LatticeModelOptions& options,
                               LatticeModelReport* report) {
  const model::ScalarSamples& samples = taken.samples;
  data::RelevantRuns runs = data::encode_relevant(
      taken.geometry, {samples.type, samples.value_scale, samples.value_offset}, samples.bytes,
      *options.relevant, {taken.threads, taken.stop});
  const std::int64_t num_relevant = runs.num_relevant();
  const auto lattice = std::make_shared<RunLattice>(
      taken.geometry, std::move(runs),
      ResidentLatticeOptions{options.kernel.support_radius() * taken.geometry.unit_spacing(),
                             samples.value_scale, samples.value_offset, taken.threads, taken.stop});
  const ValueRange range = data::merged_range(*lattice);
  if (range.is_empty())
    fail(fmt::format("array '{}': none of its {} samples is finite", taken.array.name,
                     taken.array.num_tuples));
  if (report != nullptr) {
    *report = {taken.array.name, 0, lattice->resident_bytes(), taken.array.bytes.view.size(), {}};
    report->notes.push_back(fmt::format(
        "array '{}': {} of {} samples are relevant ({:.1f} %) and kept, {:.3g} MiB",
        taken.array.name, num_relevant, taken.array.num_tuples,
        100.0 * static_cast<double>(num_relevant) / static_cast<double>(taken.array.num_tuples),
        static_cast<double>(report->resident_bytes) / (1 << 20)));
  }
  return {lattice, options.kernel, options.reconstruction, range};
}

}  // namespace

LatticeField make_lattice_field(const Dataset& dataset, const LatticeModelOptions& options,
                                LatticeModelReport* report, std::stop_token stop) {
  data::validate_kernel(options.kernel);
  const int threads = data::resolve_threads(options.threads);
  if (options.prefilter) model::require_interpolating(options.kernel);
  if (dataset.kind != DatasetKind::kLattice) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': is no lattice but {}; make_kernel_field() takes it",
                            dataset.source, name_of(dataset.kind)));
  }
  const DataArray& array = dataset.array(options.array);
  const LatticeGeometry geometry = sample_geometry(dataset, array);
  validate_array(array, geometry);
  if (options.prefilter && geometry.kind != LatticeKind::kCartesian) {
    throw Error(ErrorCode::kUnsupported,
                "prefilter: is for cartesian lattices, whose axes can be filtered one by one");
  }

  if (options.prefilter && options.relevant)
    throw Error(ErrorCode::kUnsupported,
                "prefilter: is for fields of all samples, not of relevant ones");

  try {
    const model::ScalarSamples samples =
        model::take_component(array, {options.component, options.prefilter, threads, stop});
    const auto in_bricks = [&] {
      return std::make_shared<ResidentLattice>(
          geometry, samples.type, samples.bytes,
          ResidentLatticeOptions{options.kernel.support_radius() * geometry.unit_spacing(),
                                 samples.value_scale, samples.value_offset, threads, stop});
    };
    if (options.relevant) {
      return field_of_relevant({geometry, samples, array, threads, stop}, options, report);
    }
    auto lattice = in_bricks();
    if (lattice->num_missing() == array.num_tuples) {
      fail(fmt::format("array '{}': none of its {} samples is finite", array.name,
                       array.num_tuples));
    }
    const ValueRange value_range = data::merged_range(*lattice);
    if (options.prefilter) {
      model::prefilter({samples.writable, static_cast<std::size_t>(array.num_tuples)},
                       geometry.dims, {options.kernel, options.reconstruction, threads, stop});
      lattice = in_bricks();
    }
    LatticeField field(lattice, options.kernel, options.reconstruction, value_range);
    if (report != nullptr) {
      *report = {array.name,
                 lattice->num_missing(),
                 lattice->resident_bytes(),
                 array.bytes.view.size(),
                 {}};
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
