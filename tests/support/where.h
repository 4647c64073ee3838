// SPDX-License-Identifier: Apache-2.0
// Where a test runs. Every test runs in a release build for every commit. A test that is worth less
// than its time elsewhere says so in the first line of its body, and why.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string_view>

namespace ovoid::test {

#ifdef OVOID_SANITIZED_ADDRESS
inline constexpr bool kHasAddressSanitizer = true;
#else
inline constexpr bool kHasAddressSanitizer = false;
#endif
#ifdef OVOID_SANITIZED_THREAD
inline constexpr bool kHasThreadSanitizer = true;
#else
inline constexpr bool kHasThreadSanitizer = false;
#endif

// `make nightly` runs what takes longer than a commit's check may.
inline bool is_nightly() {
  const char* const value = std::getenv("OVOID_TEST_NIGHTLY");
  return value != nullptr && std::string_view(value) == "1";
}

// The agreement tests are run once more on a Vulkan device.
inline bool is_on_device() {
  const char* const value = std::getenv("OVOID_TEST_BACKEND");
  return value != nullptr && std::string_view(value) == "vulkan";
}

}  // namespace ovoid::test

// Not under AddressSanitizer, or ThreadSanitizer: other tests run the same code in less time.
#define OVOID_NOT_UNDER_ASAN()             \
  if (::ovoid::test::kHasAddressSanitizer) \
  GTEST_SKIP() << "other tests run the same code under AddressSanitizer"
#define OVOID_NOT_UNDER_TSAN()            \
  if (::ovoid::test::kHasThreadSanitizer) \
  GTEST_SKIP() << "one thread, or code that other tests run under ThreadSanitizer"

// On a Vulkan device in `make nightly` alone: software drivers take seconds for each new pipeline.
#define OVOID_NIGHTLY_ON_DEVICE()                                    \
  if (::ovoid::test::is_on_device() && !::ovoid::test::is_nightly()) \
  GTEST_SKIP() << "on a device in make nightly alone (OVOID_TEST_NIGHTLY=1)"

// Of what backend vulkan refuses.
#define OVOID_NOT_ON_DEVICE(why) \
  if (::ovoid::test::is_on_device()) GTEST_SKIP() << "backend vulkan " why
