// SPDX-License-Identifier: Apache-2.0
#include "conversion.h"

#include <fmt/format.h>

#include <algorithm>

#include "check_files.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/sampler.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

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

Dataset to_lattice(const ConvertFlags& convert, const Dataset& dataset, Session& session) {
  if (dataset.kind != DatasetKind::kLattice)
    refuse_kind("--lattice", "lattices (--size makes one)", dataset);
  Progress progress("resampling");
  const bool is_body_centred = *convert.lattice == TargetLattice::kBodyCentred;
  return resample_lattice(dataset,
                          is_body_centred ? LatticeKind::kBodyCentred : LatticeKind::kCartesian,
                          resample_options(convert, progress, session));
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

}  // namespace

Flags make_convert_flags(ConvertFlags* into) {
  Flags flags(
      "convert", "INPUT... -o OUT [FLAG...]",
      "Writes a dataset in another format; any field as a grid (--size), or a mesh's and "
      "particles' kernels (.ply). Without these, --array names the one array to write (default: "
      "all). A look of any kind that --tf reads is written as ParaView JSON if OUT ends in .json, "
      "its points sorted and its defaults written out.");
  flags.section("");
  flags.add(convert_settings(), into);
  add_input_flags(flags, &into->data);
  add_array_flags(flags, &into->model);
  add_kernel_flags(flags, &into->model);
  return flags;
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

}  // namespace ovoid::cli
