// SPDX-License-Identifier: Apache-2.0
// The deflated syntax: what lies behind the meta information is one stream of deflate.
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "io/core/decompressors.h"
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

// The file's meta information as it stands, and behind it the inflated data set.
std::string inflated(const ByteSource& file, std::int64_t begin) {
  constexpr std::int64_t kChunk = std::int64_t{1} << 18;
  std::string out = file.text(0, begin);
  Inflater inflater(Inflater::kBare);
  std::string in, piece(static_cast<std::size_t>(kChunk), '\0');
  for (std::int64_t at = begin; !inflater.ended;) {
    if (inflater.stream.avail_in == 0) {
      in = file.text(at, kChunk);
      at += static_cast<std::int64_t>(in.size());
      inflater.stream.next_in = reinterpret_cast<Bytef*>(in.data());
      inflater.stream.avail_in = static_cast<uInt>(in.size());
    }
    inflater.stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    inflater.stream.avail_out = static_cast<uInt>(piece.size());
    const bool has_input = !in.empty();
    const bool is_broken = !inflater.step().empty();
    const std::size_t made = piece.size() - inflater.stream.avail_out;
    out.append(piece, 0, made);
    if (out.size() > kMaxInflated) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: its deflated data set has more than {} bytes", file.name(),
                              kMaxInflated));
    }
    if (is_broken || (!has_input && made == 0 && !inflater.ended)) {
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
