// SPDX-License-Identifier: Apache-2.0
// Shares of the rows of particle files: put together they are the whole, and where a reader can, it
// reads nothing else.
#include "io/core/row_share.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fuzz/seeds.h"
#include "io/core/test_folder.h"
#include "io/images/npy.h"
#include "io/images/test_volumes.h"
#include "io/points/test_shares.h"
#include "io/read_source.h"
#include "ovoid/series.h"

namespace ovoid::io {
namespace row_share_test {

ReadWith reader_of(const std::string& name, const std::string& bytes) {
  return [name, bytes](const ReadOptions& options) {
    return read_source(*open_memory(name, std::as_bytes(std::span(bytes))), options);
  };
}

ReadWith reader_of(const std::vector<std::string>& paths) {
  return [paths](const ReadOptions& options) { return read_dataset(paths, options); };
}

constexpr std::size_t kRows = 10;

Dataset particles() {
  Dataset dataset;
  dataset.kind = DatasetKind::kParticles;
  dataset.positions = make_array("positions", ScalarType::kFloat32, counting<float>(3 * kRows), 3);
  dataset.arrays = {
      make_array("v", ScalarType::kFloat64, counting<double>(2 * kRows), 2),
      make_array("id", ScalarType::kInt32, counting<std::int32_t>(kRows)),
  };
  return dataset;
}

Dataset kernels() {
  Dataset dataset = particles();
  dataset.kind = DatasetKind::kKernels;
  dataset.reconstruction = Reconstruction::kSum;
  dataset.cutoff = 2.5;
  dataset.arrays = {
      make_array("value", ScalarType::kFloat32, counting<float>(kRows)),
      make_array("scale", ScalarType::kFloat32, counting<float>(3 * kRows), 3),
      make_array("rotation", ScalarType::kFloat32, counting<float>(4 * kRows), 4),
      make_array("weight", ScalarType::kFloat32, counting<float>(kRows)),
  };
  return dataset;
}

// A file in memory that counts what is read of it.
class CountingSource final : public ByteSource {
 public:
  explicit CountingSource(std::string name, const std::string& bytes)
      : ByteSource(std::move(name), static_cast<std::int64_t>(bytes.size())),
        source_(open_memory(ByteSource::name(), std::as_bytes(std::span(bytes)))) {}

  void read(std::int64_t offset, std::span<std::byte> out) const override {
    num_read += static_cast<std::int64_t>(out.size());
    source_->read(offset, out);
  }

  mutable std::int64_t num_read = 0;

 private:
  std::unique_ptr<ByteSource> source_;
};

// Bytes that a reader takes of a file for one share of sixteen.
std::int64_t bytes_read(const std::string& name, const std::string& bytes) {
  const CountingSource source(name, bytes);
  ReadOptions options;
  options.share = RowShare{5, 16};
  const Dataset dataset = read_source(source, options);
  EXPECT_TRUE(dataset.share.has_value());
  return source.num_read;
}

TEST(RowShare, RunsFollowEachOtherWithoutOverflow) {
  constexpr std::int64_t kMany = std::numeric_limits<std::int64_t>::max() - 1;
  constexpr int kShares = std::numeric_limits<int>::max();
  EXPECT_EQ(rows_of_share(RowShare{0, kShares}, kMany).first, 0);
  EXPECT_EQ(rows_of_share(RowShare{kShares - 1, kShares}, kMany).end(), kMany);
  EXPECT_EQ(rows_of_share(RowShare{17, kShares}, kMany).end(),
            rows_of_share(RowShare{18, kShares}, kMany).first);
  EXPECT_EQ(rows_of_share(RowShare{1, 3}, 10).first, 3);
  EXPECT_EQ(rows_of_share(RowShare{1, 3}, 10).count, 3);
  EXPECT_EQ(rows_of_share({}, 10).count, 10);
}

TEST(RowShare, WrittenFilesComeTogether) {
  const TestFolder folder;
  for (const std::string name : {"a.csv", "a.npz", "a.ply"}) {
    SCOPED_TRACE(name);
    write_dataset(particles(), folder.file(name));
    const Dataset whole = expect_shares(reader_of({folder.file(name)}));
    EXPECT_EQ(whole.num_positions(), std::int64_t{kRows});
    EXPECT_EQ(whole.arrays.size(), 2U);
  }
}

TEST(RowShare, StoredKernelsComeTogether) {
  const TestFolder folder;
  write_dataset(kernels(), folder.file("a.ply"));
  const Dataset whole = expect_shares(reader_of({folder.file("a.ply")}));
  EXPECT_EQ(whole.kind, DatasetKind::kKernels);
  EXPECT_EQ(whole.reconstruction, Reconstruction::kSum);
  EXPECT_EQ(values_of<float>(whole.array("weight")), counting<float>(kRows));
}

TEST(RowShare, NpyInEitherOrderComesTogether) {
  for (const std::int64_t columns : {3, 4}) {
    const auto num = static_cast<std::size_t>(columns) * kRows;
    const std::vector<std::int64_t> shape{kRows, columns};
    const std::string plain =
        npy_header(ScalarType::kFloat32, shape) + bytes_of(counting<float>(num));
    const std::string integers =
        npy_header(ScalarType::kInt16, shape) + bytes_of(counting<std::int16_t>(num));
    expect_shares(reader_of("a.npy", plain));
    expect_shares(reader_of("a.npy", with(plain, "'<f4'", "'>f4'")));
    for (const std::string& bytes : {plain, integers})
      expect_shares(reader_of("a.npy", with(bytes, "False, ", "True,  ")));
  }
}

TEST(RowShare, DeflatedNpzComesTogether) {
  const auto floats = counting<float>(3 * kRows);
  const std::vector<std::int64_t> places{kRows, 3}, values{kRows}, others{3};
  expect_shares(reader_of(
      "a.npz",
      fuzz::zip_file({{"v.npy", npy_header(ScalarType::kUInt8, values) + "0123456789"},
                      {"pos.npy", npy_header(ScalarType::kFloat32, places) + bytes_of(floats)},
                      {"w.npy", npy_header(ScalarType::kUInt8, others) + "abc"}},
                     true)));
}

TEST(RowShare, TextComesTogether) {
  std::string rows;
  for (int i = 0; i < 11; ++i) rows += std::to_string(i) + " 2 -" + std::to_string(i) + " .5\n\n";
  expect_shares(reader_of("a.txt", rows));
  expect_shares(reader_of("a.txt", "# x y z value\n" + rows + "# end\n"));
  expect_shares(reader_of("a.txt", "\xef\xbb\xbfx y z value\n" + rows));
  expect_shares(reader_of("a.csv", fuzz::gzip("x y z value\n" + rows)));
  expect_shares(reader_of("a.ply",
                          "ply\nformat ascii 1.0\nelement vertex 11\nproperty float x\n"
                          "property int y\nproperty float z\nproperty double v\nend_header\n" +
                              rows));
  std::string line;
  for (int i = 0; i < 30; ++i) line += std::to_string(i) + " ";
  expect_shares(reader_of("a.txt", line + "\n" + line + "\n" + line + "\n"));
}

std::string frame(int step, int num_atoms, const std::string& value) {
  std::string text = "ITEM: TIMESTEP\n" + std::to_string(step) + "\nITEM: NUMBER OF ATOMS\n" +
                     std::to_string(num_atoms) +
                     "\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n-1 1\nITEM: ATOMS id xs ys zs v\n";
  for (int i = 0; i < num_atoms; ++i)
    text += std::to_string(num_atoms - i) + " 0." + std::to_string(i) + " 0.5 0.25 " +
            (i + 1 < num_atoms ? "1" : value) + "\n";
  return text;
}

// Fails if a share chooses the step by its own rows, of which one alone has another value.
TEST(RowShare, DumpsComeTogetherAtTheSameStep) {
  const std::string text = frame(0, 9, "1") + frame(50, 10, "2") + frame(100, 3, "3");
  EXPECT_EQ(expect_shares(reader_of("a.dump", text)).step, 1);
  ReadOptions options;
  options.step = 2;
  const Dataset whole = expect_shares(reader_of("a.dump", text), options);
  EXPECT_EQ(whole.num_positions(), 3);
  EXPECT_TRUE(whole.periodic_box.has_value());
  EXPECT_EQ(expect_shares(reader_of("a.dump", text + "ITEM: TIMESTEP\n"), options).notes.size(),
            1U);
  expect_shares(reader_of("a.dump", fuzz::bzip2(text)), options);
}

TEST(RowShare, FilesInTimeComeTogetherAtTheSameStep) {
  const TestFolder folder;
  const std::string constant = folder.write("0.csv", "x,y,z,v\n1,2,3,5\n2,3,4,5\n3,4,5,5\n");
  const std::string varies = folder.write("1.csv", "x,y,z,v\n1,2,3,5\n2,3,4,5\n3,4,5,5\n9,9,9,6\n");
  EXPECT_EQ(expect_shares(reader_of({constant, varies})).step, 1);
  ReadOptions options;
  options.share = RowShare{1, 2};
  const auto steps = open_steps({constant, varies}, options);
  EXPECT_EQ(steps->read(0).share->first, 1);
  EXPECT_EQ(steps->read(1).share->first, 2);
  EXPECT_EQ(values_of<double>(steps->read(1).array("v")), (std::vector<double>{5, 6}));
}

TEST(RowShare, WhatHasNoRowsIsReadWhole) {
  const TestFolder folder;
  Dataset lattice;
  lattice.lattice.dims = {4, 3, 2};
  lattice.arrays = {make_array("v", ScalarType::kFloat32, counting<float>(24))};
  ReadOptions options;
  options.share = RowShare{1, 5};
  for (const char* const name : {"a.nrrd", "a.npy"}) {
    write_dataset(lattice, folder.file(name));
    const Dataset read = read_dataset({folder.file(name)}, options);
    EXPECT_FALSE(read.share.has_value());
    EXPECT_EQ(values_of<float>(read.arrays[0]), counting<float>(24));
  }
}

TEST(RowShare, NumbersThatAreNoneAreRefused) {
  const TestFolder folder;
  const std::string path = folder.write("a.csv", "x,y,z\n1,2,3\n");
  for (const RowShare share : {RowShare{-1, 2}, RowShare{2, 2}, RowShare{0, 0}, RowShare{0, -1}}) {
    ReadOptions options;
    options.share = share;
    const std::string expected = "invalid-argument: share: number " + std::to_string(share.number) +
                                 " of " + std::to_string(share.count) +
                                 ": expected 0 <= number < count";
    EXPECT_EQ(error_of([&] { read_dataset({path}, options); }), expected);
    EXPECT_EQ(error_of([&] { read_dataset({path, path}, options); }), expected);
  }
}

// Fails if a reader goes through, or holds, what belongs to other shares.
TEST(RowShare, OthersRowsAreNotRead) {
  constexpr std::size_t kMany = 200000;
  const std::vector<std::int64_t> shape{kMany, 4};
  const std::string npy =
      npy_header(ScalarType::kFloat32, shape) + std::string(kMany * 4 * sizeof(float), '\x01');
  const auto most = [](const std::string& bytes) {
    return static_cast<std::int64_t>(bytes.size()) / 16 + 150000;
  };
  EXPECT_LT(bytes_read("a.npy", npy), most(npy));
  const std::string by_column = with(npy, "False, ", "True,  ");
  EXPECT_LT(bytes_read("a.npy", by_column), most(npy));
  const std::vector<std::int64_t> places{kMany, 3};
  const std::string npz =
      fuzz::zip_file({{"xyz.npy", npy_header(ScalarType::kFloat32, places) +
                                      std::string(kMany * 3 * sizeof(float), '\x01')}},
                     false);
  EXPECT_LT(bytes_read("a.npz", npz), most(npz));
  const std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                          std::to_string(kMany) +
                          "\nproperty float x\nproperty float y\nproperty float z\n"
                          "property float v\nend_header\n" +
                          std::string(kMany * 4 * sizeof(float), '\x01');
  EXPECT_LT(bytes_read("a.ply", ply), most(ply));
}

}  // namespace row_share_test
}  // namespace ovoid::io
