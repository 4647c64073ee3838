// SPDX-License-Identifier: Apache-2.0
// What must not compile, because it could only be a mistake: each line fails to compile if it does.
#include <gtest/gtest.h>

#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ovoid/ovoid.h"

namespace ovoid {
namespace public_misuse_test {

// Values that are gone before they are used.
static_assert(std::constructible_from<BorrowedValues<double>, std::vector<double>&>);
static_assert(std::constructible_from<BorrowedValues<double>, const std::vector<double>&>);
static_assert(!std::constructible_from<BorrowedValues<double>, std::vector<double>>);
template <typename Columns>
concept TakesATemporary = requires(Columns columns) {
  columns.centers = std::vector<double>{};
};
static_assert(!TakesATemporary<KernelColumns>);

// Of a temporary the array comes as a copy, which shares the values.
static_assert(std::is_reference_v<decltype(std::declval<const Dataset&>().array())>);
static_assert(!std::is_reference_v<decltype(std::declval<Dataset>().array())>);

static_assert(std::constructible_from<SliceFields, const Series&, LatticeModelOptions>);
static_assert(!std::constructible_from<SliceFields, Series, LatticeModelOptions>);

// A number or a bool for a setting, and one setting for another.
template <typename Options>
concept TakesNumbers = requires(Options options) {
  options.slab = 1;
}
|| requires(Options options) { options.gradient = true; }
|| requires(Options options) { options.evaluate = Slab::kMid; };
static_assert(!TakesNumbers<RenderOptions>);
static_assert(std::constructible_from<Renderer, Backend, int>);
static_assert(!std::constructible_from<Renderer, int> && !std::constructible_from<Renderer, bool>);
static_assert(!std::constructible_from<LatticeField, std::shared_ptr<const BrickSource>,
                                       LatticeKernel, bool>);

// A pointer for three numbers.
template <typename Background>
concept IsBackground = requires(const Image& image, Background background) {
  write_image(image, "a.png", background);
};
static_assert(IsBackground<Rgb> && IsBackground<std::optional<Rgb>>);
static_assert(!IsBackground<const double*> && !IsBackground<std::nullptr_t>);

// Copies of what owns threads, memory on a device or a file that is being written.
static_assert(!std::copyable<Renderer> && std::movable<Renderer>);
static_assert(!std::copyable<Series> && !std::copyable<LatticeFileWriter>);

// The static_asserts above are the test; this names it where tests are listed.
TEST(PublicMisuse, DoesNotCompile) {
  const std::vector<double> named{1, 2, 3};
  EXPECT_EQ(BorrowedValues<double>(named).size(), 3U);
  EXPECT_EQ(version(), Version());
}

}  // namespace public_misuse_test
}  // namespace ovoid
