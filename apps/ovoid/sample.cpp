// SPDX-License-Identifier: Apache-2.0
// ovoid sample: the reconstructed field and its gradient at given points.

#include <fmt/format.h>

#include "check_files.h"
#include "command.h"
#include "environment.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "take_samples.h"
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

}  // namespace

void run_sample(const Words& words, Session& session) {
  SampleFlags sample;
  Flags flags("sample", "INPUT... --points FILE -o OUT [FLAG...]",
              "Writes the reconstructed field and its gradient at given points: x, y, z, value, "
              "gx, gy, gz, weight (the sum of the kernels, about 1 inside; of a lattice over that "
              "of an endless one) and defined (0 or 1; "
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
  require_values(dataset, "sample");
  check_kind_flags(flags, dataset);
  const Modelled modelled = make_field(dataset, sample.model, 0, session);
  const Dataset samples = [&] {
    Progress progress("sampling");
    return take_samples(points, modelled.field, session, progress.callback());
  }();
  session.check_stop();
  write_dataset(samples, sample.output, {session.stop()});
}

}  // namespace ovoid::cli
