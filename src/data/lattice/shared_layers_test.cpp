// SPDX-License-Identifier: Apache-2.0
// What is asked of all samples of a lattice in a file, by one process and by several that share it.
#include "data/lattice/shared_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "data/field_samples.h"
#include "data/lattice/paged_lattice.h"
#include "data/lattice/rise_samples.h"
#include "data/lattice/sample_survey.h"
#include "ovoid/error.h"
#include "support/thread_team.h"

namespace ovoid::data {
namespace shared_layers_test {

constexpr Index3 kDims{40, 75, 230};  // eight layers of pages, the last one cut

// A file that counts what is read of it.
template <class T>
class CountedFile final : public StoredSamples {
 public:
  explicit CountedFile(std::vector<T> values) : values_(std::move(values)) {}
  std::int64_t num_bytes() const noexcept override {
    return static_cast<std::int64_t>(values_.size() * sizeof(T));
  }
  std::int64_t memory_for_pages() const noexcept override { return 1 << 20; }
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    num_read += static_cast<std::int64_t>(out.size());
    std::memcpy(out.data(), reinterpret_cast<const std::byte*>(values_.data()) + offset,
                out.size());
  }
  mutable std::atomic<std::int64_t> num_read = 0;

 private:
  std::vector<T> values_;
};

template <class T>
std::shared_ptr<const CountedFile<T>> file_of(
    const std::function<double(std::int64_t x, std::int64_t y, std::int64_t z)>& value) {
  std::vector<T> values;
  values.reserve(static_cast<std::size_t>(num_samples(kDims)));
  for (std::int64_t z = 0; z < kDims[2]; ++z) {
    for (std::int64_t y = 0; y < kDims[1]; ++y) {
      for (std::int64_t x = 0; x < kDims[0]; ++x) values.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  return std::make_shared<const CountedFile<T>>(std::move(values));
}

double wave(std::int64_t x, std::int64_t y, std::int64_t z) {
  return 100 + 90 * std::sin(0.1 * static_cast<double>(x)) *
                   std::cos(0.07 * static_cast<double>(y)) *
                   std::sin(0.03 * static_cast<double>(z));
}

// With a hole that lies in one process' layers alone.
double wave_with_hole(std::int64_t x, std::int64_t y, std::int64_t z) {
  return z > 100 && z < 104 ? std::numeric_limits<double>::quiet_NaN() : wave(x, y, z);
}

double regions(std::int64_t x, std::int64_t y, std::int64_t z) {
  return 3 * static_cast<double>(x / 10 + 4 * (y / 25) + (z > 200 ? 12 : 0));
}

// More than are few, some of them in the last layers alone.
double many_regions(std::int64_t x, std::int64_t y, std::int64_t z) {
  return 1000 + 3 * static_cast<double>(x / 8 + 5 * (y / 15) + 25 * (z / 23));
}

// Few integers but for one sample, which the last process has.
double regions_with_a_number(std::int64_t x, std::int64_t y, std::int64_t z) {
  return z == kDims[2] - 1 && x == 3 && y == 4 ? 2.5 : regions(x, y, z);
}

template <class T>
ResidentLattice in_memory(const CountedFile<T>& file, ScalarType type) {
  auto bytes = std::make_shared<std::vector<T>>(static_cast<std::size_t>(num_samples(kDims)));
  file.read(0, std::as_writable_bytes(std::span(*bytes)));
  return {{.dims = kDims}, type, Bytes{bytes, std::as_bytes(std::span(*bytes))}};
}

void expect_same_samples(const BrickSource& a, const BrickSource& b) {
  const FieldSamples found = take_samples(a), expected = take_samples(b);
  EXPECT_EQ(found.values, expected.values);
  EXPECT_EQ(found.on_faces, expected.on_faces);
  EXPECT_EQ(found.share_of_equals, expected.share_of_equals);
  EXPECT_EQ(found.share_of_jumps, expected.share_of_jumps);
  EXPECT_EQ(found.is_counted, expected.is_counted);
  EXPECT_EQ(labels_of(a), labels_of(b));
}

template <class T>
class AskedOnce {
 public:
  AskedOnce(ScalarType type,
            const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& value)
      : type_(type), file_(file_of<T>(value)) {}

  // As in memory, and with nothing read for it after the lattice is made; of more labels than few
  // a pass of its own is part of that.
  void expect_as_in_memory(std::size_t num_labels) const {
    const PagedLattice paged({.dims = kDims}, type_, file_);
    const std::int64_t num_read = file_->num_read;
    expect_same_samples(paged, in_memory(*file_, type_));
    EXPECT_EQ(labels_of(paged).size(), num_labels);
    EXPECT_EQ(file_->num_read, num_read + file_->num_bytes());  // into memory
  }

  // Processes see what one does, and each has read about its part of the file.
  void expect_the_same_by(int count) const {
    SCOPED_TRACE(::testing::Message() << count << " processes");
    const PagedLattice alone({.dims = kDims}, type_, file_);
    const std::vector<RiseSample> rises = take_rises(alone);
    const std::int64_t num_before = file_->num_read;
    ovoid::testing::Room room(count);
    ovoid::testing::run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
      const PagedLattice paged({.dims = kDims}, type_, file_, {}, team);
      const SharedLayers layers = shared_layers(paged);
      EXPECT_EQ(layers.team, team.get());
      expect_same_samples(paged, alone);
      const std::vector<RiseSample> own = take_rises(paged);
      EXPECT_EQ(own.size(), rises.size());
      for (std::size_t i = 0; i < std::min(own.size(), rises.size()); ++i) {
        EXPECT_EQ(own[i].value, rises[i].value);
        EXPECT_EQ(own[i].gradient, rises[i].gradient);
        EXPECT_EQ(own[i].agreement, rises[i].agreement);
      }
      constexpr std::int64_t kEdge = PagedLattice::kBrickEdge;
      for (std::int64_t z = 0; z * kEdge < kDims[2]; ++z) {
        for (std::int64_t y = 0; y * kEdge < kDims[1]; ++y) {
          for (std::int64_t x = 0; x * kEdge < kDims[0]; ++x) {
            EXPECT_EQ(paged.brick_range(x, y, z).lo, alone.brick_range(x, y, z).lo);
            EXPECT_EQ(paged.brick_range(x, y, z).hi, alone.brick_range(x, y, z).hi);
            EXPECT_EQ(paged.has_missing(x, y, z), alone.has_missing(x, y, z));
          }
        }
      }
      return 0;
    });
    // Once for the ranges, with layers around each part, and once for rises.
    const auto most = static_cast<double>(file_->num_bytes()) * (3.5 + 0.15 * count);
    EXPECT_LE(static_cast<double>(file_->num_read - num_before), most);
  }

 private:
  ScalarType type_;
  std::shared_ptr<const CountedFile<T>> file_;
};

TEST(FewIntegers, EndWithTheFirstNumberThatDoesNotFit) {
  const auto found = [](const std::vector<float>& values, std::size_t most) {
    FewIntegers integers(most);
    for (const float value : values) integers.add(value);
    return integers.found();
  };
  EXPECT_EQ(found({0, 7, 2, 40, 7}, 4), (std::vector<int>{0, 2, 7, 40}));
  EXPECT_TRUE(found({0, 7, 2, 40}, 3).empty());
  for (const float odd : {70000.0F, -1.0F, 0.5F}) EXPECT_TRUE(found({0, 7, odd, 2}, 8).empty());
}

TEST(PagedSamples, AreThoseInMemory) {
  AskedOnce<float>(ScalarType::kFloat32, wave).expect_as_in_memory(0);
  AskedOnce<float>(ScalarType::kFloat32, wave_with_hole).expect_as_in_memory(0);
  AskedOnce<std::uint8_t>(ScalarType::kUInt8, wave).expect_as_in_memory(0);
  AskedOnce<std::uint8_t>(ScalarType::kUInt8, regions).expect_as_in_memory(24);
  AskedOnce<std::int16_t>(ScalarType::kInt16, many_regions).expect_as_in_memory(250);
}

TEST(PagedSamples, AreSharedByATeam) {
  const AskedOnce<float> waves(ScalarType::kFloat32, wave_with_hole);
  const AskedOnce<std::uint8_t> labels(ScalarType::kUInt8, regions);
  const AskedOnce<std::int16_t> many(ScalarType::kInt16, many_regions);
  const AskedOnce<float> nearly(ScalarType::kFloat32, regions_with_a_number);
  for (const int count : {1, 2, 3, 9}) {
    waves.expect_the_same_by(count);
    labels.expect_the_same_by(count);
    many.expect_the_same_by(count);
    nearly.expect_the_same_by(count);
  }
}

TEST(PagedSamples, AreOfOneFile) {
  const auto file = file_of<std::uint8_t>(wave), other = file_of<std::uint8_t>(regions);
  ovoid::testing::Room room(3);
  ovoid::testing::run_as_team(room, [&](const std::shared_ptr<KernelTeam>& team) {
    try {
      const PagedLattice paged({.dims = kDims}, ScalarType::kUInt8,
                               team->number() == 2 ? other : file, {}, team);
      ADD_FAILURE() << "process " << team->number() << " takes it for one file";
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(),
                   "process 2 of 3: its file has other samples than that of process 0");
    }
    return 0;
  });
}

}  // namespace shared_layers_test
}  // namespace ovoid::data
