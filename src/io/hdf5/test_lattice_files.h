// SPDX-License-Identifier: Apache-2.0
// For tests of lattice files: small lattices, steps, and what an error says of a file.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "data/scalar_visit.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"

namespace ovoid::io {

inline Affine3 oblique() {
  Affine3 place = Affine3::Identity();
  place.linear() << 0.5, 0.125, 0, 0, -2, 0.25, 0.0625, 0, 3;
  place.translation() = Vec3(1e6, -2.5, 0.1);
  return place;
}

// Samples that differ, of any type: i * i modulo 251, floats with a fraction.
inline DataArray array_of(const std::string& name, ScalarType type, std::int64_t count,
                          int num_components = 1, int seed = 0) {
  return data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    std::vector<T> values;
    for (std::int64_t i = 0; i < count * num_components; ++i) {
      const auto value = static_cast<double>((i + seed) * (i + seed) % 251);
      values.push_back(static_cast<T>(std::is_floating_point_v<T> ? value / 8 - 3
                                      : std::is_signed_v<T>       ? value - 125
                                                                  : value));
    }
    return make_array(name, type, values, num_components);
  });
}

inline Dataset lattice_dataset(const Index3& dims, LatticeKind kind = LatticeKind::kCartesian) {
  Dataset dataset;
  dataset.lattice = {dims, oblique(), kind};
  dataset.space = Space::kLps;
  dataset.arrays = {array_of("density", ScalarType::kFloat32, num_samples(dims))};
  return dataset;
}

inline void expect_same_array(const DataArray& a, const DataArray& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.num_components, b.num_components);
  EXPECT_EQ(a.num_tuples, b.num_tuples);
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.value_scale, b.value_scale);
  EXPECT_EQ(a.value_offset, b.value_offset);
  EXPECT_EQ(values_of<std::uint8_t>(a), values_of<std::uint8_t>(b)) << a.name;
}

inline std::string lattice_error(const std::string& path, const ReadOptions& options = {}) {
  const std::string message = error_of([&] { read_dataset({path}, options); });
  const auto at = message.find(path);
  return at == std::string::npos ? message
                                 : message.substr(0, at) + "F" + message.substr(at + path.size());
}

inline LatticeFileHeader series_header(SeriesKind series, std::vector<double> times) {
  LatticeFileHeader header;
  header.lattice = {{4, 3, 2}, oblique(), LatticeKind::kCartesian};
  header.series = series;
  header.arrays = {{"a", ScalarType::kUInt16, 1, "K", 0.5, 1},
                   {"b", ScalarType::kFloat32, 2, "", 1, 0}};
  header.times = std::move(times);
  header.time_unit = "ms";
  return header;
}

inline Dataset step_of(std::int64_t step) {
  Dataset dataset;
  const auto seed = static_cast<int>(step) + 1;
  dataset.arrays = {array_of("a", ScalarType::kUInt16, 24, 1, seed),
                    array_of("b", ScalarType::kFloat32, 24, 2, seed)};
  return dataset;
}

inline void write_runs(const Dataset& dataset, const std::string& path,
                       std::optional<double> background = {}) {
  LatticeFileHeader header = lattice_file_header(dataset);
  header.relevant = RelevantSamples{0, background};
  LatticeFileWriter writer(path, header);
  writer.write_step(dataset);
  writer.finish();
}

}  // namespace ovoid::io
