// SPDX-License-Identifier: Apache-2.0
#include "mpi_kernel_team.h"

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <functional>
#include <utility>

#include "end_job.h"
#include "ovoid/error.h"

namespace ovoid::cli {
namespace {

// What is asked, and the tag of the message that answers it.
struct Question {
  std::int32_t question, reply_tag;
  std::int64_t number;
};

constexpr int kQuestionTag = 1;
constexpr unsigned kFirstReplyTag = 2;
constexpr unsigned kReplyTags = 32'000;  // MPI grants 32767 at least
// Counts of MPI are ints.
constexpr std::size_t kMostInMessage = std::size_t{1} << 30;

// Looks often at first, then more and more seldom: processes share processors, and threads, too.
class Pauses {
 public:
  void pause() {
    std::this_thread::sleep_for(length_);
    length_ = std::min(length_ * 2, kLongest);
  }
  void start_again() { length_ = kShortest; }

 private:
  static constexpr std::chrono::microseconds kShortest{10}, kLongest{400};
  std::chrono::microseconds length_ = kShortest;
};

// A message of unknown length, once it is there; false if it does not come in time.
bool receive(int from, int tag, MPI_Comm comm, MpiKernelTeam::Duration patience,
             std::vector<std::byte>& message) {
  const auto start = std::chrono::steady_clock::now();
  Pauses pauses;
  MPI_Message handle = MPI_MESSAGE_NULL;
  MPI_Status status;
  for (int is_there = 0;;) {
    MPI_Improbe(from, tag, comm, &is_there, &handle, &status);
    if (is_there != 0) break;
    if (std::chrono::steady_clock::now() - start > patience) return false;
    pauses.pause();
  }
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  message.resize(static_cast<std::size_t>(size));
  MPI_Mrecv(message.data(), size, MPI_BYTE, &handle, MPI_STATUS_IGNORE);
  return true;
}

// Calls visit(offset, count) for pieces of a letter that messages can hold.
void for_each_piece(std::size_t size, const std::function<void(std::size_t, int)>& visit) {
  for (std::size_t at = 0; at < size; at += kMostInMessage)
    visit(at, static_cast<int>(std::min(kMostInMessage, size - at)));
}

}  // namespace

MpiKernelTeam::MpiKernelTeam(int number, int count, std::function<void()> meet, Duration patience)
    : number_(number), count_(count), meet_(std::move(meet)), patience_(patience) {
  MPI_Comm_dup(MPI_COMM_WORLD, &letters_);
  MPI_Comm_dup(MPI_COMM_WORLD, &questions_);
  answering_ = std::thread([this] { answer_all(); });
}

MpiKernelTeam::~MpiKernelTeam() {
  is_over_ = true;
  answering_.join();
}

KernelTeam::Letters MpiKernelTeam::exchange(Letters letters) {
  meet_();
  try {
    return exchange_here(std::move(letters));
  } catch (const std::exception& error) {
    // The others wait for what will not come.
    end_job(fmt::format("process {} of {}: while kernels are exchanged: {}", number_, count_,
                        error.what()));
  }
}

KernelTeam::Letters MpiKernelTeam::exchange_here(Letters letters) {
  const auto processes = static_cast<std::size_t>(count());
  std::vector<std::int64_t> sizes(processes), coming(processes);
  for (std::size_t p = 0; p < processes; ++p)
    sizes[p] = static_cast<std::int64_t>(letters[p].size());
  MPI_Alltoall(sizes.data(), 1, MPI_INT64_T, coming.data(), 1, MPI_INT64_T, letters_);
  Letters received(processes);
  const auto own = static_cast<std::size_t>(number());
  received[own] = std::move(letters[own]);
  // One after the other, so that letters go as others come.
  for (std::size_t step = 1; step < processes; ++step) {
    const std::size_t to = (own + step) % processes;
    const std::size_t from = (own + processes - step) % processes;
    received[from].resize(static_cast<std::size_t>(coming[from]));
    std::vector<MPI_Request> requests;
    for_each_piece(received[from].size(), [&](std::size_t at, int size) {
      MPI_Irecv(received[from].data() + at, size, MPI_BYTE, static_cast<int>(from), 0, letters_,
                &requests.emplace_back());
    });
    for_each_piece(letters[to].size(), [&](std::size_t at, int size) {
      MPI_Isend(letters[to].data() + at, size, MPI_BYTE, static_cast<int>(to), 0, letters_,
                &requests.emplace_back());
      bytes_sent_ += size;
    });
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    letters[to] = {};
  }
  return received;
}

int MpiKernelTeam::answer(Answer answer) {
  int question = 0;
  {
    const std::scoped_lock lock(mutex_);
    question = static_cast<int>(answers_.size());
    answers_.push_back(std::move(answer));
  }
  meet_();  // from here on the others may ask
  return question;
}

std::vector<std::byte> MpiKernelTeam::fetch(int process, int question, std::int64_t number) const {
  const auto reply_tag = static_cast<int>(kFirstReplyTag + next_reply_++ % kReplyTags);
  const Question asked{question, reply_tag, number};
  MPI_Send(&asked, sizeof asked, MPI_BYTE, process, kQuestionTag, questions_);
  std::vector<std::byte> message;
  if (!receive(process, reply_tag, questions_, patience_, message))
    throw Error(ErrorCode::kUnsupported,
                fmt::format("process {} of {} has not sent its kernels within {:g} s "
                            "(OVOID_MPI_WAIT sets how long)",
                            process, count(), patience_.count()));
  return message;
}

void MpiKernelTeam::answer_all() {
  Pauses pauses;
  while (!is_over_) {
    if (answer_one()) {
      pauses.start_again();
    } else {
      pauses.pause();
    }
  }
}

bool MpiKernelTeam::answer_one() {
  int is_there = 0;
  MPI_Message handle = MPI_MESSAGE_NULL;
  MPI_Status status;
  MPI_Improbe(MPI_ANY_SOURCE, kQuestionTag, questions_, &is_there, &handle, &status);
  if (is_there == 0) return false;
  Question asked{};
  MPI_Mrecv(&asked, sizeof asked, MPI_BYTE, &handle, MPI_STATUS_IGNORE);
  const std::vector<std::byte> letter = answer_to(asked.question, asked.number);
  MPI_Send(letter.data(), static_cast<int>(letter.size()), MPI_BYTE, status.MPI_SOURCE,
           asked.reply_tag, questions_);
  bytes_sent_ += static_cast<std::int64_t>(letter.size());
  return true;
}

// Empty where there is nothing to say: who has asked refuses it.
std::vector<std::byte> MpiKernelTeam::answer_to(int question, std::int64_t number) {
  Answer answer;
  {
    const std::scoped_lock lock(mutex_);
    answer = answers_.at(static_cast<std::size_t>(question));
  }
  try {
    return answer(number);
  } catch (const std::exception&) {  // no memory
    return {};
  }
}

}  // namespace ovoid::cli
