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
#include <unordered_set>
#include <utility>
#include <vector>

#include "io/core/byte_source.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_handle.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// Is `name` in the group an object of the file's own? Links outside the file are not followed; in
// it, soft ones neither: what they mean is listed where it is.
bool is_hard_link(hid_t group, const std::string& name);

// A dataset, described.
struct Hdf5Dataset {
  std::string path;   // "/PartType0/Coordinates"
  std::string group;  // "/PartType0"; "/" for the root
  std::string name;   // "Coordinates"
  std::vector<std::int64_t> dims;
  std::optional<Hdf5Type> type;  // none if it holds no numbers that are read
  std::string type_text = {};    // of what is none (hdf5_type_text())
};

// A dataset of one or two axes that is open, its rows as tuples; of a file that must outlive it.
class Hdf5Table {
 public:
  // After check_hdf5_storage(). `is_transposed`: [k, n], whose columns are the rows.
  Hdf5Table(std::string name, Hdf5Handle dataset, Hdf5Extent extent, bool is_transposed)
      : name_(std::move(name)),
        dataset_(std::move(dataset)),
        extent_(std::move(extent)),
        is_transposed_(is_transposed) {}

  std::int64_t num_rows() const noexcept { return extent_.dims[is_transposed_ ? 1 : 0]; }
  // Rows whose reading, one run behind the other, unpacks each chunk once.
  std::int64_t rows_at_once() const;
  // A run of the rows. Peak memory is theirs, twice that if transposed, and a chunk. Throws Error:
  // kFileFormat, kCancelled.
  DataArray read(const Rows& rows, ReadProgress& progress) const;

 private:
  std::string name_;
  Hdf5Handle dataset_;
  Hdf5Extent extent_;
  bool is_transposed_;
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
  // Those of more axes, of none and of sizes that no file has, of which the first few are kept.
  const std::vector<Hdf5Dataset>& others() const noexcept { return others_; }
  // Paths of groups, in their order, without the root.
  const std::vector<std::string>& groups() const noexcept { return groups_; }
  static constexpr int kMaxObjects = 100000;
  static constexpr int kMaxDepth = 16;

  bool exists(const std::string& path) const;
  const Hdf5Dataset* find(const std::string& path) const noexcept;  // among datasets()
  hid_t id() const noexcept { return file_.get(); }
  const ByteSource& source() const noexcept { return *source_; }
  // A group or dataset; not open if there is none.
  Hdf5Handle object(const std::string& path) const;

  // A dataset of one or two axes. Throws Error: kFileFormat for one that is broken or does not fit
  // the file, kUnsupported as check_hdf5_storage() says.
  Hdf5Table open(const Hdf5Dataset& described, bool is_transposed = false) const;
  // Bytes in the file, as far as that is known; for progress.
  std::int64_t num_bytes(const Hdf5Dataset& dataset) const;

  // All numbers of an attribute of `object`, or else of the small dataset of that name in it; empty
  // if there is neither. Of texts the same, without the dataset.
  std::vector<double> numbers(const std::string& object, const std::string& name) const;
  // Throws what open() does; of up to Hdf5Extent::kMaxRank axes.
  void check(const Hdf5Dataset& described) const;
  // All numbers of a dataset of as many axes. Throws what open() does.
  std::vector<double> values(const Hdf5Dataset& described) const;
  std::vector<std::string> texts(const std::string& object, const std::string& name) const;
  std::optional<std::string> text(const std::string& object, const std::string& name) const;

 private:
  [[noreturn]] void fail(const std::string& what, bool is_unsupported = false) const;
  Hdf5Extent checked(const Hdf5Dataset& described, hid_t dataset) const;
  void list(hid_t group, const std::string& path, int depth);
  void describe(hid_t group, const std::string& path, const std::string& name);

  std::string name_;
  int max_rank_;
  std::unique_ptr<ByteSource> source_;
  Hdf5Silence silence_;
  Hdf5Handle file_;
  std::vector<Hdf5Dataset> datasets_, others_;
  std::vector<std::string> groups_;
  std::unordered_set<std::string> paths_;  // of all groups and datasets
  int num_objects_ = 0;
};

}  // namespace ovoid::io
