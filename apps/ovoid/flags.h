// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "setting.h"

namespace ovoid::cli {

inline constexpr const char* kListFlags = "--list-flags";

using Words = std::vector<std::string>;

// A flag as it stood on the command line. `values` are several of a repeatable flag, and none of a
// toggle or where an optional value is missing.
struct GivenFlag {
  std::string name;  // as FlagForm has it
  std::vector<std::string> values;
  bool has_value = false;
  int times = 1;
};

// A command line taken apart, whatever its values mean. A word behind "--" is no flag.
struct Line {
  std::vector<GivenFlag> given;  // in the order in which each stands there first
  Words others;                  // what is no flag
  Words unknown;                 // flags that are not among the forms, up to an equals sign
  std::string problem;           // the first value that is missing, or too much; empty: none
  bool asks_for_help = false;
};
Line take_apart(const Words& words, const std::vector<FlagForm>& forms);

// The flags of one command: the rows of some tables and the values that they set, in sections that
// group the help.
class Flags {
 public:
  // `usage` is the line under which the help stands: "INPUT... -o OUT".
  Flags(std::string command, std::string usage, std::string summary);

  void section(std::string title);
  // The rows, in the section opened last. `into` outlives parse().
  template <class S>
  void add(const Table<S>& table, S* into) {
    for (const Setting<S>& setting : table) {
      declare(setting.flag, [take = setting.take, into](const std::string& v) { take(*into, v); });
    }
  }

  // Arguments that are not flags, kept in order.
  void positionals(const std::string& name, const std::string& text,
                   std::vector<std::string>* into);
  // A flag that others have, or a later version: an error by its name. Not in the help.
  void refuse(std::string name, std::string why = "not available in this version");
  // A line of the help that is no flag: a name that a positional may take.
  void explain(const std::string& name, const std::string& text);
  // A paragraph printed under the flags.
  void footer(std::string text);

  // Takes the words after the command's name, and checks the rules. Prints the help, or with the
  // only word kListFlags the flags for a shell to complete (names, form, sentence, with tabs
  // between), and returns false if that was asked for. Throws UsageError.
  bool parse(const Words& words);

  // The flags given on the command line, in the order in which each stands there first. With its
  // form each can be written again: an optional value stands behind an equals sign.
  const std::vector<GivenFlag>& given() const noexcept { return line_.given; }
  const std::vector<FlagForm>& forms() const noexcept { return forms_; }

  bool is_given(const std::string& name) const;  // without dashes
  // The first flag of a table that is on the command line, with dashes; empty: none.
  template <class S>
  std::string first_given(const Table<S>& table) const {
    for (const Setting<S>& setting : table) {
      if (is_given(setting.flag.name)) return "--" + setting.flag.name;
    }
    return "";
  }

  const std::string& command() const noexcept { return command_; }
  std::string help() const;

 private:
  struct Entry {
    std::string shown;  // "-o, --output OUT"
    std::string text;
  };
  struct Section {
    std::string title;
    std::vector<Entry> entries;
  };

  using Take = std::function<void(const std::string& value)>;

  void declare(const FlagForm& form, Take take);
  void add_line(const std::string& shown, const std::string& text);
  void take_values() const;
  [[noreturn]] void explain_unknown() const;

  std::string command_, usage_, summary_, footer_;
  std::vector<Section> sections_;
  std::vector<FlagForm> forms_;
  std::vector<Take> takes_;                                   // of each form
  std::vector<std::pair<std::string, std::string>> refused_;  // and why
  Words* positionals_ = nullptr;
  Line line_;
};

const GivenFlag* find_given(const std::vector<GivenFlag>& given, const std::string& name);
const FlagForm* find_form(const std::vector<FlagForm>& forms, const std::string& name);

// What a test finds in the value of a flag, which is its value where there is no test; none: the
// flag is not given, or its value is another.
std::optional<std::string> found(Test test, const GivenFlag* flag);

// Throws UsageError for the first rule that the flags break.
void check_rules(const std::vector<FlagForm>& forms, const std::vector<GivenFlag>& given);

}  // namespace ovoid::cli
