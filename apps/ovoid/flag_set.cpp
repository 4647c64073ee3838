// SPDX-License-Identifier: Apache-2.0
#include "flag_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "command.h"
#include "ovoid/error.h"
#include "suggest.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Json = FlagSet::Json;

// A file's name, or JSON itself.
bool may_be_json(const FlagForm& form) {
  return form.content == Content::kLook || form.content == Content::kCamera ||
         form.content == Content::kLabels;
}

[[noreturn]] void refuse(const std::string& message) {
  throw Error(ErrorCode::kInvalidArgument, message);
}

[[noreturn]] void refuse_value(const std::string& name, const Json& value,
                               const std::string& expected) {
  constexpr std::size_t kShown = 40;
  std::string shown = value.is_object() ? "{...}"
                      : value.is_array() && value.size() > 4
                          ? fmt::format("[{} elements]", value.size())
                          : value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (shown.size() > kShown) shown = shown.substr(0, kShown) + "...";
  refuse(fmt::format("{} = {}: must be {}", name, shown, expected));
}

const FlagForm& form_of(const std::string& name) {
  const FlagForm* const found = find_render_flag(name);
  // What a state of other people's making must not decide.
  if (found != nullptr && found->content == Content::kOfRun)
    refuse(name + ": is for the command line alone, a set of flags writes no files");
  if (found != nullptr) return *found;
  std::vector<std::string> names;
  for (const FlagForm& form : render_flags()) {
    if (form.content != Content::kOfRun) names.push_back(form.name);
  }
  constexpr std::size_t kShown = 40;
  refuse(fmt::format("{}: unknown flag{}", name.substr(0, kShown), did_you_mean(name, names)));
}

// Words end at a zero byte.
bool is_text(const Json& value) {
  return value.is_string() && value.get_ref<const std::string&>().find('\0') == std::string::npos;
}

bool is_list(const Json& value, bool (*holds)(const Json&)) {
  return value.is_array() && !value.empty() && std::all_of(value.begin(), value.end(), holds);
}

void check_value(const FlagForm& form, const Json& value) {
  const std::string& name = form.name;
  const auto is_object = [](const Json& element) { return element.is_object(); };
  switch (form.kind) {
    case FlagKind::kToggle:
      if (!value.is_boolean() || !value.get<bool>()) refuse_value(name, value, "true, or left out");
      return;
    case FlagKind::kRepeatable:
      if (!is_list(value, is_text)) refuse_value(name, value, "an array of strings");
      return;
    case FlagKind::kOptionalValue:
      if (value.is_boolean() ? !value.get<bool>()
                             : !is_text(value) || value.get_ref<const std::string&>().empty())
        refuse_value(name, value, "true or a string that is not empty");
      return;
    case FlagKind::kValue:
      if (is_text(value)) return;
      if (!may_be_json(form)) refuse_value(name, value, "a string");
      if (form.content != Content::kLook && !value.is_object())
        refuse_value(name, value, "a string or an object");
      if (!value.is_object() && !is_list(value, is_object))
        refuse_value(name, value, "a string, an object or an array of objects");
  }
}

std::string word_of(const std::string& name, const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  try {
    return value.dump();
  } catch (const Json::exception&) {
    refuse(name + ": must be UTF-8");
  }
}

// JSON in a string as JSON.
Json opened(const FlagForm& form, Json value) {
  if (!may_be_json(form) || !value.is_string()) return value;
  const std::string& text = value.get_ref<const std::string&>();
  if (!is_json(text)) return value;
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) refuse(form.name + ": begins like JSON and is none");
  return json;
}

}  // namespace

const FlagForm* find_render_flag(const std::string& name) {
  return find_form(render_flags(), name);
}

bool names_file(const std::string& flag, const std::string& value) {
  const FlagForm* const form = find_render_flag(flag);
  if (form == nullptr || value.empty()) return false;
  return form->content == Content::kFile || (may_be_json(*form) && !is_json(value));
}

FlagSet FlagSet::of(const std::vector<GivenFlag>& given) {
  FlagSet set;
  for (const GivenFlag& flag : given) {
    const FlagForm* const form = find_render_flag(flag.name);
    if (form == nullptr || form->content == Content::kOfRun) continue;
    if (form->kind == FlagKind::kRepeatable) {
      set.set(flag.name, flag.values);
    } else {
      set.set(flag.name, flag.has_value ? Json(flag.values.front()) : Json(true));
    }
  }
  return set;
}

FlagSet FlagSet::from_json(const Json& json, const std::string& place) {
  if (!json.is_object()) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: must be an object of flags and their values", place));
  }
  FlagSet set;
  for (const auto& [name, value] : json.items()) {
    try {
      set.set(name, value);
    } catch (const Error& error) {
      throw Error(ErrorCode::kFileFormat, fmt::format("{}.{}", place, error.what()));
    }
  }
  return set;
}

Json FlagSet::to_json() const {
  Json json = Json::object();
  for (const Flag& flag : flags_) json[flag.name] = flag.value;
  return json;
}

void FlagSet::set(const std::string& name, Json value) {
  const FlagForm& form = form_of(name);
  value = opened(form, std::move(value));
  // One alone may stand without its list, as a flag's value did before it could be given twice.
  if (form.kind == FlagKind::kRepeatable && is_text(value)) value = Json::array({std::move(value)});
  check_value(form, value);
  const auto found = std::find_if(flags_.begin(), flags_.end(),
                                  [&](const Flag& flag) { return flag.name == name; });
  if (found == flags_.end()) {
    flags_.push_back({name, std::move(value)});
  } else {
    found->value = std::move(value);
  }
}

bool FlagSet::erase(const std::string& name) {
  return std::erase_if(flags_, [&](const Flag& flag) { return flag.name == name; }) > 0;
}

const Json* FlagSet::find(const std::string& name) const {
  const auto found = std::find_if(flags_.begin(), flags_.end(),
                                  [&](const Flag& flag) { return flag.name == name; });
  return found == flags_.end() ? nullptr : &found->value;
}

Words FlagSet::words() const {
  Words words;
  for (const auto& [name, value] : flags_) {
    const FlagKind kind = form_of(name).kind;
    const std::string word = "--" + name;
    if (value.is_boolean()) {
      words.push_back(word);
    } else if (kind == FlagKind::kOptionalValue) {
      words.push_back(word + "=" + word_of(name, value));
    } else if (kind == FlagKind::kRepeatable) {
      for (const Json& element : value) {
        words.push_back(word);
        words.push_back(word_of(name, element));
      }
    } else {
      words.push_back(word);
      words.push_back(word_of(name, value));
    }
  }
  return words;
}

}  // namespace ovoid::cli
