// SPDX-License-Identifier: Apache-2.0
#include "io/reader/reader_link.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace ovoid::io {
namespace {

// What stands before the bytes of every message.
struct Header {
  std::uint32_t type = 0;
  std::uint32_t num_bytes = 0;
};

// Room for one descriptor beside the bytes of a message.
union FdMessage {
  cmsghdr align;
  std::array<char, CMSG_SPACE(sizeof(int))> bytes;
};

bool send_some(int socket, std::span<const std::uint8_t>& bytes, int fd) {
  iovec part{const_cast<std::uint8_t*>(bytes.data()), bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  FdMessage control{};
  if (fd >= 0) {
    message.msg_control = control.bytes.data();
    message.msg_controllen = control.bytes.size();
    cmsghdr* const head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(head), &fd, sizeof(int));
  }
  ssize_t count = 0;
  do {
    count = ::sendmsg(socket, &message, MSG_NOSIGNAL);
  } while (count < 0 && errno == EINTR);
  if (count <= 0) return false;
  bytes = bytes.subspan(static_cast<std::size_t>(count));
  return true;
}

}  // namespace

UniqueFd::~UniqueFd() {
  if (fd_ >= 0) ::close(fd_);
}

bool ReaderLink::send(LinkMessage type, std::span<const std::uint8_t> bytes, int fd) const {
  if (bytes.size() > kMaxLinkMessage) return false;
  const Header header{static_cast<std::uint32_t>(type), static_cast<std::uint32_t>(bytes.size())};
  std::array<std::uint8_t, sizeof(Header)> head{};
  std::memcpy(head.data(), &header, sizeof(Header));
  for (std::span<const std::uint8_t> rest = head; !rest.empty(); fd = -1)
    if (!send_some(socket_.get(), rest, fd)) return false;
  while (!bytes.empty())
    if (!send_some(socket_.get(), bytes, -1)) return false;
  return true;
}

bool ReaderLink::receive_bytes(std::span<std::uint8_t> bytes, UniqueFd* fd) const {
  while (!bytes.empty()) {
    iovec part{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    FdMessage control{};
    message.msg_control = control.bytes.data();
    message.msg_controllen = control.bytes.size();
    const ssize_t count = ::recvmsg(socket_.get(), &message, MSG_CMSG_CLOEXEC);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    const cmsghdr* const head = CMSG_FIRSTHDR(&message);
    if (head != nullptr && head->cmsg_level == SOL_SOCKET && head->cmsg_type == SCM_RIGHTS &&
        head->cmsg_len == CMSG_LEN(sizeof(int))) {
      int received = -1;
      std::memcpy(&received, CMSG_DATA(head), sizeof(int));
      UniqueFd owned(received);
      if (fd != nullptr) *fd = std::move(owned);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

std::optional<ReaderLink::Message> ReaderLink::receive() const {
  std::array<std::uint8_t, sizeof(Header)> head{};
  Message message;
  if (!receive_bytes(head, &message.fd)) return std::nullopt;
  Header header;
  std::memcpy(&header, head.data(), sizeof(Header));
  if (header.type > static_cast<std::uint32_t>(LinkMessage::kError) ||
      header.num_bytes > kMaxLinkMessage)
    return std::nullopt;
  message.type = static_cast<LinkMessage>(header.type);
  message.bytes.resize(header.num_bytes);
  if (!receive_bytes(message.bytes, nullptr)) return std::nullopt;
  return message;
}

bool ReaderLink::wait(int milliseconds) const {
  pollfd events{socket_.get(), POLLIN, 0};
  return ::poll(&events, 1, milliseconds) != 0;
}

}  // namespace ovoid::io
