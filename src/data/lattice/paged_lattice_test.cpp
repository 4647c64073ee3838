// SPDX-License-Identifier: Apache-2.0
// A lattice in a file shows what the same lattice in memory does.
#include "data/lattice/paged_lattice.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "data/lattice/brick_reach.h"
#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "ovoid/error.h"

namespace ovoid {
namespace paged_lattice_test {

template <class T>
constexpr ScalarType kTypeOf = ScalarType::kFloat32;
template <>
constexpr ScalarType kTypeOf<std::uint8_t> = ScalarType::kUInt8;
template <>
constexpr ScalarType kTypeOf<std::int16_t> = ScalarType::kInt16;

// Counts what is read, and fails when it is told to.
template <class T>
class FakeFile final : public StoredSamples {
 public:
  FakeFile(std::vector<T> values, std::int64_t memory)
      : values_(std::move(values)), memory_(memory) {}
  std::int64_t num_bytes() const noexcept override {
    return static_cast<std::int64_t>(values_.size() * sizeof(T));
  }
  std::int64_t memory_for_pages() const noexcept override { return memory_; }
  void read(std::int64_t offset, std::span<std::byte> out) const override {
    if (is_broken) throw Error(ErrorCode::kFileFormat, "the file has shrunk");
    num_read += static_cast<std::int64_t>(out.size());
    const auto bytes = std::as_bytes(std::span(values_));
    std::memcpy(out.data(), bytes.subspan(static_cast<std::size_t>(offset), out.size()).data(),
                out.size());
  }
  mutable std::atomic<std::int64_t> num_read = 0;
  std::atomic<bool> is_broken = false;

 private:
  std::vector<T> values_;
  std::int64_t memory_;
};

constexpr Index3 kPagedDims{21, 75, 70};  // 3 x 3 pages, the last ones cut

template <class T>
std::vector<T> numbers() {
  std::vector<T> values;
  for (std::int64_t i = 0; i < num_samples(kPagedDims); ++i)
    values.push_back(static_cast<T>(100 + i * i % 97 - i % 31));
  if constexpr (std::is_same_v<T, float>) {
    values[5] = values[90000] = std::numeric_limits<float>::quiet_NaN();
  }
  return values;
}

template <class T>
class PagedLattices : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::int16_t, float>;
TYPED_TEST_SUITE(PagedLattices, Types);

TYPED_TEST(PagedLattices, ShowWhatIsInTheFile) {
  using T = TypeParam;
  const std::vector<T> values = numbers<T>();
  // Two pages at a time, so that all are read again and again.
  const auto file = std::make_shared<FakeFile<T>>(values, 1);
  const ResidentLatticeOptions options{2.0, -0.5, 3.0, 2, {}};
  const LatticeGeometry geometry{.dims = kPagedDims};
  const PagedLattice lattice(geometry, kTypeOf<T>, file, options);
  const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return values[static_cast<std::size_t>(i + kPagedDims[0] * (j + kPagedDims[1] * k))];
  };
  for (std::int64_t bz = 0; bz < 9; ++bz) {
    for (std::int64_t by = 0; by < 10; ++by) {
      for (std::int64_t bx = 0; bx < 3; ++bx) {
        const auto own = data::samples_in_brick(geometry, {bx, by, bz}, lattice.brick_edge());
        const BrickView view = lattice.acquire(bx, by, bz, 0);
        ASSERT_EQ(view.type, kTypeOf<T>);
        for (std::size_t a = 0; a < 3; ++a) {
          ASSERT_LE(view.lo[a], own.lo[a]);
          ASSERT_GE(view.hi[a], own.hi[a]);
        }
        for (std::int64_t k = own.lo[2]; k < own.hi[2]; ++k) {
          for (std::int64_t j = own.lo[1]; j < own.hi[1]; ++j) {
            const T* row = static_cast<const T*>(view.data) + (j - view.lo[1]) * view.stride_y +
                           (k - view.lo[2]) * view.stride_z - view.lo[0];
            for (std::int64_t i = own.lo[0]; i < own.hi[0]; ++i) {
              const T expected = at(i, j, k);
              ASSERT_EQ(std::memcmp(&row[i], &expected, sizeof(T)), 0);
            }
          }
        }
        const auto reached =
            data::samples_in_reach(geometry, {bx, by, bz}, lattice.brick_edge(), 2.0);
        ValueRange range;
        bool is_missing = false;
        for (std::int64_t k = reached.lo[2]; k < reached.hi[2]; ++k) {
          for (std::int64_t j = reached.lo[1]; j < reached.hi[1]; ++j) {
            for (std::int64_t i = reached.lo[0]; i < reached.hi[0]; ++i) {
              const double stored = static_cast<double>(at(i, j, k));
              if (!std::isfinite(stored)) {
                is_missing = true;
                continue;
              }
              const auto value = static_cast<float>(stored * -0.5 + 3.0);
              range = range.is_empty()
                          ? ValueRange{value, value}
                          : ValueRange{std::min(range.lo, value), std::max(range.hi, value)};
            }
          }
        }
        ASSERT_EQ(lattice.brick_range(bx, by, bz).lo, range.lo) << bx << ' ' << by << ' ' << bz;
        ASSERT_EQ(lattice.brick_range(bx, by, bz).hi, range.hi);
        ASSERT_EQ(lattice.has_missing(bx, by, bz), is_missing);
      }
    }
  }
  EXPECT_LT(lattice.resident_bytes(), std::size_t{2} * 21 * 32 * 32 * sizeof(T) + 10000);
}

// Pages within the memory are read once, and by many threads at once.
TEST(PagedLattice, PagesThatAreKeptAreReadOnce) {
  const auto file = std::make_shared<FakeFile<float>>(numbers<float>(), 1 << 24);
  const PagedLattice lattice({.dims = kPagedDims}, ScalarType::kFloat32, file);
  file->num_read = 0;
  data::parallel_ranges({20000, 16, 4, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t by = i * 7 % 10, bz = i * 11 % 9;
      const BrickView view = lattice.acquire(0, by, bz, 0);
      ASSERT_EQ(view.lo[1], by / 4 * 32);
      ASSERT_EQ(view.lo[2], bz / 4 * 32);
    }
  });
  EXPECT_EQ(file->num_read, file->num_bytes());
}

// A view stays valid when its page is given up, and a page that could not be read is tried again.
TEST(PagedLattice, ViewsOutliveTheirPagesAndErrorsPass) {
  const std::vector<std::uint8_t> values = numbers<std::uint8_t>();
  const auto file = std::make_shared<FakeFile<std::uint8_t>>(values, 1);
  const PagedLattice lattice({.dims = kPagedDims}, ScalarType::kUInt8, file);
  const BrickView first = lattice.acquire(0, 0, 0, 0);
  for (int by = 0; by < 10; ++by) lattice.acquire(0, by, 8, 0);
  EXPECT_EQ(static_cast<const std::uint8_t*>(first.data)[20], values[20]);
  file->is_broken = true;
  EXPECT_THROW(lattice.acquire(0, 0, 4, 0), Error);
  EXPECT_THROW(lattice.acquire(0, 0, 4, 0), Error);
  file->is_broken = false;
  EXPECT_EQ(*static_cast<const std::uint8_t*>(lattice.acquire(0, 0, 4, 0).data),
            values[std::size_t{21} * 75 * 32]);
}

TEST(PagedLattice, RefusesWhatItCannotShow) {
  const auto file = std::make_shared<FakeFile<std::uint8_t>>(numbers<std::uint8_t>(), 1 << 20);
  EXPECT_THROW(PagedLattice({.dims = {21, 75, 71}}, ScalarType::kUInt8, file), Error);
  EXPECT_THROW(PagedLattice({.dims = kPagedDims}, ScalarType::kInt16, file), Error);
  EXPECT_THROW(PagedLattice({.dims = kPagedDims, .kind = LatticeKind::kBodyCentred},
                            ScalarType::kUInt8, file),
               Error);
}

}  // namespace paged_lattice_test
}  // namespace ovoid
