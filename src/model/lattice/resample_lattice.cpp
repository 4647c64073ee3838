// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "model/lattice/band_limit.h"
#include "model/lattice/convert.h"
#include "model/lattice/holes.h"
#include "model/lattice/lattice_samples.h"
#include "ovoid/error.h"
#include "ovoid/resample.h"

namespace ovoid {
namespace {

// NaN where the nearest sample was missing.
void restore_holes(const std::vector<bool>& missing, const LatticeGeometry& from,
                   const LatticeGeometry& to, std::vector<float>& samples) {
  const Affine3 from_to = from.world_from_index.inverse() * to.world_from_index;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < to.dims[2]; ++k) {
    for (std::int64_t j = 0; j < to.dims[1]; ++j) {
      for (std::int64_t i = 0; i < to.dims[0]; ++i, ++at) {
        const Vec3 place = from_to * to.index_position({i, j, k});
        std::int64_t nearest = 0;
        for (int a = 2; a >= 0; --a) {
          const std::int64_t n = from.dims[static_cast<std::size_t>(a)];
          nearest = nearest * n + std::clamp<std::int64_t>(std::llround(place[a]), 0, n - 1);
        }
        if (missing[static_cast<std::size_t>(nearest)])
          samples[at] = std::numeric_limits<float>::quiet_NaN();
      }
    }
  }
}

// Of stored numbers.
std::vector<float> resampled(std::vector<float> samples, const LatticeGeometry& from,
                             const LatticeGeometry& to, const LatticeResampleOptions& options) {
  const std::vector<bool> missing = model::fill_missing(samples, from.dims, options.stop);
  if (options.band_limit)
    model::limit_band(samples, from.dims, {0.5 / options.spacing, options.threads, options.stop});
  std::vector<float> out = model::at_lattice(samples, from, to, {options.threads, options.stop});
  if (!missing.empty()) restore_holes(missing, from, to, out);
  return out;
}

// Component by component, which lie side by side in the result.
DataArray resampled(const DataArray& array, const LatticeGeometry& from, const LatticeGeometry& to,
                    const LatticeResampleOptions& options) {
  DataArray out = array;
  out.num_tuples = num_samples(to.dims);
  const auto count = static_cast<std::size_t>(array.num_components);
  std::vector<float> tuples(count * static_cast<std::size_t>(out.num_tuples));
  for (int c = 0; c < array.num_components; ++c) {
    const model::ScalarSamples samples =
        model::take_component(array, {c, false, options.threads, options.stop});
    const std::vector<float> values =
        resampled(model::as_floats(samples, array.num_tuples), from, to, options);
    for (std::size_t i = 0; i < values.size(); ++i)
      tuples[i * count + static_cast<std::size_t>(c)] = values[i];
    out.type = samples.type;
    out.value_scale = samples.value_scale;
    out.value_offset = samples.value_offset;
  }
  out.bytes = model::stored_as(out.type, tuples);
  return out;
}

std::vector<const DataArray*> arrays_to_resample(const Dataset& dataset, const std::string& name) {
  if (!name.empty()) return {&dataset.array(name)};
  std::vector<const DataArray*> arrays;
  for (const DataArray& array : dataset.arrays) {
    if (!array.is_cell_data) arrays.push_back(&array);
  }
  if (arrays.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': has no array of the lattice's points", dataset.source));
  }
  return arrays;
}

}  // namespace

Dataset resample_lattice(const Dataset& dataset, LatticeKind kind,
                         const LatticeResampleOptions& options) {
  const std::vector<const DataArray*> arrays = arrays_to_resample(dataset, options.array);
  for (const DataArray* array : arrays) model::require_point_lattice(dataset, *array);
  Dataset out;
  out.source = dataset.source;
  out.format = "resampled";
  out.space = dataset.space;
  out.lattice = kind == LatticeKind::kBodyCentred
                    ? body_centred_like(dataset.lattice, options.spacing)
                    : cartesian_like(dataset.lattice, options.spacing);
  try {
    for (const DataArray* array : arrays) {
      out.arrays.push_back(resampled(*array, dataset.lattice, out.lattice, options));
      if (options.progress)
        options.progress(static_cast<double>(out.arrays.size()) /
                         static_cast<double>(arrays.size()));
    }
  } catch (const std::bad_alloc&) {
    throw Error(
        ErrorCode::kOutOfMemory,
        fmt::format("'{}': no memory to resample {} x {} x {} samples", dataset.source,
                    dataset.lattice.dims[0], dataset.lattice.dims[1], dataset.lattice.dims[2]));
  }
  return out;
}

}  // namespace ovoid
