// SPDX-License-Identifier: Apache-2.0
// As much of HDF5 as reading arrays of numbers needs. Sizes that a file claims are compared with
// the file before memory is taken, and nothing outside it is followed: no external links, files or
// virtual datasets.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// Is `name` in the group an object of the file's own? Links outside the file are not followed; in
// it, soft ones neither: what they mean is listed where it is.
bool is_hard_link(hid_t group, const std::string& name);

// A dataset of numbers, described.
struct Hdf5Dataset {
  std::string path;   // "/PartType0/Coordinates"
  std::string group;  // "/PartType0"; "/" for the root
  std::string name;   // "Coordinates"
  std::vector<std::int64_t> dims;
  std::optional<Hdf5Type> type;  // none if it holds no numbers that are read
};

class Hdf5File {
 public:
  // Lists datasets of up to `max_rank` axes. Throws Error(kFileFormat) if the library cannot open
  // it.
  explicit Hdf5File(const std::string& path, std::size_t max_rank = 2);

  // All datasets of one to `max_rank` axes in the file, in the order of their paths. Throws
  // Error(kUnsupported) for a file of more than kMaxObjects or with groups more than kMaxDepth
  // deep.
  const std::vector<Hdf5Dataset>& datasets() const noexcept { return datasets_; }
  static constexpr int kMaxObjects = 100000;
  static constexpr int kMaxDepth = 16;

  bool exists(const std::string& path) const;

  // The numbers of a dataset of one or two axes with rows as tuples; [k, n] with `is_transposed`.
  // Throws Error: kFileFormat for one that is broken or does not fit the file, kUnsupported as
  // check_hdf5_storage() says, kCancelled.
  DataArray read(const Hdf5Dataset& described, bool is_transposed, ReadProgress& progress) const;
  // Bytes in the file, as far as that is known; for progress.
  std::int64_t num_bytes(const Hdf5Dataset& dataset) const;

  // All numbers of an attribute of `object`, or else of the small dataset of that name in it; empty
  // if there is neither.
  std::vector<double> numbers(const std::string& object, const std::string& name) const;

 private:
  [[noreturn]] void fail(const std::string& what, bool is_unsupported = false) const;
  void list(hid_t group, const std::string& path, int depth);
  void describe(hid_t group, const std::string& path, const std::string& name);

  std::string name_;
  int max_rank_;
  std::unique_ptr<ByteSource> source_;
  Hdf5Silence silence_;
  Hdf5Handle file_;
  std::vector<Hdf5Dataset> datasets_;
  int num_objects_ = 0;
};

}  // namespace ovoid::io
