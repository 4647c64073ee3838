// SPDX-License-Identifier: Apache-2.0
// Groups and arrays of a VTKHDF file, through the HDF5 library. All members throw
// Error(kFileFormat) naming the file and the object; kUnsupported for what is stored in a way that
// is not read.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/core/samples.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_objects.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// A dataset of numbers, of which rows along the slowest axis are read.
class VtkHdfArray {
 public:
  VtkHdfArray(const Hdf5Objects& objects, Hdf5Handle dataset, std::string place);

  const std::string& place() const noexcept { return place_; }
  const std::vector<std::int64_t>& dims() const noexcept { return extent_.dims; }
  std::int64_t num_rows() const noexcept { return extent_.dims[0]; }

  // Rows from `first` on, as tuples of all that a row holds; there may be none.
  DataArray rows(std::int64_t first, std::int64_t count, ReadProgress& progress) const;

 private:
  const Hdf5Objects* objects_;
  Hdf5Handle dataset_;
  std::string place_;
  Hdf5Extent extent_;  // rows may be none
};

// What groups of a file have in common. Arrays stay open: opening one looks at all its chunks.
struct VtkHdfFile {
  const Hdf5Objects& objects;
  std::map<std::string, VtkHdfArray> arrays{};  // by place
};

// Copies are the same group.
class VtkHdfGroup {
 public:
  // `place` is what messages call it: "/VTKHDF/PointData".
  VtkHdfGroup(VtkHdfFile& file, Hdf5Handle group, std::string place)
      : file_(&file),
        group_(std::make_shared<Hdf5Handle>(std::move(group))),
        place_(std::move(place)) {}

  const Hdf5Objects& objects() const noexcept { return file_->objects; }
  const std::string& place() const noexcept { return place_; }
  hid_t id() const noexcept { return group_->get(); }

  // What hangs in it on links of its own, by name. Others lead out of the group, or the file.
  struct Member {
    std::string name;
    H5L_type_t link = H5L_TYPE_HARD;
    H5O_type_t type = H5O_TYPE_UNKNOWN;
  };
  std::vector<Member> members() const;

  // Is there anything of that name, on whatever link?
  bool has(const std::string& name) const;
  // Nothing unless it has a group of that name.
  std::optional<VtkHdfGroup> group(const std::string& name) const;
  // A dataset that has to be there; stays valid.
  const VtkHdfArray& needed(const std::string& name) const;
  // All numbers of a small array. Throws unless each is whole, from 0 to kMaxNumBytes.
  std::vector<std::int64_t> counts(const std::string& name) const;
  // One of them: a row of an array of one or two axes.
  std::int64_t count_at(const std::string& name, std::int64_t row, std::int64_t column = 0) const;

  // Text of an attribute, also of variable length, up to 64 letters; "" for none.
  std::string text(const char* name) const;

 private:
  VtkHdfFile* file_;
  std::shared_ptr<const Hdf5Handle> group_;
  std::string place_;
};

// The numbers of an array as they are needed to find places: whole, from 0 to kMaxNumBytes.
std::vector<std::int64_t> whole_numbers_of(const Hdf5Objects& objects, const std::string& place,
                                           const DataArray& array);

}  // namespace ovoid::io
