// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "io/reader/reader_messages.h"
#include "ovoid/dataset.h"
#include "ovoid/io.h"

namespace ovoid {

// The process that readers of other people's libraries run in: ovoid-read, started when it is first
// needed and kept for the steps of a series, until the session ends. It may open the files that
// were named and nothing else (docs/reliability.md, "Readers in a process of their own").
//
// The host of the library is left as it is: no handler of a signal is set, none is raised, no other
// child is waited for, and no descriptor of the host's is handed on.
class ReaderSession {
 public:
  // `inputs`: all files that will be read in this session, as the user named them. Nothing is
  // started or opened.
  explicit ReaderSession(std::vector<std::string> inputs);
  ~ReaderSession();  // ends the process
  ReaderSession(const ReaderSession&) = delete;
  ReaderSession& operator=(const ReaderSession&) = delete;

  // Reads `paths`, of the format that formats() call so, of what the user calls `source`.
  // options.progress and options.stop are heeded. Throws what the reader throws; Error(kFileFormat)
  // if the process ends for another reason or sends what is wrong; Error(kUnsupported) if it cannot
  // be found or started; kCancelled. May be called from many threads: one reads, the others wait.
  Dataset read(const std::string& format, const std::string& source,
               const std::vector<std::string>& paths, const ReadOptions& options);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

namespace io {

// Of the format that formats() call so. In options.session's process, or that of a session for
// these paths alone.
Dataset read_foreign(const std::string& format, const std::string& source,
                     const std::vector<std::string>& paths, const ReadOptions& options);

}  // namespace io
}  // namespace ovoid
