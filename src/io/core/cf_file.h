// SPDX-License-Identifier: Apache-2.0
// A file of variables on named dimensions, as netCDF has them: what its readers tell, and
// cf_grid.h makes a dataset of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/cf_conventions.h"
#include "io/core/chunked_array.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

struct CfDimension {
  std::string name;  // empty: the file gives none
  std::int64_t size = 0;
  bool is_unlimited = false;  // one along which a file grows
};

struct CfVariable {
  std::string name;                  // with its groups: "temp", "ocean/temp"
  std::optional<ScalarType> type{};  // none: no numbers that are read
  std::string unread{};              // then what they are, where it is no text
  std::vector<std::size_t> dims{};   // numbers of dimensions, the slowest first
  CfAttributes attributes{};

  std::string text(std::string_view attribute) const { return cf_text(attributes, attribute); }
  std::string_view own_name() const {  // without groups
    return std::string_view(name).substr(name.rfind('/') + 1);
  }
};

struct CfDescription {
  std::vector<CfDimension> dimensions;
  CfAttributes attributes;
  std::vector<CfVariable> variables;

  std::vector<std::int64_t> shape(const CfVariable& variable) const;
  // Of this name, with its groups; null: not there.
  const CfVariable* variable(std::string_view wanted) const;
};

class CfFile {
 public:
  explicit CfFile(std::string name) : name_(std::move(name)) {}  // of the file, for messages
  virtual ~CfFile() = default;
  CfFile(const CfFile&) = delete;
  CfFile& operator=(const CfFile&) = delete;

  const std::string& name() const noexcept { return name_; }
  virtual const char* format() const { return "netCDF"; }  // as Dataset::format has it
  virtual const CfDescription& description() const = 0;
  // The values, as stored, of a variable of numbers and at most one dimension, of at most `most`
  // samples; empty for any other, and for one that cannot be read.
  virtual std::vector<double> numbers(const CfVariable& variable, std::int64_t most) const = 0;
  // What stands for samples that nobody has written.
  virtual CfFill fill() const { return CfFill::kOfNetcdf; }
  // A variable of numbers: shape, chunk, type, byte order and how chunks are read. Samples that
  // `may_stay` are read after this is gone. Throws Error for what cannot be read.
  virtual ChunkedArray array(const CfVariable& variable, bool may_stay) const = 0;

 private:
  std::string name_;
};

}  // namespace ovoid::io
