// SPDX-License-Identifier: Apache-2.0
#include "flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <utility>

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

// "-o,--output" as the flag that messages name: the long form if there is one.
std::string long_name(const std::string& names) { return split(names, ',').back(); }

// "output", of "-o,--output".
std::string bare_name(const std::string& names) {
  const std::string name = long_name(names);
  return name.substr(name.find_first_not_of('-'));
}

// "-o, --output OUT", "--profile[=FILE]"
std::string shown(const std::string& names, const std::string& form) {
  std::string out;
  for (const std::string& name : split(names, ',')) out += (out.empty() ? "" : ", ") + name;
  if (!form.empty()) out += form.front() == '[' ? form : ' ' + form;
  return out;
}

struct Entry {
  std::string names;  // "-o,--output"
  std::string form;   // "OUT"; empty for flags without a value and what is no flag
  std::string text;
  CLI::Option* option = nullptr;  // null for what is no flag
  bool is_repeatable = false;

  FlagKind kind() const {
    if (form.empty()) return FlagKind::kToggle;
    if (form.front() == '[') return FlagKind::kOptionalValue;
    return is_repeatable ? FlagKind::kRepeatable : FlagKind::kValue;
  }
};

struct Section {
  std::string title;
  std::vector<Entry> entries;
};

// What CLI11 would take differently from what was meant, or report without naming it.
void check_words(const Entry& flag, const std::vector<std::string>& words) {
  const bool takes_value = !flag.form.empty();
  const bool is_optional = takes_value && flag.form.front() == '[';
  for (const std::string& name : split(flag.names, ',')) {
    for (const std::string& word : words) {
      if (word == "--") break;
      const bool has_value = word.rfind(name + '=', 0) == 0;
      const bool has_nothing = has_value && word.size() == name.size() + 1;
      const bool is_last = word == name && &word == &words.back();
      if (has_value && !takes_value) throw UsageError(name + ": takes no value");
      if (has_nothing || (is_last && takes_value && !is_optional)) {
        throw UsageError(fmt::format("{}: expected a value, {}", name, flag.form));
      }
    }
  }
}

}  // namespace

struct Flags::Impl {
  std::string command;
  std::string usage;
  std::string summary;
  std::string footer;
  std::vector<Section> sections;
  CLI::App app;

  void add(Entry entry);
  CLI::Option* add_taker(const std::string& names, const Take& take);
  std::vector<const Entry*> flags() const;
  [[noreturn]] void explain_extras() const;
};

void Flags::Impl::add(Entry entry) {
  if (sections.empty()) sections.emplace_back();
  sections.back().entries.push_back(std::move(entry));
}

// An option that hands every value it is given to `take`, and completes what `take` complains
// about.
CLI::Option* Flags::Impl::add_taker(const std::string& names, const Take& take) {
  const CLI::callback_t take_all = [names, take](const CLI::results_t& given) {
    for (const std::string& value : given) {
      try {
        take(value);
      } catch (const BadValue& bad) {
        throw UsageError(fmt::format("{} '{}': {}", long_name(names), value, bad.what()));
      }
    }
    return true;
  };
  CLI::Option* const option = app.add_option(names, take_all);
  return option->type_size(1)->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

std::vector<const Entry*> Flags::Impl::flags() const {
  std::vector<const Entry*> found;
  for (const Section& section : sections) {
    for (const Entry& entry : section.entries) {
      if (entry.option != nullptr) found.push_back(&entry);
    }
  }
  return found;
}

void Flags::Impl::explain_extras() const {
  std::vector<std::string> known = {"--help"};
  for (const Entry* const flag : flags()) known.push_back(long_name(flag->names));
  const std::vector<std::string> extras = app.remaining();
  for (const std::string& extra : extras) {
    if (extra.size() < 2 || extra.front() != '-') continue;
    const std::string name = extra.substr(0, extra.find('='));
    throw UsageError(fmt::format("{}: unknown flag{} (see ovoid {} --help)", name,
                                 did_you_mean(name, known), command));
  }
  throw UsageError(
      fmt::format("'{}': unexpected argument (see ovoid {} --help)", extras.front(), command));
}

Flags::Flags(std::string command, std::string usage, std::string summary)
    : impl_(std::make_unique<Impl>()) {
  impl_->command = std::move(command);
  impl_->usage = std::move(usage);
  impl_->summary = std::move(summary);
  impl_->app.set_help_flag("-h,--help", "");
  impl_->app.allow_windows_style_options(false);
}

Flags::~Flags() = default;

const std::string& Flags::command() const noexcept { return impl_->command; }

void Flags::section(std::string title) { impl_->sections.push_back({std::move(title), {}}); }

void Flags::footer(std::string text) { impl_->footer = std::move(text); }

void Flags::positionals(const std::string& name, const std::string& text,
                        std::vector<std::string>* into) {
  impl_->app.add_option(name, *into);
  impl_->add({name, "", text});
}

void Flags::explain(const std::string& name, const std::string& text) {
  impl_->add({name, "", text});
}

void Flags::value(const std::string& names, const std::string& form, const std::string& text,
                  const Take& take) {
  impl_->add({names, form, text, impl_->add_taker(names, take)});
}

void Flags::repeatable(const std::string& names, const std::string& form, const std::string& text,
                       const Take& take) {
  impl_->add({names, form, text, impl_->add_taker(names, take), true});
}

void Flags::toggle(const std::string& names, const std::string& text, bool* into, bool set_to) {
  const auto set = [into, set_to](std::int64_t) { *into = set_to; };
  CLI::Option* const option = impl_->app.add_flag_function(names, set);
  option->disable_flag_override();
  impl_->add({names, "", text, option});
}

void Flags::optional_value(const std::string& names, const std::string& form,
                           const std::string& text, const Take& take) {
  // CLI11 stores "true" for a flag without a value, so a value of exactly that name cannot be
  // given.
  const Take take_or_default = [take](const std::string& value) {
    take(value == "true" ? "" : value);
  };
  CLI::Option* const option = impl_->add_taker(names, take_or_default);
  option->type_size(0)->expected(0);
  impl_->add({names, form, text, option});
}

void Flags::refuse(std::initializer_list<const char*> names) {
  for (const char* const name : names) {
    const CLI::callback_t refuse_it = [name](const CLI::results_t&) -> bool {
      throw UsageError(fmt::format("{}: not available in this version", name));
    };
    CLI::Option* const option = impl_->app.add_option(name, refuse_it);
    option->type_size(1)->expected(0, 1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }
}

bool Flags::parse(const std::vector<std::string>& words) {
  if (words.size() == 1 && words[0] == kListFlags) {
    for (const Entry* const flag : impl_->flags())
      print_out("{}\t{}\t{}\n", flag->names, flag->form, flag->text);
    print_out("-h,--help\t\tthis help\n");
    return false;
  }
  for (const Entry* const flag : impl_->flags()) check_words(*flag, words);
  try {
    // CLI11 wants the last word first.
    impl_->app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForHelp&) {
    print_out("{}", help());
    return false;
  } catch (const CLI::ExtrasError&) {
    impl_->explain_extras();
  } catch (const CLI::ParseError& error) {
    throw UsageError(fmt::format("{} (see ovoid {} --help)", error.what(), impl_->command));
  }
  for (const Entry* const flag : impl_->flags()) {
    if (flag->is_repeatable || flag->option->count() < 2) continue;
    throw UsageError(fmt::format("{}: given {} times, expected once", long_name(flag->names),
                                 flag->option->count()));
  }
  return true;
}

std::vector<GivenFlag> Flags::given() const {
  std::vector<GivenFlag> all;
  const std::vector<const Entry*> known = impl_->flags();
  for (const CLI::Option* const option : impl_->app.parse_order()) {
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const Entry* entry) { return entry->option == option; });
    if (found == known.end()) continue;
    const Entry& entry = **found;
    GivenFlag flag{bare_name(entry.names), {}, false};
    const bool is_known = std::any_of(all.begin(), all.end(), [&](const GivenFlag& earlier) {
      return earlier.name == flag.name;
    });
    if (is_known) continue;
    const FlagKind kind = entry.kind();
    const bool is_bare = kind == FlagKind::kOptionalValue && option->results().front() == "true";
    if (kind != FlagKind::kToggle && !is_bare) flag.values = option->results();
    flag.has_value = !flag.values.empty();
    all.push_back(std::move(flag));
  }
  return all;
}

std::vector<FlagForm> Flags::forms() const {
  std::vector<FlagForm> all;
  for (const Entry* const flag : impl_->flags()) {
    const std::vector<std::string> names = split(flag->names, ',');
    all.push_back(
        {bare_name(flag->names), names.size() > 1 ? names.front().substr(1) : "", flag->kind()});
  }
  return all;
}

bool Flags::is_given(const std::string& name) const {
  return impl_->app.get_option(name)->count() > 0;
}

const char* Flags::first_given(std::initializer_list<const char*> names) const {
  const auto* const found =
      std::find_if(names.begin(), names.end(), [&](const char* name) { return is_given(name); });
  return found == names.end() ? nullptr : *found;
}

std::string Flags::help() const {
  std::string out = fmt::format("usage: ovoid {} {}\n\n{}\n", impl_->command, impl_->usage,
                                wrapped(impl_->summary, 0));
  for (const Section& section : impl_->sections) {
    out += section.title.empty() ? "\n" : fmt::format("\n{}:\n", section.title);
    for (const Entry& entry : section.entries) {
      std::string line = "  " + shown(entry.names, entry.form);
      if (line.size() + 2 > kTextColumn) {
        line += '\n' + std::string(kTextColumn, ' ');
      } else {
        line += std::string(kTextColumn - line.size(), ' ');
      }
      out += line + wrapped(entry.text, kTextColumn) + '\n';
    }
  }
  if (!impl_->footer.empty()) out += '\n' + wrapped(impl_->footer, 0) + '\n';
  return out;
}

}  // namespace ovoid::cli
