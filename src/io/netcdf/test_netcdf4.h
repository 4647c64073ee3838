// SPDX-License-Identifier: Apache-2.0
// netCDF-4 files for tests: what a classic file of test_netcdf.h holds, through the HDF5 library as
// netCDF's own lays it out [NetCDF-4].
#pragma once

#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/foreign/hdf5_handle.h"
#include "io/netcdf/test_netcdf.h"

namespace ovoid::io {

struct TestNc4Options {
  bool is_packed = false;    // in chunks, shuffled and deflated
  bool has_strings = false;  // attributes of variable length, as netCDF's NC_STRING
};

class TestNc4Writer {
 public:
  TestNc4Writer(const std::string& path, const TestNc& nc, TestNc4Options options = {})
      : nc_(nc), options_(options), file_(create_file(path)) {
    for (const TestNcVariable& variable : nc.variables) add(variable);
    for (std::size_t d = 0; d < nc.dims.size(); ++d)
      if (!scales_.contains(static_cast<int>(d))) add_dimension(static_cast<int>(d));
    for (const TestNcVariable& variable : nc.variables) {
      if (is_coordinate(variable)) continue;
      for (std::size_t axis = 0; axis < variable.dims.size(); ++axis)
        H5DSattach_scale(datasets_.at(variable.name).get(), scales_.at(variable.dims[axis])->get(),
                         static_cast<unsigned>(axis));
    }
  }

  hid_t file() const { return file_.get(); }
  hid_t dataset(const std::string& name) const { return datasets_.at(name).get(); }

 private:
  // netCDF's library keeps the order in which things were made.
  static Hdf5Handle create_file(const std::string& path) {
    const Hdf5Handle plist(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_link_creation_order(plist.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
    return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plist.get(), H5P_DEFAULT), H5Fclose};
  }
  static hid_t type_of(int type) {
    static const hid_t kTypes[] = {0,
                                   H5T_STD_I8BE,
                                   0,
                                   H5T_STD_I16BE,
                                   H5T_STD_I32BE,
                                   H5T_IEEE_F32BE,
                                   H5T_IEEE_F64BE,
                                   H5T_STD_U8BE,
                                   H5T_STD_U16BE,
                                   H5T_STD_U32BE,
                                   H5T_STD_I64BE,
                                   H5T_STD_U64BE};
    return kTypes[type];
  }
  hsize_t size_of_dim(int dim) const {
    const std::int64_t size = nc_.dims[static_cast<std::size_t>(dim)].second;
    return static_cast<hsize_t>(size == 0 ? nc_.num_records : size);
  }
  bool is_coordinate(const TestNcVariable& variable) const {
    return variable.dims.size() == 1 &&
           nc_.dims[static_cast<std::size_t>(variable.dims[0])].first == variable.name;
  }

  Hdf5Handle create(const std::string& name, const std::vector<int>& dims, hid_t type) {
    std::vector<hsize_t> sizes, most, chunk;
    bool has_records = false;
    for (const int dim : dims) {
      const bool is_of_records = nc_.dims[static_cast<std::size_t>(dim)].second == 0;
      sizes.push_back(size_of_dim(dim));
      most.push_back(is_of_records ? H5S_UNLIMITED : sizes.back());
      chunk.push_back(is_of_records ? 1 : (sizes.back() + 1) / 2);
      has_records = has_records || is_of_records;
    }
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    if (has_records || (options_.is_packed && !dims.empty()))
      H5Pset_chunk(plist.get(), static_cast<int>(chunk.size()), chunk.data());
    if (options_.is_packed && !dims.empty()) {
      H5Pset_shuffle(plist.get());
      H5Pset_deflate(plist.get(), 4);
    }
    const Hdf5Handle space(
        H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), most.data()), H5Sclose);
    return {H5Dcreate2(file_.get(), name.c_str(), type, space.get(), H5P_DEFAULT, plist.get(),
                       H5P_DEFAULT),
            H5Dclose};
  }

  void add(const TestNcVariable& variable) {
    const hid_t type = type_of(variable.type);
    Hdf5Handle dataset = create(variable.name, variable.dims, type);
    if (!variable.bytes.empty())
      H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, variable.bytes.data());
    for (const TestNcAttribute& one : variable.attributes) attribute(dataset.get(), one);
    const Hdf5Handle& kept = datasets_.emplace(variable.name, std::move(dataset)).first->second;
    if (!is_coordinate(variable)) return;
    H5DSset_scale(kept.get(), variable.name.c_str());
    scales_[variable.dims[0]] = &kept;
  }

  // One without a variable has a dataset for its length alone.
  void add_dimension(int dim) {
    const std::string& name = nc_.dims[static_cast<std::size_t>(dim)].first;
    const Hdf5Handle& kept =
        datasets_.emplace(name, create(name, {dim}, H5T_IEEE_F32BE)).first->second;
    H5DSset_scale(kept.get(), "This is a netCDF dimension but not a netCDF variable.         7");
    scales_[dim] = &kept;
  }

  void attribute(hid_t dataset, const TestNcAttribute& one) const {
    const bool is_text = one.type == kNcChar;
    const hsize_t count = is_text ? 1 : one.bytes.size() / H5Tget_size(type_of(one.type));
    const Hdf5Handle space(is_text ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr),
                           H5Sclose);
    const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
    const bool is_string = is_text && options_.has_strings;
    H5Tset_size(text.get(), is_string ? H5T_VARIABLE : std::max<std::size_t>(one.bytes.size(), 1));
    const hid_t type = is_text ? text.get() : type_of(one.type);
    const Hdf5Handle made(
        H5Acreate2(dataset, one.name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    const char* const pointer = one.bytes.c_str();
    H5Awrite(made.get(), type, is_string ? static_cast<const void*>(&pointer) : pointer);
  }

  const TestNc& nc_;
  TestNc4Options options_;
  Hdf5Handle file_;
  std::map<std::string, Hdf5Handle> datasets_;
  std::map<int, const Hdf5Handle*> scales_;  // of the dimensions
};

}  // namespace ovoid::io
