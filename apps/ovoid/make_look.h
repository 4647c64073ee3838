// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "ovoid/field.h"
#include "ovoid/look.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// The default look of a field, made when it is first asked for: that reads all samples, and a scene
// that is drawn again and again needs it for every frame. Not thread-safe.
class UsualLook {
 public:
  struct Found {
    Look look;
    bool is_noisy = false;  // so much that a wider kernel is worth advising
  };
  const Found& of(const Field& field, const std::string& unit) const;
  // That one instead.
  void set(Look look) { found_ = Found{std::move(look)}; }

 private:
  mutable std::optional<Found> found_;
};

// The look for a field, whose array has `unit`, by the order of precedence in docs/command-line.md.
// `usual`: the field's. Throws Error.
Look make_look(const LookFlags& flags, const Field& field, const std::string& unit,
               Session& session, const UsualLook& usual = {});

// Moves a preset that is in Hounsfield units to where the data have them, or have air and bone; the
// others stay. Returns what it had to assume, in words; empty: nothing.
std::string place_hounsfield_units(TransferFunction& tf, const Field& field,
                                   const std::string& unit);

// Of a look that says nothing of it: what is seen at once, and costs little (docs/performance.md).
inline constexpr double kUsualOcclusion = 0.4;

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
// What notes call it: the file, or the flag.
std::string source_of_flag(const char* flag, const std::string& value);

bool uses_opacity(Mode mode);  // of the transfer function

}  // namespace ovoid::cli
