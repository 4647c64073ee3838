// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "ovoid/field.h"
#include "ovoid/model.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// The array that must be read alone, as far as the model knows; empty: all.
std::string array_to_read(const ModelFlags& model);

// A field, and what the model stage found.
struct Modelled {
  Field field;
  std::string array;        // gives opacity and surfaces
  std::string color_array;  // gives colour
  int component = 0;        // of the array: what was asked for, or the usual one
  LatticeModelReport lattice;
  KernelModelReport kernels;
  std::shared_ptr<const Surface> surface;  // of a mesh that a team has; else it is not made here
};

// What a component means for an array: kUsualComponent becomes another.
int component_of(const DataArray& array, int component);

// The unit of the values that give opacity, or colour; empty if the file names none.
enum class Role { kOpacity, kColor };
std::string unit_of(const Dataset& dataset, const Modelled& modelled, Role role);

const DataArray* find_array(const Dataset& dataset, const std::string& name);  // null: none

// What flags say of the kernels of data that are no lattice; tells how vectors are taken.
KernelModelOptions kernel_options(const Dataset& dataset, const ModelFlags& model, int threads,
                                  Session& session);

// Chooses kernels; tells which array was chosen where there are several, and the model's notes.
Modelled make_field(const Dataset& dataset, const ModelFlags& model, int threads, Session& session);

}  // namespace ovoid::cli
