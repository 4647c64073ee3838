// SPDX-License-Identifier: Apache-2.0
// ovoid convert: a dataset from one format to another, or a look rewritten.

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "check_files.h"
#include "command.h"
#include "conversion.h"
#include "load.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"
#include "ovoid/series.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

void convert_look(const std::vector<std::string>& inputs, const std::string& name,
                  const std::string& output) {
  if (inputs.size() != 1) {
    throw UsageError(fmt::format("--output '{}': expected one look as input", output));
  }
  write_look(read_look(inputs[0], name), output);
}

bool keeps_relevant(const ConvertFlags& convert) {
  return convert.relevant_above || !convert.relevant_look.empty();
}

// The value up to which a look shows nothing. Throws Error(kInvalidArgument) if it shows the least.
double invisible_up_to(const std::string& path) {
  const TransferFunction tf = read_look(path).transfer_function;
  const auto first = std::find_if(tf.opacities.begin(), tf.opacities.end(),
                                  [](const OpacityPoint& point) { return point.opacity > 0; });
  if (tf.opacities.empty() || first == tf.opacities.begin()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("--relevant-tf: '{}' shows even the least values, so that all samples "
                            "are relevant",
                            path));
  }
  return first == tf.opacities.end() ? tf.opacities.back().x : std::prev(first)->x;
}

std::optional<RelevantSamples> relevant_of(const ConvertFlags& convert) {
  if (convert.relevant_above)
    return RelevantSamples{*convert.relevant_above, convert.background_value};
  if (convert.relevant_look.empty()) return std::nullopt;
  return RelevantSamples{invisible_up_to(convert.relevant_look), convert.background_value, true};
}

// Runs of the relevant samples, and what that saves.
void write_relevant(const ConvertFlags& convert, const Dataset& dataset, Session& session) {
  if (dataset.kind != DatasetKind::kLattice)
    refuse_kind("--relevant-above", "lattices (--size makes one)", dataset);
  LatticeFileHeader header = lattice_file_header(dataset);
  header.relevant = relevant_of(convert);
  LatticeFileWriter writer(convert.output, header, {session.stop()});
  writer.write_step(dataset);
  writer.finish();
  note_relevant(convert.output, writer.counts(), session);
}

// True if nothing but the way in which samples are stored is to change. Only Ovoid's own files hold
// staggered steps.
bool may_keep_steps(const ConvertFlags& convert) {
  const DataFlags& data = convert.data;
  const bool is_same_lattice = !convert.lattice || (*convert.lattice == TargetLattice::kD4Star &&
                                                    convert.lattice_spacing == 1.0);
  return keeps_relevant(convert) && is_same_lattice && !convert.size.is_given() &&
         !convert.as_kernels && !data.step && !data.time && !data.slice.plane &&
         data.inputs.size() == 1 && has_ending(data.inputs.front(), ".h5");
}

// Writes all steps of a D4* lattice as they are. False if the input is none.
bool write_staggered_steps(const ConvertFlags& convert, Session& session) {
  const Series series = open_series(convert.data, session);
  if (series.source().kind() != SeriesKind::kStaggered) return false;
  write_steps(series.source(), convert.output, relevant_of(convert), session);
  return true;
}

// All steps on a lattice in space and time.
void convert_in_time(const ConvertFlags& convert, Session& session) {
  const Series series = open_series(convert.data, session);
  const auto steps = [&] {
    Progress progress("resampling");
    SeriesResampleOptions options;
    options.lattice = resample_options(convert, progress, session);
    const int asked = convert.model.component;
    options.component = asked == kUsualComponent ? 0 : asked;
    return resample_series(series, series_of(*convert.lattice), options);
  }();
  write_steps(*steps, convert.output, relevant_of(convert), session);
}

void check_output(const ConvertFlags& convert) {
  const std::string& output = convert.output;
  if (output.empty()) throw UsageError("--output: none given, expected -o OUT");
  if (convert.as_kernels && !has_ending(output, ".ply"))
    throw UsageError(fmt::format("--kernels: '{}' holds no kernels, only .ply does", output));
  if (keeps_relevant(convert) && !has_ending(output, ".h5")) {
    throw UsageError(fmt::format("--relevant-{}: '{}' holds no runs, only .h5 does",
                                 convert.relevant_above ? "above" : "tf", output));
  }
  if (convert.lattice) require_file_in_time(*convert.lattice, output);
}

}  // namespace

void run_convert(const Words& words, Session& session) {
  ConvertFlags convert;
  Flags flags = make_convert_flags(&convert);
  if (!flags.parse(words)) return;

  const std::string& output = convert.output;
  require_inputs(flags, convert.data);
  check_output(convert);
  std::vector<InputFile> inputs = volume_inputs(convert.data.inputs);
  if (!convert.relevant_look.empty())
    inputs.push_back({convert.relevant_look, "the look of --relevant-tf"});
  check_files(inputs, volume_outputs("--output", output));
  if (has_ending(output, ".json")) {
    convert_look(convert.data.inputs, convert.look_name, output);
    return;
  }
  check_volume_output("--output", output);
  take_from_model(&convert.data, &convert.model);
  if (may_keep_steps(convert) && write_staggered_steps(convert, session)) return;
  if (convert.lattice && is_in_time(*convert.lattice)) return convert_in_time(convert, session);
  const Dataset loaded = load(convert.data, session);
  require_values(loaded, "convert");
  Dataset dataset = converted(convert, flags, loaded, session);
  if (convert.data.time) {
    // What is written is one step, at that time and not at a step's.
    dataset.num_steps = 1;
    dataset.step = 0;
    dataset.times = {*convert.data.time};
  }
  session.check_stop();
  if (keeps_relevant(convert)) return write_relevant(convert, dataset, session);
  write_dataset(dataset, output, {session.stop()});
  if (const std::string lost = lost_place(dataset, output); !lost.empty())
    session.note(fmt::format("{}: {}", output, lost));
}

}  // namespace ovoid::cli
