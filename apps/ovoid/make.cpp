// SPDX-License-Identifier: Apache-2.0
// ovoid make: sample data by formula.

#include <fmt/format.h>

#include <algorithm>

#include "check_files.h"
#include "command.h"
#include "flags.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "suggest.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<ScalarType> kTypes = {{"float32", ScalarType::kFloat32},
                                  {"uint8", ScalarType::kUInt8},
                                  {"uint16", ScalarType::kUInt16}};

// "N" for a cube, or "XxYxZ"
Index3 parse_samples(const std::string& text) {
  if (text.find('x') != std::string::npos) return parse_dims(text);
  try {
    const std::int64_t n = parse_integer(text, 1, 1'000'000);
    return {n, n, n};
  } catch (const BadValue&) {
    throw BadValue("expected N or XxYxZ, each a whole number >= 1");
  }
}

// What it refuses is on the command line.
Dataset make(const std::string& name, const MakeOptions& options) {
  try {
    return make_sample(name, options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument) throw;
    throw UsageError(fmt::format("--{}", error.what()));
  }
}

}  // namespace

void run_make(const Words& words, Session& session) {
  std::vector<std::string> names;
  std::string output;
  MakeOptions options;
  Flags flags("make", "NAME -o OUT [FLAG...]",
              "Writes a volume, mesh, particles or kernels made by formula.");
  flags.section("");
  flags.positionals("NAME", "what to make, see below", &names);
  flags.value(
      "-o,--output", "OUT",
      "the file: a volume .nrrd, .nhdr, .nii, .nii.gz, .npy, .raw, .vti, .vtk; a mesh .vtu; "
      "particles .csv, .npz, .ply; kernels .ply",
      [&output](const std::string& text) { output = text; });
  flags.value("--size", "N|XxYxZ", "samples of a volume (default: the name's own)",
              [&options](const std::string& text) { options.size = parse_samples(text); });
  flags.value("--count", "N",
              "nodes (about so many), particles or kernels, of names that are no volume (default: "
              "the name's own)",
              [&options](const std::string& text) {
                options.count = parse_integer(text, 1, std::int64_t{1} << 30);
              });
  flags.value("--type", joined(kTypes),
              fmt::format("of a sample; integers use their full range (default {})",
                          name_in(kTypes, options.type)),
              [&options](const std::string& text) { options.type = parse_name(text, kTypes); });
  flags.value("--seed", "N",
              fmt::format("of random numbers, where the name uses some (default {})", options.seed),
              [&options](const std::string& text) { options.seed = parse_seed(text); });
  flags.section("names");
  for (const std::string& name : sample_names()) flags.explain(name, describe_sample(name));
  if (!flags.parse(words)) return;

  if (names.size() != 1)
    throw UsageError(
        fmt::format("NAME: {} given, expected one (see ovoid make --help)", names.size()));
  const std::vector<std::string> known = sample_names();
  if (std::find(known.begin(), known.end(), names[0]) == known.end()) {
    throw UsageError(fmt::format("NAME '{}': expected one of {}{}", names[0],
                                 fmt::join(known, ", "), did_you_mean(names[0], known)));
  }
  if (output.empty()) throw UsageError("--output: none given, expected -o OUT");
  check_files({}, volume_outputs("--output", output));
  check_volume_output("--output", output);
  const Dataset dataset = make(names[0], options);
  session.check_stop();
  write_dataset(dataset, output);
}

}  // namespace ovoid::cli
