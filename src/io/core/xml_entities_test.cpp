// SPDX-License-Identifier: Apache-2.0
// Entities that a DOCTYPE declares. What would make it fail: one put where it is no reference, or
// put in without end.
#include "io/core/xml_entities.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace xml_entities_test {

using testing::EndsWith;
using testing::HasSubstr;

// What becomes of `text` behind a DOCTYPE with these declarations.
std::string put_in(const std::string& declarations, const std::string& text) {
  const std::string head =
      "<?xml version=\"1.0\"?>\n<!DOCTYPE a SYSTEM \"a.dtd\" [" + declarations + "]>\n";
  const std::string whole = with_own_entities("f", head + text);
  EXPECT_EQ(whole.substr(0, head.size()), head);
  return whole.substr(head.size());
}

std::string entity_error(const std::string& declarations, const std::string& text) {
  return error_of([&] { put_in(declarations, text); });
}

TEST(XmlEntities, ArePutIn) {
  const std::string file = "<!ENTITY file \"x.h5\">";
  EXPECT_EQ(put_in(file, "<a>&file;:/v</a>"), "<a>x.h5:/v</a>");
  EXPECT_EQ(put_in("<!-- ]> &b; --> <!ENTITY  file\n 'x.h5' >", "<a>&file;</a>"), "<a>x.h5</a>");
  EXPECT_EQ(put_in(file + "<!ENTITY where '&file;:/v'>", "<a>&where;</a>"), "<a>x.h5:/v</a>");
  EXPECT_EQ(put_in("<!ENTITY grid '<b c=\"d\"/>'>", "<a>&grid;</a>"), "<a><b c=\"d\"/></a>");
  // The first declaration counts.
  EXPECT_EQ(put_in(file + "<!ENTITY file \"y.h5\">", "<a>&file;</a>"), "<a>x.h5</a>");
  // In an attribute quotes are letters.
  EXPECT_EQ(put_in("<!ENTITY q '\"'>", "<a b=\"&q;\" c='&q;'/>&q;"),
            "<a b=\"&quot;\" c='&quot;'/>\"");
}

TEST(XmlEntities, OthersStay) {
  for (const char* const text :
       {"<a>&lt;&#10;&#x41;&amp;b;</a>", "<!-- &b; --><a/>", "<a><![CDATA[&b;]]></a>",
        "<?p &b;?><a/>", "<a>b & c &</a>", "<a>&;</a>"})
    EXPECT_EQ(put_in("", text), text);
  EXPECT_EQ(with_own_entities("f", "<a>&lt;</a>"), "<a>&lt;</a>");
}

TEST(XmlEntities, AreRefusedByName) {
  EXPECT_EQ(entity_error("", "<a>&b;</a>"),
            "file-format: f: the entity '&b;' is not declared: expected a declaration in the "
            "file's DOCTYPE");
  EXPECT_EQ(entity_error("<!ENTITY b SYSTEM \"/etc/passwd\">", "<a>&b;</a>"),
            "unsupported: f: the entity '&b;' stands for '/etc/passwd', another file, which is not "
            "read");
  EXPECT_THAT(entity_error("<!ENTITY b PUBLIC \"c\" \"d.xml\">", "<a>&b;</a>"),
              HasSubstr("stands for 'd.xml'"));
  EXPECT_THAT(entity_error("<!ENTITY % b \"c\"> %b;", "<a>&b;</a>"), HasSubstr("is not declared"));
}

TEST(XmlEntities, HaveBounds) {
  std::string laughs = "<!ENTITY l0 \"ha\">";
  std::string silent = "<!ENTITY l0 \"\">";
  for (int i = 1; i < 15; ++i) {
    std::string ten;
    for (int k = 0; k < 10; ++k) ten += "&l" + std::to_string(i - 1) + ";";
    const std::string one = "<!ENTITY l" + std::to_string(i) + " \"" + ten + "\">";
    laughs += one;
    silent += one;
  }
  for (const std::string& declarations : {laughs, silent})
    EXPECT_THAT(entity_error(declarations, "<a>&l14;</a>"),
                EndsWith("would put in more than 16777216 bytes or references"));
  EXPECT_THAT(entity_error("<!ENTITY b \"&c;\"><!ENTITY c \"&b;\">", "<a>&b;</a>"),
              HasSubstr("is made of entities that are made of entities"));
  std::string many;
  for (int i = 0; i < 20000; ++i) many += "<!ENTITY e" + std::to_string(i) + " \"\">";
  EXPECT_THAT(entity_error(many, "<a>&b;</a>"), HasSubstr("is one of more than 10000"));
  // Declarations that do not end.
  for (const char* const text : {"<!DOCTYPE a [<!ENTITY b \"&b;", "<!DOCTYPE a [<!ENTITY b",
                                 "<!DOCTYPE a \"&b;", "<!DOCTYPE a [<!-- &b;"})
    error_of([&] { with_own_entities("f", text); });
}

}  // namespace xml_entities_test
}  // namespace ovoid::io
