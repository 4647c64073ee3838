// SPDX-License-Identifier: Apache-2.0
// Encoded samples to bytes in memory, from the front to the back. A stream gives exactly the bytes
// that it is asked for or throws Error(kFileFormat); memory grows with what is really decoded,
// never with what is claimed. Samples come out in the byte order of the file (text: native).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

enum class Encoding { kRaw, kGzip, kBzip2, kText, kHex };

const char* name_of(Encoding encoding) noexcept;

// What the file should hold.
struct WantedSamples {
  std::int64_t num_bytes = 0;
  // Decoded bytes before them to leave out; kRaw: -1 takes the last bytes of the file.
  std::int64_t num_skipped = 0;
  ScalarType type = ScalarType::kUInt8;
  // The file that says so, and what: "a.nhdr" and "64x64x64 uint8", for messages.
  std::string header;
  std::string layout;
};

// Hands out the wanted bytes, decoded. In all, no more than wanted.num_bytes may be asked for; of
// text only whole samples.
class SampleStream {
 public:
  SampleStream() = default;
  virtual ~SampleStream() = default;
  SampleStream(const SampleStream&) = delete;
  SampleStream& operator=(const SampleStream&) = delete;

  // Appends the next `count` bytes to the buffer.
  virtual void append(std::int64_t count, SampleBuffer& out) = 0;
  // Passes the next `count` bytes. Of raw data they are not read.
  virtual void skip(std::int64_t count) = 0;
  // After the last wanted byte: verifies the checksum of gzip and bzip2. Bytes that follow are
  // reported in `notes` and otherwise ignored, as the NRRD format has it.
  virtual void finish(std::vector<std::string>& notes) = 0;
};

// Decodes from byte `offset` of the source to its end; the source and `progress` must outlive the
// stream. gzip and bzip2 may consist of several members. Throws as check_plausible does.
std::unique_ptr<SampleStream> open_samples(const ByteSource& source, std::int64_t offset,
                                           Encoding encoding, const WantedSamples& wanted,
                                           ReadProgress& progress);

// Throws Error(kFileFormat) if the size of the source alone shows that it cannot hold the wanted
// samples.
void check_plausible(const ByteSource& source, std::int64_t offset, Encoding encoding,
                     const WantedSamples& wanted);

// Up to `count` first bytes of what gzip data stand for; fewer if they end or are broken.
std::string gzip_start(const ByteSource& source, std::size_t count);

}  // namespace ovoid::io
