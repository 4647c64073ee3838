// SPDX-License-Identifier: Apache-2.0
#include "memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::viewer {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostOfMemoryFile = std::size_t{1} << 20;

Json object_of(const std::string& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return Json::object();  // a pipe would block
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostOfMemoryFile, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? json : Json::object();
}

// The XDG base directories: what is in a variable counts if it is absolute.
std::string folder_in(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && *value == '/' ? value : "";
}

std::string absolute(const std::string& path) {
  std::error_code error;
  const fs::path whole = fs::absolute(path, error);
  return error ? path : whole.lexically_normal().string();
}

// Throws what is no entry.
RecentInput recent_from(const Json& json) {
  RecentInput input;
  input.inputs = json.at("inputs").get<std::vector<std::string>>();
  const bool is_absolute =
      std::all_of(input.inputs.begin(), input.inputs.end(), [](const std::string& path) {
        return path.starts_with('/') && path.find('\0') == std::string::npos;
      });
  if (input.inputs.empty() || !is_absolute)
    throw Error(ErrorCode::kFileFormat, "inputs: must be absolute paths");
  if (json.contains("flags")) input.flags = cli::FlagSet::from_json(json["flags"]);
  return input;
}

bool is_same(const RecentInput& a, const RecentInput& b) {
  return a.inputs == b.inputs && a.flags.to_json() == b.flags.to_json();
}

}  // namespace

std::string RecentInput::title() const {
  // A folder's own name, whether a slash ends it or not.
  const fs::path first = inputs.front().ends_with('/') ? fs::path(inputs.front()).parent_path()
                                                       : fs::path(inputs.front());
  std::string name = first.filename().string();
  if (inputs.size() > 1) name += fmt::format(" and {} more", inputs.size() - 1);
  return name;
}

std::string RecentInput::folder() const {
  const std::string folder = fs::path(inputs.front()).parent_path().string();
  const std::string home = folder_in("HOME");
  const bool is_at_home = !home.empty() && folder.starts_with(home) &&
                          (folder.size() == home.size() || folder[home.size()] == '/');
  return is_at_home ? "~" + folder.substr(home.size()) : folder;
}

cli::Words RecentInput::words() const {
  cli::Words words = inputs;
  for (std::string& word : flags.words()) words.push_back(std::move(word));
  return words;
}

RecentInput recent_input(const cli::DataFlags& data) {
  RecentInput input;
  for (const std::string& path : data.inputs) input.inputs.push_back(absolute(path));
  cli::DataFlags told = data;
  for (std::string& folder : told.folders) folder = absolute(folder);
  told.step.reset();  // the moment is no part of the data
  told.time.reset();
  cli::tell(cli::data_settings(), told, &input.flags);
  cli::tell(cli::raw_settings(), told, &input.flags);
  return input;
}

std::string usual_memory_path() {
  constexpr const char* kName = "/ovoid/window.json";
  if (const std::string state = folder_in("XDG_STATE_HOME"); !state.empty()) return state + kName;
  const std::string home = folder_in("HOME");
  return home.empty() ? "" : home + "/.local/state" + kName;
}

bool is_file_there(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

Memory::Memory(std::string path, FileFinder::Question is_there)
    : path_(std::move(path)), finder_(std::move(is_there)) {
  read();
}

bool Memory::update() {
  if (!finder_.take_news()) return false;
  mark_those_there();
  return true;
}

void Memory::mark_those_there() {
  for (RecentInput& input : recent_)
    input.is_there = finder_.are_there(input.inputs).value_or(true);
}

void Memory::read() {
  if (path_.empty()) return;
  kept_ = object_of(path_);
  if (kept_.contains("theme") && kept_["theme"].is_string()) {
    const auto name = kept_["theme"].get<std::string>();
    for (const auto& [known, theme] : theme_names()) {
      if (name == known) theme_ = theme;
    }
  }
  if (!kept_.contains("recent") || !kept_["recent"].is_array()) return;
  recent_.clear();
  for (const Json& entry : kept_["recent"]) {
    if (recent_.size() == kMostRecent) break;
    try {
      recent_.push_back(recent_from(entry));
    } catch (const std::exception&) {  // no entry, or of a version with other flags
    }
  }
  mark_those_there();
  for (const RecentInput& input : recent_) finder_.look_for(input.inputs);
}

void Memory::set_theme(Theme theme) {
  read();
  theme_ = theme;
  kept_["theme"] = cli::name_in(theme_names(), theme);
  write();
}

void Memory::add_recent(RecentInput input) {
  read();
  std::erase_if(recent_, [&](const RecentInput& old) { return is_same(old, input); });
  recent_.insert(recent_.begin(), std::move(input));
  if (recent_.size() > kMostRecent) recent_.resize(kMostRecent);
  write();
}

void Memory::forget_recent() {
  read();
  recent_.clear();
  write();
}

void Memory::write() {
  if (path_.empty()) return;
  kept_["recent"] = Json::array();
  for (const RecentInput& input : recent_)
    kept_["recent"].push_back({{"inputs", input.inputs}, {"flags", input.flags.to_json()}});
  // What was opened is nobody else's business.
  const fs::path folder = fs::path(path_).parent_path();
  std::error_code ignored;
  if (fs::create_directories(folder, ignored))
    fs::permissions(folder, fs::perms::owner_all, ignored);
  write_file(path_, kept_.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ovoid::viewer
