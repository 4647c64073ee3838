// SPDX-License-Identifier: Apache-2.0
#include "state_words.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <string>

#include "session.h"
#include "state_file.h"
#include "values.h"

namespace ovoid::cli {
namespace {

using Values = std::map<std::string, std::string>;  // by flag; of toggles and JSON ""

// The words, flag by flag, as Flags takes them apart.
struct Scanned {
  Values given;
  std::string state;
  int num_states = 0;
  bool has_inputs = false;
  bool is_known = true;  // no flag but those of render
};

// The flag that a word names, and what stands behind its equals sign or, of a short one, its name.
struct Named {
  const FlagForm* form = nullptr;
  std::optional<std::string> value;
};

Named named(const std::string& word) {
  if (word.compare(0, 2, "--") == 0) {
    const std::size_t end = word.find('=');
    Named flag{find_render_flag(word.substr(2, end == std::string::npos ? end : end - 2)), {}};
    if (end != std::string::npos) flag.value = word.substr(end + 1);
    return flag;
  }
  for (const FlagForm& form : render_flags()) {
    if (form.short_name.empty() || word.compare(1, form.short_name.size(), form.short_name) != 0)
      continue;
    Named flag{&form, {}};
    if (word.size() > 1 + form.short_name.size()) {
      flag.value = word.substr(1 + form.short_name.size());
      if (flag.value->front() == '=') flag.value->erase(0, 1);
    }
    return flag;
  }
  return {};
}

Scanned scan(const Words& words) {
  Scanned found;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--") {
      found.has_inputs = found.has_inputs || i + 1 < words.size();
      break;
    }
    if (words[i].size() < 2 || words[i].front() != '-') {
      found.has_inputs = true;
      continue;
    }
    auto [form, value] = named(words[i]);
    const bool is_apart = form != nullptr && !value &&
                          (form->kind == FlagKind::kValue || form->kind == FlagKind::kRepeatable);
    if (form == nullptr || (is_apart && i + 1 == words.size())) {
      found.is_known = false;
      break;
    }
    if (is_apart) value = words[++i];
    found.given[form->name] = value.value_or("");
    if (form->name != "state") continue;
    found.state = *value;
    ++found.num_states;
  }
  return found;
}

using Holds = bool (*)(const std::string& value);

bool is_unlit(const std::string& mode) { return mode != "composite" && mode != "isosurface"; }
bool is_no_layer(const std::string& mode) { return mode != "composite"; }
bool is_no_surface(const std::string& mode) { return mode != "isosurface"; }
bool is_without_opacity(const std::string& mode) { return mode == "xray" || mode == "isosurface"; }
bool is_xray(const std::string& mode) { return mode == "xray"; }
bool is_extracted(const std::string& method) { return method == "extracted"; }
bool is_density(const std::string& quantity) { return quantity == "density"; }
bool is_published_way(const std::string& way) { return way != "off" && way != "auto"; }
bool is_float_picture(const std::string& output) { return !has_ending(output, ".png"); }

std::optional<double> number_at(const std::string& text) {
  double number = 0;
  const std::size_t blank = text.find_first_not_of(" +");
  if (blank == std::string::npos) return std::nullopt;
  const auto [end, error] = std::from_chars(text.data() + blank, text.data() + text.size(), number);
  return error == std::errc() ? std::optional(number) : std::nullopt;
}

// Of --range and --opacity, and of --colormap, if it is a list.
bool begins_below_logarithms(const std::string& list) {
  return list.find_first_of(",:") != std::string::npos && number_at(list).value_or(1) <= 0;
}

bool window_begins_below_logarithms(const std::string& window) {
  const std::size_t comma = window.find(',');
  if (comma == std::string::npos) return false;
  return number_at(window.substr(comma + 1)).value_or(1) - number_at(window).value_or(0) / 2 <= 0;
}

struct Term {
  const char* flag;
  Holds holds = nullptr;  // null: whatever its value
};

struct Contradiction {
  Term a, b;
};

// What check_data_flags() and check_drawing_flags() refuse together.
constexpr Contradiction kContradictions[] = {
    {{"camera"}, {"view"}},
    {{"step"}, {"time"}},
    {{"step"}, {"hyperslice"}},
    {{"time"}, {"hyperslice"}},
    {{"motion-blur"}, {"hyperslice"}},
    {{"motion-blur"}, {"mode", is_unlit}},
    {{"motion-blur"}, {"post-convolution", is_published_way}},
    {{"value-plane"}, {"motion-blur"}},
    {{"value-plane"}, {"mode", is_unlit}},
    {{"slice-method", is_extracted}, {"slice-lattice"}},
    {{"slice-method", is_extracted}, {"slice-spacing"}},
    {{"no-shade"}, {"shade"}},
    {{"no-shade"}, {"ambient"}},
    {{"no-shade"}, {"diffuse"}},
    {{"no-shade"}, {"specular"}},
    {{"no-shade"}, {"specular-power"}},
    {{"no-shade"}, {"light"}},
    {{"mode", is_unlit}, {"shade"}},
    {{"mode", is_unlit}, {"ambient"}},
    {{"mode", is_unlit}, {"diffuse"}},
    {{"mode", is_unlit}, {"specular"}},
    {{"mode", is_unlit}, {"specular-power"}},
    {{"mode", is_unlit}, {"light"}},
    {{"mode", is_no_layer}, {"classification"}},
    {{"mode", is_no_layer}, {"unit-distance"}},
    {{"mode", is_no_layer}, {"gradient-opacity"}},
    {{"mode", is_no_surface}, {"iso"}},
    {{"mode", is_without_opacity}, {"opacity"}},
    {{"mode", is_xray}, {"color-array"}},
    {{"crop"}, {"crop-world"}},
    {{"tf"}, {"preset"}},
    {{"tf"}, {"window"}},
    {{"preset"}, {"window"}},
    {{"range"}, {"window"}},
    {{"log"}, {"symlog"}},
    {{"log"}, {"range", begins_below_logarithms}},
    {{"log"}, {"opacity", begins_below_logarithms}},
    {{"log"}, {"colormap", begins_below_logarithms}},
    {{"log"}, {"window", window_begins_below_logarithms}},
    {{"relevant-above"}, {"prefilter"}},
    {{"quantity", is_density}, {"array"}},
    {{"mass"}, {"mass-array"}},
    {{"output", is_float_picture}, {"background"}},
    {{"output", is_float_picture}, {"colorbar"}},
    {{"output", is_float_picture}, {"axes"}},
    {{"output", is_float_picture}, {"bounding-box"}},
    {{"output", is_float_picture}, {"scale-bar"}},
};

// What is refused without one of some others.
struct Need {
  const char* flag;
  std::vector<const char*> of;
};

const std::vector<Need>& needs() {
  static const std::vector<Need> all = {
      {"tf-name", {"tf"}},
      {"iso", {"mode"}},
      {"slice-method", {"hyperslice"}},
      {"slice-lattice", {"hyperslice"}},
      {"slice-spacing", {"hyperslice"}},
      {"trail-tf", {"motion-blur"}},
      {"length-unit", {"colorbar", "axes", "bounding-box", "scale-bar"}},
  };
  return all;
}

bool holds(const Term& term, const std::string& value) {
  return term.holds == nullptr || term.holds(value);
}

bool is_given(const Term& term, const Values& given) {
  const auto found = given.find(term.flag);
  return found != given.end() && holds(term, found->second);
}

void drop(const Term& term, FlagSet* flags) {
  const FlagSet::Json* const value = flags->find(term.flag);
  if (value != nullptr && holds(term, value->is_string() ? value->get<std::string>() : ""))
    flags->erase(term.flag);
}

FlagSet beaten_by(const Values& given, FlagSet flags) {
  // It names a look of the state's file.
  if (given.contains("tf")) flags.erase("tf-name");
  for (const auto& [name, value] : given) flags.erase(name);
  for (const auto& [a, b] : kContradictions) {
    if (is_given(a, given)) drop(b, &flags);
    if (is_given(b, given)) drop(a, &flags);
  }
  for (const auto& [flag, of] : needs()) {
    const bool is_of_use = std::any_of(of.begin(), of.end(), [&](const char* other) {
      return flags.find(other) != nullptr || given.contains(other);
    });
    if (!is_of_use) flags.erase(flag);
  }
  return flags;
}

}  // namespace

Words with_state(const Words& words) {
  const Scanned line = scan(words);
  if (line.num_states != 1 || line.state.empty() || !line.is_known) return words;
  const State state = read_state(line.state);
  Words all;
  if (!line.has_inputs) all = state.inputs;
  const Words kept = beaten_by(line.given, state.flags).words();
  all.insert(all.end(), kept.begin(), kept.end());
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

}  // namespace ovoid::cli
