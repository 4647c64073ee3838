// SPDX-License-Identifier: Apache-2.0
// Attributes, groups and datasets of an HDF5 file that have to be there. `place` is what messages
// call the object; every function throws Error(kFileFormat) that names the file.
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/dataset.h"
#include "ovoid/error.h"

namespace ovoid::io {

class Hdf5Objects {
 public:
  // `source` is the file, and outlives this.
  Hdf5Objects(std::string name, const ByteSource& source)
      : name_(std::move(name)), source_(source) {}

  const std::string& name() const noexcept { return name_; }
  const ByteSource& source() const noexcept { return source_; }

  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const;
  std::string text(hid_t object, const std::string& place, const char* name) const;
  std::vector<double> numbers(hid_t object, const std::string& place, const char* name,
                              std::size_t count) const;
  std::int64_t whole_number(double value, const std::string& place, const char* name,
                            std::int64_t most, std::int64_t least = 1) const;
  std::int64_t count(hid_t object, const std::string& place, const char* name,
                     std::int64_t most) const;
  // An object by its name in a group, if it is of the file's own and of that type.
  Hdf5Handle open(hid_t group, const std::string& name, const std::string& place,
                  H5O_type_t type) const;
  // What a dataset of numbers holds, checked against the file.
  Hdf5Extent extent_of(hid_t dataset, const std::string& place) const;
  DataArray samples(hid_t dataset, const Hdf5Extent& extent, DataArray description,
                    ReadProgress& progress) const;

 private:
  std::string name_;
  const ByteSource& source_;
};

}  // namespace ovoid::io
