// SPDX-License-Identifier: Apache-2.0
// XDMF whose numbers lie in HDF5 files, read in the process of its own. What would make it fail: a
// type or shape of the XDMF's believed against the file's, links that lead out of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/xdmf/test_xdmf.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

#ifdef OVOID_IO_HDF5
#include <hdf5.h>

#include "io/foreign/hdf5_handle.h"

namespace ovoid::io {
namespace xdmf_hdf5_test {

using testing::ElementsAre;
using testing::HasSubstr;

// Numbers counted from 1 at /g/NAME, big endian, in two chunks if there are two rows or more.
void write_counted(const std::string& path, const std::string& name,
                   const std::vector<hsize_t>& dims) {
  const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  const Hdf5Handle group(H5Gcreate2(file.get(), "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                         H5Gclose);
  hsize_t count = 1;
  for (const hsize_t dim : dims) count *= dim;
  std::vector<hsize_t> chunk = dims;
  chunk[0] = (chunk[0] + 1) / 2;
  const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(plist.get(), static_cast<int>(chunk.size()), chunk.data());
  H5Pset_deflate(plist.get(), 4);
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                         H5Sclose);
  const Hdf5Handle dataset(H5Dcreate2(group.get(), name.c_str(), H5T_STD_I16BE, space.get(),
                                      H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                           H5Dclose);
  const auto values = counting<std::int16_t>(count);
  H5Dwrite(dataset.get(), H5T_NATIVE_INT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Lcreate_external("elsewhere.h5", "/g/f", group.get(), "outside", H5P_DEFAULT, H5P_DEFAULT);
}

class XdmfInHdf5 : public testing::Test {
 protected:
  void SetUp() override { write_counted(folder.file("a.h5"), "f", {2, 3, 4}); }

  Dataset read(const std::string& item, const ReadOptions& options = {}) const {
    return read_dataset(
        {folder.write("a.xdmf", xdmf_file(xdmf_grid(kXdmfEven + xdmf_attribute("f", item))))},
        options);
  }
  std::string item_error(const std::string& item) const {
    return error_of([&] { read(item); });
  }

  TestFolder folder;
};

const std::string kInHdf5 =
    "<DataItem Dimensions=\"2 3 4\" Format=\"HDF\">\n a.h5:/g/f\n</DataItem>";

TEST_F(XdmfInHdf5, TypesAreTheFiles) {
  const Dataset dataset = read(kInHdf5);
  EXPECT_EQ(dataset.format, "XDMF");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.5, 2, 3));
  EXPECT_EQ(values_of<std::int16_t>(dataset.array("f")), counting<std::int16_t>(24));
  // Another shape of as many numbers.
  EXPECT_EQ(values_of<std::int16_t>(read(with(kInHdf5, "2 3 4", "24 1")).array("f")),
            counting<std::int16_t>(24));
  EXPECT_EQ(read(with(kInHdf5, "Dimensions=\"2 3 4\"", "")).array("f").num_tuples, 24);
}

// What h5py and the HDF5 reader make of the same array.
TEST_F(XdmfInHdf5, IsWhatTheHdf5ReaderReads) {
  const Dataset grid = read_dataset({folder.file("a.h5")});
  EXPECT_EQ(grid.lattice.dims, read(kInHdf5).lattice.dims);
  EXPECT_EQ(values_of<std::int16_t>(grid.array()), values_of<std::int16_t>(read(kInHdf5).array()));
}

TEST_F(XdmfInHdf5, SlabsAreReadByRows) {
  write_counted(folder.file("s.h5"), "f", {3, 2, 3, 4});
  const auto slab = [](const std::string& choice) {
    return "<DataItem ItemType=\"HyperSlab\" Dimensions=\"2 3 4\">" +
           xdmf_item("3 4", choice, "NumberType=\"Int\"") +
           "<DataItem Dimensions=\"3 2 3 4\" Format=\"HDF\">s.h5:/g/f</DataItem></DataItem>";
  };
  const auto values = values_of<std::int16_t>(read(slab("2 0 0 0 1 1 1 1 1 2 3 4")).array());
  EXPECT_EQ(values.front(), 49);
  EXPECT_EQ(values.back(), 72);
  // The first plane of the first and the third volume.
  const auto planes = values_of<std::int16_t>(read(slab("0 0 0 0 2 1 1 1 2 1 3 4")).array());
  EXPECT_EQ(planes[11], 12);
  EXPECT_EQ(planes[12], 49);
  EXPECT_THAT(item_error(slab("3 0 0 0 1 1 1 1 1 2 3 4")),
              HasSubstr("takes 1 from 3 by 1 of axis 0, which has 3"));
}

TEST_F(XdmfInHdf5, StepsAreFound) {
  const std::string grid =
      xdmf_grid(kXdmfEven + "<Time Value=\"2\"/>" + xdmf_attribute("f", kInHdf5));
  const std::string path = folder.write(
      "t.xmf", xdmf_file(xdmf_grid(grid + with(grid, "\"2\"/>", "\"4\"/>"),
                                   "GridType=\"Collection\" CollectionType=\"Temporal\"")));
  const auto steps = open_steps({path});
  EXPECT_THAT(steps->times(), ElementsAre(2, 4));
  EXPECT_EQ(steps->read(1).array("f").num_tuples, 24);
  EXPECT_THAT(files_read_for(path), ElementsAre(path, folder.file("a.h5")));
}

TEST_F(XdmfInHdf5, WhatIsNotThereIsTold) {
  EXPECT_THAT(item_error(with(kInHdf5, "2 3 4", "2 3 5")),
              HasSubstr("has Dimensions 2 3 5: '/g/f' in"));
  EXPECT_THAT(item_error(with(kInHdf5, "/g/f", "/g/h")), HasSubstr("there is no such dataset"));
  EXPECT_THAT(item_error(with(kInHdf5, "/g/f", "/g")), HasSubstr("'/g': is no dataset"));
  EXPECT_THAT(item_error(with(kInHdf5, "/g/f", "/g/f/f")), HasSubstr("there is no such dataset"));
  EXPECT_THAT(item_error(with(kInHdf5, "/g/f", "/g/outside")),
              HasSubstr("there is no such dataset"));
  EXPECT_THAT(item_error(with(kInHdf5, "a.h5:/g/f", "a.h5")), HasSubstr("expected FILE:/PATH"));
  EXPECT_THAT(item_error(with(kInHdf5, "/g/f", "/g/f|0 0 0")),
              HasSubstr("selections behind | are not read"));
  EXPECT_THAT(item_error(with(kInHdf5, "a.h5", "b.h5")), HasSubstr("b.h5"));
  EXPECT_THAT(item_error(with(kInHdf5, "a.h5", "/etc/hostname")),
              HasSubstr("which lies outside its folder"));
  folder.write("a.h5", "no HDF5");
  EXPECT_THAT(item_error(kInHdf5), HasSubstr("a.h5"));
}

}  // namespace xdmf_hdf5_test
}  // namespace ovoid::io
#else
namespace ovoid::io {
namespace xdmf_hdf5_test {

TEST(XdmfInHdf5, NeedsHdf5) {
  const TestFolder folder;
  const std::string item = "<DataItem Dimensions=\"2 3 4\" Format=\"HDF\">a.h5:/g/f</DataItem>";
  const std::string path =
      folder.write("a.xdmf", xdmf_file(xdmf_grid(kXdmfEven + xdmf_attribute("f", item))));
  EXPECT_THAT(error_of([&] { read_dataset({path}); }),
              testing::HasSubstr("this build has no HDF5"));
}

}  // namespace xdmf_hdf5_test
}  // namespace ovoid::io
#endif
