// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "flags.h"
#include "ovoid/field.h"
#include "ovoid/model.h"
#include "session.h"

namespace ovoid::cli {

// Which array is drawn, and how it becomes a field: what lattices, and what everything else takes.
struct ModelFlags {
  LatticeModelOptions lattice;
  KernelModelOptions kernels;
};

// The array that must be read alone, as far as the model knows; empty: all.
std::string array_to_read(const ModelFlags& model);

void add_array_flags(Flags& flags, ModelFlags* model);  // --array, --color-array, --component
void add_model_flags(Flags& flags, ModelFlags* model);
// --relevant-above, for commands that draw or describe.
void add_relevant_flag(Flags& flags, ModelFlags* model);
// Throws UsageError for contradictions.
void check_model_flags(const Flags& flags, const ModelFlags& model);

// Throws Error(kInvalidArgument) for the first flag of add_array_flags() and add_model_flags() that
// is given but not for this kind of data.
void check_kind_flags(const Flags& flags, const Dataset& dataset);

// Whether any of them is given.
bool is_model_flag_given(const Flags& flags);

// "--kernel: is for lattices, 'x.csv' holds particles"
[[noreturn]] void refuse_kind(const char* flag, const char* meant, const Dataset& dataset);

// A field, and what the model stage found.
struct Modelled {
  Field field;
  std::string array;        // gives opacity and surfaces
  std::string color_array;  // gives colour
  LatticeModelReport lattice;
  KernelModelReport kernels;
};

// The unit of the values that give opacity, or colour; empty if the file names none.
enum class Role { kOpacity, kColor };
std::string unit_of(const Dataset& dataset, const Modelled& modelled, Role role);

const DataArray* find_array(const Dataset& dataset, const std::string& name);  // null: none

// Chooses kernels; tells which array was chosen where there are several, and the model's notes.
Modelled make_field(const Dataset& dataset, const ModelFlags& model, int threads, Session& session);

}  // namespace ovoid::cli
