// SPDX-License-Identifier: Apache-2.0
// ovoid convert: a dataset from one format to another, or a look rewritten.

#include <fmt/format.h>

#include "check_files.h"
#include "command.h"
#include "data_flags.h"
#include "ovoid/io.h"
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

// What the format cannot hold, in one note.
void note_losses(const Dataset& dataset, const std::string& output, Session& session) {
  const bool has_space = dataset.space != Space::kNone;
  const bool is_placed = !dataset.lattice.world_from_index.matrix().isIdentity(0);
  if (has_ending(output, ".npy") || has_ending(output, ".raw")) {
    if (has_space || is_placed)
      session.note(
          fmt::format("{}: holds no spacing, directions and origin: they are lost", output));
  } else if (has_space && (has_ending(output, ".vti") || has_ending(output, ".vtk"))) {
    session.note(fmt::format("{}: holds no patient space: that the axes are {} is lost", output,
                             name_of(dataset.space)));
  } else if (has_ending(output, ".nii") || has_ending(output, ".nii.gz")) {
    const Affine3& place = dataset.lattice.world_from_index;
    const Mat3 axes = place.linear();
    const bool is_spacing_alone =
        axes.isDiagonal(0) && axes.diagonal().minCoeff() > 0 && place.translation().isZero(0);
    if (!has_space && !is_spacing_alone)
      session.note(fmt::format(
          "{}: holds a place in patient space only: x, y, z are now right, anterior, superior",
          output));
  }
}

}  // namespace

void run_convert(const Words& words, Session& session) {
  DataFlags data;
  std::string output;
  Flags flags(
      "convert", "INPUT... -o OUT [FLAG...]",
      "Writes a dataset in another format. A look of any kind that --tf reads is written as "
      "ParaView JSON if OUT ends in .json, its points sorted and its defaults written out.");
  flags.section("");
  flags.value("-o,--output", "OUT",
              "the file: .nrrd, .nhdr, .nii, .nii.gz, .npy, .raw, .vti, .vtk; looks: .json",
              [&output](const std::string& text) { output = text; });
  flags.value("--array", "NAME", "write this array alone (default: all)",
              [&data](const std::string& text) { data.array = text; });
  std::string look_name;
  flags.value("--tf-name", "NAME", "which look of a file with several (default: the first)",
              [&look_name](const std::string& text) { look_name = text; });
  flags.refuse({"--size", "--time"});
  add_input_flags(flags, &data);
  if (!flags.parse(words)) return;

  require_inputs(flags, data);
  if (output.empty()) throw UsageError("--output: none given, expected -o OUT");
  check_files(volume_inputs(data.inputs), volume_outputs("--output", output));
  if (has_ending(output, ".json")) {
    convert_look(data.inputs, look_name, output);
    return;
  }
  check_volume_output("--output", output);
  Dataset dataset = load(data, session);
  if (!data.array.empty()) dataset.arrays = {dataset.array(data.array)};
  session.check_stop();
  write_dataset(dataset, output);
  note_losses(dataset, output, session);
}

}  // namespace ovoid::cli
