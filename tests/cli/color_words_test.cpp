// SPDX-License-Identifier: Apache-2.0
#include "color_words.h"

#include <gtest/gtest.h>

#include "values.h"

namespace ovoid::cli {
namespace color_words_test {

TEST(ColorWords, NamesAndHexadecimals) {
  EXPECT_EQ(hex_text(color_of_word("aliceblue")), "#f0f8ff");
  EXPECT_EQ(hex_text(color_of_word("steelblue")), "#4682b4");
  EXPECT_EQ(hex_text(color_of_word("gray")), hex_text(color_of_word("grey")));
  EXPECT_EQ(hex_text(color_of_word("yellowgreen")), "#9acd32");
  EXPECT_EQ(hex_text(color_of_word("#0aF")), "#00aaff");
  EXPECT_EQ(hex_text(color_of_word("#c05030")), "#c05030");
  EXPECT_EQ(parse_rgb("0.25,0.5,1"), (Rgb{0.25, 0.5, 1}));
  EXPECT_EQ(parse_rgb("white"), (Rgb{1, 1, 1}));
}

TEST(ColorWords, WhatIsNoColour) {
  const auto words = [](const std::string& text) -> std::string {
    try {
      (void)parse_rgb(text);
    } catch (const BadValue& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(words("stealblue").find("did you mean steelblue?"), std::string::npos);
  EXPECT_NE(words("#12345").find("expected #rrggbb"), std::string::npos);
  EXPECT_NE(words("#12345g").find("expected #rrggbb"), std::string::npos);
  EXPECT_NE(words("").find("expected 3 numbers"), std::string::npos);
  EXPECT_NE(words("1,2,3").find("in [0, 1]"), std::string::npos);
}

}  // namespace color_words_test
}  // namespace ovoid::cli
