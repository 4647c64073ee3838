// SPDX-License-Identifier: Apache-2.0
#include "flags.h"

#include <fmt/format.h>

#include <algorithm>

#include "console.h"
#include "suggest.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

constexpr std::size_t kHelpColumns = 80;  // the least width a terminal is likely to have
constexpr std::size_t kTextColumn = 30;   // where the sentences begin

// `text` broken between words, so that no line passes kHelpColumns; lines but the first are
// indented. A newline in the text starts a new line.
std::string wrapped(const std::string& text, std::size_t indent) {
  std::string out;
  std::size_t column = indent;
  bool is_first_line = true;
  for (const std::string& line : split(text, '\n')) {
    if (!is_first_line) {
      out += '\n' + std::string(line.empty() ? 0 : indent, ' ');
      column = indent;
    }
    is_first_line = false;
    bool is_first_word = true;
    for (const std::string& word : split(line, ' ')) {
      if (!is_first_word && column + 1 + word.size() > kHelpColumns) {
        out += '\n' + std::string(indent, ' ');
        column = indent;
        is_first_word = true;
      }
      out += (is_first_word ? "" : " ") + word;
      column += word.size() + (is_first_word ? 0 : 1);
      is_first_word = false;
    }
  }
  return out;
}

// "-o,--output", with any separator.
std::string names_of(const FlagForm& flag, const char* separator) {
  const std::string name = "--" + flag.name;
  return flag.short_name.empty() ? name : "-" + flag.short_name + separator + name;
}

bool takes_next_word(const FlagForm& flag) {
  return flag.kind == FlagKind::kValue || flag.kind == FlagKind::kRepeatable;
}

// A word that begins with a dash, as a flag.
struct Named {
  const FlagForm* form = nullptr;    // null: unknown
  std::string name;                  // as it was written
  std::optional<std::string> value;  // behind an equals sign, or behind a short name
};

Named named(const std::string& word, const std::vector<FlagForm>& forms) {
  Named flag;
  if (word.starts_with("--")) {
    const std::size_t end = word.find('=');
    flag.name = word.substr(0, end);
    flag.form = find_form(forms, flag.name.substr(2));
    if (end != std::string::npos) flag.value = word.substr(end + 1);
    return flag;
  }
  for (const FlagForm& form : forms) {
    if (form.short_name.empty() || word.compare(1, form.short_name.size(), form.short_name) != 0)
      continue;
    flag.form = &form;
    flag.name = "-" + form.short_name;
    if (word.size() > flag.name.size()) flag.value = word.substr(flag.name.size());
    if (flag.value && flag.value->front() == '=') flag.value->erase(0, 1);
    return flag;
  }
  flag.name = word.substr(0, word.find('='));
  return flag;
}

void add_given(std::vector<GivenFlag>& given, const FlagForm& form,
               const std::optional<std::string>& value) {
  auto place = std::find_if(given.begin(), given.end(),
                            [&](const GivenFlag& flag) { return flag.name == form.name; });
  if (place == given.end()) {
    place = given.insert(given.end(), GivenFlag{form.name, {}, false, 0});
  }
  ++place->times;
  place->has_value = place->has_value || value;
  if (value) place->values.push_back(*value);
}

}  // namespace

const GivenFlag* find_given(const std::vector<GivenFlag>& given, const std::string& name) {
  const auto place = std::find_if(given.begin(), given.end(),
                                  [&](const GivenFlag& flag) { return flag.name == name; });
  return place == given.end() ? nullptr : &*place;
}

const FlagForm* find_form(const std::vector<FlagForm>& forms, const std::string& name) {
  const auto place = std::find_if(forms.begin(), forms.end(),
                                  [&](const FlagForm& form) { return form.name == name; });
  return place == forms.end() ? nullptr : &*place;
}

Line take_apart(const Words& words, const std::vector<FlagForm>& forms) {
  Line line;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--") {
      line.others.insert(line.others.end(), words.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                         words.end());
      break;
    }
    if (words[i].size() < 2 || words[i].front() != '-') {
      line.others.push_back(words[i]);
      continue;
    }
    auto [form, name, value] = named(words[i], forms);
    if (form == nullptr && (name == "-h" || name == "--help")) {
      line.asks_for_help = true;
    } else if (form == nullptr) {
      line.unknown.push_back(name);
    } else {
      const bool is_empty = value && value->empty();
      const bool is_last = i + 1 == words.size();
      const bool lacks_value = is_empty || (!value && takes_next_word(*form) && is_last);
      if (form->kind == FlagKind::kToggle && value) {
        if (line.problem.empty()) line.problem = name + ": takes no value";
      } else if (lacks_value && line.problem.empty()) {
        line.problem = fmt::format("{}: expected a value, {}", name, form->form);
      }
      if (!value && !is_last && takes_next_word(*form)) value = words[++i];
      add_given(line.given, *form, value);
    }
  }
  return line;
}

std::optional<std::string> found(Test test, const GivenFlag* flag) {
  if (flag == nullptr) return std::nullopt;
  const std::string value = flag->has_value ? flag->values.front() : "";
  if (test == nullptr) return value;
  try {
    return test(value);
  } catch (const BadValue&) {
    return std::nullopt;
  }
}

namespace {

// What the rule says of the flag; empty: it is kept.
std::string breach(const Rule& rule, const GivenFlag& flag, const std::vector<FlagForm>& forms,
                   const std::vector<GivenFlag>& given) {
  const auto own = found(rule.own_test, &flag);
  const auto is_given = [&](const std::string& name) { return find_given(given, name) != nullptr; };
  if (!own || rule.kind == Rule::Kind::kForData ||
      std::any_of(rule.unless.begin(), rule.unless.end(), is_given))
    return "";
  for (const std::string& name : rule.others) {
    const auto other = found(rule.other_test, find_given(given, name));
    if (!other) continue;
    if (rule.kind == Rule::Kind::kNeeds) return "";
    return fmt::format("--{}: {}", flag.name,
                       fmt::format(fmt::runtime(rule.message), "--" + name, *other, *own));
  }
  const bool has_any = std::any_of(rule.others.begin(), rule.others.end(), [&](const auto& name) {
    return find_form(forms, name) != nullptr;
  });
  if (rule.kind != Rule::Kind::kNeeds || !has_any) return "";
  return fmt::format("--{}{}: {}", flag.name, rule.own_test ? " " + *own : "", rule.message);
}

}  // namespace

void check_rules(const std::vector<FlagForm>& forms, const std::vector<GivenFlag>& given) {
  for (const FlagForm& form : forms) {
    const GivenFlag* const flag = find_given(given, form.name);
    if (flag == nullptr) continue;
    for (const Rule& rule : form.rules) {
      const std::string said = breach(rule, *flag, forms, given);
      if (!said.empty()) throw UsageError(said);
    }
  }
}

Flags::Flags(std::string command, std::string usage, std::string summary)
    : command_(std::move(command)), usage_(std::move(usage)), summary_(std::move(summary)) {}

void Flags::section(std::string title) { sections_.push_back({std::move(title), {}}); }

void Flags::footer(std::string text) { footer_ = std::move(text); }

void Flags::refuse(std::string name, std::string why) {
  refused_.emplace_back(std::move(name), std::move(why));
}

void Flags::add_line(const std::string& shown, const std::string& text) {
  if (sections_.empty()) sections_.emplace_back();
  sections_.back().entries.push_back({shown, text});
}

void Flags::positionals(const std::string& name, const std::string& text, Words* into) {
  positionals_ = into;
  add_line(name, text);
}

void Flags::explain(const std::string& name, const std::string& text) { add_line(name, text); }

void Flags::declare(const FlagForm& form, Take take) {
  forms_.push_back(form);
  takes_.push_back(std::move(take));
  const bool is_apart = takes_next_word(form);
  add_line(names_of(form, ", ") + (is_apart ? " " : "") + form.form, form.text);
}

bool Flags::is_given(const std::string& name) const {
  return find_given(line_.given, name) != nullptr;
}

void Flags::explain_unknown() const {
  std::vector<std::string> known = {"--help"};
  for (const FlagForm& flag : forms_) known.push_back("--" + flag.name);
  const std::string& name = line_.unknown.front();
  throw UsageError(fmt::format("{}: unknown flag{} (see ovoid {} --help)", name,
                               did_you_mean(name, known), command_));
}

void Flags::take_values() const {
  for (std::size_t i = 0; i < forms_.size(); ++i) {
    const GivenFlag* const flag = find_given(line_.given, forms_[i].name);
    if (flag == nullptr) continue;
    for (const std::string& value : flag->has_value ? flag->values : Words{""}) {
      try {
        takes_[i](value);
      } catch (const BadValue& bad) {
        throw UsageError(fmt::format("--{} '{}': {}", forms_[i].name, value, bad.what()));
      }
    }
  }
}

bool Flags::parse(const Words& words) {
  if (words.size() == 1 && words[0] == kListFlags) {
    for (const FlagForm& flag : forms_)
      print_out("{}\t{}\t{}\n", names_of(flag, ","), flag.form, flag.text);
    print_out("-h,--help\t\tthis help\n");
    return false;
  }
  line_ = take_apart(words, forms_);
  if (!line_.problem.empty()) throw UsageError(line_.problem);
  for (const std::string& name : line_.unknown) {
    for (const auto& [refused, why] : refused_) {
      if (name == refused) throw UsageError(fmt::format("{}: {}", name, why));
    }
  }
  take_values();
  if (line_.asks_for_help) {
    print_out("{}", help());
    return false;
  }
  if (!line_.unknown.empty()) explain_unknown();
  if (positionals_ != nullptr) {
    *positionals_ = line_.others;
  } else if (!line_.others.empty()) {
    throw UsageError(fmt::format("'{}': unexpected argument (see ovoid {} --help)",
                                 line_.others.front(), command_));
  }
  for (const FlagForm& form : forms_) {
    const GivenFlag* const flag = find_given(line_.given, form.name);
    if (flag != nullptr && flag->times > 1 && form.kind != FlagKind::kRepeatable)
      throw UsageError(fmt::format("--{}: given {} times, expected once", form.name, flag->times));
  }
  check_rules(forms_, line_.given);
  return true;
}

std::string Flags::help() const {
  std::string out =
      fmt::format("usage: ovoid {} {}\n\n{}\n", command_, usage_, wrapped(summary_, 0));
  for (const Section& section : sections_) {
    out += section.title.empty() ? "\n" : fmt::format("\n{}:\n", section.title);
    for (const Entry& entry : section.entries) {
      std::string line = "  " + entry.shown;
      if (line.size() + 2 > kTextColumn) {
        line += '\n' + std::string(kTextColumn, ' ');
      } else {
        line += std::string(kTextColumn - line.size(), ' ');
      }
      out += line + wrapped(entry.text, kTextColumn) + '\n';
    }
  }
  if (!footer_.empty()) out += '\n' + wrapped(footer_, 0) + '\n';
  return out;
}

}  // namespace ovoid::cli
