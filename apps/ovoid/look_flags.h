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

// Appearance: colours and opacities, mode, light. What is not given is the file's or the preset's,
// or else the default look's.
struct LookFlags {
  std::string file;        // a name, or JSON itself
  std::string file_name;   // which look of the file; empty: the first
  std::string color_file;  // the colours of --color-array; empty: the other flags say them
  std::string preset;
  std::string color_map;           // by name; empty: none
  std::vector<ColorPoint> colors;  // or as a list
  std::vector<OpacityPoint> opacities;
  std::vector<OpacityPoint> gradient_opacities;
  std::optional<std::pair<double, double>> range;
  bool is_window = false;  // `range` was given as window and level
  bool is_log = false;
  std::optional<double> linear_width;  // of a symmetric logarithm; none: not asked for
  std::optional<Rgb> below_color;
  std::optional<Rgb> above_color;
  std::optional<double> unit_distance;
  Mode mode = Mode::kComposite;
  double isovalue = 0;
  bool shade = false;  // asked for
  bool no_shade = false;
  std::optional<double> ambient;
  std::optional<double> diffuse;
  std::optional<double> specular;
  std::optional<double> specular_power;
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

// Whether the look shows labels as such if the field holds some: the default one does, and the
// preset for them.
bool may_be_labels(const LookFlags& flags);

// Ends for a logarithmic scale from those of the data or of a picture: where `lo` is not above 0, a
// thousandth of `hi`, with a note. Throws Error(kInvalidArgument) if nothing is above 0.
std::pair<double, double> logarithmic_range(double lo, double hi, Session& session);

// The look that the value of a flag such as --tf is: JSON itself (values.h), or a file's, the first
// or the one called `name`. Throws Error; of JSON it names the flag.
Look look_of_flag(const char* flag, const std::string& value, const std::string& name);
// Throws UsageError for JSON that is no look, before any file is read.
void check_look_of_flag(const char* flag, const std::string& value, const std::string& name);
// What notes call it: the file, or the flag.
std::string source_of_flag(const char* flag, const std::string& value);

bool uses_opacity(Mode mode);  // of the transfer function
const char* name_of_mode(Mode mode);

}  // namespace ovoid::cli
