// SPDX-License-Identifier: Apache-2.0
// What is said over a ReaderLink. Descriptions are MessagePack; numbers of arrays lie in one piece
// of shared memory, sealed so that it can neither shrink nor change.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/reader/reader_link.h"
#include "ovoid/dataset.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {

// A reader that speaks another version refuses every request.
inline constexpr int kReaderProtocol = 8;

// Reads one dataset, or one step of it.
struct ReaderRequest {
  std::string format;              // as formats() call it
  std::string source;              // what the user named, for messages
  std::vector<std::string> paths;  // files; as named, from `folder`
  std::string folder;              // the working directory
  // But for all of `raw` save axis_order and spacing, `progress`, `stop` and `session`.
  ReadOptions options;
  std::int64_t memory = 0;  // of the host: available_memory()
  // What may be opened, canonical paths: regular files, and folders with all that is below them.
  std::vector<std::string> files;
  std::vector<std::string> folders;
};

std::vector<std::uint8_t> to_message(const ReaderRequest& request);
std::vector<std::uint8_t> to_message(const Error& error);

// Throw Error(kFileFormat) for what is none.
ReaderRequest request_from_message(const std::vector<std::uint8_t>& message);
Error error_from_message(const std::vector<std::uint8_t>& message);

// A dataset with its arrays moved to shared memory, one after the other: each is given back as soon
// as it is copied. Throws Error(kOutOfMemory).
struct DatasetMessage {
  std::vector<std::uint8_t> description;
  UniqueFd memory;
};
DatasetMessage to_message(Dataset dataset);

// Who has sent the request.
struct ReaderHost {
  std::string source;              // as the request's
  std::vector<std::string> paths;  // as the request's
  ReadOptions options;

  // Where samples that stay in their file lie: in what a dataset calls its source, if that is one
  // of the paths, else in the first.
  const std::string& file_of(const Dataset& dataset) const;
};

// The dataset, its arrays and cells in the memory itself, which they keep, or, where they may, left
// in the file. Everything is checked as if it came
// from a file: the seals and the size of the memory, the places of arrays in it and in the file,
// sizes against each other, node numbers, positions (finite), the lattice's axes, and that the rows
// are the share that was asked for. Throws Error(kFileFormat) naming `source`, and what open_file()
// does.
Dataset dataset_from_message(const ReaderHost& host, const DatasetMessage& message);

}  // namespace ovoid::io
