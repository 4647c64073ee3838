// SPDX-License-Identifier: Apache-2.0
#include "serve.h"

#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <mutex>
#include <new>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "io/core/memory.h"
#include "io/core/row_share.h"
#include "io/core/work_done.h"
#include "io/reader/reader_messages.h"
#include "ovoid/error.h"
#include "sandbox.h"
#include "unwritten.h"

namespace ovoid::reader {
namespace {

namespace fs = std::filesystem;

// What files write into messages may be long; who shows them makes them shorter.
constexpr std::size_t kMaxMessage = std::size_t{1} << 16;

// Nobody needs to hear of less.
constexpr double kProgressStep = 0.01;

// Ends the process as soon as nobody waits for it any more, whatever a reader is at.
void end_with(int socket) {
  std::thread([socket] {
    pollfd events{socket, POLLRDHUP, 0};
    while (::poll(&events, 1, -1) < 0) {
    }
    ::_exit(0);
  }).detach();
}

class Server {
 public:
  Server(io::UniqueFd socket, ReadHere read_here)
      : link_(std::move(socket)), read_here_(read_here) {}

  void answer(const std::vector<std::uint8_t>& message) {
    source_.clear();
    try {
      io::ReaderRequest request = io::request_from_message(message);
      source_ = request.source;
      read(request);
    } catch (const Error& error) {
      refuse(error.code(), error.what());
    } catch (const std::bad_alloc&) {
      refuse(ErrorCode::kOutOfMemory,
             source_ + ": memory for its arrays: the system has none left");
    } catch (const std::exception& error) {
      refuse(ErrorCode::kFileFormat,
             fmt::format("{}: its reader failed: {}", source_, error.what()));
    }
  }

  const io::ReaderLink& link() const noexcept { return link_; }

 private:
  void read(io::ReaderRequest& request) {
    std::error_code ignored;
    fs::current_path(request.folder, ignored);
    if (!std::exchange(is_in_sandbox_, true)) enter_sandbox(request.files, request.folders);
    take_refused_file();
    io::set_available_memory(request.memory);
    double told = 0;
    request.options.progress = [&](double fraction) {
      if (fraction < told + kProgressStep) return;
      told = fraction;
      tell(io::LinkMessage::kProgress, fraction);
    };
    io::set_work_listener([&](std::int64_t num_bytes) { tell(io::LinkMessage::kWork, num_bytes); });
    Dataset dataset = read_what_is_written(request, read_here_);
    io::cut_to_share(dataset, request.options.share);
    if (const std::string refused = take_refused_file(); !refused.empty())
      dataset.notes.push_back(refused_text(refused));
    const io::DatasetMessage answer = io::to_message(std::move(dataset));
    if (!link_.send(io::LinkMessage::kDataset, answer.description, answer.memory.get())) {
      refuse(ErrorCode::kUnsupported,
             fmt::format("{}: the names of its arrays take {} bytes: at most {} are read", source_,
                         answer.description.size(), io::kMaxLinkMessage));
    }
  }

  template <typename Number>
  void tell(io::LinkMessage type, Number number) const {
    std::array<std::uint8_t, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), &number, sizeof(Number));
    const std::lock_guard lock(telling_);  // readers may work in many threads
    link_.send(type, bytes);
  }

  void refuse(ErrorCode code, std::string what) {
    // It is why the reader failed, more likely than what the reader says.
    const std::string refused = take_refused_file();
    if (!refused.empty()) {
      code = ErrorCode::kUnsupported;
      what = refused_text(refused);
    }
    if (what.size() > kMaxMessage) what = what.substr(0, kMaxMessage) + " ...";
    link_.send(io::LinkMessage::kError, io::to_message(Error(code, what)));
  }

  std::string refused_text(const std::string& file) const {
    return fmt::format(
        "{}: takes data from '{}', which is none of its files and was not opened: "
        "if it may, allow that with --data-folder '{}'",
        source_, file, fs::path(file).parent_path().string());
  }

  io::ReaderLink link_;
  mutable std::mutex telling_;
  ReadHere read_here_;
  std::string source_;
  bool is_in_sandbox_ = false;
};

[[noreturn]] void serve_requests(io::UniqueFd socket, ReadHere read) {
  // Memory is limited by addresses, of which glibc takes 64 MiB for every thread's arena.
  ::mallopt(M_ARENA_MAX, 1);
  end_with(socket.get());
  Server server(std::move(socket), read);
  while (const auto message = server.link().receive())
    if (message->type == io::LinkMessage::kRequest) server.answer(message->bytes);
  // Not by exit(): what libraries do then is no part of reading.
  ::_exit(0);
}

}  // namespace

int run_reader(const char* name, ReadHere read) {
  constexpr int kSocket = 3;
  int type = 0;
  socklen_t size = sizeof(type);
  if (::getsockopt(kSocket, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
    std::fprintf(stderr, "%s: is started by Ovoid's library and has no use of its own\n", name);
    return 2;
  }
  serve_requests(io::UniqueFd(kSocket), read);
}

}  // namespace ovoid::reader
