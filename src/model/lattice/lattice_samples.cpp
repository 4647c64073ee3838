// SPDX-License-Identifier: Apache-2.0
//
// Samples -> spline coefficients -> samples of each sublattice, axis after axis: sublattices are
// Cartesian and parallel to the input's axes, so that lines are all it takes.
#include "model/lattice/lattice_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "data/scalar_visit.h"
#include "model/lattice/lines.h"
#include "model/lattice/spline.h"
#include "ovoid/error.h"

namespace ovoid::model {
namespace {

// Where samples of a sublattice lie along one axis, in samples of the source from its first.
std::vector<double> places_along(const LatticeGeometry& to, const LatticeGeometry& from,
                                 int sublattice, int axis) {
  const Affine3 from_to = from.world_from_index.inverse() * to.world_from_index;
  const std::int64_t count = to.dims_of(sublattice)[static_cast<std::size_t>(axis)];
  std::vector<double> out;
  for (std::int64_t i = 0; i < count; ++i) {
    const double index = static_cast<double>(i) + to.offset_of(sublattice)[axis];
    out.push_back(from_to.linear()(axis, axis) * index + from_to.translation()[axis]);
  }
  return out;
}

std::vector<float> sublattice_samples(std::span<const float> samples, const LatticeGeometry& from,
                                      const LatticeGeometry& to, int s,
                                      const PlaceOptions& options) {
  std::vector<float> out;
  Index3 dims = from.dims;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const std::vector<double> places = places_along(to, from, s, a);
    const SplineTaps taps(dims[axis], places);
    out = transform_lines(a == 0 ? samples : std::span<const float>(out), dims,
                          static_cast<std::int64_t>(taps.size()),
                          [&](std::span<const float> line, std::span<float> result) {
                            thread_local std::vector<double> coefficients;
                            coefficients.assign(line.begin(), line.end());
                            to_spline_coefficients(coefficients);
                            for (std::size_t i = 0; i < result.size(); ++i)
                              result[i] = static_cast<float>(taps.at(i, coefficients));
                          },
                          {a, options.threads, options.stop});
    dims[axis] = static_cast<std::int64_t>(taps.size());
  }
  return out;
}

}  // namespace

void require_point_lattice(const Dataset& dataset, const DataArray& array) {
  const auto refuse = [](const std::string& message) {
    throw Error(ErrorCode::kInvalidArgument, message);
  };
  if (dataset.kind != DatasetKind::kLattice || dataset.lattice.kind != LatticeKind::kCartesian)
    refuse(fmt::format("'{}': must be a cartesian lattice", dataset.source));
  if (array.is_cell_data)
    refuse(fmt::format("array '{}': is of cells, must be of points", array.name));
  if (array.num_components < 1 || array.num_tuples != num_samples(dataset.lattice.dims))
    refuse(fmt::format("array '{}': {} tuples, must be {}", array.name, array.num_tuples,
                       num_samples(dataset.lattice.dims)));
}

std::vector<float> as_floats(const ScalarSamples& samples, std::int64_t count) {
  std::vector<float> out(static_cast<std::size_t>(count));
  data::visit_scalar(samples.type, [&]<class T>(std::type_identity<T>) {
    for (std::int64_t i = 0; i < count; ++i)
      out[static_cast<std::size_t>(i)] =
          static_cast<float>(data::load_scalar<T>(samples.bytes.view.data(), i));
  });
  return out;
}

Bytes stored_as(ScalarType type, std::span<const float> values) {
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    const auto memory = std::make_shared_for_overwrite<T[]>(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      if constexpr (std::is_floating_point_v<T>) {
        memory[i] = static_cast<T>(values[i]);
      } else {
        constexpr auto kLo = static_cast<double>(std::numeric_limits<T>::lowest());
        constexpr auto kHi = static_cast<double>(std::numeric_limits<T>::max());
        memory[i] =
            static_cast<T>(std::llround(std::clamp(static_cast<double>(values[i]), kLo, kHi)));
      }
    }
    return Bytes{memory, std::as_bytes(std::span<const T>(memory.get(), values.size()))};
  });
}

std::vector<float> at_lattice(std::span<const float> samples, const LatticeGeometry& from,
                              const LatticeGeometry& to, const PlaceOptions& options) {
  const int count = to.num_sublattices();
  if (count == 1) return sublattice_samples(samples, from, to, 0, options);
  std::vector<float> out(static_cast<std::size_t>(num_samples(to.dims)));
  const std::int64_t layer = to.dims[0] * to.dims[1];
  for (int s = 0; s < count; ++s) {
    const std::vector<float> own = sublattice_samples(samples, from, to, s, options);
    for (std::int64_t z = 0; z < to.dims_of(s)[2]; ++z)
      std::copy_n(own.begin() + z * layer, layer, out.begin() + (z * count + s) * layer);
  }
  return out;
}

}  // namespace ovoid::model
