// SPDX-License-Identifier: Apache-2.0
#include "state_words.h"

#include <algorithm>
#include <string>

#include "session.h"
#include "state_file.h"

namespace ovoid::cli {
namespace {

// The flag as a line would give it; of toggles and JSON without a value.
std::optional<GivenFlag> given_in(const FlagSet& flags, const std::string& name) {
  const FlagSet::Json* const value = flags.find(name);
  if (value == nullptr) return std::nullopt;
  GivenFlag flag{name, {}, value->is_string()};
  if (flag.has_value) flag.values.push_back(value->get<std::string>());
  return flag;
}

// Whether the test finds something in the flag of the set.
bool holds(Test test, const FlagSet& flags, const std::string& name) {
  const std::optional<GivenFlag> flag = given_in(flags, name);
  return flag && found(test, &*flag);
}

// Drops of the set what the line's flags contradict.
void drop_contradicted(const FlagForm& form, const Rule& rule, const std::vector<GivenFlag>& line,
                       FlagSet& flags) {
  const bool own_is_given = found(rule.own_test, find_given(line, form.name)).has_value();
  for (const std::string& name : rule.others) {
    const bool is_given = found(rule.other_test, find_given(line, name)).has_value();
    if (own_is_given && holds(rule.other_test, flags, name)) flags.erase(name);
    if (is_given && holds(rule.own_test, flags, form.name)) flags.erase(form.name);
  }
}

bool lacks(const FlagForm& form, const Rule& rule, const std::vector<GivenFlag>& line,
           const FlagSet& flags) {
  return rule.kind == Rule::Kind::kNeeds && holds(rule.own_test, flags, form.name) &&
         std::none_of(rule.others.begin(), rule.others.end(), [&](const std::string& name) {
           return found(rule.other_test, find_given(line, name)) ||
                  holds(rule.other_test, flags, name);
         });
}

FlagSet beaten_by(const std::vector<GivenFlag>& line, FlagSet flags,
                  const std::vector<FlagForm>& forms) {
  // It names a look of the state's file.
  if (find_given(line, "tf") != nullptr) flags.erase("tf-name");
  for (const GivenFlag& flag : line) flags.erase(flag.name);
  for (const FlagForm& form : forms) {
    for (const Rule& rule : form.rules) {
      if (rule.kind == Rule::Kind::kNotWith) drop_contradicted(form, rule, line, flags);
    }
  }
  // What is dropped may be what another flag needs.
  for (bool is_done = false; !is_done;) {
    is_done = true;
    for (const FlagForm& form : forms) {
      const bool is_lost = std::any_of(form.rules.begin(), form.rules.end(), [&](const Rule& rule) {
        return lacks(form, rule, line, flags);
      });
      if (is_lost && flags.erase(form.name)) is_done = false;
    }
  }
  return flags;
}

}  // namespace

Words with_state(const Words& words, const std::vector<FlagForm>& forms) {
  const Line line = take_apart(words, forms);
  const GivenFlag* const given = find_given(line.given, "state");
  const bool is_right = line.problem.empty() && line.unknown.empty() && !line.asks_for_help;
  if (!is_right || given == nullptr || given->times != 1 || given->values.front().empty())
    return words;
  const State state = read_state(given->values.front());
  Words all;
  if (line.others.empty()) all = state.inputs;
  const Words kept = beaten_by(line.given, state.flags, forms).words();
  all.insert(all.end(), kept.begin(), kept.end());
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace ovoid::cli
