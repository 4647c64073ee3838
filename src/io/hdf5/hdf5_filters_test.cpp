// SPDX-License-Identifier: Apache-2.0
// What chunks of HDF5 files went through, undone: by the library, and by our own filters.
#ifdef OVOID_IO_HDF5
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "fuzz/targets.h"
#include "io/core/test_folder.h"
#include "io/hdf5/test_hdf5.h"
#include "io/reader/reader_session.h"
#include "io/zarr/test_zarr.h"
#include "support/where.h"

namespace ovoid::io {
namespace hdf5_filters_test {

using testing::HasSubstr;

const Hdf5Sizes kSizes{2, 5, 10};
constexpr std::size_t kCount = 100;

// Runs of bytes alone: the least that LZF data can be.
std::string with_lzf(const std::string& bytes) {
  std::string packed;
  for (std::size_t at = 0; at < bytes.size(); at += 32) {
    const std::string run = bytes.substr(at, 32);
    packed += static_cast<char>(run.size() - 1) + run;
  }
  return packed;
}

std::string big(std::uint64_t value, int size) {
  std::string bytes;
  for (int i = size; i-- > 0;) bytes += static_cast<char>(value >> (8 * i) & 255);
  return bytes;
}

std::string lz4_block(const std::string& bytes) { return with_lz4(bytes).substr(4); }

// The filter's own layout: sizes, and blocks with theirs.
std::string with_lz4_filter(const std::string& bytes, std::size_t block_size) {
  std::string packed = big(bytes.size(), 8) + big(block_size, 4);
  for (std::size_t at = 0; at < bytes.size(); at += block_size) {
    const std::string block = bytes.substr(at, block_size), small = lz4_block(block);
    const std::string& kept = small.size() < block.size() ? small : block;
    packed += big(kept.size(), 4) + kept;
  }
  return packed;
}

// By its definition: bit k of byte b of the items stands in row 8 b + k.
std::string shuffled_bits(const std::string& block, std::size_t item_size) {
  const std::size_t num_items = block.size() / item_size;
  std::string out(block.size(), '\0');
  for (std::size_t i = 0; i < num_items; ++i) {
    for (std::size_t b = 0; b < item_size; ++b) {
      for (std::size_t k = 0; k < 8; ++k) {
        const bool bit = (static_cast<unsigned char>(block[i * item_size + b]) >> k & 1U) != 0;
        const std::size_t at = (b * 8 + k) * num_items + i;
        if (bit)
          out[at / 8] = static_cast<char>(static_cast<unsigned char>(out[at / 8]) | 1U << at % 8);
      }
    }
  }
  return out;
}

enum class Packing { kNone, kLz4, kZstd };

std::string with_bitshuffle(const std::string& bytes, std::size_t item_size, std::size_t block,
                            Packing packing) {
  std::string packed =
      packing == Packing::kNone ? "" : big(bytes.size(), 8) + big(block * item_size, 4);
  const std::size_t num_items = bytes.size() / item_size;
  std::size_t at = 0;
  for (std::size_t item = 0; item + 8 <= num_items;) {
    const std::size_t count = std::min(block, (num_items - item) / 8 * 8);
    const std::string bits = shuffled_bits(bytes.substr(at, count * item_size), item_size);
    const std::string kept = packing == Packing::kLz4    ? lz4_block(bits)
                             : packing == Packing::kZstd ? with_zstd(bits)
                                                         : bits;
    packed += (packing == Packing::kNone ? "" : big(kept.size(), 4)) + kept;
    item += count;
    at += count * item_size;
  }
  return packed + bytes.substr(at);
}

TestHdf5::Creation filter(H5Z_filter_t number, const std::vector<unsigned>& values = {}) {
  return [=](hid_t creation) {
    H5Pset_filter(creation, number, H5Z_FLAG_OPTIONAL, values.size(), values.data());
  };
}

class Hdf5Filters : public testing::Test {
 protected:
  Hdf5Filters() {
    for (std::size_t i = 0; i < kCount; ++i) values.push_back(static_cast<std::uint16_t>(i / 3));
  }

  std::string bytes() const { return bytes_of(values); }
  // Fails unless the dataset's samples are the values.
  void expect_values(const char* what) const {
    SCOPED_TRACE(what);
    EXPECT_EQ(hdf5_error_of(path), "");
    const Dataset dataset = read_dataset({path});
    EXPECT_EQ(values_of<std::uint16_t>(dataset.array("v")), values);
  }
  void expect_chunk(const char* what, const std::string& packed, const TestHdf5::Creation& set) {
    TestHdf5(path).chunk("/v", kSizes, packed, H5T_STD_U16LE, set);
    expect_values(what);
  }

  TestFolder folder;
  std::string path = folder.file("a.h5");
  std::vector<std::uint16_t> values;
};

TEST_F(Hdf5Filters, ThoseOfTheLibrary) {
  const auto written = [&](const char* what, const TestHdf5::Creation& set) {
    TestHdf5(path).dataset("/v", kSizes, values, H5T_STD_U16LE, [&](hid_t creation) {
      const hsize_t chunk[] = {1, 4, 10};
      H5Pset_chunk(creation, 3, chunk);
      set(creation);
    });
    expect_values(what);
  };
  written("nothing", [](hid_t) {});
  written("shuffle, deflate, checksum", [](hid_t creation) {
    H5Pset_shuffle(creation);
    H5Pset_deflate(creation, 6);
    H5Pset_fletcher32(creation);
  });
  written("scale-offset", [](hid_t creation) { H5Pset_scaleoffset(creation, H5Z_SO_INT, 0); });
  written("n-bit", [](hid_t creation) { H5Pset_nbit(creation); });
  unsigned can = 0;
  if (H5Zget_filter_info(H5Z_FILTER_SZIP, &can) >= 0 &&
      (can & H5Z_FILTER_CONFIG_ENCODE_ENABLED) != 0)
    written("szip", [](hid_t creation) { H5Pset_szip(creation, H5_SZIP_NN_OPTION_MASK, 8); });
}

TEST_F(Hdf5Filters, ThoseThatOthersRegistered) {
  expect_chunk("LZF", with_lzf(bytes()), filter(32000));
  expect_chunk("bzip2", with_bzip2(bytes()), filter(307));
  expect_chunk("Zstandard", with_zstd(bytes()), filter(32015));
  for (const char* const inner : {"blosclz", "lz4", "zlib", "zstd"})
    expect_chunk(inner, with_blosc(bytes(), inner, BLOSC_SHUFFLE, 2), filter(32001));
  expect_chunk("Blosc, bits shuffled", with_blosc(bytes(), "lz4", BLOSC_BITSHUFFLE, 2),
               filter(32001));
  expect_chunk("LZ4", with_lz4_filter(bytes(), 1000), filter(32004));
  expect_chunk("LZ4 in blocks", with_lz4_filter(bytes(), 48), filter(32004));
  for (const unsigned block : {0U, 16U, 64U}) {
    const std::size_t items = block == 0 ? 4096 : block;
    expect_chunk("bitshuffle", with_bitshuffle(bytes(), 2, items, Packing::kNone),
                 filter(32008, {0, 2, 2, block, 0}));
    expect_chunk("bitshuffle, LZ4", with_bitshuffle(bytes(), 2, items, Packing::kLz4),
                 filter(32008, {0, 2, 2, block, 2}));
    expect_chunk("bitshuffle, Zstandard", with_bitshuffle(bytes(), 2, items, Packing::kZstd),
                 filter(32008, {0, 3, 2, block, 3, 1}));
  }
}

TEST_F(Hdf5Filters, SeveralInARow) {
  std::string shuffled;
  for (int b = 0; b < 2; ++b)
    for (const std::uint16_t value : values) shuffled += static_cast<char>(value >> 8 * b & 255);
  expect_chunk("shuffle, LZF", with_lzf(shuffled), [](hid_t creation) {
    H5Pset_shuffle(creation);
    H5Pset_filter(creation, 32000, H5Z_FLAG_OPTIONAL, 0, nullptr);
  });
}

TEST_F(Hdf5Filters, AnotherIsNamedWithAWayOut) {
  TestHdf5(path).chunk("/v", kSizes, "?", H5T_STD_U16LE, filter(32013));
  EXPECT_THAT(hdf5_error_of(path),
              HasSubstr("unsupported: F: '/v': is compressed by filter 32013 (ZFP), which is not "
                        "read: copy it where it can be, in Python: import h5py"));
  TestHdf5(path)
      .chunk("/w", kSizes, "?", H5T_STD_U16LE, filter(32013))
      .dataset("/v", kSizes, values, H5T_STD_U16LE);
  expect_values("beside another");
  EXPECT_THAT(read_dataset({path}).notes.front(), HasSubstr("'/w': is compressed by filter"));
}

// As other programs read them.
TEST_F(Hdf5Filters, ChunksThatWereNeverWrittenHoldTheFillValue) {
  const Hdf5Sizes sizes{2, 2, 4};
  {
    TestHdf5 file(path);
    const hsize_t chunk[] = {1, 2, 4}, first[] = {0, 0, 0};
    const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(creation.get(), 3, chunk);
    const std::uint16_t fill = 7;
    H5Pset_fill_value(creation.get(), H5T_NATIVE_UINT16, &fill);
    const Hdf5Handle space(H5Screate_simple(3, sizes.data(), nullptr), H5Sclose);
    const Hdf5Handle made(H5Dcreate2(file.id(), "/v", H5T_STD_U16LE, space.get(), H5P_DEFAULT,
                                     creation.get(), H5P_DEFAULT),
                          H5Dclose);
    const std::string eight = bytes_of(counting<std::uint16_t>(8));
    H5Dwrite_chunk(made.get(), H5P_DEFAULT, 0, first, eight.size(), eight.data());
  }
  const Dataset dataset = read_dataset({path});
  EXPECT_EQ(values_of<std::uint16_t>(dataset.array("v")),
            (std::vector<std::uint16_t>{1, 2, 3, 4, 5, 6, 7, 8, 7, 7, 7, 7, 7, 7, 7, 7}));
  EXPECT_THAT(dataset.notes.front(), HasSubstr("'/v': 1 of its chunks were never written"));
}

// Whatever a chunk holds, it is read or refused.
TEST_F(Hdf5Filters, DamagedChunks) {
  OVOID_NOT_UNDER_TSAN();
  const std::vector<std::pair<std::string, TestHdf5::Creation>> kinds{
      {with_lzf(bytes()), filter(32000)},
      {with_bzip2(bytes()), filter(307)},
      {with_zstd(bytes()), filter(32015)},
      {with_blosc(bytes(), "lz4", BLOSC_SHUFFLE, 2), filter(32001)},
      {with_lz4_filter(bytes(), 48), filter(32004)},
      {with_bitshuffle(bytes(), 2, 16, Packing::kLz4), filter(32008, {0, 2, 2, 16, 2})}};
  const auto session = std::make_shared<ReaderSession>(std::vector{path});
  ReadOptions options;
  options.session = session;
  std::mt19937 random(20261129);
  int num_read = 0;
  for (int i = 0; i < 600; ++i) {
    auto [packed, set] = kinds[static_cast<std::size_t>(i) % kinds.size()];
    for (std::size_t k = 1 + random() % 3; k > 0; --k)
      packed[random() % packed.size()] = static_cast<char>(random());
    if (i % 7 == 0) packed.resize(1 + random() % packed.size());
    TestHdf5(path).chunk("/v", kSizes, packed, H5T_STD_U16LE, set);
    fuzz::expect_dataset_or_error([&] {
      Dataset dataset = read_dataset({path}, options);
      ++num_read;
      return dataset;
    });
  }
  EXPECT_GT(num_read, 20);
}

}  // namespace hdf5_filters_test
}  // namespace ovoid::io
#endif
