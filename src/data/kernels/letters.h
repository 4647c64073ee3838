// SPDX-License-Identifier: Apache-2.0
// What processes of a team write to each other (KernelTeam::exchange): arrays of numbers and of
// plain structures, one behind the other. All run the same program.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/kernel_team.h"

namespace ovoid::data {

using Letter = std::vector<std::byte>;

// T: without pointers.
template <class T>
void append(Letter& letter, std::span<const T> items) {
  const std::size_t before = letter.size();
  letter.resize(before + items.size_bytes());
  if (!items.empty())
    std::memcpy(letter.data() + before, static_cast<const void*>(items.data()), items.size_bytes());
}

// Rows by the process that they go to: what is in a list of numbers of rows.
using RowLists = std::vector<std::vector<std::uint32_t>>;

// Empty letters with room for as many rows of so many bytes.
inline KernelTeam::Letters letters_of(const RowLists& lists, std::size_t row_bytes) {
  KernelTeam::Letters letters(lists.size());
  for (std::size_t p = 0; p < lists.size(); ++p) letters[p].reserve(lists[p].size() * row_bytes);
  return letters;
}

// Appends rows of a column, `width` numbers each, to the letters.
template <class T>
void append_rows(KernelTeam::Letters& letters, const RowLists& lists, std::size_t width,
                 const std::vector<T>& column) {
  if (width == 0) return;
  for (std::size_t p = 0; p < lists.size(); ++p) {
    Letter& letter = letters[p];
    std::size_t to = letter.size();
    letter.resize(to + lists[p].size() * width * sizeof(T));
    for (const std::size_t row : lists[p]) {
      std::memcpy(letter.data() + to, column.data() + width * row, width * sizeof(T));
      to += width * sizeof(T);
    }
  }
}

// The same, and frees the column.
template <class T>
void append_rows(KernelTeam::Letters& letters, const RowLists& lists, std::size_t width,
                 std::vector<T>& column) {
  append_rows(letters, lists, width, std::as_const(column));
  column = {};
}

class LetterReader {
 public:
  explicit LetterReader(std::span<const std::byte> letter) : rest_(letter) {}

  std::size_t num_left() const noexcept { return rest_.size(); }

  // Appends the next `count` items to `items`. Throws Error(kInvalidArgument) if the letter ends.
  template <class T>
  void take(std::size_t count, std::vector<T>& items) {
    if (rest_.size() / sizeof(T) < count)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("a letter of the team has {} bytes left, expected {} items of {}",
                              rest_.size(), count, sizeof(T)));
    const std::size_t before = items.size();
    items.resize(before + count);
    if (count > 0)
      std::memcpy(static_cast<void*>(items.data() + before), rest_.data(), count * sizeof(T));
    rest_ = rest_.subspan(count * sizeof(T));
  }

 private:
  std::span<const std::byte> rest_;
};

// The same letter for everybody; what each has written. All call it.
inline KernelTeam::Letters gathered_letters(KernelTeam& team, const Letter& own) {
  return team.exchange(KernelTeam::Letters(static_cast<std::size_t>(team.count()), own));
}

// The items of all, by process.
template <class T>
std::vector<std::vector<T>> gathered(KernelTeam& team, std::span<const T> own) {
  Letter letter;
  append(letter, own);
  std::vector<std::vector<T>> all;
  for (const Letter& from : gathered_letters(team, letter))
    LetterReader(from).take(from.size() / sizeof(T), all.emplace_back());
  return all;
}

// The same, one behind the other.
template <class T>
std::vector<T> joined(KernelTeam& team, std::span<const T> own) {
  std::vector<T> all;
  for (const std::vector<T>& from : gathered(team, own))
    all.insert(all.end(), from.begin(), from.end());
  return all;
}

}  // namespace ovoid::data
