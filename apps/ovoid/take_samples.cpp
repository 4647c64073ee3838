// SPDX-License-Identifier: Apache-2.0
#include "take_samples.h"

#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "ovoid/sampler.h"

namespace ovoid::cli {
namespace {

// For so many places a lattice is not copied.
constexpr std::size_t kFewPlaces = 4096;

// Evaluates a field at some places.
std::function<FieldSample(const Vec3&)> sampler_of(const Field& field, std::size_t num_places) {
  if (num_places <= kFewPlaces)
    return [probe = std::make_shared<FieldProbe>(field)](const Vec3& at) { return probe->at(at); };
  return [all = std::make_shared<FieldSampler>(field)](const Vec3& at) { return all->at(at); };
}

Vec3 place_of(const DataArray& positions, std::int64_t index) {
  const std::byte* const at = positions.bytes.view.data();
  const auto load = [&]<class T>(T) {
    T stored[3];
    std::memcpy(stored, at + index * static_cast<std::int64_t>(sizeof(stored)), sizeof(stored));
    return Vec3(stored[0], stored[1], stored[2]);
  };
  return positions.type == ScalarType::kFloat32 ? load(float{}) : load(double{});
}

template <class T>
DataArray column(const char* name, ScalarType type, const std::shared_ptr<std::vector<T>>& values) {
  DataArray array;
  array.name = name;
  array.type = type;
  array.num_tuples = static_cast<std::int64_t>(values->size());
  array.bytes = {values, std::as_bytes(std::span(*values))};
  return array;
}

}  // namespace

Dataset take_samples(const Dataset& points, const Field& field, Session& session,
                     const std::function<void(double)>& progress) {
  const KernelField* const set = field.kernels();
  const bool has_color = set != nullptr && set->has_own_color();
  using Column = std::shared_ptr<std::vector<double>>;
  const auto count = static_cast<std::size_t>(points.num_positions());
  const auto make = [&] { return std::make_shared<std::vector<double>>(count); };
  const Column value = make(), gx = make(), gy = make(), gz = make(), weight = make();
  const Column color = has_color ? make() : nullptr;
  const auto defined = std::make_shared<std::vector<std::uint8_t>>(count);

  const auto sample_at = sampler_of(field, count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 1024 == 0) {
      session.check_stop();
      progress(static_cast<double>(i) / static_cast<double>(count));
    }
    FieldSample at = sample_at(place_of(points.positions, static_cast<std::int64_t>(i)));
    (*defined)[i] = at.is_defined ? 1 : 0;
    (*weight)[i] = at.weight;
    if (!at.is_defined) {
      at.value = at.color_value = std::numeric_limits<double>::quiet_NaN();
      at.gradient.setConstant(at.value);
    }
    (*value)[i] = at.value;
    if (color) (*color)[i] = at.color_value;
    (*gx)[i] = at.gradient.x();
    (*gy)[i] = at.gradient.y();
    (*gz)[i] = at.gradient.z();
  }
  Dataset samples;
  samples.kind = DatasetKind::kParticles;
  samples.positions = points.positions;
  const auto add = [&](const char* name, const Column& values) {
    samples.arrays.push_back(column(name, ScalarType::kFloat64, values));
  };
  add("value", value);
  if (color) add("color_value", color);
  add("gx", gx);
  add("gy", gy);
  add("gz", gz);
  add("weight", weight);
  samples.arrays.push_back(column("defined", ScalarType::kUInt8, defined));
  return samples;
}

}  // namespace ovoid::cli
