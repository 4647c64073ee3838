// SPDX-License-Identifier: Apache-2.0
#include "io/images/nifti_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

using namespace std::string_view_literals;

struct DataType {
  int code;
  const char* name;
  std::optional<ScalarType> type;  // empty: not read
  int num_channels = 1;
};

constexpr DataType kDataTypes[] = {
    {2, "uint8", ScalarType::kUInt8},      {4, "int16", ScalarType::kInt16},
    {8, "int32", ScalarType::kInt32},      {16, "float32", ScalarType::kFloat32},
    {64, "float64", ScalarType::kFloat64}, {256, "int8", ScalarType::kInt8},
    {512, "uint16", ScalarType::kUInt16},  {768, "uint32", ScalarType::kUInt32},
    {1024, "int64", ScalarType::kInt64},   {1280, "uint64", ScalarType::kUInt64},
    {128, "RGB24", ScalarType::kUInt8, 3}, {2304, "RGBA32", ScalarType::kUInt8, 4},
    {0, "unknown", std::nullopt},          {1, "binary", std::nullopt},
    {32, "complex64", std::nullopt},       {1536, "float128", std::nullopt},
    {1792, "complex128", std::nullopt},    {2048, "complex256", std::nullopt},
};

bool has_bytes_at(std::string_view start, std::size_t offset, std::string_view text) {
  return start.size() >= offset + text.size() && start.substr(offset, text.size()) == text;
}

// The size that a header states of itself, in the byte order in which it makes sense.
struct StatedSize {
  std::int32_t value = 0;
  bool is_big_endian = false;
};

StatedSize stated_size(std::string_view bytes) {
  StatedSize size;
  if (bytes.size() < 4) return size;
  const auto little = number_at<std::uint32_t>(bytes.data(), false);
  const std::uint32_t big = swapped(little);
  for (const std::size_t known : {kNifti1Size, kNifti2Size}) {
    if (little == known || big == known) return {static_cast<std::int32_t>(known), big == known};
  }
  return size;
}

class Parser {
 public:
  Parser(const std::string& name, std::string_view bytes) : name_(name), bytes_(bytes) {}

  NiftiHeader run() {
    const StatedSize size = stated_size(bytes_);
    if (size.value == 0)
      fail(fmt::format("sizeof_hdr: expected {} or {}", kNifti1Size, kNifti2Size));
    header_.version = size.value == static_cast<std::int32_t>(kNifti1Size) ? 1 : 2;
    header_.is_big_endian = size.is_big_endian;
    if (bytes_.size() < header_.size()) {
      fail(fmt::format("ends after {} bytes: the header of NIfTI-{} has {}", bytes_.size(),
                       header_.version, header_.size()));
    }
    header_.version == 1 ? read_version_1() : read_version_2();
    check_offset();
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code, fmt::format("{}: {}", name_, what));
  }

  template <typename T>
  T get(std::size_t offset) const {
    return number_at<T>(bytes_.data() + offset, header_.is_big_endian);
  }

  std::string text(std::size_t offset, std::size_t size) const {
    const std::string_view field = bytes_.substr(offset, size);
    return std::string(field.substr(0, field.find('\0')));
  }

  void read_version_1() {
    header_.is_pair = has_bytes_at(bytes_, 344, "ni1\0"sv);
    if (!header_.is_pair && !has_bytes_at(bytes_, 344, "n+1\0"sv))
      fail("magic: expected n+1 or ni1");
    read_dims<std::int16_t>(40);
    read_type(get<std::int16_t>(70), get<std::int16_t>(72));
    read_numbers<float>(76, header_.pixdim);
    const double offset = get<float>(108);
    if (!(offset >= 0 && offset <= 0x1p53 && std::floor(offset) == offset))
      fail(fmt::format("vox_offset = {}: expected a number of bytes", offset));
    header_.vox_offset = static_cast<std::int64_t>(offset);
    header_.slope = get<float>(112);
    header_.intercept = get<float>(116);
    header_.units = get<unsigned char>(123);
    header_.time_offset = get<float>(136);
    header_.qform_code = get<std::int16_t>(252);
    header_.sform_code = get<std::int16_t>(254);
    read_numbers<float>(256, header_.quaternion);
    read_numbers<float>(268, header_.qform_offset);
    for (std::size_t i = 0; i < 3; ++i) read_numbers<float>(280 + 16 * i, header_.sform[i]);
    header_.intent_name = text(328, 16);
  }

  void read_version_2() {
    header_.is_pair = has_bytes_at(bytes_, 4, "ni2\0"sv);
    if (!header_.is_pair && !has_bytes_at(bytes_, 4, "n+2\0"sv)) fail("magic: expected n+2 or ni2");
    if (!has_bytes_at(bytes_, 8, "\r\n\x1a\n"sv))
      fail("magic: its line ends were changed, so that the samples are no longer what they were");
    refuse_cifti(get<std::int32_t>(504));
    read_type(get<std::int16_t>(12), get<std::int16_t>(14));
    read_dims<std::int64_t>(16);
    read_numbers<double>(104, header_.pixdim);
    header_.vox_offset = get<std::int64_t>(168);
    header_.slope = get<double>(176);
    header_.intercept = get<double>(184);
    header_.time_offset = get<double>(216);
    header_.qform_code = get<std::int32_t>(344);
    header_.sform_code = get<std::int32_t>(348);
    read_numbers<double>(352, header_.quaternion);
    read_numbers<double>(376, header_.qform_offset);
    for (std::size_t i = 0; i < 3; ++i) read_numbers<double>(400 + 32 * i, header_.sform[i]);
    header_.units = get<std::int32_t>(500);
    header_.intent_name = text(508, 16);
  }

  // CIFTI-2 keeps a matrix whose rows are places on a surface and in a volume.
  void refuse_cifti(int intent) const {
    constexpr int kFirst = 3000, kLast = 3099;
    if (intent < kFirst || intent > kLast) return;
    fail(
        "is CIFTI (values on a brain's surface, dscalar, dtseries, dlabel and the like), which is "
        "not read: expected its volume as NIfTI, by 'wb_command -cifti-separate A.dscalar.nii "
        "COLUMN -volume-all A.nii'",
        ErrorCode::kUnsupported);
  }

  template <typename T, std::size_t N>
  void read_numbers(std::size_t offset, std::array<double, N>& numbers) const {
    for (std::size_t i = 0; i < N; ++i)
      numbers[i] = static_cast<double>(get<T>(offset + i * sizeof(T)));
  }

  template <typename T>
  void read_dims(std::size_t offset) {
    const auto num_dims = static_cast<std::int64_t>(get<T>(offset));
    if (num_dims < 1 || num_dims > 7)
      fail(fmt::format("dim[0] = {}: expected 1 to 7 axes", num_dims));
    for (std::size_t i = 0; i < static_cast<std::size_t>(num_dims); ++i) {
      auto dim = static_cast<std::int64_t>(get<T>(offset + (i + 1) * sizeof(T)));
      if (dim == 0 && i >= 3) dim = 1;  // as some writers have it
      if (dim < 1 || dim > kMaxAxisSize)
        fail(fmt::format("dim[{}] = {}: expected 1 to {}", i + 1, dim, kMaxAxisSize));
      header_.dims[i] = dim;
    }
    for (std::size_t i = 5; i < 7; ++i) {
      if (header_.dims[i] == 1) continue;
      fail(fmt::format("dim[{}] = {}: expected 1: only space, time and components are read", i + 1,
                       header_.dims[i]),
           ErrorCode::kUnsupported);
    }
  }

  void read_type(int code, int num_bits) {
    const auto* const found =
        std::find_if(std::begin(kDataTypes), std::end(kDataTypes),
                     [&](const DataType& candidate) { return candidate.code == code; });
    const bool is_known = found != std::end(kDataTypes);
    if (!is_known || !found->type) {
      fail(fmt::format("datatype {}{}: expected integers of 1 to 8 bytes, float32, float64, RGB24 "
                       "or RGBA32",
                       code, is_known ? fmt::format(" ({})", found->name) : ""),
           ErrorCode::kUnsupported);
    }
    header_.type = *found->type;
    header_.num_channels = found->num_channels;
    const int expected = static_cast<int>(8 * size_of(header_.type)) * found->num_channels;
    if (num_bits != expected && num_bits != 0) {  // 0: not said
      fail(fmt::format("bitpix = {}: datatype {} ({}) has {} bits", num_bits, code, found->name,
                       expected));
    }
  }

  void check_offset() {
    if (header_.vox_offset < 0 || header_.vox_offset > kMaxNumBytes)
      fail(fmt::format("vox_offset = {}: expected a number of bytes", header_.vox_offset));
    const auto least = static_cast<std::int64_t>(header_.size() + kNiftiExtenderSize);
    if (header_.is_pair || header_.vox_offset >= least) return;
    // Some writers leave it out.
    if (header_.vox_offset != 0) {
      fail(fmt::format("vox_offset = {}: expected at least {}, behind the header",
                       header_.vox_offset, least));
    }
    header_.vox_offset = least;
  }

  const std::string& name_;
  std::string_view bytes_;
  NiftiHeader header_;
};

}  // namespace

bool looks_like_nifti(std::string_view start) noexcept {
  return has_bytes_at(start, 344, "n+1\0"sv) || has_bytes_at(start, 344, "ni1\0"sv) ||
         has_bytes_at(start, 4, "n+2\0"sv) || has_bytes_at(start, 4, "ni2\0"sv);
}

bool looks_like_analyze(std::string_view start) noexcept {
  return start.size() >= kNifti1Size && !looks_like_nifti(start) &&
         stated_size(start).value == static_cast<std::int32_t>(kNifti1Size);
}

NiftiHeader parse_nifti_header(const std::string& name, std::string_view bytes) {
  return Parser(name, bytes).run();
}

int nifti_code_of(ScalarType type) noexcept {
  for (const DataType& candidate : kDataTypes) {
    if (candidate.type == type && candidate.num_channels == 1) return candidate.code;
  }
  return 0;
}

}  // namespace ovoid::io
