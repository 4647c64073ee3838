// SPDX-License-Identifier: Apache-2.0
// A setting is declared once, as a row of a table (settings.h): its flag, what its value means, how
// that is parsed and told, what it is refused with or without, and which data it is for. Help,
// completion, checks, state files and the window's commands come from the rows.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/dataset.h"
#include "values.h"

namespace ovoid::cli {

enum class FlagKind { kToggle, kValue, kRepeatable, kOptionalValue };

// What the text of a value stands for, beyond itself. kFile is the name of a file or folder that is
// read; kLook, kCamera and kLabels are a file's name or JSON itself; kOfRun is for the command line
// alone: what a run writes, or takes its flags from.
enum class Content { kText, kFile, kLook, kCamera, kLabels, kOfRun };

// What a rule finds in the text of a value, as its message shows it; none: the rule is about other
// values. A value that cannot be parsed (BadValue) is another value.
using Test = std::optional<std::string> (*)(const std::string& value);

// What a flag is refused with, what it is refused without, or which data it is for. Of flags that
// the command does not have a rule says nothing.
struct Rule {
  enum class Kind { kNotWith, kNeeds, kForData };
  Kind kind;
  std::vector<std::string> others;  // of kNeeds one is enough
  // Stands behind the flag's name; {0} is the other flag, {1} what was found of its value, {2} of
  // the flag's own.
  std::string message;
  Test other_test = nullptr;  // null: whatever its value
  Test own_test = nullptr;
  std::vector<std::string> unless{};  // one of these is given, too
  std::vector<DatasetKind> kinds{};   // of kForData, whose message names them
};
using Rules = std::vector<Rule>;

inline constexpr const char* kGiveOne = "contradicts {0}; give one of them";
// `others`: names with blanks between.
inline Rule not_with(const std::string& others, std::string message = "contradicts {0}",
                     Test other_test = nullptr, Test own_test = nullptr) {
  return {Rule::Kind::kNotWith, split(others, ' '), std::move(message), other_test, own_test};
}
inline Rule needs(const std::string& one_of, std::string message, Test other_test = nullptr,
                  Test own_test = nullptr) {
  return {Rule::Kind::kNeeds, split(one_of, ' '), std::move(message), other_test, own_test};
}
inline Rule for_data(std::vector<DatasetKind> kinds, std::string meant) {
  return {Rule::Kind::kForData, {}, std::move(meant), nullptr, nullptr, {}, std::move(kinds)};
}

// A row without the values that it is about.
struct FlagForm {
  std::string name;        // long, without dashes: "output"
  std::string short_name;  // without dash: "o"; empty: none
  FlagKind kind = FlagKind::kToggle;
  std::string form;  // "OUT", "[=TITLE]"; empty for toggles
  std::string text;
  Content content = Content::kText;
  Rules rules;
};

// How values of a type are written.
template <class T>
struct Form {
  std::string shown;                            // "WIDTHxHEIGHT", as the help has it
  std::function<T(const std::string&)> parse;   // throws BadValue
  std::function<std::string(const T&)> tell{};  // what parse() takes; none: is not told
  Content content = Content::kText;
};

inline Form<std::string> word(std::string shown, Content content = Content::kText) {
  const auto same = [](const std::string& text) { return text; };
  return {std::move(shown), same, same, content};
}
inline Form<std::string> look_file() { return word("FILE|JSON", Content::kLook); }

inline Form<double> number(std::string shown, const Interval& interval = {}) {
  return {std::move(shown),
          [interval](const std::string& text) { return parse_number(text, interval); },
          [](const double& value) { return fmt::format("{}", value); }};
}

template <class T = int>
Form<T> integer(std::string shown, std::int64_t lo, std::int64_t hi) {
  return {std::move(shown),
          [lo, hi](const std::string& text) { return static_cast<T>(parse_integer(text, lo, hi)); },
          [](const T& value) { return fmt::format("{}", value); }};
}

template <class T = std::size_t>
Form<T> bytes(std::string shown) {
  return {std::move(shown),
          [](const std::string& text) { return static_cast<T>(parse_bytes(text)); },
          [](const T& value) { return fmt::format("{}", value); }};
}

// One name of a table.
template <class T>
Form<T> choice(const Names<T>& names, std::string shown = "") {
  return {shown.empty() ? joined(names) : std::move(shown),
          [names](const std::string& text) { return parse_name(text, names); },
          [names](const T& value) { return std::string(name_in(names, value)); }};
}

// Where a value lies: a member, or a member of a member.
template <class A, class B>
auto at(A outer, B inner) {
  return [=](auto& settings) -> auto& { return settings.*outer.*inner; };
}

struct Toggle {
  bool set_to = true;
};

// A value that is taken and told in its own way, as it is more than one member.
template <class S>
struct Own {
  std::string shown;
  std::function<void(S&, const std::string&)> take;
  std::function<nlohmann::ordered_json(const S&)> tell;  // null: as it is without the flag
  Content content = Content::kText;
  bool is_repeatable = false;
};

// A row of the table of the settings in an S.
template <class S>
struct Setting {
  using Json = nlohmann::ordered_json;

  FlagForm flag;
  std::function<void(S&, const std::string&)> take;
  std::function<Json(const S&)> tell;  // null: as it is without the flag

  // `get` leads to a T, which then is the flag's default and {} in `text`, to a std::optional of
  // it, or to a vector of a flag that may be repeated.
  template <class T, class Get, std::same_as<Rule>... R>
  Setting(const char* names, const Form<T>& form, Get get, const std::string& text, R... rules)
      : Setting(names, form.shown, text, form.content, Rules{std::move(rules)...}) {
    using Member = std::remove_cvref_t<decltype(std::invoke(get, std::declval<S&>()))>;
    if constexpr (std::is_same_v<Member, T>) {
      take = [=](S& s, const std::string& value) { std::invoke(get, s) = form.parse(value); };
      if (!form.tell) return;
      const S defaults{};
      const std::string usual = form.tell(std::invoke(get, defaults));
      tell = [=](const S& s) {
        const std::string told = form.tell(std::invoke(get, s));
        return told == usual ? Json() : Json(told);
      };
      if (const auto place = flag.text.find("{}"); place != std::string::npos)
        flag.text.replace(place, 2, usual);
    } else if constexpr (std::is_same_v<Member, std::optional<T>>) {
      take = [=](S& s, const std::string& value) { std::invoke(get, s) = form.parse(value); };
      tell = [=](const S& s) {
        const auto& value = std::invoke(get, s);
        return value ? Json(form.tell(*value)) : Json();
      };
    } else {
      flag.kind = FlagKind::kRepeatable;
      take = [=](S& s, const std::string& v) { std::invoke(get, s).push_back(form.parse(v)); };
      tell = [=](const S& s) {
        Json all;
        for (const T& value : std::invoke(get, s)) all.push_back(form.tell(value));
        return all;
      };
    }
  }

  template <class Get, std::same_as<Rule>... R>
  Setting(const char* names, Toggle toggle, Get get, const std::string& text, R... rules)
      : Setting(names, "", text, Content::kText, Rules{std::move(rules)...}) {
    take = [=](S& s, const std::string&) { std::invoke(get, s) = toggle.set_to; };
    tell = [=](const S& s) { return std::invoke(get, s) == toggle.set_to ? Json(true) : Json(); };
  }

  template <std::same_as<Rule>... R>
  Setting(const char* names, const Own<S>& own, const std::string& text, R... rules)
      : Setting(names, own.shown, text, own.content, Rules{std::move(rules)...}) {
    if (own.is_repeatable) flag.kind = FlagKind::kRepeatable;
    take = own.take;
    tell = own.tell;
  }

 private:
  Setting(const std::string& names, const std::string& form, const std::string& text,
          Content content, Rules rules)
      : flag{split(names, ',').back().substr(2),
             "",
             FlagKind::kToggle,
             form,
             text,
             content,
             std::move(rules)} {
    if (const auto comma = names.find(','); comma != std::string::npos)
      flag.short_name = names.substr(1, comma - 1);
    if (!form.empty())
      flag.kind = form.front() == '[' ? FlagKind::kOptionalValue : FlagKind::kValue;
  }
};

template <class S>
using Table = std::vector<Setting<S>>;

}  // namespace ovoid::cli
