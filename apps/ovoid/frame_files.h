// SPDX-License-Identifier: Apache-2.0
// The files of an animation's frames, and which of them an earlier run has left whole.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace ovoid::cli {

// A name with one number in it: "turn/frame_%04d.png".
class FrameNames {
 public:
  FrameNames() = default;
  // Throws UsageError naming --output unless the last part of the path has exactly one %d or %0Nd.
  explicit FrameNames(const std::string& pattern);

  // Whether there is a '%' in the last part of the path, so that a pattern is meant.
  static bool is_pattern(const std::string& path);

  std::string path(std::int64_t number) const;
  // Where it is written what made them: "turn/frame.ovoid".
  std::string record_path() const;

 private:
  std::string before_, after_;
  int width_ = 0;
};

// 64 bits that tell texts and files from each other (FNV-1a); no protection against forgery.
std::uint64_t hash_of(std::string_view bytes, std::uint64_t seed = 14695981039346656037ULL);

// What makes frames what they are: the command line, this version, and the files that are read as
// they now lie there (place, size, time of change).
std::uint64_t settings_key(const std::string& command_line, const std::vector<std::string>& files);

// Knows by a file beside the frames which of them are whole and made by the same settings: a line
// for each, added when the frame is there, with its key and a hash of its bytes. A frame that was
// damaged, replaced or made otherwise is not among them.
class FrameRecord {
 public:
  // Reads what is there, if anything, and writes nothing before the first frame is there: a run
  // that fails before leaves nothing. Throws Error(kFileWrite) for a file that is not a record.
  explicit FrameRecord(FrameNames names);

  // Whether the frame's file is there and as it was when it was recorded under this key.
  bool is_whole(std::int64_t number, std::uint64_t key) const;
  // Throws Error(kFileWrite).
  void add(std::int64_t number, std::uint64_t key);
  bool is_empty() const noexcept { return entries_.empty(); }

 private:
  struct Entry {
    std::uint64_t key = 0, content = 0;
  };
  void write() const;

  FrameNames names_;
  bool is_written_ = false;               // by this run
  std::map<std::string, Entry> entries_;  // by the file's name without folder
};

}  // namespace ovoid::cli
