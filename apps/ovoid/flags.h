// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

namespace ovoid::cli {

inline constexpr const char* kListFlags = "--list-flags";

enum class FlagKind { kToggle, kValue, kRepeatable, kOptionalValue };

// How a flag is given.
struct FlagForm {
  std::string name;        // long, without dashes: "output"
  std::string short_name;  // without dash: "o"; empty: none
  FlagKind kind = FlagKind::kToggle;
};

// A flag as it stood on the command line. `values` are several of a repeatable flag, and none of a
// toggle or where an optional value is missing.
struct GivenFlag {
  std::string name;  // as FlagForm has it
  std::vector<std::string> values;
  bool has_value = false;
};

// The flags of one command. CLI11 takes the command line apart; this class keeps the words of each
// flag, so that parsing, help text and error messages come from one declaration. Sections group the
// help; a flag belongs to the section opened last.
class Flags {
 public:
  using Take = std::function<void(const std::string& value)>;  // may throw BadValue (values.h)

  // `usage` is the line under which the help stands: "INPUT... -o OUT".
  Flags(std::string command, std::string usage, std::string summary);
  ~Flags();
  Flags(const Flags&) = delete;
  Flags& operator=(const Flags&) = delete;

  void section(std::string title);

  // Arguments that are not flags, kept in order.
  void positionals(const std::string& name, const std::string& text,
                   std::vector<std::string>* into);

  // A flag with a value of the form `form`; names are like "--size" or "-o,--output". Given at most
  // once, except `repeatable` ones.
  void value(const std::string& names, const std::string& form, const std::string& text,
             const Take& take);
  void repeatable(const std::string& names, const std::string& form, const std::string& text,
                  const Take& take);

  // A flag without a value; it sets `*into` to `set_to`.
  void toggle(const std::string& names, const std::string& text, bool* into, bool set_to = true);

  // A flag whose value is optional and must follow an equals sign ("--profile", "--profile=FILE"):
  // `take` gets "" without one.
  void optional_value(const std::string& names, const std::string& form, const std::string& text,
                      const Take& take);

  // Flags of a later version: an error by their name, whatever follows them. Not in the help.
  void refuse(std::initializer_list<const char*> names);

  // A line of the help that is no flag: a name that a positional may take.
  void explain(const std::string& name, const std::string& text);

  // A paragraph printed under the flags.
  void footer(std::string text);

  // Takes the words after the command's name. Prints the help, or with the only word kListFlags the
  // flags for a shell to complete (names, form, sentence, with tabs between), and returns false if
  // that was asked for. Throws UsageError.
  bool parse(const std::vector<std::string>& words);

  // The flags given on the command line, in the order in which each stands there first; what is no
  // flag is apart. With its form (forms()) each can be written again: an optional value stands
  // behind an equals sign.
  std::vector<GivenFlag> given() const;

  // All flags that were declared and not refused, in that order; --help is none of them.
  std::vector<FlagForm> forms() const;

  bool is_given(const std::string& name) const;
  // The first of `names` that is on the command line, or null.
  const char* first_given(std::initializer_list<const char*> names) const;

  const std::string& command() const noexcept;
  std::string help() const;

 private:
  struct Impl;  // keeps CLI11's header, which takes long to compile, out of every other file
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovoid::cli
