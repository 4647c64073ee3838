// SPDX-License-Identifier: Apache-2.0
// The samples of several files as one stream.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/core/decode.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::io {

// Opens one part after the other; all arguments must outlive it. No more than the samples of all
// parts may be asked for. Throws what open_samples() and its streams throw.
class PartsStream {
 public:
  PartsStream(const SampleParts& parts, ReadProgress& progress, std::vector<std::string>& notes)
      : parts_(parts), progress_(progress), notes_(notes) {}

  void append(std::int64_t count, SampleBuffer& out) {
    pass(count, [&](SampleStream& stream, std::int64_t piece) { stream.append(piece, out); });
  }
  void skip(std::int64_t count) {
    pass(count, [](SampleStream& stream, std::int64_t piece) { stream.skip(piece); });
  }

 private:
  template <typename Action>
  void pass(std::int64_t count, const Action& action) {
    while (count > 0) {
      if (!stream_) {
        part_ = parts_.open(index_);
        stream_ =
            open_samples(*part_.source, part_.offset, parts_.encoding, parts_.each, progress_);
        num_left_ = parts_.each.num_bytes;
      }
      const std::int64_t piece = std::min(count, num_left_);
      action(*stream_, piece);
      count -= piece;
      num_left_ -= piece;
      if (num_left_ > 0) continue;
      stream_->finish(notes_);
      stream_.reset();
      part_ = {};
      ++index_;
    }
  }

  const SampleParts& parts_;
  ReadProgress& progress_;
  std::vector<std::string>& notes_;
  std::int64_t index_ = 0;
  std::int64_t num_left_ = 0;
  SamplePart part_;
  std::unique_ptr<SampleStream> stream_;
};

// Bytes of the files, for progress. Throws Error if one is not there or too small.
inline std::int64_t check_parts(const SampleParts& parts, const ReadOptions& options) {
  std::int64_t num_stored = 0;
  for (std::int64_t i = 0; i < parts.count; ++i) {
    const SamplePart part = parts.open(i);
    check_plausible(*part.source, part.offset, parts.encoding, parts.each);
    num_stored += part.source->size() - part.offset;
    if (options.stop.stop_requested())
      throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
  }
  return num_stored;
}

}  // namespace ovoid::io
