// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "io/core/byte_source.h"
#include "ovoid/error.h"

namespace ovoid::io {

// One line that gives a value to a name, and where it stands.
struct HeaderField {
  const ByteSource* source = nullptr;
  int line = 0;  // from 1
  std::string name;
  std::string value;

  // Throws Error that names file, line and field.
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const;
  std::string quoted() const;  // the value, shortened, for a message
};

// Walks a text header line by line, holding no more of the file than the header itself.
class HeaderLines {
 public:
  explicit HeaderLines(const ByteSource& source) : source_(source) {}

  // The next line without its end, of Unix, Windows or old Macs (\n, \r\n, \r), in any mixture;
  // false at the end of the file. Where all lines so far have ended in \r alone, a \n behind one
  // belongs to what follows: samples may begin with it. Throws
  // Error(kFileFormat) if the header has more than 16 MiB: long enough for a list of 100 000 file
  // names, and a file that is all header is refused before it is held in memory.
  bool next(std::string& line);

  int number() const { return number_; }  // of the line returned last, from 1
  // Behind that line.
  std::int64_t offset() const { return static_cast<std::int64_t>(position_); }

 private:
  const ByteSource& source_;
  std::size_t find_end(std::size_t from) const { return text_.find_first_of("\r\n", from); }

  std::string text_;
  bool are_returns_ = true;  // the ends of all lines so far
  std::size_t position_ = 0;
  int number_ = 0;
};

}  // namespace ovoid::io
