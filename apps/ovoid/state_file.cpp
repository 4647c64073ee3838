// SPDX-License-Identifier: Apache-2.0
#include "state_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "checked_json.h"
#include "console.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "suggest.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxBytes = std::size_t{16} << 20;
constexpr std::array<const char*, 5> kMembers = {"ovoid_state", "program", "inputs", "flags",
                                                 "window"};

[[noreturn]] void refuse_state(const std::string& message) {
  throw Error(ErrorCode::kFileFormat, message);
}

void check_version(const Json& json, const std::string& path) {
  if (!json.is_object() || !json.contains("ovoid_state")) {
    refuse_state(path +
                 ": is no state, expected an object with the members ovoid_state, program, "
                 "inputs, flags and window");
  }
  const Json& version = json["ovoid_state"];
  const bool is_number = version.is_number_integer() && version > 0;
  if (!is_number) {
    refuse_state(
        fmt::format("{}: ovoid_state = {}: must be a whole number, from 1", path,
                    cut_line(version.dump(-1, ' ', true, Json::error_handler_t::replace))));
  }
  if (version == kStateVersion) return;
  const bool has_program = json.contains("program") && json["program"].is_string();
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: a state of version {}, this program reads version {}; {} or newer reads it",
                  path, version.dump(), kStateVersion,
                  has_program ? "ovoid " + cut_line(json["program"].get<std::string>())
                              : "the ovoid that wrote it"));
}

void check_members(const Json& json, const std::string& path) {
  for (const auto& [key, value] : json.items()) {
    if (std::find(kMembers.begin(), kMembers.end(), key) != kMembers.end()) continue;
    refuse_state(fmt::format("{}: {}: unknown; a state has {}{}", path, cut_line(key),
                             fmt::join(kMembers, ", "),
                             did_you_mean(key, {kMembers.begin(), kMembers.end()})));
  }
  if (json.contains("program") && !json["program"].is_string())
    refuse_state(path + ": program: must be a string");
  if (json.contains("window") && !json["window"].is_object())
    refuse_state(path + ": window: must be an object");
}

// The value of a flag with other names in the place of those of files: its own, or each of several.
template <typename Rename>
Json with_names(const std::string& flag, Json value, const Rename& rename) {
  if (value.is_array()) {
    for (Json& element : value) element = with_names(flag, element, rename);
  } else if (value.is_string() && names_file(flag, value.get<std::string>())) {
    value = rename(value.get<std::string>());
  }
  return value;
}

// A relative name is meant from the folder; one that begins with a dash would be taken for a flag.
std::string from_folder(const std::string& name, const fs::path& folder) {
  const std::string path = (folder / name).string();
  return path.front() == '-' ? "./" + path : path;
}

std::vector<std::string> inputs_from(const Json& json, const std::string& path) {
  std::vector<std::string> inputs;
  if (!json.contains("inputs")) return inputs;
  const Json& list = json["inputs"];
  if (!list.is_array()) refuse_state(path + ": inputs: must be an array of strings");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string place = fmt::format("{}: inputs[{}]", path, i);
    if (!list[i].is_string()) refuse_state(place + ": must be a string");
    const auto name = list[i].get<std::string>();
    if (name.empty() || name.find('\0') != std::string::npos)
      refuse_state(place + ": must be the name of a file");
    inputs.push_back(from_folder(name, fs::path(path).parent_path()));
  }
  return inputs;
}

FlagSet flags_from(const Json& json, const std::string& path) {
  if (!json.contains("flags")) return {};
  FlagSet flags = FlagSet::from_json(json["flags"], path + ": flags");
  const std::vector<FlagSet::Flag> all = flags.flags();
  const fs::path folder = fs::path(path).parent_path();
  for (const auto& [name, value] : all)
    flags.set(name,
              with_names(name, value, [&](const auto& text) { return from_folder(text, folder); }));
  try {
    check_render_flags(flags.words());
  } catch (const UsageError& error) {
    refuse_state(fmt::format("{}: flags: {}", path, error.what()));
  }
  return flags;
}

// The folder that the file lies in, without links on the way.
fs::path folder_of(const std::string& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  const fs::path name = whole.filename();
  // "." and "x/" are folders by themselves.
  if (name.empty() || name == "." || name == "..") return fs::weakly_canonical(whole);
  return fs::weakly_canonical(whole.parent_path());
}

std::string to_folder(const std::string& name, const fs::path& folder) {
  fs::path own = folder_of(name);
  const fs::path last = fs::absolute(name).lexically_normal().filename();
  if (!last.empty() && last != "." && last != "..") own /= last;
  if (!own.has_filename() && own.has_relative_path()) own = own.parent_path();
  const fs::path relative = own.lexically_relative(folder);
  if (relative.empty() || *relative.begin() == "..") return own.string();
  const std::string text = relative.string();
  return is_json(text) ? "./" + text : text;
}

}  // namespace

State read_state(const std::string& path) {
  const Json json = checked_json(read_text_file(path, kMaxBytes), path);
  check_version(json, path);
  check_members(json, path);
  State state;
  state.inputs = inputs_from(json, path);
  state.flags = flags_from(json, path);
  if (json.contains("window")) state.window = json["window"];
  return state;
}

void write_state(const State& state, const std::string& path) {
  const fs::path folder = folder_of(path);
  Json json;
  json["ovoid_state"] = kStateVersion;
  json["program"] = OVOID_VERSION;
  json["inputs"] = Json::array();
  for (const std::string& input : state.inputs) json["inputs"].push_back(to_folder(input, folder));
  Json flags = state.flags.to_json();
  for (const auto& [name, value] : flags.items())
    value = with_names(name, value, [&](const auto& text) { return to_folder(text, folder); });
  json["flags"] = std::move(flags);
  json["window"] = state.window.is_null() ? Json::object() : state.window;
  std::string text;
  try {
    text = json.dump(1) + "\n";
  } catch (const Json::exception&) {
    throw Error(ErrorCode::kInvalidArgument,
                path + ": a state holds only names and texts that are UTF-8");
  }
  write_file(path, text);
}

}  // namespace ovoid::cli
