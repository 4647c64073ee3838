// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/netcdf_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

class NetcdfChecker {
 public:
  explicit NetcdfChecker(const ByteSource& source) : source_(source) {}

  void run() {
    const std::string magic = source_.text(0, 4);
    if (magic.size() < 4 || !magic.starts_with("CDF")) fail("is no netCDF file");
    version_ = static_cast<unsigned char>(magic[3]);
    if (version_ != 1 && version_ != 2 && version_ != 5)
      fail(fmt::format("netCDF version {}: expected 1, 2 or 5", version_));
    position_ = 4;
    num_records_ = count("number of records");
    read_dimensions();
    pass_attributes("the file");
    read_variables();
    if (!has_exodus_version_)
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is netCDF, but no Exodus mesh (it has no attribute "
                              "'api_version'), and other netCDF files are not read: write its grid "
                              "as NRRD, VTI, NPY or HDF5",
                              source_.name()));
  }

 private:
  static constexpr std::int64_t kMaxItems = 1 << 20;  // dimensions, variables, attributes of one

  struct Variable {
    std::string name;
    std::int64_t num_bytes = 0;  // of one record, or of all
    bool has_records = false;
    std::int64_t begin = 0;
  };

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

  // Counts and sizes have 8 bytes in version 5, else 4. All ones: records are still being written.
  std::int64_t count(const std::string& what) {
    const std::uint64_t value = unsigned_number(version_ == 5 ? 8 : 4, what);
    const bool is_streaming = value == (version_ == 5 ? ~std::uint64_t{0} : 0xffffffffU);
    if (is_streaming || value > static_cast<std::uint64_t>(kMaxNumBytes))
      fail(fmt::format("netCDF {}: {}: expected a number", what, value));
    return static_cast<std::int64_t>(value);
  }

  // The elements of a list; 0 if it is absent.
  std::int64_t begin_list(std::uint64_t expected_tag, const std::string& what) {
    const std::uint64_t tag = unsigned_number(4, what);
    const std::int64_t num_items = count(what);
    const bool is_absent = tag == 0 && num_items == 0;
    if (!is_absent && (tag != expected_tag || num_items > kMaxItems))
      fail(fmt::format("netCDF {}: {} of tag {}: not expected", what, num_items, tag));
    return num_items;
  }

  std::string name(const std::string& what) {
    const std::int64_t size = count(what);
    if (size > 4096 || size > source_.size() - position_)
      fail(fmt::format("netCDF {}: a name of {} bytes", what, size));
    std::string text = source_.text(position_, size);
    position_ += (size + 3) / 4 * 4;
    return text;
  }

  std::int64_t type_size(const std::string& what) {
    // byte char short int float double, from version 5 on ubyte ushort uint int64 uint64
    constexpr std::array<std::int64_t, 12> kSizes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    const std::uint64_t type = unsigned_number(4, what);
    if (type < 1 || type >= kSizes.size()) fail(fmt::format("netCDF {}: type {}", what, type));
    return kSizes[type];
  }

  void read_dimensions() {
    for (std::int64_t left = begin_list(0x0a, "dimensions"); left > 0; --left) {
      name("a dimension");
      dimensions_.push_back(count("a dimension"));
    }
  }

  void pass_attributes(const std::string& of) {
    const std::string what = "attributes of " + of;
    for (std::int64_t left = begin_list(0x0c, what); left > 0; --left) {
      if (name(what) == "api_version") has_exodus_version_ = true;
      const std::int64_t size = type_size(what);
      const std::int64_t num_values = count(what);
      if (num_values > (source_.size() - position_) / size)
        fail(fmt::format("netCDF {}: {} values do not fit the file: is it truncated?", what,
                         num_values));
      position_ += (num_values * size + 3) / 4 * 4;
    }
  }

  void read_variables() {
    std::vector<Variable> variables;
    for (std::int64_t left = begin_list(0x0b, "variables"); left > 0; --left)
      variables.push_back(read_variable());
    std::int64_t num_record_bytes = 0;
    std::int64_t num_record_variables = 0;
    for (const Variable& variable : variables) {
      if (!variable.has_records) continue;
      ++num_record_variables;
      num_record_bytes += std::min(variable.num_bytes, kMaxNumBytes / kMaxItems);
    }
    // Records are padded to four bytes, but for those of a single variable.
    if (num_record_variables == 1) {
      for (const Variable& variable : variables)
        if (variable.has_records) num_record_bytes = variable.num_bytes;
    }
    for (const Variable& variable : variables) check_place(variable, num_record_bytes);
  }

  Variable read_variable() {
    Variable variable;
    variable.name = name("a variable");
    const std::string what = fmt::format("variable '{}'", variable.name.substr(0, 80));
    const std::int64_t num_dims = count(what);
    if (num_dims > 1024) fail(fmt::format("netCDF {}: {} dimensions", what, num_dims));
    std::vector<std::int64_t> sizes;
    for (std::int64_t i = 0; i < num_dims; ++i) {
      const std::int64_t number = count(what);
      if (number >= static_cast<std::int64_t>(dimensions_.size()))
        fail(fmt::format("netCDF {}: dimension {} of {}", what, number, dimensions_.size()));
      sizes.push_back(dimensions_[static_cast<std::size_t>(number)]);
      // A dimension of size 0 is that of the records; it can only be the first.
      if (sizes.back() != 0) continue;
      if (i != 0) fail(fmt::format("netCDF {}: records along its dimension {}", what, i));
      variable.has_records = true;
      sizes.pop_back();
    }
    pass_attributes(what);
    sizes.push_back(type_size(what));
    count(what);  // its own idea of the size, which may be too small a number for it
    variable.begin = static_cast<std::int64_t>(
        std::min<std::uint64_t>(unsigned_number(version_ == 1 ? 4 : 8, what), kMaxNumBytes));
    const auto num_bytes = checked_product(sizes);
    if (!num_bytes || *num_bytes > kMaxNumBytes)
      fail(fmt::format("netCDF {}: {} are more than any file holds", what, dims_text(sizes)));
    variable.num_bytes = *num_bytes;
    if (variable.has_records) variable.num_bytes = (variable.num_bytes + 3) / 4 * 4;
    return variable;
  }

  void check_place(const Variable& variable, std::int64_t num_record_bytes) const {
    std::int64_t num_needed = variable.num_bytes;
    if (variable.has_records && num_records_ > 0) {
      const auto others = checked_product(std::array{num_records_ - 1, num_record_bytes});
      if (!others || *others > kMaxNumBytes)
        fail(fmt::format("netCDF: {} records of {} bytes", num_records_, num_record_bytes));
      num_needed += *others;
    } else if (variable.has_records) {
      num_needed = 0;
    }
    // The last value's padding may be missing.
    if (variable.begin + num_needed <= source_.size() + 3) return;
    fail(
        fmt::format("netCDF variable '{}' needs {} bytes from {} on, the file has {}: is it "
                    "truncated?",
                    variable.name.substr(0, 80), num_needed, variable.begin, source_.size()));
  }

  const ByteSource& source_;
  int version_ = 1;
  std::int64_t position_ = 0;
  std::int64_t num_records_ = 0;
  bool has_exodus_version_ = false;
  std::vector<std::int64_t> dimensions_;
};

}  // namespace

void check_exodus(const ByteSource& source) { NetcdfChecker(source).run(); }

void check_hdf5_size(const ByteSource& source) {
  const std::string start = source.text(0, 96);
  // Where the address of the end stands, in addresses of 8 bytes, behind which version of the
  // superblock (HDF5 File Format Specification, II.A). Others are left to the library.
  std::size_t place = 0;
  if (start.size() == 96 && (start[8] == 0 || start[8] == 1) && start[13] == 8)
    place = start[8] == 0 ? 40 : 44;
  if (start.size() == 96 && (start[8] == 2 || start[8] == 3) && start[9] == 8) place = 28;
  if (place == 0) return;
  std::uint64_t end = 0;
  for (std::size_t i = 8; i-- > 0;) end = end << 8U | static_cast<unsigned char>(start[place + i]);
  if (end <= static_cast<std::uint64_t>(source.size())) return;
  throw Error(ErrorCode::kFileFormat,
              fmt::format("{}: the HDF5 file says it has {} bytes, it has {}: is it truncated?",
                          source.name(), end, source.size()));
}

}  // namespace ovoid::io
