// SPDX-License-Identifier: Apache-2.0
// The socket between the library and its reader process: messages of a type and some bytes, one of
// which may bring a file descriptor. Linux.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace ovoid::io {

// A file descriptor, closed when it goes.
class UniqueFd {
 public:
  UniqueFd() = default;
  explicit UniqueFd(int fd) : fd_(fd) {}
  ~UniqueFd();
  UniqueFd(UniqueFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }

  int get() const noexcept { return fd_; }
  bool is_open() const noexcept { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

enum class LinkMessage : std::uint32_t {
  kRequest,   // library: what to read
  kProgress,  // reader: a double in [0, 1]
  kWork,      // reader: an int64, bytes that took longer than their file's size says
  kDataset,   // reader: what was read, with the memory that holds the numbers
  kError,     // reader: code and message
};

// No message is longer: the names, types and places of 100 000 arrays fit.
inline constexpr std::size_t kMaxLinkMessage = std::size_t{64} << 20;

class ReaderLink {
 public:
  explicit ReaderLink(UniqueFd socket) : socket_(std::move(socket)) {}

  struct Message {
    LinkMessage type = LinkMessage::kError;
    std::vector<std::uint8_t> bytes;
    UniqueFd fd;
  };

  // False if the other end is gone. Never raises SIGPIPE.
  bool send(LinkMessage type, std::span<const std::uint8_t> bytes, int fd = -1) const;

  // Waits for the next message. Nothing if the other end is gone or sends what is none.
  std::optional<Message> receive() const;

  // Whether something can be received, or the other end is gone, within this time.
  bool wait(int milliseconds) const;

  int socket() const noexcept { return socket_.get(); }

 private:
  bool receive_bytes(std::span<std::uint8_t> bytes, UniqueFd* fd) const;

  UniqueFd socket_;
};

}  // namespace ovoid::io
