// SPDX-License-Identifier: Apache-2.0
#include "io/reader/reader_session.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/input_files.h"
#include "io/reader/reader_program.h"
#include "ovoid/error.h"

namespace ovoid {
namespace io {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Descriptor 3 is the socket; 0, 1 and 2 are nowhere.
constexpr int kSocketInChild = 3;

// Processor time of one request: what starting takes on a slow machine, and the slowest of readers,
// which are those of text.
constexpr double kBaseSeconds = 2;
constexpr double kBytesPerSecond = 2e6;
// And 1 s for so many bytes that are unpacked: a few kernels, or a compressed frame, stand for many
// samples.
constexpr double kUnpackedPerSecond = 16e6;

// Addresses that VTK and all below it, and the reader's own threads, take before a file is read.
constexpr std::int64_t kLibraries = std::int64_t{1} << 30;

// A reader that neither works nor waits for a disk is stuck.
constexpr std::chrono::seconds kIdleLimit{6};

// posix_spawn's two tables.
class SpawnSettings {
 public:
  SpawnSettings() {
    posix_spawn_file_actions_init(&files_);
    posix_spawnattr_init(&attributes_);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  // The socket, nothing else of the host's descriptors; its signals as they are in a new program,
  // and those of the terminal not at all: the library ends the reader itself.
  void set_up(int socket) {
    for (int fd = 0; fd < 3; ++fd)
      posix_spawn_file_actions_addopen(&files_, fd, "/dev/null", fd == 0 ? O_RDONLY : O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files_, socket, kSocketInChild);
    posix_spawn_file_actions_addclosefrom_np(&files_, kSocketInChild + 1);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }

  pid_t start(const std::string& program) {
    std::string name = "ovoid-read";
    std::array<char*, 2> arguments{name.data(), nullptr};
    std::vector<std::string> variables = reader_environment(std::getenv("LD_LIBRARY_PATH"));
    std::vector<char*> environment;
    environment.reserve(variables.size() + 1);
    for (std::string& variable : variables) environment.push_back(variable.data());
    environment.push_back(nullptr);
    pid_t pid = -1;
    const int error = ::posix_spawn(&pid, program.c_str(), &files_, &attributes_, arguments.data(),
                                    environment.data());
    if (error != 0) {
      throw Error(ErrorCode::kUnsupported, fmt::format("{}: cannot be started: {}", program,
                                                       std::generic_category().message(error)));
    }
    return pid;
  }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

// A running reader. A process descriptor keeps its number from meaning another process once the
// host has waited for all its children.
class ReaderProcess {
 public:
  explicit ReaderProcess(const std::string& program) {
    std::array<int, 2> ends{-1, -1};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      throw Error(ErrorCode::kUnsupported, fmt::format("{}: no socket for it: {}", program,
                                                       std::generic_category().message(errno)));
    }
    link_.emplace(UniqueFd(ends[0]));
    const UniqueFd theirs(above_standard(UniqueFd(ends[1])));
    SpawnSettings settings;
    settings.set_up(theirs.get());
    pid_ = settings.start(program);
    handle_ = UniqueFd(static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0)));
  }
  ~ReaderProcess() {
    if (is_reaped_) return;
    kill();
    reap(0);
  }
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;

  const ReaderLink& link() const noexcept { return *link_; }

  // May be called while another thread receives.
  void kill() noexcept {
    if (handle_.is_open())
      ::syscall(SYS_pidfd_send_signal, handle_.get(), SIGKILL, nullptr, 0);
    else if (!is_reaped_)
      ::kill(pid_, SIGKILL);
  }

  // Of one that has closed its end of the socket: the signal that ended it, or minus its exit code;
  // nothing if it has not ended, or the host has taken that knowledge.
  std::optional<int> reason() noexcept {
    for (int i = 0; i < 100 && !is_reaped_; ++i) {
      if (i > 0) ::usleep(2000);
      reap(WNOHANG);
    }
    return reason_;
  }

  // Lets it use so many seconds more of a processor, then the system ends it, or who waits for it
  // does; and so many bytes beside its libraries, then it gets no more.
  void allow(double seconds, [[maybe_unused]] std::int64_t num_bytes) noexcept {
    allowance_ = seconds;
    since_request_ = since_work_ = used_seconds();
    set_limit(since_request_ + allowance_);
#ifndef OVOID_SANITIZED  // these take terabytes
    const auto size = static_cast<rlim_t>(num_bytes + kLibraries);
    const rlimit memory{size, size};
    ::prlimit(pid_, RLIMIT_AS, &memory, nullptr);
#endif
  }

  // It has unpacked so many bytes more, and gets the time for them, and from now on as much as any
  // part of the work may need: an endless loop behind much work is ended as soon as one before it.
  void extend(std::int64_t num_bytes) noexcept {
    const double earned = static_cast<double>(num_bytes) / kUnpackedPerSecond;
    since_request_ += earned;
    since_work_ = std::max(since_work_, used_seconds() + earned);
    set_limit(std::min(since_request_, since_work_) + allowance_);
  }
  bool is_out_of_time() const noexcept { return used_seconds() > limit_ + 1; }

  double used_seconds() const noexcept {
    clockid_t clock{};
    timespec time{};
    if (::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0;
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
  }

  // Does it sleep for something that is not a disk?
  bool is_asleep() const {
    std::ifstream file(fmt::format("/proc/{}/stat", pid_));
    std::string text;
    std::getline(file, text);
    const auto end = text.rfind(')');
    return end != std::string::npos && text.substr(end, 3) == ") S";
  }

 private:
  // The hard limit stays: only a privileged user could raise it again.
  void set_limit(double seconds) noexcept {
    limit_ = std::min(seconds, 1e9);
    rlimit time{};
    if (::prlimit(pid_, RLIMIT_CPU, nullptr, &time) != 0) return;
    time.rlim_cur = std::min(static_cast<rlim_t>(limit_ + 1), time.rlim_max);
    ::prlimit(pid_, RLIMIT_CPU, &time, nullptr);
  }

  // Closing 0, 1 and 2 in the child must not close the socket.
  static UniqueFd above_standard(UniqueFd fd) {
    if (fd.get() > kSocketInChild) return fd;
    return UniqueFd(::fcntl(fd.get(), F_DUPFD_CLOEXEC, kSocketInChild + 1));
  }

  // A host that waits for all children, or ignores their ends, leaves nothing to wait for.
  void reap(int flags) noexcept {
    siginfo_t info{};
    int result = 0;
    do {
      result = ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | flags);
    } while (result != 0 && errno == EINTR);
    if (result == 0 && info.si_pid == 0) return;
    is_reaped_ = true;
    if (result == 0) reason_ = info.si_code == CLD_EXITED ? -info.si_status : info.si_status;
  }

  std::optional<ReaderLink> link_;
  pid_t pid_ = -1;
  UniqueFd handle_;
  double limit_ = 0;      // seconds of a processor in all
  double allowance_ = 0;  // of this request, by the size of its files
  // Where the allowance begins: at the request, with what was earned, or at the last work told.
  double since_request_ = 0, since_work_ = 0;
  bool is_reaped_ = false;
  std::optional<int> reason_;
};

std::string reason_text(const std::optional<int>& reason) {
  if (!reason) return "";
  if (*reason == SIGXCPU) return " (it took more processor time than such a file needs)";
  if (*reason == SIGKILL) return " (the system killed it: did memory run out?)";
  if (*reason > 0) return fmt::format(" (signal {})", *reason);
  return fmt::format(" (exit code {})", -*reason);
}

double seconds_for(const std::vector<std::string>& files) {
  double num_bytes = 0;
  for (const std::string& file : files) {
    std::error_code ignored;
    const auto size = fs::file_size(file, ignored);
    if (!ignored) num_bytes += static_cast<double>(size);
  }
  return kBaseSeconds + num_bytes / kBytesPerSecond;
}

}  // namespace
}  // namespace io

struct ReaderSession::Impl {
  std::vector<std::string> inputs;
  std::mutex mutex;
  std::shared_ptr<io::ReaderProcess> process;
  std::string program;             // that the process runs
  std::vector<std::string> files;  // what the process may open
  std::vector<std::string> folders;

  void start(const std::string& format, const std::string& source, const ReadOptions& options);
  Dataset receive(const io::ReaderHost& host);
  void report_progress(const ReadOptions& options, double fraction);
  // Throws Error(kCancelled) if the caller has stopped, and with that killed the process.
  void require_running(const std::stop_token& stop);
  [[noreturn]] void report_end(const std::string& source, const char* what);
};

ReaderSession::ReaderSession(std::vector<std::string> inputs) : impl_(std::make_unique<Impl>()) {
  impl_->inputs = std::move(inputs);
}

ReaderSession::~ReaderSession() = default;

void ReaderSession::Impl::start(const std::string& format, const std::string& source,
                                const ReadOptions& options) {
  const std::string_view wanted = io::reader_program_of(format);
  if (process && program == wanted) return;
  process.reset();
  program = wanted;
  files = io::files_that_may_be_read(inputs, options);
  folders = io::real_data_folders(options);
  process = std::make_shared<io::ReaderProcess>(
      io::find_reader_program(source, options.reader_program, wanted));
}

void ReaderSession::Impl::require_running(const std::stop_token& stop) {
  if (!stop.stop_requested()) return;
  process.reset();
  throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
}

void ReaderSession::Impl::report_end(const std::string& source, const char* what) {
  const auto reason = process->reason();
  process.reset();
  constexpr int kNotLoaded = -127;  // what the system's loader ends with
  if (reason && *reason == kNotLoaded) {
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("{}: its reader could not start: memory is limited to less than its "
                            "libraries take (ulimit -v), or one of them is missing",
                            source));
  }
  throw Error(ErrorCode::kFileFormat, fmt::format("{}: its reader {}{}: is the file damaged?",
                                                  source, what, io::reason_text(reason)));
}

void ReaderSession::Impl::report_progress(const ReadOptions& options, double fraction) {
  try {
    options.progress(fraction);
  } catch (...) {
    process.reset();  // its answer is still to come, and nobody waits for it
    throw;
  }
}

Dataset ReaderSession::Impl::receive(const io::ReaderHost& host) {
  const std::string& source = host.source;
  const ReadOptions& options = host.options;
  double used = 0;
  auto last_work = io::Clock::now();
  for (;;) {
    if (process->is_out_of_time()) {  // and has not let the system end it
      process.reset();
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: its reader stopped{}: is the file damaged?", source,
                              io::reason_text(SIGXCPU)));
    }
    if (!process->link().wait(500)) {
      const double now_used = process->used_seconds();
      if (now_used > used || !process->is_asleep()) last_work = io::Clock::now();
      used = now_used;
      if (io::Clock::now() - last_work < io::kIdleLimit) continue;
      process.reset();
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: its reader is stuck: is the file damaged?", source));
    }
    auto message = process->link().receive();
    require_running(options.stop);
    if (!message) report_end(source, "stopped");
    switch (message->type) {
      case io::LinkMessage::kProgress:
        if (double fraction = 0; message->bytes.size() == sizeof(double)) {
          std::memcpy(&fraction, message->bytes.data(), sizeof(double));
          if (options.progress && fraction >= 0 && fraction <= 1)
            report_progress(options, fraction);
        }
        break;
      case io::LinkMessage::kWork:
        if (std::int64_t num_bytes = 0; message->bytes.size() == sizeof(num_bytes)) {
          std::memcpy(&num_bytes, message->bytes.data(), sizeof(num_bytes));
          process->extend(std::clamp<std::int64_t>(num_bytes, 0, io::kMaxNumBytes));
        }
        break;
      case io::LinkMessage::kDataset:
        return io::dataset_from_message(host, {std::move(message->bytes), std::move(message->fd)});
      case io::LinkMessage::kError:
        throw io::error_from_message(message->bytes);
      default:
        report_end(source, "sent nonsense");
    }
  }
}

Dataset ReaderSession::read(const std::string& format, const std::string& source,
                            const std::vector<std::string>& paths, const ReadOptions& options) {
  const std::lock_guard lock(impl_->mutex);
  if (options.stop.stop_requested())
    throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
  impl_->start(format, source, options);
  io::ReaderRequest request;
  request.format = format;
  request.source = source;
  request.paths = paths;
  std::error_code ignored;
  request.folder = std::filesystem::current_path(ignored).string();
  request.options = options;
  request.files = impl_->files;
  request.folders = impl_->folders;
  request.memory = std::min(io::available_memory(), io::kMaxNumBytes);
  impl_->process->allow(io::seconds_for(impl_->files), request.memory);
  // Who asks to stop may kill the process when its answer is already here; the next read must not
  // find it. Declared before the callback, so that this runs when that has ended.
  struct LeavesNoneKilled {
    Impl& impl;
    const std::stop_token& stop;
    ~LeavesNoneKilled() {
      if (stop.stop_requested()) impl.process.reset();
    }
  } const leaves_none_killed{*impl_, options.stop};
  // The callback may run while this thread already gives the process up, and holds it so long.
  const std::stop_callback killer(options.stop, [process = impl_->process] { process->kill(); });
  if (!impl_->process->link().send(io::LinkMessage::kRequest, io::to_message(request))) {
    impl_->require_running(options.stop);  // else it was killed, and could not take the request
    impl_->report_end(source, "did not start");
  }
  return impl_->receive({source, paths, options});
}

Dataset io::read_foreign(const std::string& format, const std::string& source,
                         const std::vector<std::string>& paths, const ReadOptions& options) {
  if (options.session) return options.session->read(format, source, paths, options);
  return ReaderSession(paths).read(format, source, paths, options);
}

}  // namespace ovoid
