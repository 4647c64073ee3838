// SPDX-License-Identifier: Apache-2.0
// ovoid convert: a dataset from one format to another, or a look rewritten.

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "check_files.h"
#include "command.h"
#include "lattice_flags.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/lattice_file.h"
#include "ovoid/resample.h"
#include "ovoid/sampler.h"
#include "ovoid/series.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

void convert_look(const std::vector<std::string>& inputs, const std::string& name,
                  const std::string& output) {
  if (inputs.size() != 1) {
    throw UsageError(fmt::format("--output '{}': expected one look as input", output));
  }
  write_look(read_look(inputs[0], name), output);
}

// What --size asks for: sides, or one for the longest, of cubes.
struct GridSize {
  std::optional<Index3> dims;
  std::int64_t longest = 0;

  bool is_given() const noexcept { return dims || longest > 0; }
};

GridSize parse_grid_size(const std::string& text) {
  GridSize size;
  try {
    if (text.find('x') == std::string::npos) {
      size.longest = parse_integer(text, 1, kMaxLatticeSide);
      return size;
    }
    size.dims = parse_dims(text);
  } catch (const BadValue&) {
    throw BadValue(fmt::format("expected N or XxYxZ, each 1 to {}", kMaxLatticeSide));
  }
  for (const std::int64_t side : *size.dims) {
    if (side > kMaxLatticeSide)
      throw BadValue(fmt::format("expected N or XxYxZ, each 1 to {}", kMaxLatticeSide));
  }
  return size;
}

struct ConvertFlags {
  DataFlags data;
  ModelFlags model;
  std::string output;
  std::string look_name;
  GridSize size;
  bool as_kernels = false;
  std::optional<TargetLattice> lattice;
  double lattice_spacing = 1.0;
  bool band_limit = true;
  std::optional<double> relevant_above;
  std::string relevant_look;  // a file
  std::optional<double> background_value;
  int threads = 0;
};

Dataset to_grid(const ConvertFlags& convert, const Dataset& dataset, Session& session) {
  const Modelled modelled = make_field(dataset, convert.model, convert.threads, session);
  const Bounds3 bounds = modelled.field.world_bounds();
  const LatticeGeometry lattice = convert.size.dims
                                      ? lattice_over(bounds, *convert.size.dims)
                                      : lattice_of_cubes(bounds, convert.size.longest);
  Progress progress("resampling");
  ResampleOptions options;
  options.name = modelled.array;
  if (modelled.color_array != modelled.array) options.color_name = modelled.color_array;
  options.threads = convert.threads;
  options.progress = progress.callback();
  options.stop = session.stop();
  Dataset grid = resample(modelled.field, lattice, options);
  grid.source = dataset.source;
  grid.space = dataset.space;
  grid.arrays[0].unit = unit_of(dataset, modelled, Role::kOpacity);
  if (grid.arrays.size() > 1) grid.arrays[1].unit = unit_of(dataset, modelled, Role::kColor);
  return grid;
}

Dataset to_kernels(const ConvertFlags& convert, const Dataset& dataset, Session& session) {
  const Modelled modelled = make_field(dataset, convert.model, convert.threads, session);
  return make_kernel_dataset(*modelled.field.kernels());
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

// Meshes have no other way into a file of points.
bool becomes_kernels(const ConvertFlags& convert, const Dataset& dataset) {
  if (convert.as_kernels) return true;
  const bool has_cells = dataset.kind == DatasetKind::kMesh || dataset.kind == DatasetKind::kBoxes;
  return has_cells && has_ending(convert.output, ".ply");
}

bool is_grid_name(const std::string& path) {
  const std::vector<std::string> endings = written_endings(DatasetKind::kLattice);
  return std::any_of(endings.begin(), endings.end(),
                     [&](const std::string& ending) { return has_ending(path, ending); });
}

LatticeResampleOptions resample_options(const ConvertFlags& convert, Progress& progress,
                                        Session& session) {
  LatticeResampleOptions options;
  options.array = convert.model.array;
  options.spacing = convert.lattice_spacing;
  options.band_limit = convert.band_limit;
  options.threads = convert.threads;
  options.progress = progress.callback();
  options.stop = session.stop();
  return options;
}

Dataset to_lattice(const ConvertFlags& convert, const Dataset& dataset, Session& session) {
  if (dataset.kind != DatasetKind::kLattice)
    refuse_kind("--lattice", "lattices (--size makes one)", dataset);
  Progress progress("resampling");
  const bool is_body_centred = *convert.lattice == TargetLattice::kBodyCentred;
  return resample_lattice(dataset,
                          is_body_centred ? LatticeKind::kBodyCentred : LatticeKind::kCartesian,
                          resample_options(convert, progress, session));
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

Dataset converted(const ConvertFlags& convert, const Flags& flags, const Dataset& dataset,
                  Session& session) {
  check_kind_flags(flags, dataset);
  if (convert.size.is_given()) return to_grid(convert, dataset, session);
  if (convert.lattice) return to_lattice(convert, dataset, session);
  if (convert.as_kernels && dataset.kind == DatasetKind::kLattice)
    refuse_kind("--kernels", "meshes and particles", dataset);
  if (becomes_kernels(convert, dataset)) return to_kernels(convert, dataset, session);
  std::string flag = flags.first_given(kernel_settings());
  if (flag.empty()) flag = flags.first_given(particle_settings());
  for (const char* const name : {"component", "color-array"}) {
    if (flags.is_given(name)) flag = fmt::format("--{}", name);
  }
  if (!flag.empty()) {
    throw UsageError(
        fmt::format("{}: has no effect without --size, --kernels or a mesh as .ply", flag));
  }
  if (dataset.kind != DatasetKind::kLattice && is_grid_name(convert.output)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: holds a grid, '{}' is none; --size N resamples it to one",
                            convert.output, dataset.source));
  }
  Dataset same = dataset;
  const std::string& array = convert.model.array;
  if (!array.empty()) same.arrays = {dataset.array(array)};
  return same;
}

const Table<ConvertFlags>& convert_settings() {
  using C = ConvertFlags;
  const Rule of_lattice = needs("lattice", "has no effect without --lattice");
  static const Table<C> all = {
      {"-o,--output", word("OUT"), &C::output, written_files_text() + "; a look .json"},
      {"--size", Form<GridSize>{"N|XxYxZ", parse_grid_size}, &C::size,
       "resample the field to a grid over its bounds, NaN where it is not defined; N: of cubes, so "
       "many along the longest side"},
      {"--kernels", Toggle(), &C::as_kernels,
       "write the kernels that are drawn, not the particles, to .ply (a mesh as .ply: always)",
       not_with("size", kGiveOne)},
      {"--lattice", lattice_form(), &C::lattice,
       "resample a volume to this lattice, limited to a ball of frequencies: Cartesian or "
       "body-centred, of one step, or, with all steps to .h5, in space and time",
       not_with("size kernels", "contradicts --size and --kernels; give one of them")},
      {"--lattice-spacing", number("S", {.lo = 0, .hi = 1000, .lo_open = true}),
       &C::lattice_spacing, "T of --lattice, in spacings (and steps) of the input (default {})",
       of_lattice},
      {"--no-band-limit", Toggle{false}, &C::band_limit, "resample by splines alone", of_lattice},
      {"--relevant-above", number("V"), &C::relevant_above,
       "to .h5: keep the samples whose value is greater, and missing ones, as runs"},
      {"--relevant-tf", word("FILE"), &C::relevant_look,
       "to .h5: keep the samples that a picture with this look (as --tf) takes, as runs, so that "
       "it stays the same",
       not_with("relevant-above", kGiveOne)},
      {"--background-value", number("B"), &C::background_value,
       "with one of these: the value of all others (default: the least there is)",
       needs("relevant-above relevant-tf",
             "has no effect without --relevant-above or --relevant-tf")},
      {"--tf-name", word("NAME"), &C::look_name,
       "which look of a file with several (default: the first)"},
      {"--threads", integer("N", 0, 1024), &C::threads, "(default {}: one per hardware thread)"},
  };
  return all;
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
  Flags flags(
      "convert", "INPUT... -o OUT [FLAG...]",
      "Writes a dataset in another format; any field as a grid (--size), or a mesh's and "
      "particles' kernels (.ply). Without these, --array names the one array to write (default: "
      "all). A look of any kind that --tf reads is written as ParaView JSON if OUT ends in .json, "
      "its points sorted and its defaults written out.");
  flags.section("");
  flags.add(convert_settings(), &convert);
  add_input_flags(flags, &convert.data);
  add_array_flags(flags, &convert.model);
  add_kernel_flags(flags, &convert.model);
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
  if (convert.lattice && is_in_time(*convert.lattice)) return convert_in_time(convert, session);
  Dataset dataset = converted(convert, flags, load(convert.data, session), session);
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
