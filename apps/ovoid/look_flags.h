// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "flags.h"
#include "ovoid/field.h"
#include "ovoid/look.h"
#include "session.h"

namespace ovoid::cli {

// Appearance: colours and opacities, mode, light. What is not given is the file's, or else the
// default look's.
struct LookFlags {
  std::string file;
  std::string color_map;
  std::vector<OpacityPoint> opacities;
  std::optional<std::pair<double, double>> range;
  std::optional<double> unit_distance;
  Mode mode = Mode::kComposite;
  double isovalue = 0;
  bool shade = true;
  Material material;
  std::optional<Vec3> light_direction;
};

void add_look_flags(Flags& flags, LookFlags* look);
void check_look_flags(const Flags& flags,
                      const LookFlags& look);  // throws UsageError for contradictions

// The look for a field, whose array has `unit`, by the order of precedence in docs/command-line.md.
// Throws Error.
Look make_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session);

// Whether default_look() makes the look, or a part of it.
bool uses_default_look(const LookFlags& flags);

bool uses_opacity(Mode mode);  // of the transfer function
const char* name_of_mode(Mode mode);

}  // namespace ovoid::cli
