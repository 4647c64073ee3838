// SPDX-License-Identifier: Apache-2.0
#include "memory.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

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

}  // namespace

std::string usual_memory_path() {
  constexpr const char* kName = "/ovoid/window.json";
  if (const std::string state = folder_in("XDG_STATE_HOME"); !state.empty()) return state + kName;
  const std::string home = folder_in("HOME");
  return home.empty() ? "" : home + "/.local/state" + kName;
}

Memory::Memory(std::string path) : path_(std::move(path)) { read(); }

void Memory::read() {
  if (path_.empty()) return;
  kept_ = object_of(path_);
  if (!kept_.contains("theme") || !kept_["theme"].is_string()) return;
  const auto name = kept_["theme"].get<std::string>();
  for (const auto& [known, theme] : theme_names()) {
    if (name == known) theme_ = theme;
  }
}

void Memory::set_theme(Theme theme) {
  read();
  theme_ = theme;
  kept_["theme"] = cli::name_in(theme_names(), theme);
  write();
}

void Memory::write() {
  if (path_.empty()) return;
  // What was opened is nobody else's business.
  const fs::path folder = fs::path(path_).parent_path();
  std::error_code ignored;
  if (fs::create_directories(folder, ignored))
    fs::permissions(folder, fs::perms::owner_all, ignored);
  write_file(path_, kept_.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ovoid::viewer
