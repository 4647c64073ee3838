// SPDX-License-Identifier: Apache-2.0
// The deflated syntax: what lies behind the meta information is one stream of deflate.
#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "io/dicom/dicom_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr const char* kDeflatedSyntax = "1.2.840.10008.1.2.1.99";

// What a deflated data set may grow to: memory is taken as it does.
constexpr std::size_t kMaxInflated = std::size_t{1} << 30;

class InflatedSource final : public ByteSource {
 public:
  InflatedSource(std::string name, std::string bytes)
      : ByteSource(std::move(name), static_cast<std::int64_t>(bytes.size())),
        bytes_(std::move(bytes)) {}

  void read(std::int64_t offset, std::span<std::byte> out) const override {
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }

 private:
  std::string bytes_;
};

// zlib's state, which goes away with it.
struct RawInflater {
  RawInflater() { is_ready = inflateInit2(&stream, -15) == Z_OK; }  // no header of zlib's or gzip's
  ~RawInflater() { inflateEnd(&stream); }
  RawInflater(const RawInflater&) = delete;
  RawInflater& operator=(const RawInflater&) = delete;

  z_stream stream{};
  bool is_ready = false;
};

// The file's meta information as it stands, and behind it the inflated data set.
std::string inflated(const ByteSource& file, std::int64_t begin) {
  constexpr std::int64_t kChunk = std::int64_t{1} << 18;
  std::string out = file.text(0, begin);
  RawInflater inflater;
  if (!inflater.is_ready)
    throw Error(ErrorCode::kOutOfMemory, file.name() + ": no memory for zlib");
  int status = Z_OK;
  std::string piece(static_cast<std::size_t>(kChunk), '\0');
  for (std::int64_t at = begin; status != Z_STREAM_END;) {
    std::string in = file.text(at, kChunk);
    at += static_cast<std::int64_t>(in.size());
    inflater.stream.next_in = reinterpret_cast<Bytef*>(in.data());
    inflater.stream.avail_in = static_cast<uInt>(in.size());
    do {
      inflater.stream.next_out = reinterpret_cast<Bytef*>(piece.data());
      inflater.stream.avail_out = static_cast<uInt>(piece.size());
      status = inflate(&inflater.stream, Z_NO_FLUSH);
      if (status == Z_MEM_ERROR)
        throw Error(ErrorCode::kOutOfMemory, file.name() + ": no memory for zlib");
      out.append(piece, 0, piece.size() - inflater.stream.avail_out);
      if (out.size() > kMaxInflated) {
        throw Error(ErrorCode::kUnsupported,
                    fmt::format("{}: its deflated data set has more than {} bytes", file.name(),
                                kMaxInflated));
      }
    } while (status == Z_OK && inflater.stream.avail_out == 0);
    const bool is_stuck = status == Z_BUF_ERROR && !in.empty();
    if ((status != Z_OK && status != Z_STREAM_END && !is_stuck) ||
        (in.empty() && status != Z_STREAM_END)) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: byte {}: the deflated data set is damaged or cut short",
                              file.name(), at));
    }
  }
  return out;
}

}  // namespace

std::shared_ptr<const ByteSource> dicom_data_source(std::shared_ptr<const ByteSource> file) {
  const DicomMeta meta = read_dicom_meta(*file);
  if (meta.transfer_syntax != kDeflatedSyntax) return file;
  return std::make_shared<InflatedSource>(file->name(), inflated(*file, meta.end));
}

}  // namespace ovoid::io
