// SPDX-License-Identifier: Apache-2.0
// ovoid sample: the reconstructed field and its gradient at given points.

#include <fmt/format.h>

#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <utility>

#include "check_files.h"
#include "command.h"
#include "environment.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/sampler.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

struct SampleFlags {
  DataFlags data;
  ModelFlags model;
  std::string points;
  std::string output;
};

const Table<SampleFlags>& sample_settings() {
  using S = SampleFlags;
  static const Table<S> all = {
      {"--points", word("FILE"), &S::points,
       "where: the places of particles in any format, such as CSV with columns x, y, z"},
      {"-o,--output", word("OUT"), &S::output, "the samples: .csv, .npz or .ply"},
  };
  return all;
}

void check_flags(const Flags& flags, const SampleFlags& sample) {
  require_inputs(flags, sample.data);
  if (sample.points.empty()) throw UsageError("--points: none given, expected --points FILE");
  if (sample.output.empty())
    throw UsageError("--output: none given, expected -o OUT.csv, .npz or .ply");
  if (!has_ending(sample.output, ".csv") && !has_ending(sample.output, ".npz") &&
      !has_ending(sample.output, ".ply")) {
    throw UsageError(fmt::format("--output '{}': expected a name that ends in .csv, .npz or .ply",
                                 sample.output));
  }
  std::vector<InputFile> inputs = volume_inputs(sample.data.inputs);
  inputs.push_back({sample.points, "the points of --points"});
  check_files(inputs, volume_outputs("--output", sample.output));
}

Dataset read_points(const std::string& path, Session& session) {
  ReadOptions options;
  options.stop = session.stop();
  options.reader_program = reader_of_environment();
  Dataset points = read_dataset({path}, options);
  session.notes(points.notes);
  if (points.kind == DatasetKind::kLattice) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--points: '{}' is a lattice, expected particles", path));
  }
  return points;
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

// The points as they were given, with what the field is there; NaN where it is not defined.
Dataset take_samples(const Dataset& points, const Field& field, Session& session) {
  const KernelField* const set = field.kernels();
  const bool has_color = set != nullptr && set->has_own_color();
  using Column = std::shared_ptr<std::vector<double>>;
  const auto count = static_cast<std::size_t>(points.num_positions());
  const auto make = [&] { return std::make_shared<std::vector<double>>(count); };
  const Column value = make(), gx = make(), gy = make(), gz = make(), weight = make();
  const Column color = has_color ? make() : nullptr;
  const auto defined = std::make_shared<std::vector<std::uint8_t>>(count);

  const FieldSampler sampler(field);
  Progress progress("sampling");
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 1024 == 0) {
      session.check_stop();
      progress.show(static_cast<double>(i) / static_cast<double>(count));
    }
    FieldSample at = sampler.at(place_of(points.positions, static_cast<std::int64_t>(i)));
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

}  // namespace

void run_sample(const Words& words, Session& session) {
  SampleFlags sample;
  Flags flags("sample", "INPUT... --points FILE -o OUT [FLAG...]",
              "Writes the reconstructed field and its gradient at given points: x, y, z, value, "
              "gx, gy, gz, weight (the sum of the kernels, about 1 inside) and defined (0 or 1; "
              "value and gradient are NaN where it is 0); with --color-array also color_value.");
  flags.section("");
  flags.add(sample_settings(), &sample);
  add_input_flags(flags, &sample.data);
  add_array_flags(flags, &sample.model);
  add_kernel_flags(flags, &sample.model);
  if (!flags.parse(words)) return;
  check_flags(flags, sample);
  check_volume_output("--output", sample.output);

  const Dataset points = read_points(sample.points, session);
  take_from_model(&sample.data, &sample.model);
  sample.data.may_stay_in_file = true;
  const Dataset dataset = load(sample.data, session);
  check_kind_flags(flags, dataset);
  const Modelled modelled = make_field(dataset, sample.model, 0, session);
  const Dataset samples = take_samples(points, modelled.field, session);
  session.check_stop();
  write_dataset(samples, sample.output, {session.stop()});
}

}  // namespace ovoid::cli
