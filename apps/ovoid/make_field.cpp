// SPDX-License-Identifier: Apache-2.0
#include "make_field.h"

#include <fmt/format.h>

#include <algorithm>

#include "ovoid/kernel_team.h"
#include "team.h"

namespace ovoid::cli {
namespace {

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
  if (find_array(dataset, chosen) == nullptr) {
    if (count > 0) session.note(fmt::format("--array draws one of {}", names));
  } else if (count > 1) {
    session.note(fmt::format("array '{}' of {}; choose with --array", chosen, names));
  }
}

// Particles may be drawn without any array.
int component_to_draw(const Dataset& dataset, const ModelFlags& model, Session& session) {
  if (model.component != kUsualComponent) return model.component;
  KernelModelOptions options = model.kernels;
  options.array = model.array;
  if (dataset.arrays.empty() || draws_density(dataset, options)) return 0;
  const DataArray& array = dataset.array(model.array);
  const int component = component_of(array, model.component);
  if (component == LatticeModelOptions::kMagnitude) {
    session.note(
        fmt::format("array '{}' holds vectors: drawn by their length; --component N takes "
                    "one of {} numbers",
                    array.name, array.num_components));
  }
  return component;
}

Modelled make_kernels(const Dataset& dataset, const ModelFlags& model, int threads,
                      Session& session) {
  const KernelModelOptions options = kernel_options(dataset, model, threads, session);
  Modelled made;
  made.component = options.component;
  made.field = dataset.share
                   ? make_team_field(dataset, {options, model.kept_bytes, &made.surface},
                                     session.team()->kernels(), &made.kernels, session.stop())
                   : make_kernel_field(dataset, options, &made.kernels, session.stop());
  made.array = made.kernels.array;
  made.color_array = made.kernels.color_array;
  if (options.array.empty() && !options.is_density.value_or(false))
    note_choice(dataset, made.array, session);
  session.notes(made.kernels.notes);
  return made;
}

}  // namespace

KernelModelOptions kernel_options(const Dataset& dataset, const ModelFlags& model, int threads,
                                  Session& session) {
  KernelModelOptions options = model.kernels;
  options.array = model.array;
  options.component = component_to_draw(dataset, model, session);
  options.reconstruction = model.reconstruction;
  options.threads = threads;
  return options;
}

int component_of(const DataArray& array, int component) {
  if (component != kUsualComponent) return component;
  const bool is_vector =
      (array.num_components == 2 || array.num_components == 3) && is_floating(array.type);
  return is_vector ? LatticeModelOptions::kMagnitude : 0;
}

std::string array_to_read(const ModelFlags& model) {
  const KernelModelOptions& set = model.kernels;
  const bool is_alone = set.color_array.empty() && set.radius_array.empty() &&
                        set.mass_array.empty() && !set.is_density.value_or(false);
  return is_alone ? model.array : "";
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
  if (dataset.kind != DatasetKind::kLattice) return make_kernels(dataset, model, threads, session);
  LatticeModelOptions options = model.lattice;
  options.array = model.array;
  Modelled made;
  made.component = component_to_draw(dataset, model, session);
  options.component = made.component;
  options.reconstruction = model.reconstruction.value_or(options.reconstruction);
  if (model.relevant_above) options.relevant = RelevantSamples{*model.relevant_above};
  options.threads = threads;
  if (session.team() != nullptr) options.team = session.team()->kernels();
  made.field = make_lattice_field(dataset, options, &made.lattice, session.stop());
  made.array = made.color_array = made.lattice.array;
  if (options.array.empty()) note_choice(dataset, made.array, session);
  session.notes(made.lattice.notes);
  return made;
}

}  // namespace ovoid::cli
