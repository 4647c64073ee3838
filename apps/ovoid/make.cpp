// SPDX-License-Identifier: Apache-2.0
// ovoid make: sample data by formula, and subdivision solids.

#include <fmt/format.h>

#include <algorithm>

#include "check_files.h"
#include "command.h"
#include "flags.h"
#include "lattice_flags.h"
#include "make_solid.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "ovoid/series.h"
#include "suggest.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<ScalarType> kTypes = {{"float32", ScalarType::kFloat32},
                                  {"uint8", ScalarType::kUInt8},
                                  {"uint16", ScalarType::kUInt16}};

// "N" for a cube, or "XxYxZ"
Index3 parse_sample_counts(const std::string& text) {
  if (text.find('x') != std::string::npos) return parse_dims(text);
  try {
    const std::int64_t n = parse_integer(text, 1, 1'000'000);
    return {n, n, n};
  } catch (const BadValue&) {
    throw BadValue("expected N or XxYxZ, each a whole number >= 1");
  }
}

struct MakeFlags {
  std::vector<std::string> names;
  std::string output;
  MakeOptions options;
  TargetLattice lattice = TargetLattice::kCartesian;
  std::int64_t steps = 1;
  SolidFlags solid;
};

// What it refuses is on the command line.
template <class Make>
auto made(const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument) throw;
    throw UsageError(fmt::format("--{}", error.what()));
  }
}

void check_lattice(const MakeFlags& make) {
  require_file_in_time(make.lattice, make.output);
  const bool has_steps = is_in_time(make.lattice) || make.steps > 1;
  if (has_steps && !has_ending(make.output, ".h5"))
    throw UsageError(
        fmt::format("--steps: '{}' holds one step, only .h5 holds several", make.output));
  if (has_steps && !sample_moves(make.names[0]))
    throw UsageError(
        fmt::format("NAME '{}': does not move, expected one that does, see below", make.names[0]));
}

const Table<MakeFlags>& make_settings() {
  using M = MakeFlags;
  static const Table<M> all = {
      {"-o,--output", word("OUT"), &M::output, written_files_text()},
      {"--size", Form<Index3>{"N|XxYxZ", parse_sample_counts}, at(&M::options, &MakeOptions::size),
       "samples of a volume (default: the name's own)"},
      {"--lattice", lattice_form(), &M::lattice,
       "of a volume: Cartesian or body-centred, or, to .h5, in space and time (default cc); "
       "--size and --steps count the samples of the Cartesian one that it stands for"},
      {"--steps", integer<std::int64_t>("T", 2, 100'000), &M::steps,
       "steps in time of names that move, to .h5 (default 1; 64 in time)"},
      {"--count", integer<std::int64_t>("N", 1, std::int64_t{1} << 30),
       at(&M::options, &MakeOptions::count),
       "nodes (about so many), particles or kernels, of names that are no volume (default: the "
       "name's own)"},
      {"--type", choice(kTypes), at(&M::options, &MakeOptions::type),
       "of a sample; integers use their full range (default {})"},
      {"--seed", Form<std::uint64_t>{"N", parse_seed}, at(&M::options, &MakeOptions::seed),
       fmt::format("of random numbers, where the name uses some (default {})", M{}.options.seed)},
  };
  return all;
}

std::vector<std::string> known_names() {
  std::vector<std::string> names = sample_names();
  names.emplace_back(kSolidName);
  return names;
}

// Each name has flags of its own.
void check_name_flags(const Flags& flags, const std::string& name) {
  if (name != kSolidName) {
    const std::string flag = flags.first_given(solid_settings());
    if (!flag.empty()) throw UsageError(fmt::format("{}: is for '{}' alone", flag, kSolidName));
    return;
  }
  for (const Setting<MakeFlags>& setting : make_settings()) {
    const std::string& flag = setting.flag.name;
    if (flag != "output" && flags.is_given(flag))
      throw UsageError(fmt::format("--{}: has no effect on '{}', see below --control", flag, name));
  }
}

}  // namespace

void run_make(const Words& words, Session& session) {
  MakeFlags make;
  Flags flags(
      "make", "NAME -o OUT [FLAG...]",
      "Writes a volume, mesh, particles or kernels made by formula, or a subdivision solid.");
  flags.section("");
  flags.positionals("NAME", "what to make, see below", &make.names);
  flags.add(make_settings(), &make);
  flags.section(kSolidName);
  flags.add(solid_settings(), &make.solid);
  flags.section("names");
  for (const std::string& name : sample_names()) flags.explain(name, describe_sample(name));
  flags.explain(kSolidName, kSolidText);
  if (!flags.parse(words)) return;

  const std::string& output = make.output;
  const std::vector<std::string>& names = make.names;
  MakeOptions& options = make.options;
  if (names.size() != 1)
    throw UsageError(
        fmt::format("NAME: {} given, expected one (see ovoid make --help)", names.size()));
  const std::vector<std::string> known = known_names();
  if (std::find(known.begin(), known.end(), names[0]) == known.end()) {
    throw UsageError(fmt::format("NAME '{}': expected one of {}{}", names[0],
                                 fmt::join(known, ", "), did_you_mean(names[0], known)));
  }
  if (output.empty()) throw UsageError("--output: none given, expected -o OUT");
  check_name_flags(flags, names[0]);
  std::vector<std::string> inputs;
  if (!make.solid.control.empty()) inputs.push_back(make.solid.control);
  check_files(volume_inputs(inputs), volume_outputs("--output", output));
  check_volume_output("--output", output);
  if (make.lattice == TargetLattice::kBodyCentred) options.lattice = LatticeKind::kBodyCentred;
  check_lattice(make);
  if (is_in_time(make.lattice) || make.steps > 1) {
    const std::int64_t count = make.steps > 1 ? make.steps : 64;
    const SeriesKind kind = series_of(make.lattice);
    write_steps(*made([&] { return make_sample_steps(names[0], count, kind, options); }), output,
                {}, session);
    return;
  }
  const Dataset dataset = names[0] == kSolidName
                              ? make_solid(make.solid, output, session)
                              : made([&] { return make_sample(names[0], options); });
  session.check_stop();
  write_dataset(dataset, output, {session.stop()});
}

}  // namespace ovoid::cli
