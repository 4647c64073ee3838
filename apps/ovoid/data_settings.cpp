// SPDX-License-Identifier: Apache-2.0
// The tables of data and of the field that they become. A row reads: flag, form of the value, where
// that lies, what it means, rules.
#include <fmt/format.h>

#include <algorithm>

#include "lattice_flags.h"
#include "ovoid/error.h"
#include "setting_forms.h"
#include "settings.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

using Found = std::optional<std::string>;

// --- names of values

const Names<TimeFilter> kTimeFilters = {{"four-steps", TimeFilter::kFourSteps},
                                        {"two-steps", TimeFilter::kTwoSteps},
                                        {"gaussian", TimeFilter::kGaussian},
                                        {"exact", TimeFilter::kExact}};
const Names<SliceMethod> kSliceMethods = {{"interpolated", SliceMethod::kInterpolated},
                                          {"extracted", SliceMethod::kExtracted}};
const Names<LatticeKind> kSliceLattices = {{"cc", LatticeKind::kCartesian},
                                           {"bcc", LatticeKind::kBodyCentred}};
const Names<Reconstruction> kReconstructions = {{"normalized", Reconstruction::kNormalized},
                                                {"sum", Reconstruction::kSum}};
const Names<bool> kQuantities = {{"attribute", false}, {"density", true}};
const Names<Neighborhood> kNeighborhoods = {{"edges", Neighborhood::kEdges},
                                            {"voronoi", Neighborhood::kVoronoi}};

Names<KernelProfile> profile_names() {
  Names<KernelProfile> names;
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov})
    names.emplace_back(name_of(profile), profile);
  return names;
}

// --- which data

using enum DatasetKind;
const Rule kOfLattices = for_data({kLattice}, "lattices");
const Rule kOfSets =
    for_data({kMesh, kBoxes, kParticles, kKernels}, "meshes, particles and kernels");
const Rule kOfMeshesAndParticles = for_data({kMesh, kBoxes, kParticles}, "meshes and particles");
const Rule kOfParticles = for_data({kParticles}, "particles");

// --- tests of values, for rules

Found is_extracted(const std::string& method) { return if_so(method == "extracted", method); }
Found is_xray(const std::string& mode) { return if_so(mode == "xray", mode); }
Found is_density(const std::string& quantity) { return if_so(quantity == "density", quantity); }
Found is_lattice_in_time(const std::string& lattice) {
  return if_so(is_in_time(lattice_form().parse(lattice)), lattice);
}

}  // namespace

const Table<DataFlags>& data_settings() {
  using D = DataFlags;
  const Rule of_slice = needs("hyperslice", "has no effect without --hyperslice");
  const Rule of_lattice =
      not_with("slice-method",
               "has no effect with --slice-method extracted, which makes no lattice", is_extracted);
  const Rule one_step = not_with("lattice", "contradicts --lattice in time, which takes all steps",
                                 is_lattice_in_time);
  static const Table<D> all = {
      {"--block", word("NAME"), &D::block,
       "which of several volumes, such as a DICOM series (default: the largest)"},
      {"--axis-order", word("ORDER"), at(&D::raw, &RawOptions::axis_order),
       "NPY, NPZ, TIFF, Zarr, netCDF, HDF5: the array's axes, the slowest first: letters of t, c "
       "(channels), z, y, x, "
       "such as czyx (default: the format's rule)"},
      {"--step", integer<std::int64_t>("N", 0, 1'000'000'000), &D::step,
       "which time step, from 0 (default: the first that varies)", one_step,
       not_with("hyperslice", kGiveOne)},
      {"--time", number("T"), &D::time,
       "the data at this time, between steps interpolated; where the input names no times, a "
       "step's number is its time",
       one_step, not_with("step hyperslice", kGiveOne)},
      {"--time-filter", choice(kTimeFilters), &D::time_filter,
       "kernels over time of lattices in space and time (D4*): docs/time.md (default {})"},
      {"--hyperslice", form("A,B,C,D[,E]", parse_hyperplane), at(&D::slice, &SliceFlags::plane),
       "of lattices in time, what lies where A x + B y + C z + D t = E, in world units and "
       "those of the times; animate goes along E if that is left out: docs/time.md",
       one_step},
      {"--slice-method", choice(kSliceMethods), at(&D::slice, &SliceFlags::method),
       "a new lattice in the plane, or the samples near it, moved onto it (default {})", of_slice},
      {"--slice-lattice", choice(kSliceLattices), at(&D::slice, &SliceFlags::lattice),
       "the lattice of an interpolated slice (default: the data's, bcc of D4*)", of_slice,
       of_lattice},
      {"--slice-spacing", number("S", {.lo = 0.05, .hi = 1000}),
       at(&D::slice, &SliceFlags::spacing), "its T, in that of the data (default {})", of_slice,
       of_lattice},
      {"--memory-limit", bytes("BYTES"), &D::memory_limit,
       "of the steps in memory, as 4G or 512M; one is in any case (default 1G); and of a lattice's "
       "samples, which stay in their file if they take more (default: most of what there is)"},
      {"--positions", word("PATH"), &D::positions,
       "HDF5: the particles' positions, such as /PartType1/Coordinates (default: found)"},
      {"--value", word("PATH"), &D::values,
       "HDF5: an array of the particles (repeatable; default: those beside the positions)"},
      {"--data-folder", word("DIR", Content::kFile), &D::folders,
       "files that the input names (pieces, samples, external storage of HDF5) may also lie "
       "below this folder (repeatable; default: below the input's own)"},
  };
  return all;
}

const Table<DataFlags>& raw_settings() {
  using D = DataFlags;
  static const Table<D> all = {
      {"--dims", form("XxYxZ", parse_dims), at(&D::raw, &RawOptions::dims),
       "samples along x, y, z"},
      {"--type", form("TYPE", parse_scalar_type), at(&D::raw, &RawOptions::type),
       "type of a sample: uint8, int16, float32, ..."},
      {"--spacing", form("A,B,C", parse_spacing), at(&D::raw, &RawOptions::spacing),
       "distance of samples along x, y, z (default 1,1,1)"},
      {"--big-endian", Toggle(), at(&D::raw, &RawOptions::big_endian),
       "most significant byte first"},
  };
  return all;
}

const Table<ModelFlags>& array_settings() {
  using M = ModelFlags;
  static const Table<M> all = {
      {"--array", word("NAME"), &M::array, "the array (default: the first that varies)",
       not_with("quantity",
                "has no effect with --quantity density; --color-array names what gives colour",
                is_density)},
      {"--color-array", word("NAME"), at(&M::kernels, &KernelModelOptions::color_array),
       "gives the colours of meshes, particles and kernels; opacity and surfaces stay "
       "--array's (default: the same)",
       kOfSets,
       not_with("mode", "has no effect with --mode xray, whose colours are integrals", is_xray)},
      {"--component", Form<int>{"N|magnitude", parse_component, text_of_component}, &M::component,
       "of arrays with several (default: the length of vectors of floating-point numbers, else 0)"},
  };
  return all;
}

const Table<ModelFlags>& kernel_settings() {
  using M = ModelFlags;
  using L = LatticeModelOptions;
  using K = KernelModelOptions;
  static const Table<M> all = {
      {"--kernel", form("bspline|catmull-rom|gaussian[:SIGMA[,CUTOFF]]", parse_kernel),
       at(&M::lattice, &L::kernel),
       "the kernel that a lattice's samples share; SIGMA in spacings (0.5), CUTOFF in sigmas (4) "
       "(default bspline; gaussian, as published, for labels and with --relevant-above; "
       "catmull-rom for slices)",
       kOfLattices},
      {"--prefilter", Toggle(), at(&M::lattice, &L::prefilter),
       "make a lattice's field take the samples' values at the samples (default with bspline)",
       kOfLattices, not_with("no-prefilter", kGiveOne)},
      {"--no-prefilter", Toggle{false}, at(&M::lattice, &L::prefilter),
       "sum the samples as they are", kOfLattices},
      {"--reconstruction", choice(kReconstructions), &M::reconstruction,
       "weighted mean of the kernels, or their sum that fades to 0 (default normalized; "
       "densities and stored kernels: sum)"},
      {"--cutoff", number("C", {1, KernelColumns::kMaxCutoff}), at(&M::kernels, &K::cutoff),
       "sigmas at which kernels of meshes, particles and files end (default 3.5 of meshes, else 4)",
       kOfSets},
      {"--neighborhood", choice(kNeighborhoods), at(&M::kernels, &K::neighborhood),
       "what shapes a kernel of meshes and scattered points: a mesh's edges, or Voronoi cells "
       "(default {})",
       kOfMeshesAndParticles},
  };
  return all;
}

const Table<ModelFlags>& particle_settings() {
  using M = ModelFlags;
  using K = KernelModelOptions;
  static const Table<M> all = {
      {"--quantity", choice(kQuantities), at(&M::kernels, &K::is_density),
       "the field: an array's mean, or mass per volume (default: density where no array is named "
       "and particles have a mass but no density of their own, or nothing but places, numbers and "
       "parts of vectors; else attribute)",
       kOfParticles},
      {"--radius-array", word("NAME"), at(&M::kernels, &K::radius_array),
       "smoothing lengths h (default: one called like one, else from neighbours)", kOfParticles},
      {"--smoothing-ends", number("N", kPositive), at(&M::kernels, &K::smoothing_reach),
       "kernels end at N smoothing lengths of the array (default: as the code that wrote the file "
       "has it, where that is known, else 2)",
       kOfParticles},
      {"--mass-array", word("NAME"), at(&M::kernels, &K::mass_array),
       "their masses (default: one called like one, else --mass)", kOfParticles},
      {"--mass", number("M", kPositive), at(&M::kernels, &K::mass),
       "the mass of every particle (default 1)", kOfParticles, not_with("mass-array", kGiveOne)},
      {"--neighbors", integer("K", 4, 512), at(&M::kernels, &K::neighbors),
       "particles within 2 h, where h comes from neighbours (default {})", kOfParticles},
      {"--anisotropic", Toggle(), at(&M::kernels, &K::anisotropic),
       "ellipsoids, drawn out as their neighbours lie", kOfParticles},
      {"--profile-kernel", choice(profile_names()), at(&M::kernels, &K::profile),
       "the kernel along its radius (default {})", kOfParticles},
  };
  return all;
}

const Table<ModelFlags>& relevant_settings() {
  using M = ModelFlags;
  static const Table<M> all = {
      {"--relevant-above", number("V"), &M::relevant_above,
       "of a lattice keep in memory the samples whose value is greater, as runs; all others "
       "become the least value",
       kOfLattices, not_with("prefilter", kGiveOne)},
  };
  return all;
}

void add_input_flags(Flags& flags, DataFlags* data) {
  flags.section("data");
  flags.positionals("INPUT",
                    "a volume, mesh, particles or kernels in any format of docs/formats.md, or a "
                    "folder of DICOM files or slices, or a Zarr folder; several are the time steps "
                    "of one, the slices of a "
                    "DICOM series, or the parts of a format that has some",
                    &data->inputs);
  flags.add(data_settings(), data);
  flags.section("raw data, where the name is not like x_256x256x256_uint8.raw");
  flags.add(raw_settings(), data);
}

void add_array_flags(Flags& flags, ModelFlags* model) {
  flags.section("array");
  flags.add(array_settings(), model);
}

void add_kernel_flags(Flags& flags, ModelFlags* model) {
  flags.section("kernels");
  flags.add(kernel_settings(), model);
  flags.section("particles");
  flags.add(particle_settings(), model);
}

void require_inputs(const Flags& flags, const DataFlags& data) {
  if (data.inputs.empty())
    throw UsageError(fmt::format("INPUT: none given (see ovoid {} --help)", flags.command()));
  for (const std::string& input : data.inputs) {
    if (input.empty()) throw UsageError("INPUT '': expected the name of a file");
  }
}

void check_kind_flags(const Flags& flags, const Dataset& dataset) {
  for (const FlagForm& form : flags.forms()) {
    for (const Rule& rule : form.rules) {
      const bool fits =
          rule.kind != Rule::Kind::kForData ||
          std::find(rule.kinds.begin(), rule.kinds.end(), dataset.kind) != rule.kinds.end() ||
          std::any_of(rule.unless.begin(), rule.unless.end(),
                      [&](const std::string& other) { return flags.is_given(other); });
      if (!fits && flags.is_given(form.name)) refuse_kind("--" + form.name, rule.message, dataset);
    }
  }
}

bool is_model_flag_given(const Flags& flags) {
  return !(flags.first_given(array_settings()) + flags.first_given(kernel_settings()) +
           flags.first_given(particle_settings()))
              .empty();
}

void refuse_kind(const std::string& flag, const std::string& meant, const Dataset& dataset) {
  const auto contents = [&]() -> const char* {
    switch (dataset.kind) {
      case DatasetKind::kLattice:
        return "is a lattice";
      case DatasetKind::kMesh:
        return "is a mesh";
      case DatasetKind::kBoxes:
        return "holds boxes";
      case DatasetKind::kParticles:
        return "holds particles";
      case DatasetKind::kKernels:
        return "holds kernels";
    }
    return "";
  };
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: is for {}, '{}' {}", flag, meant, dataset.source, contents()));
}

}  // namespace ovoid::cli
