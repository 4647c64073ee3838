// SPDX-License-Identifier: Apache-2.0
#include "io/reader/reader_program.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>
#include <unistd.h>

#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "ovoid/error.h"

namespace ovoid::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kName = "ovoid-read";
// Where the .deb puts it: a Python wheel, which lies anywhere, finds it there.
constexpr const char* kSystemFolder = "/usr/libexec/ovoid";

// The program, or the shared library, that this function is in.
fs::path own_module() {
  Dl_info info{};
  link_map* module = nullptr;
  std::error_code ignored;
  const bool is_known = ::dladdr1(reinterpret_cast<const void*>(&find_reader_program), &info,
                                  reinterpret_cast<void**>(&module), RTLD_DL_LINKMAP) != 0;
  // The main program has no name there; the one that it was called by may mean another file.
  if (is_known && module->l_name != nullptr && *module->l_name != '\0')
    return fs::canonical(module->l_name, ignored);
  return fs::read_symlink("/proc/self/exe", ignored);
}

}  // namespace

std::string_view reader_program_of(std::string_view format) {
  return format == "OpenVDB" ? "ovoid-read-vdb" : kName;
}

std::string find_reader_program(const std::string& source, const std::string& named,
                                std::string_view program) {
  if (!named.empty()) {
    std::error_code ignored;
    std::string path =
        program == kName ? named : (fs::canonical(named, ignored).parent_path() / program).string();
    if (::access(path.c_str(), X_OK) == 0) return path;
    throw Error(ErrorCode::kUnsupported,
                fmt::format("reader_program = {}: is no program that can be started: expected {}",
                            path, program));
  }
  const fs::path folder = own_module().parent_path();
  const std::vector<fs::path> places{folder / program, folder / "../libexec/ovoid" / program,
                                     folder / "../../libexec/ovoid" / program,
                                     fs::path(OVOID_READER_FOLDER) / program,
                                     fs::path(kSystemFolder) / program};
  for (const fs::path& place : places) {
    std::error_code ignored;
    if (::access(place.c_str(), X_OK) == 0) return fs::canonical(place, ignored).string();
  }
  std::string folders = OVOID_READER_FOLDER;
  if (folders != kSystemFolder) folders += fmt::format(" or {}", kSystemFolder);
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: this format is read by the program {}, which is neither beside {} "
                          "nor in {}: install the package ovoid of this version (Python "
                          "wheels leave the program out), or name it by OVOID_READER (the library: "
                          "by ReadOptions::reader_program)",
                          source, program, folder.string(), folders));
}

std::vector<std::string> reader_environment(const char* library_path) {
  std::string folders;
  std::string_view rest = library_path != nullptr ? library_path : "";
  while (!rest.empty()) {
    const std::size_t end = rest.find_first_of(":;");  // the system's loader takes both
    const std::string_view folder = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    if (!folder.starts_with('/')) continue;
    folders += folders.empty() ? "" : ":";
    folders += folder;
  }
  std::vector<std::string> variables{"GLIBC_TUNABLES=glibc.malloc.tcache_count=0"};
  if (!folders.empty()) variables.push_back("LD_LIBRARY_PATH=" + folders);
  return variables;
}

}  // namespace ovoid::io
