// SPDX-License-Identifier: Apache-2.0
#include "io/core/unpack_chunks.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <fstream>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "ovoid/error.h"
#include "support/where.h"

namespace ovoid::io {
namespace unpack_chunks_test {

// An array of 16-bit numbers that count, in chunks in a file.
class ChunkedFile {
 public:
  ChunkedFile(std::vector<std::int64_t> dims, std::vector<std::int64_t> chunk, bool is_packed)
      : path_(folder_.file("chunks.bin")) {
    storage_.dims = std::move(dims);
    storage_.chunk = std::move(chunk);
    storage_.is_shuffled = storage_.is_deflated = is_packed;
    std::vector<std::int64_t> counts;
    std::int64_t num_chunks = 1, size = 1;
    for (std::size_t a = 0; a < storage_.dims.size(); ++a) {
      counts.push_back((storage_.dims[a] - 1) / storage_.chunk[a] + 1);
      num_chunks *= counts[a];
      size *= storage_.dims[a];
    }
    for (std::int64_t i = 0; i < size; ++i) expected_.push_back(static_cast<std::uint16_t>(i * 7));
    std::string file = "head";
    for (std::int64_t n = 0; n < num_chunks; ++n) {
      const std::string bytes = chunk_bytes(n, counts, is_packed);
      storage_.chunks.push_back(
          {static_cast<std::int64_t>(file.size()), static_cast<std::int64_t>(bytes.size())});
      file += bytes;
    }
    std::ofstream(path_, std::ios::binary) << file;
  }

  const std::vector<std::uint16_t>& expected() const { return expected_; }
  StoredPlace place() const {
    return {ScalarType::kUInt16, false, 0, static_cast<std::int64_t>(2 * expected_.size()),
            std::make_shared<const ChunkedStorage>(storage_)};
  }
  std::unique_ptr<ByteSource> source() const { return open_file(path_); }
  ChunkedStorage& storage() { return storage_; }
  const std::string& path() const { return path_; }

 private:
  std::string chunk_bytes(std::int64_t number, const std::vector<std::int64_t>& counts,
                          bool is_packed) const {
    const std::size_t rank = counts.size();
    std::vector<std::int64_t> place(rank), at(rank, 0);
    for (std::size_t a = rank; a-- > 0;) {
      place[a] = number % counts[a] * storage_.chunk[a];
      number /= counts[a];
    }
    std::vector<std::uint16_t> numbers;
    while (at[0] < storage_.chunk[0]) {
      std::int64_t index = 0;
      bool is_inside = true;
      for (std::size_t a = 0; a < rank; ++a) {
        index = index * storage_.dims[a] + place[a] + at[a];
        is_inside = is_inside && place[a] + at[a] < storage_.dims[a];
      }
      numbers.push_back(is_inside ? expected_[static_cast<std::size_t>(index)] : 999);
      for (std::size_t a = rank; a-- > 0;) {
        if (++at[a] < storage_.chunk[a] || a == 0) break;
        at[a] = 0;
      }
    }
    std::string bytes;
    if (!is_packed) {
      bytes.assign(reinterpret_cast<const char*>(numbers.data()), 2 * numbers.size());
      return bytes;
    }
    for (int b = 0; b < 2; ++b) {
      for (const std::uint16_t value : numbers)
        bytes.push_back(static_cast<char>(value >> (8 * b) & 0xFF));
    }
    uLongf size = compressBound(bytes.size());
    std::string packed(size, '\0');
    compress(reinterpret_cast<Bytef*>(packed.data()), &size,
             reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    packed.resize(size);
    return packed;
  }

  TestFolder folder_;
  std::string path_;
  ChunkedStorage storage_;
  std::vector<std::uint16_t> expected_;
};

// Of one to four axes, in chunks that fit and that do not.
TEST(UnpackChunks, PutsEverySampleInItsPlace) {
  struct Layout {
    std::vector<std::int64_t> dims, chunk;
  };
  for (const Layout& layout :
       {Layout{{23}, {5}}, Layout{{6, 7}, {4, 3}}, Layout{{6, 7}, {4, 7}},
        Layout{{4, 5, 6}, {2, 2, 4}}, Layout{{4, 5, 6}, {1, 5, 6}}, Layout{{4, 5, 6}, {3, 2, 6}},
        Layout{{4, 5, 6}, {9, 9, 9}}, Layout{{2, 3, 4, 5}, {2, 1, 3, 2}}}) {
    for (const bool is_packed : {false, true}) {
      const ChunkedFile file(layout.dims, layout.chunk, is_packed);
      const auto samples = samples_in_file(*file.source(), file.place(), {});
      std::vector<std::uint16_t> got(file.expected().size());
      samples->read(0, std::as_writable_bytes(std::span(got)));
      EXPECT_EQ(got, file.expected()) << layout.dims.size() << " axes, packed: " << is_packed;
    }
  }
}

void read_all(const ChunkedFile& file, const StoredPlace& place) {
  const auto samples = samples_in_file(*file.source(), place, {});
  std::vector<std::byte> out(static_cast<std::size_t>(place.num_bytes));
  samples->read(0, out);
}

TEST(UnpackChunks, RefusesWhatIsDamaged) {
  OVOID_NOT_UNDER_TSAN();
  ChunkedFile file({6, 8}, {4, 4}, true);
  EXPECT_NO_THROW(read_all(file, file.place()));
  {
    std::fstream damaged(file.path(), std::ios::binary | std::ios::in | std::ios::out);
    damaged.seekp(file.storage().chunks[2].offset + 3);
    damaged << "xxxx";
  }
  EXPECT_NE(error_of([&] { read_all(file, file.place()); }).find("chunk 2: "), std::string::npos);
  const std::string misplaced =
      "file-format: " + file.path() + ": the samples do not lie where it says";
  const auto with = [&](auto change) {
    StoredPlace place = file.place();
    ChunkedStorage storage = *place.chunked;
    change(storage, place);
    place.chunked = std::make_shared<const ChunkedStorage>(storage);
    return error_of([&] { read_all(file, place); });
  };
  EXPECT_EQ(with([](ChunkedStorage& s, StoredPlace&) { s.chunks[1].offset = 1 << 20; }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage& s, StoredPlace&) { s.chunks[1].num_bytes = -1; }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage& s, StoredPlace&) { s.chunks.pop_back(); }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage& s, StoredPlace&) { s.dims[0] = 7; }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage& s, StoredPlace&) { s.chunk[0] = 0; }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage& s, StoredPlace&) { s.chunk.push_back(1); }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage&, StoredPlace& p) { p.num_bytes = 2; }), misplaced);
  EXPECT_EQ(with([](ChunkedStorage&, StoredPlace& p) { p.type = ScalarType::kFloat64; }),
            misplaced);
}

}  // namespace unpack_chunks_test
}  // namespace ovoid::io
