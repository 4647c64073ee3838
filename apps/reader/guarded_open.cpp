// SPDX-License-Identifier: Apache-2.0
// The functions below stand before those of the system's library for everything that is loaded into
// the program; dlsym finds the latter.
#include "guarded_open.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string_view>
#include <utility>

namespace ovoid::reader {
namespace {

struct Guard {
  std::vector<std::string> files;    // sorted
  std::vector<std::string> folders;  // each with a slash at its end
  std::mutex mutex;
  std::string refused;
};

// Never freed: other threads may open files while the process ends.
std::atomic<Guard*> guard{nullptr};

bool is_of_the_system(std::string_view path) {
  return path.starts_with("/sys/") || path.starts_with("/usr/") || path.starts_with("/etc/ld.so");
}

// What does not exist may be asked for: the system says so itself.
bool may_open(const char* path, bool writes) {
  Guard* const now = guard;
  if (now == nullptr || path == nullptr) return true;
  std::array<char, PATH_MAX> real{};
  if (::realpath(path, real.data()) == nullptr && !writes) return true;
  const std::string_view name(real.data());
  const bool is_given =
      std::binary_search(now->files.begin(), now->files.end(), name) ||
      std::any_of(now->folders.begin(), now->folders.end(),
                  [&](const std::string& folder) { return name.starts_with(folder); });
  struct stat status {};
  if (is_given && !writes && ::stat(real.data(), &status) == 0 && S_ISREG(status.st_mode))
    return true;
  const std::lock_guard lock(now->mutex);
  if (now->refused.empty() && !is_of_the_system(name)) now->refused = name;
  errno = EACCES;
  return false;
}

bool writes(int flags) { return (flags & (O_ACCMODE | O_CREAT | O_TRUNC)) != O_RDONLY; }
bool writes(const char* mode) { return std::strpbrk(mode, "wa+") != nullptr; }

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int open_next(const char* name, const char* path, int flags, mode_t mode) {
  static const auto function = next<int(const char*, int, ...)>(name);
  if (!may_open(path, writes(flags))) return -1;
  return function(path, flags, mode);
}

int openat_next(const char* name, int folder, const char* path, int flags, mode_t mode) {
  static const auto function = next<int(int, const char*, int, ...)>(name);
  // From a folder other than the working one nothing is ever named here.
  const bool is_from_here = folder == AT_FDCWD || (path != nullptr && path[0] == '/');
  if (!is_from_here && guard.load() != nullptr) {
    errno = EACCES;
    return -1;
  }
  if (!may_open(path, writes(flags))) return -1;
  return function(folder, path, flags, mode);
}

FILE* fopen_next(const char* name, const char* path, const char* mode) {
  static const auto function = next<FILE*(const char*, const char*)>(name);
  if (!may_open(path, writes(mode))) return nullptr;
  return function(path, mode);
}

// The mode is there only if a file may be made.
mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

void guard_open(const std::vector<std::string>& files, const std::vector<std::string>& folders) {
  auto* const made = new Guard;
  made->files = files;
  std::sort(made->files.begin(), made->files.end());
  for (const std::string& folder : folders)
    made->folders.push_back(folder.ends_with('/') ? folder : folder + '/');
  guard = made;
}

std::string take_refused_open() {
  Guard* const now = guard;
  if (now == nullptr) return {};
  const std::lock_guard lock(now->mutex);
  return std::exchange(now->refused, {});
}

}  // namespace ovoid::reader

// NOLINTBEGIN(cert-dcl50-cpp): the system's signatures; its names are given to the linker alone
extern "C" {

int guarded_open(const char* path, int flags, ...) __asm__("open");
int guarded_open64(const char* path, int flags, ...) __asm__("open64");
int guarded_openat(int folder, const char* path, int flags, ...) __asm__("openat");
int guarded_openat64(int folder, const char* path, int flags, ...) __asm__("openat64");
FILE* guarded_fopen(const char* path, const char* mode) __asm__("fopen");
FILE* guarded_fopen64(const char* path, const char* mode) __asm__("fopen64");

int guarded_open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ovoid::reader::mode_of(flags, arguments);
  va_end(arguments);
  return ovoid::reader::open_next("open64", path, flags, mode);
}

int guarded_open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ovoid::reader::mode_of(flags, arguments);
  va_end(arguments);
  return ovoid::reader::open_next("open64", path, flags, mode);
}

int guarded_openat(int folder, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ovoid::reader::mode_of(flags, arguments);
  va_end(arguments);
  return ovoid::reader::openat_next("openat64", folder, path, flags, mode);
}

int guarded_openat64(int folder, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ovoid::reader::mode_of(flags, arguments);
  va_end(arguments);
  return ovoid::reader::openat_next("openat64", folder, path, flags, mode);
}

FILE* guarded_fopen(const char* path, const char* mode) {
  return ovoid::reader::fopen_next("fopen64", path, mode);
}

FILE* guarded_fopen64(const char* path, const char* mode) {
  return ovoid::reader::fopen_next("fopen64", path, mode);
}

}  // extern "C"
// NOLINTEND(cert-dcl50-cpp)
