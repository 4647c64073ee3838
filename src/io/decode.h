// SPDX-License-Identifier: Apache-2.0
// Encoded samples to bytes in memory. Every function appends exactly `wanted.num_bytes` to a buffer
// or throws Error(kFileFormat); memory grows with what is really decoded, never with what is
// claimed. Samples come out in the byte order of the file (text: native).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/byte_source.h"
#include "io/samples.h"
#include "ovoid/lattice.h"

namespace ovoid::io {

enum class Encoding { kRaw, kGzip, kBzip2, kText, kHex };

const char* name_of(Encoding encoding) noexcept;

// What the samples should be.
struct WantedSamples {
  std::int64_t num_bytes = 0;
  std::int64_t num_skipped =
      0;  // decoded bytes before them to leave out; kRaw: -1 takes the last bytes of the file
  ScalarType type = ScalarType::kUInt8;
  std::string
      header;  // the file that says so, and what: "a.nhdr" and "64x64x64 uint8", for messages
  std::string layout;
};

// Decodes from byte `offset` of the source to its end. Bytes behind the wanted ones are reported in
// `notes` and otherwise ignored, as the NRRD format has it. gzip and bzip2 may consist of several
// members; their checksums are verified.
void append_decoded(const ByteSource& source, std::int64_t offset, Encoding encoding,
                    const WantedSamples& wanted, SampleBuffer& out, ReadProgress& progress,
                    std::vector<std::string>& notes);

// Throws, as append_decoded would, if the size of the source alone shows that it cannot hold the
// wanted samples.
void check_plausible(const ByteSource& source, std::int64_t offset, Encoding encoding,
                     const WantedSamples& wanted);

}  // namespace ovoid::io
