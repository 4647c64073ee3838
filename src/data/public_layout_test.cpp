// SPDX-License-Identifier: Apache-2.0
// Fails if a public type changes its size or alignment with the flags of who includes it: a program
// built for a newer processor would then read other members than the library wrote.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "layout/public_layout.h"

namespace ovoid {
namespace public_layout_test {

using Layouts = std::map<std::string, std::pair<std::size_t, std::size_t>>;  // size, alignment

Layouts layouts_of(const test::TypeLayout* list) {
  Layouts layouts;
  for (; list->name != nullptr; ++list) layouts[list->name] = {list->size, list->alignment};
  return layouts;
}

TEST(PublicLayout, DoesNotDependOnTheProcessorThatIsCompiledFor) {
  if (test::kAlignmentHere == test::kAlignmentWide)
    GTEST_SKIP() << "this compiler has no flag for wider registers";
  const Layouts wide = layouts_of(test::kLayoutsWide);
  for (const auto& [name, here] : layouts_of(test::kLayoutsHere))
    EXPECT_EQ(here, wide.at(name)) << name;
}

// Fails if a public header has a structure that the test above does not look at.
TEST(PublicLayout, IsOfEveryPublicType) {
  const Layouts here = layouts_of(test::kLayoutsHere);
  const std::regex declared(R"((^|\n)(struct|class) (\w+)[^;{\n]*\{)");
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(OVOID_SOURCE_DIR "/include/ovoid")) {
    std::ifstream file(entry.path());
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (std::sregex_iterator it(text.begin(), text.end(), declared), end; it != end; ++it) {
      ++found;
      EXPECT_TRUE(here.contains((*it)[3])) << (*it)[3] << " of " << entry.path().filename();
    }
  }
  EXPECT_GT(found, 50U);
}

}  // namespace public_layout_test
}  // namespace ovoid
