// SPDX-License-Identifier: Apache-2.0
// As much of HDF5 as reading arrays of numbers needs. Sizes that a file claims are compared with
// the file before memory is taken, and nothing outside it is followed: no external links, files or
// virtual datasets.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/byte_source.h"
#include "io/hdf5_storage.h"
#include "io/samples.h"
#include "ovoid/dataset.h"

namespace ovoid::io {

// An identifier of the library, given back when it goes.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);

  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Close by) : id_(id), close_(by) {}
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept
      : id_(std::exchange(other.id_, hid_t{-1})), close_(other.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }

  // Gives it back now; false if the library then says that something went wrong.
  bool close() noexcept {
    const hid_t id = std::exchange(id_, hid_t{-1});
    return id < 0 || close_(id) >= 0;
  }

  hid_t get() const noexcept { return id_; }
  bool is_open() const noexcept { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

// To be held around calls of the library, which may have been built without a lock of its own.
std::mutex& hdf5_mutex();

// The library prints nothing while this lives: errors are told by us.
class Hdf5Silence {
 public:
  Hdf5Silence() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Hdf5Silence() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Hdf5Silence(const Hdf5Silence&) = delete;
  Hdf5Silence& operator=(const Hdf5Silence&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

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
  // Throws Error(kFileFormat) if the library cannot open it.
  explicit Hdf5File(const std::string& path);

  // All datasets of one and two axes in the file, in the order of their paths. Throws
  // Error(kUnsupported) for a file of more than kMaxObjects or with groups more than kMaxDepth
  // deep.
  const std::vector<Hdf5Dataset>& datasets() const noexcept { return datasets_; }
  static constexpr int kMaxObjects = 100000;
  static constexpr int kMaxDepth = 16;

  bool exists(const std::string& path) const;

  // The numbers of a dataset with rows as tuples; [k, n] with `is_transposed`. Throws Error:
  // kFileFormat for one that is broken or does not fit the file, kUnsupported as
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
  std::unique_ptr<ByteSource> source_;
  Hdf5Silence silence_;
  Hdf5Handle file_;
  std::vector<Hdf5Dataset> datasets_;
  int num_objects_ = 0;
};

}  // namespace ovoid::io
