// SPDX-License-Identifier: Apache-2.0
#include "model_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ovoid/error.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<Reconstruction> kReconstructions = {{"normalized", Reconstruction::kNormalized},
                                                {"sum", Reconstruction::kSum}};
const Names<bool> kQuantities = {{"attribute", false}, {"density", true}};
const Names<Neighborhood> kNeighborhoods = {{"edges", Neighborhood::kEdges},
                                            {"voronoi", Neighborhood::kVoronoi}};

Names<KernelProfile> profile_names() {
  Names<KernelProfile> names;
  for (const KernelProfile profile : {KernelProfile::kGaussian, KernelProfile::kCubicSpline,
                                      KernelProfile::kWendlandC2, KernelProfile::kEpanechnikov}) {
    names.emplace_back(name_of(profile), profile);
  }
  return names;
}

// "gaussian", "gaussian:SIGMA" or "gaussian:SIGMA,CUTOFF"
LatticeKernel parse_kernel(const std::string& text) {
  using K = LatticeKernel;
  const std::vector<std::string> parts = split(text, ':');
  if (parts[0] != "gaussian" || parts.size() > 2) throw BadValue("expected gaussian:SIGMA,CUTOFF");
  K kernel;
  if (parts.size() == 1) return kernel;
  const std::vector<std::string> numbers = split(parts[1], ',');
  if (numbers.size() > 2) throw BadValue("expected gaussian:SIGMA,CUTOFF");
  const auto named = [](const char* what, const std::string& number, const Interval& interval) {
    try {
      return parse_number(number, interval);
    } catch (const BadValue& bad) {
      throw BadValue(fmt::format("{}: {}", what, bad.what()));
    }
  };
  kernel.sigma = named("SIGMA", numbers[0], {K::kMinSigma, K::kMaxSigma});
  if (numbers.size() == 2) kernel.cutoff = named("CUTOFF", numbers[1], {0, K::kMaxCutoff, true});
  if (kernel.support_radius() < K::kMinSupport) {
    throw BadValue(fmt::format("expected SIGMA x CUTOFF >= {:g} spacings, else kernels leave gaps",
                               K::kMinSupport));
  }
  return kernel;
}

int parse_component(const std::string& text) {
  if (text == "magnitude") return LatticeModelOptions::kMagnitude;
  try {
    return static_cast<int>(parse_integer(text, 0, 1'000'000));
  } catch (const BadValue&) {
    throw BadValue("expected a component's number, from 0, or magnitude");
  }
}

void add_set_flags(Flags& flags, KernelModelOptions* model) {
  flags.value("--cutoff", "C",
              "sigmas at which kernels of meshes, particles and files end (default 3.5 of meshes, "
              "else 4)",
              [model](const std::string& text) {
                model->cutoff = parse_number(text, {1, KernelColumns::kMaxCutoff});
              });
  flags.value(
      "--neighborhood", joined(kNeighborhoods),
      fmt::format("what shapes a kernel of meshes and scattered points: a mesh's edges, or "
                  "Voronoi cells (default {})",
                  name_in(kNeighborhoods, model->neighborhood)),
      [model](const std::string& text) { model->neighborhood = parse_name(text, kNeighborhoods); });
}

void add_particle_flags(Flags& flags, KernelModelOptions* model) {
  flags.section("particles");
  flags.value(
      "--quantity", joined(kQuantities),
      "the field: an array's mean, or mass per volume (default attribute; density where "
      "there is no array)",
      [model](const std::string& text) { model->is_density = parse_name(text, kQuantities); });
  flags.value("--radius-array", "NAME",
              "smoothing lengths h; kernels end at 2 h (default: one called like one, else from "
              "neighbours)",
              [model](const std::string& text) { model->radius_array = text; });
  flags.value("--mass-array", "NAME", "their masses (default: one called like one, else --mass)",
              [model](const std::string& text) { model->mass_array = text; });
  flags.value("--mass", "M", "the mass of every particle (default 1)",
              [model](const std::string& text) {
                model->mass = parse_number(text, {.lo = 0, .lo_open = true});
              });
  flags.value("--neighbors", "K",
              fmt::format("particles within 2 h, where h comes from neighbours (default {})",
                          model->neighbors),
              [model](const std::string& text) {
                model->neighbors = static_cast<int>(parse_integer(text, 4, 512));
              });
  flags.toggle("--anisotropic", "ellipsoids, drawn out as their neighbours lie",
               &model->anisotropic);
  const Names<KernelProfile> names = profile_names();
  flags.value(
      "--profile-kernel", joined(names),
      fmt::format("the kernel along its radius (default {})", name_of(model->profile)),
      [model, names](const std::string& text) { model->profile = parse_name(text, names); });
}

// A flag and the kinds of data that it is for.
struct KindFlag {
  const char* name;
  std::vector<DatasetKind> kinds;
  const char* meant;  // those kinds, for people
};

const std::vector<KindFlag>& kind_flags() {
  using enum DatasetKind;
  static const std::vector<KindFlag> all = {
      {"--color-array", {kMesh, kBoxes, kParticles, kKernels}, "meshes, particles and kernels"},
      {"--kernel", {kLattice}, "lattices"},
      {"--prefilter", {kLattice}, "lattices"},
      {"--cutoff", {kMesh, kBoxes, kParticles, kKernels}, "meshes, particles and kernels"},
      {"--neighborhood", {kMesh, kBoxes, kParticles}, "meshes and particles"},
      {"--quantity", {kParticles}, "particles"},
      {"--radius-array", {kParticles}, "particles"},
      {"--mass-array", {kParticles}, "particles"},
      {"--mass", {kParticles}, "particles"},
      {"--neighbors", {kParticles}, "particles"},
      {"--anisotropic", {kParticles}, "particles"},
      {"--profile-kernel", {kParticles}, "particles"},
  };
  return all;
}

const char* contents_of(DatasetKind kind) {
  switch (kind) {
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
}

// Tells which array was taken where there was a choice; the shapes of stored kernels are none.
void note_choice(const Dataset& dataset, const std::string& chosen, Session& session) {
  std::string names;
  int count = 0;
  for (const DataArray& array : dataset.arrays) {
    const bool is_shape =
        dataset.kind == DatasetKind::kKernels &&
        (array.name == "scale" || array.name == "rotation" || array.name == "weight");
    if (is_shape) continue;
    names += (names.empty() ? "" : ", ") + array.name;
    ++count;
  }
  if (count > 1) session.note(fmt::format("array '{}' of {}; choose with --array", chosen, names));
}

Modelled make_kernels(const Dataset& dataset, KernelModelOptions model, int threads,
                      Session& session) {
  model.threads = threads;
  Modelled made;
  made.field = make_kernel_field(dataset, model, &made.kernels, session.stop());
  made.array = made.kernels.array;
  made.color_array = made.kernels.color_array;
  if (model.array.empty() && !model.is_density) note_choice(dataset, made.array, session);
  session.notes(made.kernels.notes);
  return made;
}

}  // namespace

std::string array_to_read(const ModelFlags& model) {
  const KernelModelOptions& set = model.kernels;
  const bool is_alone = set.color_array.empty() && set.radius_array.empty() &&
                        set.mass_array.empty() && !set.is_density;
  return is_alone ? model.lattice.array : "";
}

void add_array_flags(Flags& flags, ModelFlags* model) {
  flags.section("array");
  flags.value(
      "--array", "NAME", "the array (default: the first that varies)",
      [model](const std::string& text) { model->lattice.array = model->kernels.array = text; });
  flags.value("--color-array", "NAME",
              "gives the colours of meshes, particles and kernels; opacity and surfaces stay "
              "--array's (default: the same)",
              [model](const std::string& text) { model->kernels.color_array = text; });
  flags.value("--component", "N|magnitude", "of arrays with several (default 0)",
              [model](const std::string& text) {
                model->lattice.component = model->kernels.component = parse_component(text);
              });
}

void add_model_flags(Flags& flags, ModelFlags* model) {
  flags.section("kernels");
  flags.value("--kernel", "gaussian:SIGMA,CUTOFF",
              fmt::format("the kernel that a lattice's samples share; SIGMA in spacings, CUTOFF in "
                          "sigmas (default gaussian:{:g},{:g})",
                          model->lattice.kernel.sigma, model->lattice.kernel.cutoff),
              [model](const std::string& text) { model->lattice.kernel = parse_kernel(text); });
  flags.toggle("--prefilter", "make a lattice's field take the samples' values at the samples",
               &model->lattice.prefilter);
  flags.value("--reconstruction", joined(kReconstructions),
              "weighted mean of the kernels, or their sum that fades to 0 (default normalized; "
              "densities and stored kernels: sum)",
              [model](const std::string& text) {
                const Reconstruction asked = parse_name(text, kReconstructions);
                model->lattice.reconstruction = asked;
                model->kernels.reconstruction = asked;
              });
  add_set_flags(flags, &model->kernels);
  add_particle_flags(flags, &model->kernels);
}

void add_relevant_flag(Flags& flags, ModelFlags* model) {
  flags.value("--relevant-above", "V",
              "of a lattice keep in memory the samples whose value is greater, as runs; all others "
              "become the least value",
              [model](const std::string& text) {
                model->lattice.relevant = RelevantSamples{parse_number(text)};
              });
}

void check_model_flags(const Flags& flags, const ModelFlags& model) {
  if (model.lattice.relevant && model.lattice.prefilter)
    throw UsageError("--relevant-above: contradicts --prefilter; give one of them");
  if (model.kernels.is_density && flags.is_given("--array")) {
    throw UsageError(
        "--array: has no effect with --quantity density; --color-array names what gives colour");
  }
  if (flags.is_given("--mass") && flags.is_given("--mass-array"))
    throw UsageError("--mass: contradicts --mass-array; give one of them");
}

void check_kind_flags(const Flags& flags, const Dataset& dataset) {
  for (const KindFlag& flag : kind_flags()) {
    const bool fits =
        std::find(flag.kinds.begin(), flag.kinds.end(), dataset.kind) != flag.kinds.end();
    if (!fits && flags.is_given(flag.name)) refuse_kind(flag.name, flag.meant, dataset);
  }
}

bool is_model_flag_given(const Flags& flags) {
  if (flags.first_given({"--array", "--component", "--reconstruction"}) != nullptr) return true;
  return std::any_of(kind_flags().begin(), kind_flags().end(),
                     [&](const KindFlag& flag) { return flags.is_given(flag.name); });
}

void refuse_kind(const char* flag, const char* meant, const Dataset& dataset) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: is for {}, '{}' {}", flag, meant,
                                                       dataset.source, contents_of(dataset.kind)));
}

const DataArray* find_array(const Dataset& dataset, const std::string& name) {
  const auto found = std::find_if(dataset.arrays.begin(), dataset.arrays.end(),
                                  [&](const DataArray& array) { return array.name == name; });
  return found == dataset.arrays.end() ? nullptr : &*found;
}

std::string unit_of(const Dataset& dataset, const Modelled& modelled, Role role) {
  if (const KernelField* const set = modelled.field.kernels()) {
    const int attribute = role == Role::kColor ? set->color_attribute() : set->attribute();
    return set->source().attributes()[static_cast<std::size_t>(attribute)].unit;
  }
  const DataArray* const drawn = find_array(dataset, modelled.array);
  return drawn == nullptr ? "" : drawn->unit;
}

Modelled make_field(const Dataset& dataset, const ModelFlags& model, int threads,
                    Session& session) {
  if (dataset.kind != DatasetKind::kLattice) {
    if (model.lattice.relevant) refuse_kind("--relevant-above", "lattices", dataset);
    return make_kernels(dataset, model.kernels, threads, session);
  }
  LatticeModelOptions options = model.lattice;
  options.threads = threads;
  Modelled made;
  made.field = make_lattice_field(dataset, options, &made.lattice, session.stop());
  made.array = made.color_array = made.lattice.array;
  if (options.array.empty()) note_choice(dataset, made.array, session);
  session.notes(made.lattice.notes);
  return made;
}

}  // namespace ovoid::cli
