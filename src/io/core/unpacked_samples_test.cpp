// SPDX-License-Identifier: Apache-2.0
//
// Packed samples, and samples in many files, that memory does not hold: through the readers.
#include "io/core/unpacked_samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "fuzz/seeds.h"
#include "io/core/test_folder.h"
#include "io/dicom/test_dicom.h"
#include "io/images/test_png.h"
#include "io/images/test_tiff.h"
#include "io/images/test_volumes.h"
#include "ovoid/model.h"

namespace ovoid::io {
namespace unpacked_samples_test {

using testing::HasSubstr;

ReadOptions without_memory() {
  ReadOptions options;
  options.may_stay_in_file = true;
  options.memory_limit = 1;
  return options;
}

// All bytes of samples in a file, in pieces that end in the middle of what was unpacked at once.
std::vector<std::byte> bytes_in_file(const StoredSamples& stored) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(stored.num_bytes()));
  const std::size_t piece = std::max<std::size_t>(bytes.size() / 3 / 8 * 8, 8);
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const std::size_t count = std::min(piece, bytes.size() - at);
    stored.read(static_cast<std::int64_t>(at), std::span(bytes).subspan(at, count));
  }
  return bytes;
}

// Every array has the bytes that it has when it is read into memory, and all but the bytes are the
// same.
void expect_the_same_from_a_file(const std::vector<std::string>& paths,
                                 ReadOptions options = without_memory()) {
  ReadOptions into_memory = options;
  into_memory.may_stay_in_file = false;
  const Dataset expected = read_dataset(paths, into_memory);
  const Dataset dataset = read_dataset(paths, options);
  EXPECT_EQ(dataset.step, expected.step);
  EXPECT_EQ(dataset.notes, expected.notes);
  ASSERT_EQ(dataset.arrays.size(), expected.arrays.size());
  for (std::size_t i = 0; i < dataset.arrays.size(); ++i) {
    const DataArray& array = dataset.arrays[i];
    const auto in_memory = expected.arrays[i].bytes.view;
    ASSERT_NE(array.stored, nullptr) << array.name;
    EXPECT_EQ(array.name, expected.arrays[i].name);
    EXPECT_EQ(array.type, expected.arrays[i].type);
    EXPECT_EQ(array.value_scale, expected.arrays[i].value_scale);
    EXPECT_TRUE(array.bytes.view.empty());
    const std::vector<std::byte> bytes = bytes_in_file(*array.stored);
    ASSERT_EQ(bytes.size(), in_memory.size());
    EXPECT_EQ(std::memcmp(bytes.data(), in_memory.data(), bytes.size()), 0) << array.name;
  }
}

std::string big_endian(const std::vector<std::uint16_t>& values) {
  std::string bytes;
  for (const std::uint16_t value : values)
    bytes += {static_cast<char>(value >> 8), static_cast<char>(value & 0xFF)};
  return bytes;
}

TEST(UnpackedSamples, OfPackedFilesAreThoseInMemory) {
  const TestFolder folder;
  const std::string nrrd =
      "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 7 6 5\nendian: big\nencoding: ";
  const auto values = counting<std::uint16_t>(210);
  expect_the_same_from_a_file(
      {folder.write("a.nrrd", nrrd + "gzip\n\n" + fuzz::gzip(big_endian(values)))});
  std::string text;
  for (const std::uint16_t value : values) text += std::to_string(value) + " ";
  expect_the_same_from_a_file({folder.write("t.nrrd", nrrd + "text\n\n" + text)});
  expect_the_same_from_a_file(
      {folder.write("a_7x6x5_uint16.raw.gz", fuzz::gzip(bytes_of(values)))});
}

// More than is unpacked at once, of which a window's end is no sample's start.
TEST(UnpackedSamples, AreUnpackedPieceByPiece) {
  const TestFolder folder;
  std::vector<float> values(std::size_t{130} * 120 * 100);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 1013);
  const std::string path =
      folder.write("a_130x120x100_float32.raw.gz", fuzz::gzip(bytes_of(values)));
  expect_the_same_from_a_file({path});
}

TEST(UnpackedSamples, OfOneStepOfSeveral) {
  const TestFolder folder;
  const std::string nrrd =
      "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 5 4 3 3\nkinds: domain domain domain time\n"
      "encoding: gzip\n\n";
  const std::string path =
      folder.write("a.nrrd", nrrd + fuzz::gzip(bytes_of(counting<std::uint8_t>(180))));
  ReadOptions options = without_memory();
  options.step = 1;
  expect_the_same_from_a_file({path}, options);
  options.step.reset();  // the first that varies has to be looked for
  EXPECT_EQ(read_dataset({path}, options).array().stored, nullptr);
}

TEST(UnpackedSamples, OfSlicesInFilesOfTheirOwn) {
  const TestFolder folder;
  folder.write("a.nhdr",
               "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n"
               "data file: LIST\none.raw\ntwo.raw\n");
  folder.write("one.raw", "abcdefghijkl");
  folder.write("two.raw", "ABCDEFGHIJKL");
  expect_the_same_from_a_file({folder.file("a.nhdr")});
  std::vector<std::string> pictures;
  for (int i = 0; i < 3; ++i) {
    const std::string rows(12, static_cast<char>('a' + i));
    pictures.push_back(
        folder.write("s" + std::to_string(i) + ".png", png_file({.width = 4, .height = 3}, rows)));
  }
  expect_the_same_from_a_file(pictures);
}

// Red, green and blue are three components, of which none alone would be shown from a file.
TEST(UnpackedSamples, OfColoursAreInMemory) {
  const TestFolder folder;
  std::vector<std::string> pictures;
  for (int i = 0; i < 2; ++i) {
    pictures.push_back(
        folder.write("s" + std::to_string(i) + ".png",
                     png_file({.width = 2, .height = 1, .pixels = PngPixels::kRgb}, "abcdef")));
  }
  EXPECT_EQ(read_dataset(pictures, without_memory()).array().stored, nullptr);
}

TEST(UnpackedSamples, OfPackedPagesAndTheirChannels) {
  const TestFolder folder;
  const TestTiff tiff{.width = 4, .height = 3, .compression = 8};
  const std::vector<std::string> pages{"abcdefghijkl", "ABCDEFGHIJKL", "mnopqrstuvwx",
                                       "MNOPQRSTUVWX"};
  expect_the_same_from_a_file({folder.write("a.tif", tiff_file(tiff, pages))});
  TestTiff channels = tiff;
  channels.description = "ImageJ=1.53\nimages=4\nchannels=2\nslices=2\nhyperstack=true\n";
  expect_the_same_from_a_file({folder.write("c.tif", tiff_file(channels, pages))});
}

TEST(UnpackedSamples, OfDicomSlicesAndPlanesBetweenThem) {
  const TestFolder folder;
  const auto write = [&](int number, const std::string& slope) {
    TestSlice slice;
    slice.uid = number % 2 == 0 ? kBigUid : kDeflatedUid;
    slice.sop = "1.2.3." + std::to_string(number);
    slice.instance = std::to_string(number);
    slice.position = "-10\\20\\" + std::to_string(3 * number);
    slice.slope = slope;
    folder.write(std::to_string(number) + ".dcm", dicom_slice(slice));
  };
  for (const int number : {1, 2, 3, 4}) write(number, "2");
  expect_the_same_from_a_file({folder.file("")});
  write(3, "4");  // values are kept instead
  expect_the_same_from_a_file({folder.file("")});
  std::filesystem::remove(folder.file("3.dcm"));
  for (const int number : {5, 6, 7}) write(number, "2");
  EXPECT_EQ(read_dataset({folder.file("")}, without_memory()).lattice.dims[2], 7);
  expect_the_same_from_a_file({folder.file("")});
}

TEST(UnpackedSamples, BrokenOnesAreToldAsInMemory) {
  const TestFolder folder;
  const std::string whole = fuzz::gzip(std::string(1000, 'x') + std::string(1000, 'y'));
  std::string wrong = whole;
  wrong[wrong.size() - 6] ^= 1;  // the checksum
  for (const std::string& packed :
       {whole.substr(0, whole.size() - 12), wrong, fuzz::gzip(std::string(2001, 'x'))}) {
    const std::string path = folder.write("a_20x10x10_uint8.raw.gz", packed);
    const std::string expected = error_of([&] { read_dataset({path}); });
    EXPECT_NE(expected, "");
    EXPECT_EQ(error_of([&] { read_dataset({path}, without_memory()); }), expected);
  }
}

// The folder for temporary files, while it lives.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& path) {
    if (const char* before = std::getenv("TMPDIR")) before_ = before;
    ::setenv("TMPDIR", path.c_str(), 1);
  }
  ~TemporaryFolder() {
    if (before_.empty())
      ::unsetenv("TMPDIR");
    else
      ::setenv("TMPDIR", before_.c_str(), 1);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

 private:
  std::string before_;
};

TEST(UnpackedSamples, WithoutAFolderForThemAreTold) {
  const TestFolder folder;
  const std::string path =
      folder.write("a_20x10x10_uint8.raw.gz", fuzz::gzip(bytes_of(counting<std::uint8_t>(2000))));
  const TemporaryFolder temporary(folder.write("tmp", "no folder"));
  EXPECT_EQ(error_of([&] { read_dataset({path}, without_memory()); }),
            "file-write: " + path + ": no temporary file in '" + folder.file("tmp") +
                "', where TMPDIR says: it is no folder");
  EXPECT_EQ(error_of([&] { read_dataset({path}); }), "");
}

TEST(UnpackedSamples, LeaveNothingBehind) {
  const TestFolder folder;
  const std::string path =
      folder.write("a_20x10x10_uint8.raw.gz", fuzz::gzip(bytes_of(counting<std::uint8_t>(2000))));
  std::filesystem::create_directory(folder.file("tmp"));
  const TemporaryFolder temporary(folder.file("tmp"));
  const Dataset dataset = read_dataset({path}, without_memory());
  EXPECT_NE(dataset.array().stored, nullptr);
  EXPECT_TRUE(std::filesystem::is_empty(folder.file("tmp")));
}

}  // namespace unpacked_samples_test
}  // namespace ovoid::io
