// SPDX-License-Identifier: Apache-2.0
// Which types of HDF5 files are numbers, and what is said of the others.
#ifdef OVOID_IO_HDF5
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "io/core/short_floats.h"
#include "io/core/test_folder.h"
#include "io/hdf5/test_hdf5.h"

namespace ovoid::io {
namespace hdf5_types_test {

using testing::ElementsAre;
using testing::HasSubstr;

const Hdf5Sizes kSizes{2, 3, 4};

class Hdf5Types : public testing::Test {
 protected:
  Dataset read() const { return read_dataset({path}); }

  TestFolder folder;
  std::string path = folder.file("a.h5");
};

// As h5py stores them; fails while an enumeration is no number.
TEST_F(Hdf5Types, Booleans) {
  const Hdf5Handle type(H5Tenum_create(H5T_STD_I8LE), H5Tclose);
  signed char value = 0;
  H5Tenum_insert(type.get(), "FALSE", &value);
  value = 1;
  H5Tenum_insert(type.get(), "TRUE", &value);
  std::string bytes(24, '\0');
  bytes[1] = bytes[23] = '\1';
  TestHdf5(path).raw("/mask", kSizes, bytes, type.get());
  const Dataset dataset = read();
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.array("mask").type, ScalarType::kUInt8);
  EXPECT_EQ(values_of<char>(dataset.array("mask")), std::vector<char>(bytes.begin(), bytes.end()));
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("'/mask': booleans become uint8")));
}

// Of arrays without coordinates, too, which no reader of CF's asks.
TEST_F(Hdf5Types, NumbersAreWhatCfAttributesSay) {
  std::string bytes;
  for (int i = 0; i < 24; ++i) bytes += static_cast<char>(110 + i);  // -128 from the 19th on
  TestHdf5(path)
      .raw("/a", kSizes, bytes, H5T_STD_I8LE)
      .text("/a", "_Unsigned", "true")
      .numbers("/a", "valid_range", {112, 130})
      .number("/a", "_FillValue", 120);
  const std::vector<float> values = values_of<float>(read().array("a"));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto number = static_cast<float>(110 + i);
    const bool is_missing = number < 112 || number > 130 || number == 120;
    EXPECT_EQ(std::isnan(values[i]), is_missing) << i;
    if (!is_missing) EXPECT_EQ(values[i], number);
  }
}

TEST_F(Hdf5Types, EnumerationsAndBitFieldsAreTheirNumbers) {
  const Hdf5Handle type(H5Tenum_create(H5T_STD_I16BE), H5Tclose);
  const std::int16_t swapped = 0x0300;  // 3
  H5Tenum_insert(type.get(), "THREE", &swapped);
  std::string bytes;
  for (char i = 0; i < 24; ++i) bytes += {'\0', i};
  TestHdf5(path).raw("/e", kSizes, bytes, type.get()).raw("/b", kSizes, bytes, H5T_STD_B16BE);
  const Dataset dataset = read();
  EXPECT_EQ(dataset.array("e").type, ScalarType::kInt16);
  EXPECT_EQ(values_of<std::int16_t>(dataset.array("e"))[23], 23);
  EXPECT_EQ(dataset.array("b").type, ScalarType::kUInt16);
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array("b"))[7], 7);
}

// A type of 16 bits with so many of exponent.
Hdf5Handle short_type(bool is_brain, H5T_order_t order) {
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  if (is_brain)
    H5Tset_fields(type.get(), 15, 7, 8, 0, 7);
  else
    H5Tset_fields(type.get(), 15, 10, 5, 0, 10);
  H5Tset_size(type.get(), 2);
  H5Tset_precision(type.get(), 16);
  H5Tset_ebias(type.get(), is_brain ? 127 : 15);
  H5Tset_order(type.get(), order);
  return type;
}

TEST_F(Hdf5Types, ShortFloatsBecomeFloat32) {
  TestHdf5 file(path);
  for (const bool is_brain : {false, true}) {
    for (const bool is_big : {false, true}) {
      const Hdf5Handle type = short_type(is_brain, is_big ? H5T_ORDER_BE : H5T_ORDER_LE);
      ASSERT_TRUE(type.is_open());
      std::string bytes;
      for (int i = 0; i < 24; ++i) {
        const auto bits =
            bits_of(static_cast<float>(i) / 2, is_brain ? ShortFloat::kBrain : ShortFloat::kHalf);
        const char low = static_cast<char>(bits & 255U), high = static_cast<char>(bits >> 8U);
        bytes += is_big ? std::string{high, low} : std::string{low, high};
      }
      file.raw(std::string("/") + (is_brain ? "brain" : "half") + (is_big ? "_big" : ""), kSizes,
               bytes, type.get());
    }
  }
  file.close();
  const Dataset dataset = read();
  ASSERT_EQ(dataset.arrays.size(), 4U);
  for (const DataArray& array : dataset.arrays) {
    EXPECT_EQ(array.type, ScalarType::kFloat32);
    EXPECT_EQ(values_of<float>(array)[23], 11.5F) << array.name;
  }
  EXPECT_THAT(dataset.notes[2], HasSubstr("'/half': float16 become float32"));
}

// What the library converts: long doubles, and integers that fill their bytes in part.
TEST_F(Hdf5Types, OddNumbersBecomeTheNextThatHoldsThem) {
  const Hdf5Handle twelve(H5Tcopy(H5T_STD_U16BE), H5Tclose),
      three(H5Tcopy(H5T_STD_I32LE), H5Tclose);
  H5Tset_precision(twelve.get(), 12);
  H5Tset_precision(three.get(), 24);
  H5Tset_size(three.get(), 3);
  std::vector<std::int32_t> integers;
  std::vector<long double> reals;
  for (int i = 0; i < 24; ++i) {
    integers.push_back(i - 5);
    reals.push_back(i / 4.0L);
  }
  TestHdf5(path)
      .dataset("/long", kSizes, reals, H5T_NATIVE_LDOUBLE)
      .dataset("/three", kSizes, integers, three.get())
      .dataset("/twelve", kSizes, counting<std::uint16_t>(24), twelve.get());
  const Dataset dataset = read();
  EXPECT_EQ(dataset.array("long").type, ScalarType::kFloat64);
  EXPECT_EQ(values_of<double>(dataset.array("long"))[23], 5.75);
  EXPECT_EQ(dataset.array("three").type, ScalarType::kInt32);
  EXPECT_EQ(values_of<std::int32_t>(dataset.array("three"))[0], -5);
  EXPECT_EQ(dataset.array("twelve").type, ScalarType::kUInt16);
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array("twelve"))[23], 24);
}

Hdf5Handle complex_type() {
  Hdf5Handle type(H5Tcreate(H5T_COMPOUND, 16), H5Tclose);
  H5Tinsert(type.get(), "r", 0, H5T_IEEE_F64LE);
  H5Tinsert(type.get(), "i", 8, H5T_IEEE_F64LE);
  return type;
}

TEST_F(Hdf5Types, OneOddMemberSpoilsNothing) {
  const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(text.get(), 3);
  TestHdf5(path)
      .raw("/psi", kSizes, std::string(16 * 24, '\0'), complex_type().get())
      .raw("/words", kSizes, std::string(3 * 24, 'x'), text.get())
      .floats("/v", kSizes);
  const Dataset dataset = read();
  EXPECT_EQ(dataset.arrays.size(), 1U);
  EXPECT_THAT(dataset.notes, ElementsAre(HasSubstr("'/psi' is left out: it holds compound (r, i): "
                                                   "complex numbers")));
}

// Fails if the error says that there is no such array, where there is one.
TEST_F(Hdf5Types, WhatIsNotDrawnIsListedWithWhy) {
  TestHdf5(path)
      .raw("/psi", kSizes, std::string(16 * 24, '\0'), complex_type().get())
      .floats("/table", {5, 2})
      .floats("/row", {1, 1, 7})
      .floats("/nine", {1, 1, 1, 1, 1, 1, 2, 3, 2});
  const std::string message = hdf5_error_of(path);
  EXPECT_THAT(message,
              HasSubstr("file-format: F: nothing in it is drawn: '/psi' [2, 3, 4] holds "
                        "compound (r, i): complex numbers, '/nine' [1, 1, 1, 1, 1, 1, 2, 3, 2] "
                        "has 9 axes, '/table' [5, 2] has two axes, '/row' [1, 1, 7] is one row "
                        "of samples: expected numbers with three axes (z, y, x)"));
  ReadOptions options;
  options.array = "rho";
  EXPECT_THAT(hdf5_error_of(path, options),
              HasSubstr("invalid-argument: F: array 'rho': the file has no such array that is "
                        "drawn: it has '/psi' [2, 3, 4]"));
  TestHdf5(path).group("/empty");
  EXPECT_THAT(hdf5_error_of(path), HasSubstr("nothing in it is drawn: it has no datasets"));
}

TEST_F(Hdf5Types, TextsOfVariableLengthAreRead) {
  TestHdf5(path)
      .floats("/v", kSizes)
      .text("/v", "units", "K", true)
      .texts("/v", "DIMENSION_LABELS", {"x", "y", "z"}, true);
  const Dataset dataset = read();
  EXPECT_EQ(dataset.array("v").unit, "K");
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 3, 4}));
  EXPECT_EQ(values_of<float>(dataset.array("v"))[1], 13);
}

}  // namespace hdf5_types_test
}  // namespace ovoid::io
#endif
