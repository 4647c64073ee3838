// SPDX-License-Identifier: Apache-2.0
#include "io/netcdf/netcdf_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostItems = 1 << 20;  // dimensions, variables, attributes of one
constexpr std::int64_t kMostKept = 4096;      // bytes of an attribute

std::int64_t padded(std::int64_t num_bytes) { return (num_bytes + 3) / 4 * 4; }

// The types from 1 on; from the seventh on those of version 5. The second is text.
constexpr std::array<std::optional<ScalarType>, 11> kTypes{
    ScalarType::kInt8,    std::nullopt,         ScalarType::kInt16, ScalarType::kInt32,
    ScalarType::kFloat32, ScalarType::kFloat64, ScalarType::kUInt8, ScalarType::kUInt16,
    ScalarType::kUInt32,  ScalarType::kInt64,   ScalarType::kUInt64};

std::int64_t netcdf_size_of(const std::optional<ScalarType>& type) {
  return type ? static_cast<std::int64_t>(size_of(*type)) : 1;
}

std::vector<double> numbers_of_bytes(ScalarType type, std::string_view bytes) {
  std::vector<double> numbers;
  data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T))
      numbers.push_back(static_cast<double>(number_at<T>(bytes.data() + at, true)));
  });
  return numbers;
}

class NetcdfHeaderReader {
 public:
  explicit NetcdfHeaderReader(const ByteSource& source) : source_(source) {}

  NetcdfHeader run() {
    const std::string magic = source_.text(0, 4);
    if (magic.size() < 4 || !magic.starts_with("CDF")) fail("is no netCDF file");
    version_ = static_cast<unsigned char>(magic[3]);
    if (version_ != 1 && version_ != 2 && version_ != 5)
      fail(fmt::format("netCDF version {}: expected 1, 2 or 5", version_));
    position_ = 4;
    const std::string what = "number of records";
    const std::uint64_t num_records = unsigned_number(count_size(), what);
    // All ones: records are still being written.
    if (num_records != (version_ == 5 ? ~std::uint64_t{0} : 0xffffffffU))
      num_records_ = checked_count(num_records, what);
    read_dimensions();
    header_.attributes = attributes_of("the file");
    for (std::int64_t left = begin_list(0x0b, "variables"); left > 0; --left) read_variable();
    place_records();
    for (const CfVariable& variable : header_.variables) check_place(variable);
    for (CfDimension& dimension : header_.dimensions)
      if (dimension.is_unlimited) dimension.size = *num_records_;
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source_.name(), what));
  }

  std::uint64_t unsigned_number(std::int64_t num_bytes, const std::string& what) {
    const std::string bytes = source_.text(position_, num_bytes);
    if (static_cast<std::int64_t>(bytes.size()) < num_bytes)
      fail(fmt::format("the netCDF header ends at {}: is the file truncated?", what));
    position_ += num_bytes;
    return unsigned_of(bytes, true);
  }

  std::int64_t count_size() const { return version_ == 5 ? 8 : 4; }

  std::int64_t checked_count(std::uint64_t value, const std::string& what) const {
    if (value > static_cast<std::uint64_t>(kMaxNumBytes))
      fail(fmt::format("netCDF {}: {}: expected a number", what, value));
    return static_cast<std::int64_t>(value);
  }

  std::int64_t count(const std::string& what) {
    return checked_count(unsigned_number(count_size(), what), what);
  }

  // The elements of a list; 0 if it is absent.
  std::int64_t begin_list(std::uint64_t expected_tag, const std::string& what) {
    const std::uint64_t tag = unsigned_number(4, what);
    const std::int64_t num_items = count(what);
    const bool is_absent = tag == 0 && num_items == 0;
    if (!is_absent && (tag != expected_tag || num_items > kMostItems))
      fail(fmt::format("netCDF {}: {} of tag {}: not expected", what, num_items, tag));
    return num_items;
  }

  std::string name(const std::string& what) {
    const std::int64_t size = count(what);
    if (size > 4096 || size > source_.size() - position_)
      fail(fmt::format("netCDF {}: a name of {} bytes", what, size));
    std::string text = source_.text(position_, size);
    position_ += padded(size);
    return text;
  }

  std::optional<ScalarType> type(const std::string& what) {
    const std::uint64_t number = unsigned_number(4, what);
    if (number < 1 || number > kTypes.size()) fail(fmt::format("netCDF {}: type {}", what, number));
    return kTypes[number - 1];
  }

  void read_dimensions() {
    for (std::int64_t left = begin_list(0x0a, "dimensions"); left > 0; --left) {
      CfDimension dimension{name("a dimension"), count("a dimension")};
      dimension.is_unlimited = dimension.size == 0;
      header_.dimensions.push_back(std::move(dimension));
    }
  }

  CfAttributes attributes_of(const std::string& owner) {
    const std::string what = "attributes of " + owner;
    CfAttributes attributes;
    for (std::int64_t left = begin_list(0x0c, what); left > 0; --left) {
      CfAttribute attribute{.name = name(what)};
      const std::optional<ScalarType> of = attribute.type = type(what);
      const std::int64_t size = netcdf_size_of(of), num_values = count(what);
      if (num_values > (source_.size() - position_) / size)
        fail(fmt::format("netCDF {}: {} values do not fit the file: is it truncated?", what,
                         num_values));
      std::string bytes = source_.text(position_, std::min(num_values * size, kMostKept));
      if (of)
        attribute.numbers = numbers_of_bytes(*of, bytes);
      else
        attribute.text = bytes.substr(0, bytes.find('\0'));
      position_ += padded(num_values * size);
      attributes.push_back(std::move(attribute));
    }
    return attributes;
  }

  void read_variable() {
    CfVariable variable;
    NetcdfPlace place;
    variable.name = name("a variable");
    const std::string what = fmt::format("variable '{}'", variable.name.substr(0, 80));
    const std::int64_t num_dims = count(what);
    if (num_dims > 1024) fail(fmt::format("netCDF {}: {} dimensions", what, num_dims));
    std::vector<std::int64_t> sizes;
    for (std::int64_t i = 0; i < num_dims; ++i) {
      const std::int64_t number = count(what);
      if (number >= static_cast<std::int64_t>(header_.dimensions.size()))
        fail(fmt::format("netCDF {}: dimension {} of {}", what, number, header_.dimensions.size()));
      variable.dims.push_back(static_cast<std::size_t>(number));
      const CfDimension& dimension = header_.dimensions[variable.dims.back()];
      if (!dimension.is_unlimited) {
        sizes.push_back(dimension.size);
        continue;
      }
      if (i != 0) fail(fmt::format("netCDF {}: records along its dimension {}", what, i));
      place.has_records = true;
    }
    variable.attributes = attributes_of(what);
    variable.type = type(what);
    sizes.push_back(netcdf_size_of(variable.type));
    count(what);  // its own idea of the size, which may be too small a number for it
    place.begin = static_cast<std::int64_t>(
        std::min<std::uint64_t>(unsigned_number(version_ == 1 ? 4 : 8, what), kMaxNumBytes));
    const auto num_bytes = checked_product(sizes);
    if (!num_bytes || *num_bytes > kMaxNumBytes)
      fail(fmt::format("netCDF {}: {} are more than any file holds", what, dims_text(sizes)));
    place.num_bytes = *num_bytes;
    header_.variables.push_back(std::move(variable));
    header_.places.push_back(place);
  }

  // Where records begin, and how many there are if the file leaves it open.
  void place_records() {
    std::int64_t num_variables = 0, stride = 0, first = source_.size();
    for (const NetcdfPlace& place : header_.places) {
      if (!place.has_records) continue;
      stride += std::min(padded(place.num_bytes), kMaxNumBytes / kMostItems);
      first = std::min(first, place.begin);
      // Those of a single variable are not padded.
      if (++num_variables == 1) header_.record_stride = place.num_bytes;
    }
    if (num_variables != 1) header_.record_stride = stride;
    if (num_records_) return;
    num_records_ = header_.record_stride > 0 ? (source_.size() - first) / header_.record_stride : 0;
  }

  void check_place(const CfVariable& variable) const {
    const NetcdfPlace& place = header_.place_of(variable);
    std::int64_t num_needed = place.num_bytes;
    if (place.has_records && *num_records_ > 0) {
      const auto others = checked_product(std::array{*num_records_ - 1, header_.record_stride});
      if (!others || *others > kMaxNumBytes)
        fail(fmt::format("netCDF: {} records of {} bytes", *num_records_, header_.record_stride));
      num_needed += *others;
    } else if (place.has_records) {
      num_needed = 0;
    }
    if (place.begin + num_needed <= source_.size()) return;
    fail(
        fmt::format("netCDF variable '{}' needs {} bytes from {} on, the file has {}: is it "
                    "truncated?",
                    variable.name.substr(0, 80), num_needed, place.begin, source_.size()));
  }

  const ByteSource& source_;
  int version_ = 1;
  std::int64_t position_ = 0;
  std::optional<std::int64_t> num_records_;
  NetcdfHeader header_;
};

}  // namespace

bool begins_like_netcdf(std::string_view start) noexcept {
  return start.starts_with("CDF\x01") || start.starts_with("CDF\x02") ||
         start.starts_with("CDF\x05");
}

NetcdfHeader read_netcdf_header(const ByteSource& source) {
  return NetcdfHeaderReader(source).run();
}

bool is_exodus_header(const NetcdfHeader& header) {
  return find_cf(header.attributes, "api_version") != nullptr;
}

std::vector<double> netcdf_numbers(const ByteSource& source, const NetcdfHeader& header,
                                   const CfVariable& variable, std::int64_t most) {
  const std::vector<std::int64_t> shape = header.shape(variable);
  const std::int64_t count = shape.empty() ? 1 : shape[0];
  if (!variable.type || shape.size() > 1 || count > most) return {};
  const std::int64_t size = netcdf_size_of(variable.type);
  const NetcdfPlace& place = header.place_of(variable);
  if (!place.has_records)
    return numbers_of_bytes(*variable.type, source.text(place.begin, count * size));
  std::vector<double> numbers;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::string bytes = source.text(place.begin + i * header.record_stride, size);
    const std::vector<double> one = numbers_of_bytes(*variable.type, bytes);
    numbers.insert(numbers.end(), one.begin(), one.end());
  }
  return numbers;
}

}  // namespace ovoid::io
