// SPDX-License-Identifier: Apache-2.0
// HDF5 files for tests, written through the library; groups on the way are made.
#pragma once

#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>
#include <string>
#include <type_traits>
#include <vector>

#include "io/foreign/hdf5_handle.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {

using Hdf5Sizes = std::vector<hsize_t>;

class TestHdf5 {
 public:
  using Creation = std::function<void(hid_t)>;  // sets what a dataset is created with

  explicit TestHdf5(const std::string& path)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose),
        links_(H5Pcreate(H5P_LINK_CREATE), H5Pclose) {
    H5Pset_create_intermediate_group(links_.get(), 1);
  }

  hid_t id() const { return file_.get(); }
  // Nobody else can open the file before.
  void close() { file_ = {}; }

  TestHdf5& group(const std::string& path) {
    const Hdf5Handle made(H5Gcreate2(id(), path.c_str(), links_.get(), H5P_DEFAULT, H5P_DEFAULT),
                          H5Gclose);
    return *this;
  }

  // Values of T, stored as `type`.
  template <typename T>
  TestHdf5& dataset(const std::string& path, const Hdf5Sizes& dims, const std::vector<T>& values,
                    hid_t type, const Creation& set = {}) {
    const Hdf5Handle made = create(path, dims, type, set);
    EXPECT_GE(H5Dwrite(made.get(), native<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
    return *this;
  }
  template <typename T>
  TestHdf5& dataset(const std::string& path, const Hdf5Sizes& dims, const std::vector<T>& values) {
    return dataset(path, dims, values, native<T>());
  }
  // Floats counted from 1.
  TestHdf5& floats(const std::string& path, const Hdf5Sizes& dims) {
    return dataset(path, dims, counting<float>(count_of(dims)), H5T_IEEE_F32LE);
  }
  // The bytes as they shall stand in the file.
  TestHdf5& raw(const std::string& path, const Hdf5Sizes& dims, const std::string& bytes,
                hid_t type) {
    const Hdf5Handle made = create(path, dims, type, {});
    EXPECT_GE(H5Dwrite(made.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()), 0);
    return *this;
  }
  // One chunk, as large as the dataset, whose bytes went through the filters that `set` names.
  TestHdf5& chunk(const std::string& path, const Hdf5Sizes& dims, const std::string& bytes,
                  hid_t type, const Creation& set) {
    const Hdf5Handle made = create(path, dims, type, [&](hid_t creation) {
      H5Pset_chunk(creation, static_cast<int>(dims.size()), dims.data());
      set(creation);
    });
    const Hdf5Sizes first(dims.size(), 0);
    EXPECT_GE(H5Dwrite_chunk(made.get(), H5P_DEFAULT, 0, first.data(), bytes.size(), bytes.data()),
              0);
    return *this;
  }

  TestHdf5& numbers(const std::string& object, const char* name,
                    const std::vector<double>& values) {
    const hsize_t count = values.size();
    const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    return put(object, name, H5T_NATIVE_DOUBLE, space.get(), values.data());
  }
  TestHdf5& number(const std::string& object, const char* name, double value) {
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    return put(object, name, H5T_NATIVE_DOUBLE, space.get(), &value);
  }
  // One text of its own length, or of a variable one.
  TestHdf5& text(const std::string& object, const char* name, const std::string& value,
                 bool is_variable = false) {
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    return put_texts(object, name, {value}, is_variable, space.get());
  }
  TestHdf5& texts(const std::string& object, const char* name,
                  const std::vector<std::string>& values, bool is_variable = false) {
    const hsize_t count = values.size();
    const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    return put_texts(object, name, values, is_variable, space.get());
  }
  // A list of single characters, as Imaris writes texts.
  TestHdf5& characters(const std::string& object, const char* name, const std::string& value) {
    std::vector<std::string> list;
    for (const char c : value) list.emplace_back(1, c);
    return texts(object, name, list);
  }

  static std::size_t count_of(const Hdf5Sizes& dims) {
    std::size_t count = 1;
    for (const hsize_t dim : dims) count *= dim;
    return count;
  }

 private:
  template <typename T>
  static hid_t native() {
    if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
    if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
    if constexpr (std::is_same_v<T, long double>) return H5T_NATIVE_LDOUBLE;
    if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_NATIVE_UINT8;
    if constexpr (std::is_same_v<T, std::int8_t>) return H5T_NATIVE_INT8;
    if constexpr (std::is_same_v<T, std::uint16_t>) return H5T_NATIVE_UINT16;
    if constexpr (std::is_same_v<T, std::int16_t>) return H5T_NATIVE_INT16;
    if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
    return H5T_NATIVE_INT64;
  }

  Hdf5Handle create(const std::string& path, const Hdf5Sizes& dims, hid_t type,
                    const Creation& set) {
    const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (set) set(creation.get());
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                           H5Sclose);
    Hdf5Handle made(H5Dcreate2(id(), path.c_str(), type, space.get(), links_.get(), creation.get(),
                               H5P_DEFAULT),
                    H5Dclose);
    EXPECT_TRUE(made.is_open()) << path;
    return made;
  }

  TestHdf5& put(const std::string& object, const char* name, hid_t type, hid_t space,
                const void* values) {
    const Hdf5Handle made(H5Acreate_by_name(id(), object.c_str(), name, type, space, H5P_DEFAULT,
                                            H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    EXPECT_GE(H5Awrite(made.get(), type, values), 0) << object << " " << name;
    return *this;
  }

  TestHdf5& put_texts(const std::string& object, const char* name,
                      const std::vector<std::string>& values, bool is_variable, hid_t space) {
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    if (is_variable) {
      H5Tset_size(type.get(), H5T_VARIABLE);
      std::vector<const char*> pointers;
      for (const std::string& value : values) pointers.push_back(value.c_str());
      return put(object, name, type.get(), space, pointers.data());
    }
    std::size_t longest = 1;
    for (const std::string& value : values) longest = std::max(longest, value.size());
    H5Tset_size(type.get(), longest);
    H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
    std::string all;
    for (std::string value : values) {
      value.resize(longest);
      all += value;
    }
    return put(object, name, type.get(), space, all.data());
  }

  Hdf5Handle file_, links_;
};

// What reading says of the file, without its name.
inline std::string hdf5_error_of(const std::string& path, const ReadOptions& options = {}) {
  std::string message = error_of([&] { read_dataset({path}, options); });
  for (std::size_t at = message.find(path); at != std::string::npos; at = message.find(path))
    message.replace(at, path.size(), "F");
  return message;
}

}  // namespace ovoid::io
