// SPDX-License-Identifier: Apache-2.0
#include "io/core/base64.h"

#include <gtest/gtest.h>

#include <string>

namespace ovoid::io {
namespace base64_test {

// The examples of RFC 4648, section 10.
TEST(Base64, AsTheRfcHasIt) {
  const std::string text = "foobar";
  const char* const encoded[] = {"", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"};
  for (std::size_t size = 0; size <= text.size(); ++size) {
    EXPECT_EQ(encoded_base64(text.substr(0, size)), encoded[size]);
    EXPECT_EQ(decoded_base64(encoded[size]), text.substr(0, size));
  }
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  EXPECT_EQ(decoded_base64(encoded_base64(all)), all);
}

TEST(Base64, LineEndsAndPiecesArePassedOver) {
  EXPECT_EQ(decoded_base64("Zm\r\n9v\n Ym\tFy"), "foobar");
  EXPECT_EQ(decoded_base64("Zm8=\nb2Jhcg==Zg=="), "foobarf");
  EXPECT_EQ(decoded_base64("Zm9v<YmFy"), "foo");
}

}  // namespace base64_test
}  // namespace ovoid::io
