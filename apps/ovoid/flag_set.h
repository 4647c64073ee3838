// SPDX-License-Identifier: Apache-2.0
// Flags of `ovoid render` as data: what a state file keeps, and what another program can turn into
// a command line.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "flags.h"

namespace ovoid::cli {

// Flags by their long names without dashes, in the order in which they were set. The value of a
// toggle is true, of a flag with a value a string, of a repeatable flag an array of strings, of a
// flag with an optional value true or a string; looks and cameras may also be JSON itself, an
// object (of looks also an array of them), which is kept as such so that people can edit it. What
// says what a run writes or reads its flags from (Content::kOfRun) is no part of a set.
// Values are checked for their kind, not for their meaning: check_render_flags() does that.
class FlagSet {
 public:
  using Json = nlohmann::ordered_json;
  struct Flag {
    std::string name;
    Json value;
  };

  // Those of a command line that a set can hold.
  static FlagSet of(const std::vector<GivenFlag>& given);

  // An object of names and values. Throws Error(kFileFormat) that begins with `place` and names the
  // flag: "s.json: flags.size = 640: must be a string".
  static FlagSet from_json(const Json& json, const std::string& place = "flags");
  Json to_json() const;

  // A flag that is set already keeps its place. A string that is JSON itself becomes JSON. Throws
  // Error(kInvalidArgument) for unknown names and values of another kind.
  void set(const std::string& name, Json value);
  bool erase(const std::string& name);              // whether it was there
  const Json* find(const std::string& name) const;  // null: not set

  bool empty() const noexcept { return flags_.empty(); }
  const std::vector<Flag>& flags() const noexcept { return flags_; }

  // As they would stand on the command line: {"--size", "640x480", "--no-shade"}; JSON in one line,
  // its numbers in the fewest digits that read back the same. Throws Error(kInvalidArgument) for
  // text that is not UTF-8 within JSON.
  Words words() const;

 private:
  std::vector<Flag> flags_;
};

// The form of a flag of render, by its long name without dashes; null: there is none.
const FlagForm* find_render_flag(const std::string& name);

// Whether the string value of a flag, or one of several, is the name of a file or folder that is
// read.
bool names_file(const std::string& flag, const std::string& value);

}  // namespace ovoid::cli
